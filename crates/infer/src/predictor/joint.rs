//! Kind `joint`: one network with shared layers for which children exist and what they are like.
//!
//! Source: DeepTree §6, "Network Comparison": the architecture that the cascade is compared with.

use deeptree_graph::MAX_CHILDREN;
use deeptree_graph::signature::paper::{self, CHILD_LEN, JOINT_LEN};

use super::paper::{child_signature, draw_children, encode, foretell_children};
use super::{Active, Branchlet, Foretold, Known, Overflow, Workspace, network};
use crate::mlp::Mlp;
use crate::weights::{ReadWeightsError, Weights};

#[derive(Clone, Debug)]
pub(super) struct Joint {
    network: Mlp,
}

impl Joint {
    pub(super) fn new(weights: &Weights) -> Result<Self, ReadWeightsError> {
        let features = paper::len(weights.species().len());
        Ok(Self { network: network(weights, "joint", features, JOINT_LEN)? })
    }

    pub(super) fn weight_count(&self) -> usize {
        self.network.weight_count()
    }

    pub(super) fn foretell(
        &self,
        species: usize,
        known: &[Known<'_>],
        work: &mut Workspace,
    ) -> Result<Vec<Foretold>, Overflow> {
        encode(species, known, |known| &known.active, work);
        let outputs = work.run_nodes(&self.network);
        foretell_children(outputs.chunks_exact(JOINT_LEN).map(|row| &row[..MAX_CHILDREN]))
    }

    pub(super) fn branchlets(
        &self,
        species: usize,
        frontier: &[Active<'_>],
        work: &mut Workspace,
        branchlets: &mut [Branchlet],
    ) -> Result<(), Overflow> {
        encode(species, frontier, |active| active, work);
        let outputs = work.run_nodes(&self.network);
        for (row, (active, outputs)) in
            frontier.iter().zip(outputs.chunks_exact(JOINT_LEN)).enumerate()
        {
            let (logits, signatures) = outputs.split_at(MAX_CHILDREN);
            let exists = match active.settled {
                Some(settled) => settled.put_standing(&mut branchlets[row]),
                None => draw_children(active, logits).ok_or(Overflow { row })?,
            };
            for (slot, signature) in signatures.chunks_exact(CHILD_LEN).enumerate() {
                if exists[slot] {
                    let child = child_signature(signature).ok_or(Overflow { row })?;
                    branchlets[row].children[slot] = Some(child);
                }
            }
        }
        Ok(())
    }
}
