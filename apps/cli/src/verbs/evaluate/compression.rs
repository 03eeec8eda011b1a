//! Chapter 9: a tree as its seed beside the same tree as a graph and as a mesh.

use anyhow::Result;
use deeptree_eval::published::{COMPRESSION, PublishedSize, SEED_AND_NETWORKS, SIZE_RATIOS};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_export::gltf::{Document, Options};
use deeptree_export::obj;
use deeptree_export::tables::{TableMeta, TableWriter};
use deeptree_graph::BranchGraph;
use deeptree_graph::codec::csv::CsvWriter;
use deeptree_graph::codec::{dtree, tree_format};
use deeptree_infer::{Model, Predictor};
use deeptree_mesh::{WoodOptions, wood};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::estimate::{Estimate, bytes};
use super::study::Study;
use super::trees;
use crate::args::ModelChoice;
use crate::output::hex;

/// Trees of each species whose files are weighed.
const FULL: u32 = 100;
const QUICK: u32 = 4;

/// What is weighed, in the order of [`weigh`].
const GRAPHS: [&str; 3] = [".tree", ".csv", ".parquet"];
const MESHES: [&str; 2] = [".glb", ".obj"];
const COLUMNS: usize = 7;

/// Bytes of each format, nodes and vertices of the trees of a species.
#[derive(Serialize, Deserialize)]
struct Sizes {
    species: String,
    tree: Estimate,
    csv: Estimate,
    parquet: Estimate,
    glb: Estimate,
    obj: Estimate,
    nodes: Estimate,
    vertices: Estimate,
}

impl Sizes {
    const fn graphs(&self) -> [&Estimate; 3] {
        [&self.tree, &self.csv, &self.parquet]
    }

    const fn meshes(&self) -> [&Estimate; 2] {
        [&self.glb, &self.obj]
    }
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("compression", "Tree model compression");
    let Some(model) = &study.model else {
        chapter.text("Not measured: only the growth model was asked for, which has no seed file.");
        return Ok(chapter);
    };
    let networks = study.verb.model.bytes()?.len();
    let rows: Vec<Sizes> = study
        .species
        .iter()
        .map(|species| measure(study, model, &species.name))
        .collect::<Result<_>>()?;
    say(&mut chapter, &rows, networks);
    if study.paper.is_some() {
        let paper = ModelChoice { model: "paper".into(), simd: None }.bytes()?.len();
        chapter.text(format!(
            "The networks of the kind paper that ship take {}; its trees are not weighed, as they are \
             as large as the node budget where they do not end (chapter table, Termination).",
            bytes(paper as f64)
        ));
    }
    save(study, &rows, networks)?;
    Ok(chapter)
}

fn measure(study: &Study<'_>, model: &Model, species: &str) -> Result<Sizes> {
    study.part(&format!("compression-{species}"), || {
        let count = study.scale(FULL, QUICK).min(study.trees());
        let sizes = trees::many(study, species, study.verb.seed, count, |work, seed| {
            weigh(&trees::generated(model, species, seed, work)?.tree, model)
        })?;
        let of = |column: usize| Estimate::of(sizes.iter().map(move |row| row[column] as f64));
        Ok(Sizes {
            species: species.to_owned(),
            tree: of(0),
            csv: of(1),
            parquet: of(2),
            glb: of(3),
            obj: of(4),
            nodes: of(5),
            vertices: of(6),
        })
    })
}

/// Bytes of the tree in each format, written as `generate` writes it, without materials; nodes;
/// vertices.
fn weigh(tree: &BranchGraph, model: &Model) -> Result<[usize; COLUMNS]> {
    let mesh = wood(tree, &WoodOptions::default());
    let mut text = Vec::new();
    tree_format::write(&mut text, tree)?;
    let mut csv = CsvWriter::new(Vec::new())?;
    csv.write(0, tree)?;
    let meta = TableMeta { model: Some(hex(model.hash())) };
    let mut parquet = TableWriter::new(Vec::new(), &meta)?;
    parquet.write(0, tree)?;
    let (mut binary, mut object) = (Vec::new(), Vec::new());
    Document::new((&mesh).into(), &tree.info, Options::default())?.write_glb(&mut binary)?;
    obj::write(&mesh, &tree.info, &mut object)?;
    Ok([
        text.len(),
        csv.finish()?.len(),
        parquet.finish()?.len(),
        binary.len(),
        object.len(),
        tree.len(),
        mesh.positions.len(),
    ])
}

fn say(chapter: &mut Chapter, rows: &[Sizes], networks: usize) {
    let base = (networks + dtree::LEN) as f64;
    let over =
        |of: fn(&Sizes) -> &Estimate| Estimate::of(rows.iter().map(move |row| of(row).mean / base));
    let graphs: [fn(&Sizes) -> &Estimate; 3] = [|s| &s.tree, |s| &s.csv, |s| &s.parquet];
    let meshes: [fn(&Sizes) -> &Estimate; 2] = [|s| &s.glb, |s| &s.obj];
    let (graph, mesh) = (graphs.map(over), meshes.map(over));
    let mean = |of: fn(&Sizes) -> &Estimate| {
        rows.iter().map(|row| of(row).mean).sum::<f64>() / rows.len() as f64
    };
    let seed = dtree::LEN as f64;
    chapter.text(format!(
        "A tree is stored as {} bytes, and the networks that grow it again as {} (paper: {} bytes \
         and {}). Beside a seed with the networks, one tree as a graph is {:.2} ({}), {:.2} ({}) or \
         {:.2} ({}) times as large, and as a mesh {:.2} ({}) or {:.2} ({}); paper: {:.2} and \
         {:.2}, in formats that are not named.",
        dtree::LEN,
        bytes(networks as f64),
        SEED_AND_NETWORKS.0,
        bytes(f64::from(SEED_AND_NETWORKS.1)),
        graph[0].mean,
        GRAPHS[0],
        graph[1].mean,
        GRAPHS[1],
        graph[2].mean,
        GRAPHS[2],
        mesh[0].mean,
        MESHES[0],
        mesh[1].mean,
        MESHES[1],
        SIZE_RATIOS[0].0,
        SIZE_RATIOS[1].0,
    ));
    let nodes = mean(|sizes| &sizes.nodes);
    let sum = |of: fn(&PublishedSize) -> f64| COMPRESSION.iter().map(of).sum::<f64>();
    let published = 1e3 * sum(|row| row.graph) / sum(|row| row.nodes);
    let trees_until = |of| (networks as f64 / (mean(of) - seed)).ceil();
    chapter.text(format!(
        "The networks are stored once for all trees. Of n trees, seeds with networks are smaller \
         than graphs from n = {:.0} on ({}), {:.0} ({}) and {:.0} ({}), and than meshes from {:.0} \
         ({}) and {:.0} ({}); of many trees, a seed takes 1/{:.0} of the smallest graph. A node takes {:.0} bytes as {}, {:.0} as \
         {} and {:.0} as {}; in the paper's graphs, {:.0}.",
        trees_until(graphs[0]),
        GRAPHS[0],
        trees_until(graphs[1]),
        GRAPHS[1],
        trees_until(graphs[2]),
        GRAPHS[2],
        trees_until(meshes[0]),
        MESHES[0],
        trees_until(meshes[1]),
        MESHES[1],
        graphs.map(mean).into_iter().fold(f64::INFINITY, f64::min) / seed,
        mean(graphs[0]) / nodes,
        GRAPHS[0],
        mean(graphs[1]) / nodes,
        GRAPHS[1],
        mean(graphs[2]) / nodes,
        GRAPHS[2],
        published,
    ));
    table(chapter, rows, networks, &graph, &mesh);
}

fn table(
    chapter: &mut Chapter,
    rows: &[Sizes],
    networks: usize,
    graph: &[Estimate],
    mesh: &[Estimate],
) {
    let quiet = |text: String| Cell::new(text, Tone::Quiet);
    let spread = |e: &Estimate| format!("{} ± {}", bytes(e.mean), bytes(e.sd));
    let count = |e: &Estimate| format!("{:.1} ± {:.1}", e.mean / 1e3, e.sd / 1e3);
    let mut body = Vec::new();
    for row in rows {
        let mut cells: Vec<Cell> = vec![row.species.as_str().into()];
        cells.push(bytes((networks + dtree::LEN) as f64).into());
        cells.extend(row.graphs().map(|e| spread(e).into()));
        cells.push(count(&row.nodes).into());
        cells.extend(row.meshes().map(|e| spread(e).into()));
        cells.push(count(&row.vertices).into());
        let paper = COMPRESSION.iter().find(|paper| paper.species == row.species);
        let megabytes = |x: f64| bytes(1e6 * x);
        cells.extend(match paper {
            None => vec![quiet("–".into()); 4],
            Some(paper) => vec![
                quiet(megabytes(paper.graph)),
                quiet(format!("{:.1}", paper.nodes)),
                quiet(megabytes(paper.mesh)),
                quiet(format!("{:.0}", paper.vertices)),
            ],
        });
        body.push(cells);
    }
    let ratio = |(mean, sd): (f64, f64)| format!("{mean:.2} ± {sd:.2}");
    let ours = |e: &Estimate| Cell::from(ratio((e.mean, e.sd)));
    let mut last: Vec<Cell> = vec!["seed + networks as 1".into(), "1".into()];
    last.extend(graph.iter().map(ours));
    last.push("–".into());
    last.extend(mesh.iter().map(ours));
    last.push("–".into());
    let paper = SIZE_RATIOS.map(|both| quiet(ratio(both)));
    let [paper_graph, paper_mesh] = paper;
    last.extend([paper_graph, quiet("–".into()), paper_mesh, quiet("–".into())]);
    body.push(last);
    let trees = rows.first().map_or(0, |row| row.nodes.count);
    let caption = format!(
        "Tree model compression: mean ± standard deviation of {trees} trees a species, a file for \
         each tree; last row over the species. Beside it the paper's table, whose base is {}. kB \
         and MB are of 1000. Wood at the finest level of detail.",
        bytes(f64::from(SEED_AND_NETWORKS.0 + SEED_AND_NETWORKS.1)),
    );
    let header = [
        "species",
        "seed + networks",
        GRAPHS[0],
        GRAPHS[1],
        GRAPHS[2],
        "nodes, 1000",
        MESHES[0],
        MESHES[1],
        "vertices, 1000",
        "paper: graph",
        "nodes, 1000",
        "mesh",
        "vertices, 1000",
    ];
    chapter.table(caption, &header, body);
}

fn save(study: &Study<'_>, rows: &[Sizes], networks: usize) -> Result<()> {
    let mut csv = String::from("species,trees,what,mean,sd\n");
    for row in rows {
        let names = GRAPHS.iter().chain(&MESHES).chain(&["nodes", "vertices"]);
        let counts = [&row.nodes, &row.vertices];
        let all = row.graphs().into_iter().chain(row.meshes()).chain(counts);
        for (name, Estimate { count, mean, sd }) in names.zip(all) {
            csv += &format!("{},{count},{name},{mean},{sd}\n", row.species);
        }
    }
    study.save("compression.csv", csv.as_bytes())?;
    let json = json!({ "seed_bytes": dtree::LEN, "network_bytes": networks, "rows": rows });
    study.save("compression.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
