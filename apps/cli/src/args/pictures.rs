//! Options of pictures.

use std::path::PathBuf;

use super::{ModelChoice, Numbers, finite, numbers, size};
use crate::look::LookArgs;
use crate::verbs::render;

#[derive(clap::Args)]
pub(crate) struct Render {
    /// The tree: .tree .csv .parquet .dtree; with --all, a table of several or a folder, too.
    #[arg(required_unless_present = "sheet", conflicts_with = "sheet")]
    pub(crate) input: Option<PathBuf>,
    /// The picture: .png (8 bits, sRGB) or .exr (linear, in light).
    #[arg(long, short, value_name = "PNG|EXR")]
    pub(crate) output: PathBuf,
    /// Which tree of a table of several.
    #[arg(long, value_name = "NUMBER")]
    pub(crate) tree: Option<u32>,
    /// All trees of the file, or of the files of a folder, together: each where its foot is, as
    /// stands are written. Wants 5 to 25 MB of memory a tree, by its size and --lod.
    #[arg(long, conflicts_with_all = ["tree", "sheet", "impostor"])]
    pub(crate) all: bool,
    /// A contact sheet in place of one tree: the eight species, grown and generated; one species by
    /// age and gravitropism; by random seeds; or one tree from all sides.
    #[arg(long, value_enum)]
    pub(crate) sheet: Option<Sheet>,
    /// The species of the sheets priors, samples and views.
    #[arg(long, default_value = "oak", requires = "sheet")]
    pub(crate) species: String,
    /// Cards to stand in for the tree from afar in place of a picture: how many, turned about the
    /// trunk; their colours in the output, and their normals in a file beside it.
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "2", conflicts_with_all = ["sheet", "views", "aov"], value_parser = clap::value_parser!(u32).range(1..=16))]
    pub(crate) impostor: Option<u32>,
    /// From where: front, right, back, left, quarter, top; trunk or twigs, from two metres. Several
    /// stand side by side [default: front, with --all quarter].
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        default_value = "front",
        default_value_if("all", "true", "quarter"),
        hide_default_value = true,
        conflicts_with = "sheet"
    )]
    pub(crate) views: Vec<String>,
    /// Width and height of each view in pixels; of a sheet, the height of the tallest tree counts
    /// [default: 512x512, of a sheet 360].
    #[arg(long, value_name = "WxH", value_parser = size)]
    pub(crate) size: Option<[u32; 2]>,
    /// Most light paths a pixel.
    #[arg(long, value_name = "N", default_value_t = 128, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..=i64::from(deeptree_render::MAX_SAMPLES)))]
    pub(crate) spp: u32,
    /// Standard error, as a share of the brightness, at which a part of the picture is good enough;
    /// 0 takes all paths everywhere.
    #[arg(long, default_value_t = 0.01, value_parser = finite)]
    pub(crate) error: f32,
    /// Seed of the paths, and of the first tree of a sheet.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// What is around the tree; transparent and white keep its shadow.
    #[arg(long, value_enum, default_value = "sky", conflicts_with = "sheet")]
    pub(crate) background: Surroundings,
    /// Elevation of the sun and its azimuth from the front to the right, in degrees.
    #[arg(long, value_name = "E,A", default_value_t = Numbers(render::SUN), allow_hyphen_values = true, value_parser = numbers::<2>)]
    pub(crate) sun: Numbers<2>,
    /// Turbidity of the air, from 2 (very clear) to 10.
    #[arg(long, default_value_t = render::HAZE, value_parser = finite)]
    pub(crate) haze: f32,
    /// Stops by which the picture is brighter.
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) exposure: f32,
    /// The curve from light to PNG.
    #[arg(long, value_enum, default_value = "filmic")]
    pub(crate) tone: Curve,
    /// Angle of view from below to above, in degrees.
    #[arg(long, value_name = "DEGREES", default_value_t = render::ANGLE, value_parser = finite)]
    pub(crate) angle: f32,
    /// Radius of the lens in metres: what is nearer or farther than the tree gets soft.
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = finite)]
    pub(crate) aperture: f32,
    /// What is where, for machines: depth, normal, labels; as files beside a .png, or channels of
    /// an .exr.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_enum)]
    pub(crate) aov: Vec<Aov>,
    /// Level of detail of the tree, 0 (finest) to 3.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=3))]
    pub(crate) lod: u8,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Threads [default: one a core].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
}

/// Contact sheets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Sheet {
    Species,
    Priors,
    Samples,
    Views,
}

/// What is around a tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Surroundings {
    Sky,
    Transparent,
    White,
}

/// Curves from light to bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Curve {
    /// As of film: dark tones a little darker, bright ones rolled off.
    Filmic,
    /// Proportional.
    Linear,
}

/// What is known of each pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Aov {
    /// Distance along the camera's axis.
    Depth,
    /// Normal of the surface.
    Normal,
    /// Kind (ground, wood, leaf), branch, order and node; with --all the tree, too.
    Labels,
}
