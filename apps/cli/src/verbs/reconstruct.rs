//! `reconstruct`: a tree from a point cloud.

use std::io::Write;
use std::path::Path;
use std::time::Instant;

use anyhow::{Context, Result, bail};
use deeptree_cloud::{Cloud, ReadOptions, Up};
use deeptree_export::write_atomically;
use deeptree_graph::{BranchGraph, Quat, Seed, Vec3, branches};
use deeptree_infer::Model;
use deeptree_mesh::{Mesh, wood};
use deeptree_reconstruct::fit::{Distances, SAMPLES, Surface};
use deeptree_reconstruct::{
    Figures, Fit, Options, ReconstructError, Reconstruction, placed, reconstruct, wood_options,
    write_cylinders,
};
use serde_json::{Value, json};

use super::render::preview;
use crate::args::{self, Args, Frame, UsageError};
use crate::batch::Made;
use crate::clouds::{self, CloudFormat};
use crate::format::Format;
use crate::output::{self, Target, is_stdout};
use crate::report;

/// Points that are read at most; of more, one a voxel is kept.
const MOST_READ: usize = 1_000_000;

/// Coordinates up to this are written as they are; farther ones relative to the cloud's origin, since
/// tree files hold `f32`: there a quarter of a millimetre is left of them.
const NEAR: f64 = 4096.0;

pub(crate) fn run(args: &Args, verb: &args::Reconstruct) -> Result<()> {
    let mut target = Target::new(&verb.out.output, verb.out.format, 1, &verb.out.mesh)?;
    target.mesh.as_scanned = true;
    preview::check(&verb.out)?;
    if target.format == Format::Dtree {
        bail!(output::seed_files_are_generated());
    }
    if target.folder {
        bail!(UsageError("name the file to write, with its extension".into()));
    }
    let labels = verb.labels.as_deref();
    let labels = labels.map(|path| Ok::<_, UsageError>((path, CloudFormat::of(path, None)?)));
    let labels = labels.transpose()?;
    let options = ReadOptions { limit: Some(MOST_READ), up: verb.up.into() };
    let read = clouds::read(args, &verb.input, &options)?;
    let frame = InFile { up: read.up, origin: read.origin };
    let mut cloud = read.with_up(Up::Y);
    let model = if verb.no_prior { None } else { Some(verb.model.load()?) };
    let start = Instant::now();
    let made = make(verb, &frame, &cloud, model.as_ref())?;
    let seconds = start.elapsed().as_secs_f64();
    say_points(args, &made);

    let local: Vec<Vec3> =
        cloud.points.iter().filter(|p| p.is_finite()).map(|&p| p - made.foot).collect();
    let mesh = wood(&made.tree, &wood_options());
    let fit = Fit::new(&local, &mesh, SAMPLES);
    let offset = if verb.frame == Frame::Tree { [0.0; 3] } else { frame.offset() };
    let tree = match verb.frame {
        Frame::Tree => made.tree.clone(),
        Frame::Cloud => frame.tree(&made),
    };
    target.write(|take| {
        let seed = verb.seed;
        take(&Made {
            seed,
            number: 0,
            tree,
            at: Vec3::ZERO,
            germ: None,
            hit_budget: false,
            avoided: None,
        })
    })?;
    preview::take(&verb.out, &made.tree)?;
    if let Some(path) = &verb.qsm {
        write_table(path, &made, &frame, verb.frame)?;
    }
    if let Some((path, format)) = labels {
        label(&mut cloud, &made, &mesh);
        clouds::write(path, format, &cloud.with_up(frame.up))?;
    }
    let figures = figures(&made, &fit, seconds, offset);
    let text = text(&figures, &verb.out.output);
    report::say(args, &figures, &text, is_stdout(&verb.out.output));
    Ok(())
}

fn make(
    verb: &args::Reconstruct,
    frame: &InFile,
    cloud: &Cloud,
    model: Option<&Model>,
) -> Result<Reconstruction> {
    let root = verb.root.map(|root| frame.to_cloud(root.0));
    let options = Options {
        root,
        cover: verb.cover,
        prior: model.map(|model| model as _),
        species: verb.species.clone(),
        complete: verb.complete,
        seed: Seed(verb.seed),
        ..Options::default()
    };
    reconstruct(&cloud.points, &options).map_err(|error| match error {
        ReconstructError::UnknownSpecies { .. }
        | ReconstructError::NotPositive { .. }
        | ReconstructError::Root { .. } => UsageError(error.to_string()).into(),
        error => anyhow::Error::new(error)
            .context(format!("no tree can be made of {}", verb.input.display())),
    })
}

/// What of the cloud was not worked on, on standard error.
fn say_points(args: &Args, made: &Reconstruction) {
    if args.quiet {
        return;
    }
    if made.ground > 0 {
        eprintln!("deeptree: {} points of the ground were left out", made.ground);
    }
    if made.left_out > 0 {
        eprintln!(
            "deeptree: {} of {} points were left out, too far from the rest to be of this tree",
            made.left_out, made.points
        );
    }
    if made.points >= deeptree_reconstruct::MOST_POINTS * 6 / 10 {
        eprintln!(
            "deeptree: the cloud was thinned to {} points, one in each cube of {:.3} m",
            made.points, made.voxel
        );
    }
}

/// How a file says where things are.
pub(crate) struct InFile {
    up: Up,
    /// What the cloud's points are relative to, as the file has its axes.
    origin: [f64; 3],
}

impl InFile {
    /// From y up to the file's axes.
    fn turn(&self) -> Quat {
        match self.up {
            Up::Y => Quat::IDENTITY,
            Up::Z => Quat::from_rotation_x(core::f32::consts::FRAC_PI_2),
        }
    }

    /// A direction, y up, in the file's axes: no digit is lost.
    fn axes(&self, v: Vec3) -> Vec3 {
        match self.up {
            Up::Y => v,
            Up::Z => Vec3::new(v.x, 0.0 - v.z, v.y),
        }
    }

    /// A place in the file's coordinates, relative to the origin and y up.
    fn to_cloud(&self, place: [f64; 3]) -> Vec3 {
        let [x, y, z] = std::array::from_fn(|k| (place[k] - self.origin[k]) as f32);
        match self.up {
            Up::Y => Vec3::new(x, y, z),
            Up::Z => Vec3::new(x, z, 0.0 - y),
        }
    }

    /// What the coordinates of tree files are relative to.
    fn offset(&self) -> [f64; 3] {
        let is_near = self.origin.iter().all(|c| c.abs() <= NEAR);
        if is_near { [0.0; 3] } else { self.origin }
    }

    fn tree(&self, made: &Reconstruction) -> BranchGraph {
        let offset = self.offset();
        let rest: [f32; 3] = std::array::from_fn(|k| (self.origin[k] - offset[k]) as f32);
        placed(&made.tree, self.turn(), self.axes(made.foot) + Vec3::from_array(rest))
    }
}

fn write_table(path: &Path, made: &Reconstruction, frame: &InFile, asked: Frame) -> Result<()> {
    let is_tree = asked == Frame::Tree;
    let place = |p: Vec3| {
        if is_tree {
            return p.to_array().map(f64::from);
        }
        let relative = frame.axes(p + made.foot).to_array();
        std::array::from_fn(|k| frame.origin[k] + f64::from(relative[k]))
    };
    let turn = |v: Vec3| if is_tree { v } else { frame.axes(v) };
    let write = |out: &mut std::io::BufWriter<std::fs::File>| {
        write_cylinders(&made.tree, place, turn, out)?;
        out.flush()
    };
    write_atomically(path, write).with_context(|| format!("cannot write {}", path.display()))
}

/// Gives each point the branch, order and node whose surface it is nearest to.
fn label(cloud: &mut Cloud, made: &Reconstruction, mesh: &Mesh) {
    let surface = Surface::new(mesh);
    let mut branch_of = vec![0; made.tree.len()];
    for (branch, path) in (0..).zip(branches(&made.tree)) {
        path.nodes.iter().for_each(|&node| branch_of[node as usize] = branch);
    }
    let node = |p: &Vec3| {
        let triangle = surface.nearest(*p - made.foot).map(|(triangle, _)| triangle as usize);
        triangle.map_or(0, |triangle| mesh.nodes[mesh.indices[3 * triangle] as usize])
    };
    let nodes: Vec<u32> = cloud.points.iter().map(node).collect();
    let columns = &mut cloud.columns;
    columns.branch = Some(nodes.iter().map(|&node| branch_of[node as usize]).collect());
    columns.order = Some(nodes.iter().map(|&node| made.tree.node(node).order).collect());
    columns.node = Some(nodes);
}

/// All that is to say, for `--json`.
fn figures(made: &Reconstruction, fit: &Fit, seconds: f64, offset: [f64; 3]) -> Value {
    let Figures { height, dbh, crown_radius, volume, length, length_of_order, branches } =
        Figures::of(&made.tree);
    let distances = |of: &Distances| {
        json!({
            "mean_m": of.mean(),
            "median_m": of.quantile(0.5),
            "p95_m": of.quantile(0.95),
            "within_1_percent": of.share_within(0.01 * height),
            "within_5_cm": of.share_within(0.05),
        })
    };
    json!({
        "species": made.tree.info.species,
        "points": made.points,
        "ground_points": made.ground,
        "points_left_out": made.left_out,
        "nodes": made.tree.len(),
        "completed_nodes": made.completed,
        "branches": branches,
        "height_m": height,
        "dbh_m": dbh,
        "crown_radius_m": crown_radius,
        "wood_volume_m3": volume,
        "skeleton_length_m": length,
        "length_by_order_m": length_of_order,
        "cloud_to_tree": distances(&fit.cloud_to_tree),
        "tree_to_cloud": distances(&fit.tree_to_cloud),
        "f_1_percent": fit.f_score(0.01 * height),
        "f_5_cm": fit.f_score(0.05),
        "offset_m": offset,
        "seconds": seconds,
    })
}

fn text(figures: &Value, place: &Path) -> String {
    let number = |key: &str| figures[key].as_f64().unwrap_or_default();
    let species = match figures["species"].as_str().unwrap_or_default() {
        "" => String::new(),
        name => format!("most like {name}, "),
    };
    let dbh = figures["dbh_m"].as_f64().map_or(String::new(), |d| format!("DBH {d:.3} m, "));
    let offset = &figures["offset_m"];
    let is_moved = (0..3).any(|k| offset[k].as_f64().unwrap_or_default() != 0.0);
    let relative =
        if is_moved { format!(", coordinates relative to {offset}") } else { String::new() };
    format!(
        "{species}{} nodes, {:.2} m high, {dbh}{:.3} m³ of wood, {:.0} m of branches; F {:.3} at 1 % of \
         the height, {:.3} at 5 cm; {:.2} s → {}{relative}",
        figures["nodes"],
        number("height_m"),
        number("wood_volume_m3"),
        number("skeleton_length_m"),
        number("f_1_percent"),
        number("f_5_cm"),
        number("seconds"),
        place.display(),
    )
}
