//! A model judges the trees that it has drawn itself: of these all that it says is right, but that it
//! leaves seldom branchings out.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

use deeptree_generate::{Limits, Request, generate};
use deeptree_graph::{BranchGraph, NodeId, Seed};
use deeptree_infer::{Foretold, KnownTree, Model, Predictor, Rank, Workspace};

const SITUATED: &[u8] = include_bytes!("../../../models/situated.safetensors");

/// Trees in which no branch has ended at the ground, where swings are drawn again and tips are
/// lost; with what the model says of each node.
fn trees(model: &Model, species: usize, count: usize) -> Vec<(BranchGraph, Vec<Foretold>)> {
    let mut work = Workspace::default();
    let grow = |seed| {
        let request = Request::new(&model.species()[species], Seed(seed));
        let tree = generate(model, &request, Limits::default(), &mut work).unwrap().tree;
        let known = KnownTree::new(model, species, &tree);
        let nodes: Vec<_> = (0..tree.len() as NodeId).map(|id| known.node(id)).collect();
        let foretold = model.foretell(&nodes, &mut work).unwrap();
        (tree, foretold)
    };
    let is_whole = |(_, foretold): &(BranchGraph, Vec<Foretold>)| {
        foretold.iter().all(|node| node.branching.is_some())
    };
    (0..4 * count as u64).map(grow).filter(is_whole).take(count).collect()
}

/// Sum of what came less what was told, in standard deviations of that sum.
#[derive(Default)]
struct Excess {
    sum: f64,
    variance: f64,
}

impl Excess {
    fn add(&mut self, excess: f64, variance: f64) {
        self.sum += excess;
        self.variance += variance;
    }

    fn chance(&mut self, told: f64, happened: bool) {
        self.add(f64::from(u8::from(happened)) - told, told * (1.0 - told));
    }

    /// The middle of an interval of ranks has the mean ½, and never a larger variance than a rank.
    fn rank(&mut self, rank: Option<Rank>) {
        if let Some(Rank { low, high }) = rank {
            assert!((0.0..=1.0).contains(&low) && (low..=1.0).contains(&high), "{low} {high}");
            self.add(0.5 * (low + high) - 0.5, 1.0 / 12.0);
        }
    }

    fn assert_chance(&self, what: &str) {
        assert!(self.variance > 2.0, "{what}: next to nothing to judge by, {}", self.variance);
        let deviations = self.sum / self.variance.sqrt();
        assert!(deviations.abs() < 5.0, "{what}: {deviations}");
    }
}

#[test]
fn what_a_model_says_of_its_own_trees_comes_true() {
    let model = Model::from_bytes(SITUATED).unwrap();
    for name in ["oak", "walnut"] {
        let species = model.species().iter().position(|known| known == name).unwrap();
        let trees = trees(&model, species, 12);
        assert_eq!(trees.len(), 12);
        let mut children: [Excess; 3] = Default::default();
        let mut ranks: [Excess; 5] = Default::default();
        let (mut heirs, mut aligned) = (Excess::default(), Excess::default());
        for (tree, foretold) in &trees {
            for (node, said) in tree.nodes().iter().zip(foretold) {
                for (slot, excess) in children.iter_mut().enumerate() {
                    excess.chance(said.children[slot], node.children[slot].is_some());
                }
                said.splits.into_iter().for_each(|rank| ranks[0].rank(rank));
                said.reaches.into_iter().for_each(|rank| ranks[1].rank(rank));
                // Near the ground, swings that lead into it are drawn again.
                if node.position.y > 1.2 {
                    said.swings_x.into_iter().for_each(|rank| ranks[2].rank(rank));
                    said.swings_y.into_iter().for_each(|rank| ranks[3].rank(rank));
                }
                said.lengths.into_iter().for_each(|rank| ranks[4].rank(rank));
                for chance in said.heirs.into_iter().flatten() {
                    heirs.chance(chance.probability, chance.happened);
                }
                for chance in said.aligned.into_iter().flatten() {
                    aligned.chance(chance.probability, chance.happened);
                }
            }
        }
        for (slot, excess) in children.iter().enumerate() {
            excess.assert_chance(&format!("{name}: children in slot {slot}"));
        }
        for (what, excess) in ["split", "reach", "x", "y", "length"].iter().zip(&ranks) {
            excess.assert_chance(&format!("{name}: {what}"));
        }
        heirs.assert_chance(&format!("{name}: heirs"));
        aligned.assert_chance(&format!("{name}: aligned"));
    }
}

#[test]
fn probabilities_are_masked_as_plans_mask_them() {
    let model = Model::from_bytes(SITUATED).unwrap();
    for (tree, foretold) in trees(&model, 0, 3) {
        for (node, said) in tree.nodes().iter().zip(foretold) {
            let expected: f64 = said.children.iter().sum();
            let is_end = node.children.iter().all(Option::is_none);
            // A node ends where its reach is spent, and nowhere else.
            assert!(if is_end { expected == 0.0 } else { expected > 1.0 - 1e-9 }, "{said:?}");
            assert!(said.branching.is_some_and(|p| p > 0.0 && p <= 1.0 + 1e-9));
        }
    }
}
