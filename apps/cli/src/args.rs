//! What the command line can say.

mod clouds;
mod pictures;

use std::path::PathBuf;

use clap::{Parser, Subcommand};
use deeptree_dataset::Span;
use deeptree_growth::Profile;

pub(crate) use clouds::*;
pub(crate) use pictures::*;

use crate::format::Format;
use crate::look::LookArgs;

/// A request that no run could fulfil: exit code 2.
#[derive(Debug)]
pub(crate) struct UsageError(pub(crate) String);

impl std::fmt::Display for UsageError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for UsageError {}

/// Trees from neural networks: grow, learn, generate, export.
#[derive(Parser)]
#[command(version, about, propagate_version = true)]
pub(crate) struct Args {
    #[command(subcommand)]
    pub(crate) verb: Verb,
    /// Print nothing but errors.
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
    /// Print the figures as JSON.
    #[arg(long, global = true)]
    pub(crate) json: bool,
}

#[derive(Subcommand)]
pub(crate) enum Verb {
    /// Grow trees from trained networks.
    Generate(Generate),
    /// Grow trees from the procedural model that the networks learn from.
    Grow(Grow),
    /// Prune a tree and grow it again from its wounds.
    Regrow(Regrow),
    /// Scan a tree with a simulated laser scanner.
    Scan(Scan),
    /// Make a tree of a point cloud.
    Reconstruct(Reconstruct),
    /// Grow a corpus to train on, in Parquet.
    Dataset(Dataset),
    /// Train networks on a corpus.
    Train(Train),
    /// Measure generated trees beside grown ones, and both beside the paper's figures.
    Evaluate(Evaluate),
    /// Take a picture of a tree, path-traced in the light of sky and sun.
    Render(Render),
    /// Say what is in a file.
    Info(Info),
    /// Convert a tree or a point cloud between formats.
    Convert(Convert),
}

/// What to write, and where.
#[derive(clap::Args)]
pub(crate) struct Out {
    /// Where to: a file (.glb .gltf .obj .ply .usda .usdz .tree .csv .parquet .dtree), a folder when there are
    /// several trees (a stand may be one .glb or .gltf), or - for standard output.
    #[arg(long, short, value_name = "FILE|DIR|-")]
    pub(crate) output: PathBuf,
    /// The format, where the name of the output does not say it [default: glb].
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<Format>,
    /// A quick picture, too, of the first tree, or of a stand as a whole: .png.
    #[arg(long, value_name = "PNG")]
    pub(crate) preview: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
}

/// How trees are meshed: for .glb, .gltf, .obj, .ply, .usda and .usdz.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Meshes")]
pub(crate) struct MeshArgs {
    /// As a scanner saw it: no flare at the foot, no flutes.
    #[arg(skip)]
    pub(crate) as_scanned: bool,
    /// Level of detail of meshes, 0 (finest) to 3.
    #[arg(long, default_value_t = 0, value_parser = clap::value_parser!(u8).range(0..=3))]
    pub(crate) lod: u8,
    /// The finest mesh of at most so many triangles, in place of a level of detail.
    #[arg(long, value_name = "N", conflicts_with = "lod", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) max_triangles: Option<u32>,
    /// One tube a branch, pushed into one another at forks, in place of one closed surface: fewer
    /// triangles.
    #[arg(long)]
    pub(crate) tubes: bool,
    /// Fissures in the bark of thick wood, as deep as this in metres [without a number: 0.02].
    #[arg(long, value_name = "M", num_args = 0..=1, require_equals = true, default_missing_value = "0.02", conflicts_with = "tubes", value_parser = finite)]
    pub(crate) bark: Option<f32>,
    /// Texels of bark of one size all over the tree, with a seam along each limb, in place of a texture
    /// that goes around each without one and is finer where the limb is thinner.
    #[arg(long, conflicts_with = "tubes")]
    pub(crate) even_texels: bool,
    /// All levels of detail, 0 to 3: in one .glb or .gltf by MSFT_lod; with =files, and in other
    /// formats, in files of their own, tree_lod0.obj and so on.
    #[arg(long, value_name = "one|files", num_args = 0..=1, require_equals = true, default_missing_value = "one", conflicts_with_all = ["lod", "max_triangles", "animate_growth"], value_enum)]
    pub(crate) lods: Option<Lods>,
    /// After the levels of detail, so many crossed cards with pictures of the tree, path-traced in
    /// even light; in files of their own, tree_impostor.obj [without a number: 2].
    #[arg(long, value_name = "CARDS", num_args = 0..=1, require_equals = true, default_missing_value = "2", requires = "lods", value_parser = clap::value_parser!(u32).range(1..=16))]
    pub(crate) impostor: Option<u32>,
    /// An animation in .glb and .gltf in which the tree unfolds from a seedling to its full shape, in
    /// so many seconds [without a number: 10].
    #[arg(long, value_name = "SECONDS", num_args = 0..=1, require_equals = true, default_missing_value = "10", conflicts_with = "instancing", value_parser = seconds)]
    pub(crate) animate_growth: Option<f32>,
    /// Leaves in .glb and .gltf as copies of one blade, by EXT_mesh_gpu_instancing: small files, for
    /// programs that know it. In .usda and .usdz they always are copies.
    #[arg(long)]
    pub(crate) instancing: bool,
    /// More attributes of vertices in .glb and .gltf: tangents, labels (branch, order, node), wind (pivot,
    /// phase, stiffness) or all.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_enum)]
    pub(crate) attributes: Vec<Attribute>,
    #[command(flatten)]
    pub(crate) look: LookArgs,
}

/// Where levels of detail go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Lods {
    /// Into one file, where the format can.
    One,
    /// Into files of their own.
    Files,
}

/// Attributes of vertices in GLB files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Attribute {
    /// For normal maps.
    Tangents,
    /// `_BRANCH`, `_ORDER`, `_NODE`.
    Labels,
    /// `_PIVOT`, `_PHASE`, `_STIFFNESS`.
    Wind,
    /// All of them.
    All,
}

/// Which trees.
#[derive(clap::Args)]
pub(crate) struct Which {
    /// Seed of the first tree; the next ones have the numbers after it.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// How many trees.
    #[arg(long, default_value_t = 1, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) count: u32,
    /// Age in growth cycles.
    #[arg(long, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) age: Option<f32>,
    /// Gravitropism: negative grows up, positive droops.
    #[arg(long, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) gravitropism: Option<f32>,
    /// Threads [default: one a core].
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) threads: Option<u16>,
}

#[derive(clap::Args)]
pub(crate) struct Generate {
    /// Name of the species: beech, corkscrew, maple, oak, pine, tulip, walnut or willow. With a
    /// stand, that of the trees whose rows name none.
    #[arg(required_unless_present_any = ["blend", "stand"], conflicts_with = "blend")]
    pub(crate) species: Option<String>,
    /// Trees that grow together and crowd each other: a table (.csv) with x, z, species, seed and,
    /// where it is not that of the others, age of each in a row. They are written at their places.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["seed", "count", "form", "blend"])]
    pub(crate) stand: Option<PathBuf>,
    /// A species between species, with the weight of each, such as oak:0.7,willow:0.3. It is an
    /// interpolation of what the networks learned of them: nothing of the kind was ever grown, and
    /// nothing says how such a tree should look.
    #[arg(long, value_name = "LIST")]
    pub(crate) blend: Option<String>,
    #[command(flatten)]
    pub(crate) which: Which,
    #[command(flatten)]
    pub(crate) place: Place,
    #[command(flatten)]
    pub(crate) out: Out,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
    /// Height of the tree in metres; what is not asked for is drawn to go with what is.
    #[arg(long, value_name = "M", value_parser = finite)]
    pub(crate) height: Option<f32>,
    /// Distance of the outermost branch from the axis in metres.
    #[arg(long, value_name = "M", value_parser = finite)]
    pub(crate) crown_radius: Option<f32>,
    /// Number of branches.
    #[arg(long, value_name = "N", value_parser = finite)]
    pub(crate) branches: Option<f32>,
    /// Length of the trunk in metres.
    #[arg(long, value_name = "M", value_parser = finite)]
    pub(crate) trunk: Option<f32>,
    /// Take the nearest that the model has seen where it is asked for more or less, with a warning.
    #[arg(long)]
    pub(crate) force: bool,
    /// Nodes a tree may have.
    #[arg(long, default_value_t = deeptree_generate::DEFAULT_BUDGET as u32, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) budget: u32,
    /// Nodes that go through the networks together; any number gives the same trees.
    #[arg(long, default_value_t = deeptree_generate::DEFAULT_BATCH as u32, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) batch: u32,
}

/// Which networks.
#[derive(clap::Args)]
pub(crate) struct ModelChoice {
    /// A model that ships (situated, paper) or a .safetensors file.
    #[arg(long, default_value = "situated", value_name = "NAME|FILE")]
    pub(crate) model: PathBuf,
    /// Instruction set of the networks (scalar sse2 avx2 avx512 neon simd128); any gives the same
    /// trees [default: the widest this processor has].
    #[arg(long, value_name = "SET")]
    pub(crate) simd: Option<deeptree_infer::SimdPath>,
}

/// What stands around a tree, and where it is kept in.
#[derive(clap::Args)]
pub(crate) struct Place {
    /// A scene file (.toml): boxes and meshes that nothing grows through and that hide the sky.
    #[arg(long, value_name = "FILE")]
    pub(crate) obstacles: Option<PathBuf>,
    /// Keep the tree within a cone, a cube, a ring or a closed mesh (.glb .obj) around the origin.
    #[arg(long, value_name = "cone|cube|ring|FILE")]
    pub(crate) form: Option<String>,
}

#[derive(clap::Args)]
pub(crate) struct Grow {
    /// Name of the species: beech, corkscrew, maple, oak, pine, tulip, walnut or willow. With a
    /// stand, that of the trees whose rows name none.
    #[arg(required_unless_present = "stand")]
    pub(crate) species: Option<String>,
    /// Trees that grow together and crowd each other: a table (.csv) with x, z, species, seed and,
    /// where it is not that of the others, age of each in a row. They are written at their places.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["seed", "count", "form"])]
    pub(crate) stand: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) which: Which,
    #[command(flatten)]
    pub(crate) place: Place,
    #[command(flatten)]
    pub(crate) out: Out,
    /// The numbers of the species: reference reproduces the paper's statistics, published is its
    /// printed table.
    #[arg(long, default_value = "reference", value_parser = profile)]
    pub(crate) profile: Profile,
}

#[derive(clap::Args)]
pub(crate) struct Regrow {
    /// The tree to prune: .tree .csv .parquet .dtree.
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) cuts: Cuts,
    /// Seed of what grows; the trees of a table have the numbers from it on.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    #[command(flatten)]
    pub(crate) place: Place,
    #[command(flatten)]
    pub(crate) out: Out,
    /// Write the pruned tree, too: .glb .gltf .obj .ply .usda .usdz .tree .csv .parquet.
    #[arg(long, value_name = "FILE")]
    pub(crate) pruned: Option<PathBuf>,
    /// Which tree of a table of several.
    #[arg(long, value_name = "NUMBER")]
    pub(crate) tree: Option<u32>,
    /// The species of the tree, whatever the file says [default: what the file says].
    #[arg(long, value_name = "NAME")]
    pub(crate) species: Option<String>,
    /// Age of the tree in growth cycles [default: what the file says, or else the species' own].
    #[arg(long, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) age: Option<f32>,
    /// Gravitropism of the tree [default: what the file says, or else the species' own].
    #[arg(long, allow_negative_numbers = true, value_parser = finite)]
    pub(crate) gravitropism: Option<f32>,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
    /// Nodes a tree may have; what was kept is kept even if it has more.
    #[arg(long, default_value_t = deeptree_generate::DEFAULT_BUDGET as u32, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) budget: u32,
    /// Nodes that go through the networks together; any number gives the same trees.
    #[arg(long, default_value_t = deeptree_generate::DEFAULT_BATCH as u32, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) batch: u32,
}

/// What to cut off: each node that any of these says, with all that it bears. Metres, y up.
#[derive(clap::Args)]
#[group(id = "any_cut", required = true, multiple = true)]
pub(crate) struct Cuts {
    /// Cut off what is higher than this.
    #[arg(long, value_name = "H", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) keep_below: Vec<f32>,
    /// Cut off branches of higher orders than this; the trunk has order 0.
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) keep_order: Vec<u16>,
    /// Cut off what is further from the foot, along the branches, than this fraction of the
    /// longest way.
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true, value_parser = finite)]
    pub(crate) keep_path: Vec<f32>,
    /// Cut off what enters a box.
    #[arg(long, value_name = "x0,y0,z0,x1,y1,z1", allow_hyphen_values = true, value_parser = numbers::<6>)]
    pub(crate) cut_box: Vec<Numbers<6>>,
    /// Cut off what enters a ball.
    #[arg(long, value_name = "x,y,z,r", allow_hyphen_values = true, value_parser = numbers::<4>)]
    pub(crate) cut_sphere: Vec<Numbers<4>>,
    /// Cut off what is beyond a plane, where nx·x + ny·y + nz·z > d.
    #[arg(long, value_name = "nx,ny,nz,d", allow_hyphen_values = true, value_parser = numbers::<4>)]
    pub(crate) cut_plane: Vec<Numbers<4>>,
    /// Cut off the nodes whose numbers are in a file, as in the column `id` of a table that
    /// DeepTree has written.
    #[arg(long, value_name = "FILE")]
    pub(crate) cut_nodes: Vec<PathBuf>,
}

#[derive(clap::Args)]
pub(crate) struct Dataset {
    /// The species, separated by commas, or all.
    #[arg(long, default_value = "all")]
    pub(crate) species: String,
    /// Trees of each species; four fifths are for training, the rest for validation.
    #[arg(long, default_value_t = 500, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) trees: u32,
    /// Grow this many trees of each species, each in a random scene of its own: walls and boxes
    /// near it.
    #[arg(long, value_name = "N", conflicts_with = "trees", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) scenes: Option<u32>,
    /// Grow this many stands instead, of trees of all these species that crowd each other, and each
    /// of their trees by itself, too: for `train --only competition`.
    #[arg(long, value_name = "N", conflicts_with_all = ["trees", "scenes", "form", "ages", "gravitropisms", "scans"], value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) stands: Option<u32>,
    /// Keep the trees within these forms, separated by commas: cone, cube, ring. There are --trees
    /// of each species in each form; their numbers take turns.
    #[arg(long, value_name = "LIST")]
    pub(crate) form: Option<String>,
    /// Seed of the first tree of each species.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// The numbers of the species.
    #[arg(long, default_value = "reference", value_parser = profile)]
    pub(crate) profile: Profile,
    /// Draw each tree's age from these growth cycles, both ends of a range included, such as
    /// 10..22,28..40 [default: the age of the profile].
    #[arg(long, value_name = "RANGES", value_parser = spans::<u32>)]
    pub(crate) ages: Option<Spans<u32>>,
    /// Draw each tree's gravitropism from these values, such as -0.4..-0.25,0.25..0.4 [default:
    /// that of the profile].
    #[arg(long, value_name = "RANGES", allow_hyphen_values = true, value_parser = spans::<f64>)]
    pub(crate) gravitropisms: Option<Spans<f64>>,
    /// A simulated scan of each tree, too, as `scan` makes it by default: a table of points beside
    /// each shard, y up as the trees.
    #[arg(long)]
    pub(crate) scans: bool,
    /// The corpus' folder; a corpus begun there is continued.
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct Train {
    /// The corpus' folder; several make one training set of the species of the first.
    #[arg(required = true)]
    pub(crate) data: Vec<PathBuf>,
    /// situated, paper for the published recipe, or joint for the one network that the paper
    /// compares its recipe with.
    #[arg(long, default_value = "situated", value_parser = ["situated", "paper", "joint"])]
    pub(crate) kind: String,
    /// Train on these species of the corpus only, separated by commas, or all.
    #[arg(long, default_value = "all")]
    pub(crate) species: String,
    /// Attributes of a node that the classifier of kind paper reads, separated by commas, or all:
    /// p t dr ds qp lp o mp a v s.
    #[arg(long, default_value = "all", value_name = "LIST")]
    pub(crate) classifier_attributes: String,
    /// Attributes of a node that the regressors of kind paper read.
    #[arg(long, default_value = "all", value_name = "LIST")]
    pub(crate) regressor_attributes: String,
    /// Seed of the weights and of the order of the samples.
    #[arg(long, default_value_t = 0, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// Epochs of every network [default: what each needs].
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) epochs: Option<u32>,
    /// Samples an epoch looks at [default: what the kind needs].
    #[arg(long, value_parser = clap::value_parser!(u64).range(1..))]
    pub(crate) samples: Option<u64>,
    /// Use only the first N training trees of each species of a corpus.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) trees: Option<u32>,
    /// Train these networks only, separated by commas, and keep the others of --model: for a change
    /// that no other network learns anything of. The networks `competition` (from corpora of stands)
    /// and `points` (from a corpus with scans) are only trained so, each by itself; so is `trend`, how
    /// whole trees change with age and gravitropism (from many trees of the open field).
    #[arg(long, value_name = "LIST", value_delimiter = ',', requires = "model")]
    pub(crate) only: Vec<String>,
    /// The model that --only keeps networks of, with its .toml beside it; made of such trees with the
    /// same options.
    #[arg(long, value_name = "FILE", requires = "only")]
    pub(crate) model: Option<PathBuf>,
    /// Networks that train side by side, one thread each [default: one a core].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    pub(crate) workers: Option<u16>,
    /// cpu, cuda or wgpu; the last two need a build with that feature.
    #[arg(long, default_value = "cpu", value_parser = ["cpu", "cuda", "wgpu"])]
    pub(crate) device: String,
    /// The model to write (.safetensors); a .toml goes beside it. Training interrupted is resumed.
    #[arg(long, short, value_name = "FILE")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct Evaluate {
    /// The species, separated by commas, or all.
    #[arg(long, default_value = "all")]
    pub(crate) species: String,
    /// Trees of each species, grown and generated [default: 500, or 24 with --quick].
    #[arg(long, allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) trees: Option<u32>,
    /// The chapters, separated by commas, or all.
    #[arg(long, default_value = "all", value_name = "LIST")]
    pub(crate) chapters: String,
    /// Everything small, in a few minutes.
    #[arg(long)]
    pub(crate) quick: bool,
    /// Forests that the two-sample test fits to permuted labels, for its p and the width of its
    /// intervals; most of its time. With 0 the width is that of the widest case measured.
    #[arg(long, value_name = "N", default_value_t = 49)]
    pub(crate) refits: usize,
    /// Seed of the first tree; the default is far from the seeds of a corpus.
    #[arg(long, default_value_t = 1_000_000, allow_negative_numbers = true)]
    pub(crate) seed: u64,
    /// The numbers of the species, for the procedural model.
    #[arg(long, default_value = "reference", value_parser = profile)]
    pub(crate) profile: Profile,
    /// Which side to measure: both, the procedural model (p) or the networks (dt).
    #[arg(long, default_value = "both", value_parser = ["both", "p", "dt"])]
    pub(crate) side: String,
    /// Point clouds for the chapter reconstruction, files or folders of them, separated by commas.
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    pub(crate) clouds: Vec<PathBuf>,
    /// A Python with torch, for the chapter runtime [default: $DEEPTREE_PYTHON, or python3].
    #[arg(long, value_name = "FILE")]
    pub(crate) python: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
    /// The folder of the report: report.html, and each chapter's figures as CSV and JSON. A run
    /// that was cut off is continued.
    #[arg(long, short, value_name = "DIR")]
    pub(crate) output: PathBuf,
}

#[derive(clap::Args)]
pub(crate) struct Info {
    /// A tree, a table, a point cloud, a scene, a model or a corpus.
    pub(crate) file: PathBuf,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
}

#[derive(clap::Args)]
pub(crate) struct Convert {
    /// The tree to read (.tree .csv .parquet .dtree) or the point cloud (.xyz .txt .csv .ply .las
    /// .laz .parquet).
    pub(crate) input: PathBuf,
    #[command(flatten)]
    pub(crate) out: OutPath,
    /// Which tree of a table of several.
    #[arg(long, value_name = "NUMBER")]
    pub(crate) tree: Option<u32>,
    #[command(flatten)]
    pub(crate) model: ModelChoice,
}

/// Where `convert` writes.
#[derive(clap::Args)]
pub(crate) struct OutPath {
    /// The file to write: .glb .gltf .obj .ply .usda .usdz .tree .csv .parquet, for a point cloud
    /// .xyz .txt .csv .ply .las .laz .parquet; - for standard output.
    pub(crate) output: PathBuf,
    /// The format, where the name of the output does not say it.
    #[arg(long, value_name = "FORMAT")]
    pub(crate) format: Option<String>,
    #[command(flatten)]
    pub(crate) mesh: MeshArgs,
}

/// A list of ranges.
#[derive(Clone, Debug)]
pub(crate) struct Spans<T>(pub(crate) Vec<Span<T>>);

/// `10..22,28..40`; one number is a range of its own.
fn spans<T: std::str::FromStr + Copy>(text: &str) -> Result<Spans<T>, String> {
    let number = |text: &str| {
        let error = || format!("`{text}` is no number; write ranges as 10..22,28..40");
        text.trim().parse::<T>().map_err(|_| error())
    };
    let span = |text: &str| match text.split_once("..") {
        Some((low, high)) => Ok(Span(number(low)?, number(high)?)),
        None => number(text).map(|value| Span(value, value)),
    };
    Ok(Spans(text.split(',').map(span).collect::<Result<_, String>>()?))
}

/// So many numbers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Numbers<const N: usize>(pub(crate) [f32; N]);

impl<const N: usize> std::fmt::Display for Numbers<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0.map(|number| number.to_string()).join(","))
    }
}

/// Finite numbers separated by commas.
fn numbers<const N: usize>(text: &str) -> Result<Numbers<N>, String> {
    let list: Vec<f32> =
        text.split(',').map(|number| finite(number.trim())).collect::<Result<_, _>>()?;
    let array = <[f32; N]>::try_from(list);
    array.map(Numbers).map_err(|list| format!("it must be {N} numbers, not {}", list.len()))
}

/// `512x512`.
fn size(text: &str) -> Result<[u32; 2], String> {
    let most = deeptree_render::MAX_SIZE;
    let error = || format!("`{text}` is no size; write it as 512x512, 1 to {most} pixels a side");
    let (width, height) = text.split_once('x').ok_or_else(error)?;
    let side = |text: &str| match text.parse() {
        Ok(side) if (1..=most).contains(&side) => Ok(side),
        _ => Err(error()),
    };
    Ok([side(width)?, side(height)?])
}

fn finite(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(x) if x.is_finite() => Ok(x),
        _ => Err("it must be a finite number".to_owned()),
    }
}

/// How long an animation takes.
fn seconds(text: &str) -> Result<f32, String> {
    match finite(text)? {
        x if (0.1..=3600.0).contains(&x) => Ok(x),
        x => Err(format!("{x} seconds; give 0.1 to 3600")),
    }
}

fn profile(text: &str) -> Result<Profile, String> {
    text.parse().map_err(|error: deeptree_growth::SpeciesError| error.to_string())
}
