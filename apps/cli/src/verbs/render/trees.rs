//! The trees of contact sheets.

use anyhow::Result;
use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::{BranchGraph, Seed};
use deeptree_growth::{SPECIES, grow};
use deeptree_infer::{Model, Predictor, Workspace};

use super::sheet::{Cell, Plan};
use crate::args::{self, Sheet};
use crate::verbs::{preset, unknown_species};

/// Ages and gravitropisms of the sheet of priors; the model has seen trees around them.
const AGES: [u16; 5] = [15, 20, 26, 32, 37];
const GRAVITROPISMS: [f32; 3] = [-0.3, 0.0, 0.3];
/// Columns and rows of the sheet of samples.
const SAMPLES: [u64; 2] = [6, 3];

/// What stands where on a sheet.
pub(super) fn plan(verb: &args::Render, which: Sheet) -> Result<Plan> {
    let mut networks = Networks { model: verb.model.load()?, work: verb.model.workspace()? };
    let known = networks.model.species();
    if !known.contains(&verb.species) {
        return Err(unknown_species(&verb.species, known).into());
    }
    match which {
        Sheet::Species => species(&mut networks, verb),
        Sheet::Priors => priors(&mut networks, verb),
        Sheet::Samples => samples(&mut networks, verb),
        Sheet::Views => views(&mut networks, verb),
    }
}

struct Networks {
    model: Model,
    work: Workspace,
}

impl Networks {
    fn tree(&mut self, request: &Request) -> Result<BranchGraph> {
        Ok(generate(&self.model, request, Limits::default(), &mut self.work)?.tree)
    }
}

/// The growth model above, the networks below.
fn species(networks: &mut Networks, verb: &args::Render) -> Result<Plan> {
    let seed = Seed(verb.seed);
    let mut grown = Vec::new();
    let mut generated = Vec::new();
    for name in SPECIES {
        let parameters = preset(name)?.parameters(deeptree_growth::Profile::Reference).clone();
        grown.push(Cell::front(grow(name, &parameters, seed)?.tree));
        generated.push(Cell::front(networks.tree(&Request::new(name, seed))?));
    }
    Ok(Plan {
        columns: SPECIES.map(str::to_owned).to_vec(),
        rows: vec!["growth model".to_owned(), "networks".to_owned()],
        cells: vec![grown, generated],
    })
}

/// Age by gravitropism.
fn priors(networks: &mut Networks, verb: &args::Render) -> Result<Plan> {
    let row = |networks: &mut Networks, gravitropism| -> Result<Vec<Cell>> {
        let one = |age| {
            let request = Request {
                age: Some(age),
                gravitropism: Some(gravitropism),
                ..Request::new(&verb.species, Seed(verb.seed))
            };
            Ok(Cell::front(networks.tree(&request)?))
        };
        AGES.into_iter().map(one).collect()
    };
    Ok(Plan {
        columns: AGES.iter().map(|age| format!("age {age}")).collect(),
        rows: GRAVITROPISMS.iter().map(|g| format!("gravitropism {g}")).collect(),
        cells: GRAVITROPISMS
            .into_iter()
            .map(|gravitropism| row(networks, gravitropism))
            .collect::<Result<_>>()?,
    })
}

/// Trees of one species, seed by seed.
fn samples(networks: &mut Networks, verb: &args::Render) -> Result<Plan> {
    let [columns, rows] = SAMPLES;
    let cell = |networks: &mut Networks, k| {
        let seed = Seed(verb.seed).of_tree(k);
        Ok(Cell::front(networks.tree(&Request::new(&verb.species, seed))?))
    };
    let row = |r| (0..columns).map(|c| cell(networks, r * columns + c)).collect();
    let cells = (0..rows).map(row).collect::<Result<_>>()?;
    Ok(Plan { columns: Vec::new(), rows: Vec::new(), cells })
}

/// One tree from all sides.
fn views(networks: &mut Networks, verb: &args::Render) -> Result<Plan> {
    let tree = networks.tree(&Request::new(&verb.species, Seed(verb.seed)))?;
    let around = [0.0f32, 60.0, 120.0, 180.0, 240.0, 300.0];
    let turned = |azimuth: f32| Cell {
        azimuth: azimuth.to_radians(),
        elevation: Cell::front(tree.clone()).elevation,
        tree: tree.clone(),
    };
    let (above, top) = (35.0f32.to_radians(), 90.0f32.to_radians());
    let mut cells: Vec<Cell> = around.map(turned).into_iter().collect();
    cells.push(Cell { elevation: above, ..turned(0.0) });
    cells.push(Cell { elevation: top, ..turned(0.0) });
    let mut columns: Vec<String> = around.iter().map(|a| format!("{a} deg")).collect();
    columns.extend(["from above", "top"].map(str::to_owned));
    Ok(Plan { columns, rows: vec![verb.species.clone()], cells: vec![cells] })
}
