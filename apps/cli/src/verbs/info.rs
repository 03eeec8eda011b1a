//! `info`: what is in a file.

use std::path::Path;

use anyhow::{Context, Result};
use deeptree_cloud::ReadOptions;
use deeptree_dataset::{Corpus, STANDS_FILE, Stands};
use deeptree_eval::{Row, TreeMetrics};
use deeptree_graph::{Occupancy, Vec3};
use deeptree_infer::{Model, Predictor};
use deeptree_scene::BoxShape;
use serde_json::{Value, json};

use crate::args::{self, Args};
use crate::{clouds, input, output, place, report};

pub(crate) fn run(args: &Args, verb: &args::Info) -> Result<()> {
    let path = &verb.file;
    let (figures, text) = if path.join(STANDS_FILE).exists() {
        stands(path)?
    } else if path.is_dir() {
        corpus(path)?
    } else if path.extension().is_some_and(|extension| extension == "safetensors") {
        model(path)?
    } else if path.extension().is_some_and(|extension| extension == "toml") {
        scene(path)?
    } else if clouds::holds_points(path) {
        let figures = clouds::figures(&clouds::read(args, path, &ReadOptions::default())?);
        let text = clouds::text(&figures);
        (figures, text)
    } else {
        trees(verb)?
    };
    report::say(args, &figures, &text, false);
    Ok(())
}

/// A table of more trees than this is told in sums only.
const LISTED: usize = 8;

fn trees(verb: &args::Info) -> Result<(Value, String)> {
    let mut figures = Vec::new();
    let mut lines = Vec::new();
    let mut sums: Vec<Row> = Vec::new();
    input::read(&verb.file, &verb.model, |number, made| {
        let tree = &made.tree;
        if figures.len() < LISTED {
            let figure = report::tree_figures(tree);
            lines.push(format!("tree {number}: {}", report::tree_text(&figure)));
            figures.push(figure);
        }
        let known = sums.iter().position(|row| row.species == tree.info.species);
        let row = known.unwrap_or_else(|| {
            sums.push(Row::new(&tree.info.species, "file"));
            sums.len() - 1
        });
        sums[row].add(&TreeMetrics::of(tree), made.hit_budget);
        Ok(true)
    })?;
    if sums.iter().map(|row| row.trees).sum::<u64>() > LISTED as u64 {
        let text: Vec<String> = sums.iter().map(Row::text).collect();
        return Ok((json!({ "sums": sums }), text.join("").trim_end().to_owned()));
    }
    Ok((json!({ "trees": figures }), lines.join("\n")))
}

fn model(path: &Path) -> Result<(Value, String)> {
    let bytes = std::fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
    let model =
        Model::from_bytes(&bytes).with_context(|| format!("{} is no model", path.display()))?;
    let roots: Vec<usize> = (0..model.species().len()).map(|s| model.roots(s).len()).collect();
    let trends = (0..model.species().len()).filter(|&s| model.trend(s).is_some()).count();
    let figures = json!({
        "kind": model.kind().name(),
        "species": model.species(),
        "roots": roots,
        "trends": trends,
        "weights": model.weight_count(),
        "bytes": bytes.len(),
        "hash": output::hex(model.hash()),
    });
    let text = format!(
        "model of kind {}: {} weights, {} bytes, hash {}\nspecies: {}\nroots to start from: {}, trends over age and gravitropism: {trends}",
        model.kind(),
        model.weight_count(),
        bytes.len(),
        output::hex(model.hash()),
        model.species().join(", "),
        roots.iter().sum::<usize>()
    );
    Ok((figures, text))
}

fn scene(path: &Path) -> Result<(Value, String)> {
    let scene = place::scene(path)?;
    let grid = scene.occupancy();
    let mut lines = Vec::new();
    for (i, cuboid) in scene.boxes().iter().enumerate() {
        let [low, high] = cuboid.bounds();
        lines.push(format!("box {}: {}", i + 1, extent(low, high)));
    }
    let mut meshes = Vec::new();
    for mesh in scene.meshes() {
        let faces = mesh.mesh.triangles().len();
        let solid = mesh.mesh.solid().iter().filter(|&&solid| solid).count();
        let [low, high] = mesh.mesh.bounds();
        let kind = match (solid, mesh.mesh.open_edges()) {
            (_, 0) => "solid".to_owned(),
            (0, open) => format!("a sheet with {open} open edges"),
            (solid, open) => format!("{solid} of them solid, the others with {open} open edges"),
        };
        let place = extent(low, high);
        lines.push(format!("mesh {}: {faces} faces, {kind}; {place}", mesh.file));
        meshes.push(json!({
            "file": mesh.file,
            "faces": faces,
            "solid_faces": solid,
            "open_edges": mesh.mesh.open_edges(),
            "min": low.to_array(),
            "max": high.to_array(),
        }));
    }
    let boxes: Vec<Value> = scene
        .boxes()
        .iter()
        .map(|cuboid| match cuboid.shape() {
            BoxShape::Aligned { min, max } => {
                json!({ "min": min.to_array(), "max": max.to_array() })
            }
            BoxShape::Turned { center, half, yaw } => {
                json!({ "center": center.to_array(), "half": half.to_array(), "yaw": yaw })
            }
        })
        .collect();
    let sky = scene.sky(Vec3::Y).free;
    let bounds = scene.bounds();
    lines.insert(
        0,
        format!(
            "scene of {} and {}: {} of {} voxels taken, {:.0} % of the sky free a metre over the \
             foot",
            counted(boxes.len(), "box", "boxes"),
            counted(meshes.len(), "mesh", "meshes"),
            grid.count(),
            Occupancy::SIDE.pow(3),
            100.0 * sky
        ),
    );
    let figures = json!({
        "boxes": boxes,
        "meshes": meshes,
        "faces": scene.meshes().iter().map(|mesh| mesh.mesh.triangles().len()).sum::<usize>(),
        "occupied_voxels": grid.count(),
        "free_sky": sky,
        "min": bounds.map(|[low, _]| low.to_array()),
        "max": bounds.map(|[_, high]| high.to_array()),
    });
    Ok((figures, lines.join("\n")))
}

fn counted(n: usize, one: &str, more: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { more })
}

/// Where something is, in metres.
fn extent(low: Vec3, high: Vec3) -> String {
    let axis = |name, k: usize| format!("{name} {:.2} to {:.2}", low[k], high[k]);
    format!("{}, {}, {} m", axis("x", 0), axis("y", 1), axis("z", 2))
}

fn corpus(path: &Path) -> Result<(Value, String)> {
    let corpus = Corpus::open(path).with_context(|| format!("{} is no corpus", path.display()))?;
    let plan = corpus.plan();
    let hash = corpus.hash()?;
    let figures = json!({
        "species": plan.species,
        "trees": plan.trees,
        "training_trees": plan.training_trees,
        "first_seed": plan.first_seed,
        "profile": plan.profile,
        "ages": plan.ages,
        "gravitropisms": plan.gravitropisms,
        "scenes": plan.scenes,
        "forms": plan.forms,
        "hash": hash,
    });
    let scenes = if plan.scenes { ", each in a scene of its own" } else { "" };
    let forms = plan.forms.as_ref().map(|forms| format!(", in the forms {}", forms.join(", ")));
    let text = format!(
        "corpus of {} trees of each of {} ({} for training){scenes}{}, seeds from {}, profile {}, hash {hash}",
        plan.trees,
        plan.species.join(", "),
        plan.training_trees,
        forms.unwrap_or_default(),
        plan.first_seed,
        plan.profile,
    );
    Ok((figures, text))
}

fn stands(path: &Path) -> Result<(Value, String)> {
    let corpus = Stands::open(path)?;
    let plan = corpus.plan();
    let hash = corpus.hash()?;
    let text = format!(
        "corpus of {} stands ({} for training) of {}, seeds from {}, profile {}, hash {hash}",
        plan.stands,
        plan.training_stands,
        plan.species.join(", "),
        plan.first_seed,
        plan.profile,
    );
    Ok((json!({ "plan": plan, "hash": hash }), text))
}
