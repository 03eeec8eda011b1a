//! What scanners saw of the trees of a set.

use deeptree_graph::{BranchGraph, NodeId, Vec3};

use crate::{TrainError, TrainingSet};

/// What a scanner saw of a tree.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// The points, in the frame of the tree: metres, y up.
    pub points: Vec<Vec3>,
    /// Of each point the node on whose internode it lies.
    pub nodes: Vec<NodeId>,
}

/// Scans of the trees of a [`TrainingSet`], one for each, in their order.
#[derive(Clone, Debug, Default)]
pub struct Scans {
    /// Of the training trees.
    pub train: Vec<Scan>,
    /// Of the validation trees.
    pub validation: Vec<Scan>,
}

impl Scans {
    /// Checks that there is a scan for each tree, with a node for each point.
    pub(crate) fn check(&self, set: &TrainingSet) -> Result<(), TrainError> {
        for (part, trees, scans) in [
            ("training", &set.train, &self.train),
            ("validation", &set.validation, &self.validation),
        ] {
            if trees.len() != scans.len() {
                let (trees, given) = (trees.len(), scans.len());
                return Err(TrainError::ScanCount { part, trees, given });
            }
            let is_sound = |(tree, scan): (&BranchGraph, &Scan)| {
                let known = |&node: &NodeId| (node as usize) < tree.len();
                scan.points.len() == scan.nodes.len() && scan.nodes.iter().all(known)
            };
            if let Some(tree) = trees.iter().zip(scans).position(|pair| !is_sound(pair)) {
                return Err(TrainError::Scan { part, tree });
            }
        }
        Ok(())
    }
}
