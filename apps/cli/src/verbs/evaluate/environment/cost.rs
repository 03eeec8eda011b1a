//! What obstacles cost, in one run with the same trees in the open field.

use std::time::Instant;

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_graph::Seed;
use deeptree_growth::Species;
use deeptree_infer::Model;
use deeptree_scene::{Environment, Scene, Site};
use serde::{Deserialize, Serialize};

use crate::verbs::evaluate::around::learner;
use crate::verbs::evaluate::study::Study;
use crate::verbs::evaluate::trees;

/// Scenes of each species, and how often each tree is made: the fastest time counts, as what slows a
/// run down is not the method.
const FULL: [u32; 2] = [10, 5];
const QUICK: [u32; 2] = [2, 2];

/// What a tree may cost at most, over one in the open field.
const GOAL: f64 = 1.3;

/// Sums over the trees of a species.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Cost {
    species: String,
    trees: u32,
    /// Seconds and nodes in the open field.
    open: (f64, u64),
    /// Seconds and nodes in the scenes, with all that is looked up of them for the first time.
    among: (f64, u64),
    /// Seconds that making the scenes ready takes.
    ready: f64,
}

/// Times the trees one after the other on this thread.
pub(super) fn measure(study: &Study<'_>, model: &Model, species: &Species) -> Result<Cost> {
    let name = &species.name;
    study.part(&format!("environment-cost-{name}"), || {
        let [count, repeats] = if study.verb.quick { QUICK } else { FULL };
        let trees = count.min(study.trees());
        let mut work = study.verb.model.workspace()?;
        let mut cost =
            Cost { species: name.clone(), trees, open: (0.0, 0), among: (0.0, 0), ready: 0.0 };
        for seed in (0..u64::from(trees)).map(|k| study.verb.seed.wrapping_add(k)) {
            let scene = Scene::random(Seed(seed));
            let environment = Environment { scene, volume: None };
            let mut fastest = [f64::INFINITY; 3];
            let mut nodes = [0, 0];
            // The two take turns, so that what slows one down does so with the other.
            for _ in 0..repeats {
                let start = Instant::now();
                nodes[0] = trees::generated(model, name, seed, &mut work)?.tree.len() as u64;
                let open = start.elapsed().as_secs_f64();
                let environment = environment.clone();
                let start = Instant::now();
                let site = Site::new(environment);
                let ready = start.elapsed().as_secs_f64();
                nodes[1] = learner(model, species, seed, &site, &mut work)?.0.len() as u64;
                let among = start.elapsed().as_secs_f64() - ready;
                let times = [open, among, ready];
                fastest = std::array::from_fn(|i| times[i].min(fastest[i]));
            }
            cost.open = (cost.open.0 + fastest[0], cost.open.1 + nodes[0]);
            cost.among = (cost.among.0 + fastest[1], cost.among.1 + nodes[1]);
            cost.ready += fastest[2];
        }
        Ok(cost)
    })
}

impl Cost {
    fn of_all(costs: &[Self]) -> Self {
        let sum = |of: fn(&Self) -> (f64, u64)| {
            costs.iter().map(of).fold((0.0, 0), |(s, n), (seconds, nodes)| (s + seconds, n + nodes))
        };
        Self {
            species: "all".to_owned(),
            trees: costs.iter().map(|cost| cost.trees).sum(),
            open: sum(|cost| cost.open),
            among: sum(|cost| cost.among),
            ready: costs.iter().map(|cost| cost.ready).sum(),
        }
    }

    fn milliseconds(&self, seconds: f64) -> f64 {
        1e3 * seconds / f64::from(self.trees.max(1))
    }

    fn ratio(&self) -> f64 {
        self.among.0 / self.open.0
    }

    fn ratio_of_nodes(&self) -> f64 {
        self.ratio() * self.open.1 as f64 / self.among.1 as f64
    }
}

pub(super) fn sentence(costs: &[Cost]) -> String {
    let all = Cost::of_all(costs);
    format!(
        "A tree takes {:.1} ms in the open field and {:.1} ms among obstacles, {:.2} times as long \
         ({:.2} times a node); {GOAL} is the goal. Making a scene ready takes {:.1} ms, once for all \
         trees of a scene.",
        all.milliseconds(all.open.0),
        all.milliseconds(all.among.0),
        all.ratio(),
        all.ratio_of_nodes(),
        all.milliseconds(all.ready),
    )
}

pub(super) fn table(chapter: &mut Chapter, costs: &[Cost]) {
    let row = |cost: &Cost| {
        let ratio =
            |x: f64| Cell::new(format!("{x:.2}"), if x <= GOAL { Tone::Good } else { Tone::Bad });
        let milliseconds = |x: f64| Cell::from(format!("{:.1}", cost.milliseconds(x)));
        vec![
            cost.species.as_str().into(),
            cost.trees.to_string().into(),
            milliseconds(cost.open.0),
            milliseconds(cost.among.0),
            ratio(cost.ratio()),
            ratio(cost.ratio_of_nodes()),
            milliseconds(cost.ready),
        ]
    };
    let mut rows: Vec<Vec<Cell>> = costs.iter().map(row).collect();
    if costs.len() > 1 {
        rows.push(row(&Cost::of_all(costs)));
    }
    chapter.table(
        "Milliseconds on one thread, of the same seeds in turns, the fastest of several times. Among \
         obstacles every tree stands in a scene of its own, whose sky nobody has asked for before; \
         of a second tree in the same scene it is known.",
        &["species", "trees", "open field", "among obstacles", "ratio", "ratio a node", "scene"],
        rows,
    );
}
