//! Options of the verbs that make and read point clouds.

use std::path::PathBuf;

use super::{ModelChoice, Out, finite};
use crate::clouds::CloudFormat;

#[derive(clap::Args)]
pub(crate) struct Scan {
    /// The tree: .tree .csv .parquet .dtree.
    pub(crate) input: PathBuf,
    /// The cloud to write, z up: .xyz .txt .csv .ply .las .laz .parquet; - for standard output.
    #[arg(long, short, value_name = "FILE|-")]
    pub(crate) output: PathBuf,
    /// The format, where the output is -.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<CloudFormat>,
    #[command(flatten)]
    pub(crate) scanner: Scanner,
    /// The tree in the leaves of summer.
    #[arg(long)]
    pub(crate) leaves: bool,
    /// A level ground at height 0 around the tree.
    #[arg(long)]
    pub(crate) ground: bool,
    /// Seed of where the scanner stands and of its noise.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Which tree of a table of several.
    #[arg(long, value_name = "NUMBER")]
    pub(crate) tree: Option<u32>,
    /// Threads [default: one a core]; any number gives the same points.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
}

/// How a scanner moves and looks.
#[derive(clap::Args)]
#[command(next_help_heading = "Scanner")]
pub(crate) struct Scanner {
    /// paper: 8000 to 35000 random rays' hits from one place on a ground of 10 m × 10 m;
    /// terrestrial: from a tripod at stations around the tree; mobile: from a vehicle that passes;
    /// airborne: in parallel tracks from 50 m above the top.
    #[arg(long, default_value = "paper", value_name = "NAME")]
    pub(crate) pattern: PatternName,
    /// Places, passes or tracks [default: 1, 4, 1 or 3].
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) stations: Option<u16>,
    /// Angle between two beams in degrees [default: 0.1, mobile 0.2, airborne 0.05]; the paper's
    /// rays are random.
    #[arg(long, value_name = "DEG", allow_negative_numbers = true)]
    pub(crate) step: Option<f64>,
    /// Standard deviation of the range in metres [default: 0, 0.003, 0.01 or 0.02].
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub(crate) noise: Option<f64>,
    /// Full angle of a beam in mrad; what it meets within 0.4 m is averaged, which gives mixed
    /// pixels [default: 0, 0.35, 0.5 or 0.5].
    #[arg(long, value_name = "MRAD", allow_negative_numbers = true)]
    pub(crate) divergence: Option<f64>,
    /// The most points [default: all; for the paper, drawn from 8000 to 35000].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) points: Option<u32>,
}

/// The patterns by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum PatternName {
    Paper,
    Terrestrial,
    Mobile,
    Airborne,
}

impl From<PatternName> for deeptree_scan::Kind {
    fn from(name: PatternName) -> Self {
        match name {
            PatternName::Paper => Self::Paper,
            PatternName::Terrestrial => Self::Terrestrial,
            PatternName::Mobile => Self::Mobile,
            PatternName::Airborne => Self::Airborne,
        }
    }
}

#[derive(clap::Args)]
pub(crate) struct Reconstruct {
    /// The cloud: .xyz .txt .csv .asc .pts .ply .las .laz; metres.
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) out: Out,
    /// Write the tree in the cloud's axes and coordinates, or in its own: y up, the foot at the
    /// origin.
    #[arg(long, value_enum, default_value = "cloud", value_name = "FRAME")]
    pub(crate) frame: Frame,
    /// Which coordinate of the cloud points upwards, where the file does not say.
    #[arg(long, value_enum, default_value = "z", value_name = "AXIS")]
    pub(crate) up: UpAxis,
    /// Where the stem's foot is, in the cloud's coordinates [default: found].
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = place)]
    pub(crate) root: Option<Place3>,
    /// Species that the networks take the tree for [default: the one whose networks expect its forks
    /// most].
    #[arg(long, value_name = "NAME", conflicts_with = "no_prior")]
    pub(crate) species: Option<String>,
    /// Let the networks grow branches of which the scanner saw nothing, for a tree that looks whole.
    #[arg(long, conflicts_with = "no_prior")]
    pub(crate) complete: bool,
    /// Geometry alone, without networks.
    #[arg(long)]
    pub(crate) no_prior: bool,
    /// Points this near to a branch need none of their own, in metres; less gives more and finer
    /// branches [default: 0.26 % of the cloud's longest side].
    #[arg(long, value_name = "M", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) cover: Option<f32>,
    /// Seed of what the networks draw.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Write the tree as a table of cylinders, too (.csv).
    #[arg(long, value_name = "FILE")]
    pub(crate) qsm: Option<PathBuf>,
    /// Write the cloud with branch, order and node of each point, too (.xyz .ply).
    #[arg(long, value_name = "FILE")]
    pub(crate) labels: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
}

/// Where a reconstructed tree stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Frame {
    /// Where the cloud is.
    Cloud,
    /// y up, the foot at the origin.
    Tree,
}

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum UpAxis {
    /// As trees.
    Y,
    /// As scanners.
    Z,
}

impl From<UpAxis> for deeptree_cloud::Up {
    fn from(axis: UpAxis) -> Self {
        match axis {
            UpAxis::Y => Self::Y,
            UpAxis::Z => Self::Z,
        }
    }
}

/// A place with all digits of a land survey.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place3(pub(crate) [f64; 3]);

fn place(text: &str) -> Result<Place3, String> {
    let number = |text: &str| text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    let list: Option<Vec<f64>> = text.split(',').map(number).collect();
    let list = list.ok_or("it must be three finite numbers")?;
    let array = <[f64; 3]>::try_from(list);
    array.map(Place3).map_err(|list| format!("it must be 3 numbers, not {}", list.len()))
}
