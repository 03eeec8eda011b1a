//! The names of the variables.

/// Declares the variables once: the enumeration, its order and the published names.
macro_rules! variables {
    ($($(#[$doc:meta])+ $variant:ident = $name:literal,)+) => {
        /// A variable of the metric: a list of samples of a tree.
        ///
        /// *Direction* of a chain is that of its first or last segment, *span* the vector from
        /// its first node to its last. The variables of forks look at each child chain i, or at
        /// each ordered pair of child chains (i, j), i = j included.
        ///
        /// # Source
        ///
        /// Polasek et al. 2021, ICTreeF
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum Variable {
            $($(#[$doc])+ $variant,)+
        }

        impl Variable {
            /// All variables, in the order of every vector made of them.
            pub const ALL: [Self; VARIABLES] = [$(Self::$variant,)+];

            /// The published name.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)+
                }
            }
        }
    };
}

/// How many variables there are.
pub const VARIABLES: usize = 46;

variables! {
    /// Radius at the end of each segment, in metres.
    SegmentThickness = "segmentThickness",
    /// Pairs: radius at the start and at the end of each segment (m), with its volume (m³).
    SegmentVolume = "segmentVolume",
    /// Segments of each chain.
    SegmentsPerChain = "segmentsPerChain",
    /// Forks between each chain and the root.
    ChainsPerDepth = "chainsPerDepth",
    /// Length of each chain along its segments, in metres, where it is not zero.
    ChainLength = "chainLength",
    /// Length of each chain's span, in metres, where it is not zero.
    ChainTotalLength = "chainTotalLength",
    /// Sum of the angles between consecutive segments of each chain, in radians.
    ChainDeformation = "chainDeformation",
    /// Length of a chain over that of its parent.
    ChainLengthRatio = "chainLengthRatio",
    /// Sum of angles of a chain less that of its parent, in radians, where neither is zero.
    ChainAngleSumDelta = "chainAngleSumDelta",
    /// Angle between the spans of a chain and its parent, in radians.
    ChainParentChildAngle = "chainParentChildAngle",
    /// Length of the span over the length, for chains of three or more nodes.
    ChainStraightness = "chainStraightness",
    /// Angle between the span and the vertical, in radians.
    ChainSlope = "chainSlope",
    /// Smallest radius of each chain, in metres.
    ChainMinThickness = "chainMinThickness",
    /// Largest radius of each chain, in metres, where it is not zero.
    ChainMaxThickness = "chainMaxThickness",
    /// Smallest over largest radius.
    ChainMinMaxThicknessRatio = "chainMinMaxThicknessRatio",
    /// How far up (span − first direction) points: a length is mixed with a unit vector.
    ChainTropismBranch = "chainTropismBranch",
    /// How far up the first direction points: cosine.
    ChainTropismHorizon = "chainTropismHorizon",
    /// Cosine between the parent's last direction and the span.
    ChainTropismParent = "chainTropismParent",
    /// At forks: angle between the last direction and the first of child i, in radians.
    ChainParentAngle = "chainParentAngle",
    /// At forks: angle between the spans of the chain and child i, in radians.
    ChainParentAngleTotal = "chainParentAngleTotal",
    /// The fork's smallest [`Variable::ChainParentAngle`].
    ChainMinParentAngle = "chainMinParentAngle",
    /// The fork's smallest [`Variable::ChainParentAngleTotal`].
    ChainMinParentAngleTotal = "chainMinParentAngleTotal",
    /// The fork's largest [`Variable::ChainParentAngleTotal`].
    ChainMaxParentAngleTotal = "chainMaxParentAngleTotal",
    /// The larger of the last child's parent angle and all sibling angles of the children before
    /// it: not the largest parent angle, which the name promises.
    ChainMaxParentAngle = "chainMaxParentAngle",
    /// At forks: angle between the first directions of children i and j, in radians.
    ChainSiblingAngle = "chainSiblingAngle",
    /// At forks: angle between the spans of children i and j, in radians.
    ChainSiblingAngleTotal = "chainSiblingAngleTotal",
    /// Smallest sibling angle of child i: that with itself, about 0.
    ChainMinSiblingAngle = "chainMinSiblingAngle",
    /// Largest sibling angle of child i.
    ChainMaxSiblingAngle = "chainMaxSiblingAngle",
    /// Smallest sibling angle of child i between spans: that with itself, about 0.
    ChainMinSiblingAngleTotal = "chainMinSiblingAngleTotal",
    /// Largest sibling angle of child i between spans.
    ChainMaxSiblingAngleTotal = "chainMaxSiblingAngleTotal",
    /// The fork's smallest sibling angle: about 0.
    ChainMinChildAngle = "chainMinChildAngle",
    /// The fork's largest sibling angle.
    ChainMaxChildAngle = "chainMaxChildAngle",
    /// The fork's smallest sibling angle between spans: about 0.
    ChainMinChildAngleTotal = "chainMinChildAngleTotal",
    /// The fork's largest sibling angle between spans.
    ChainMaxChildAngleTotal = "chainMaxChildAngleTotal",
    /// Difference of the leaf chains above children i and j, over those above the fork. Signed.
    ChainAsymmetryLeaf = "chainAsymmetryLeaf",
    /// The same of the length of the leaf chains.
    ChainAsymmetryLength = "chainAsymmetryLength",
    /// The same of the volume of the leaf chains.
    ChainAsymmetryVolume = "chainAsymmetryVolume",
    /// Sum of the distances of a chain's nodes from its first node, over the internode length.
    ChainInternodeCount = "chainInternodeCount",
    /// How well a fork fits one dominant child with equal others, at most 1.
    ChainMonopodialBranchingFitness = "chainMonopodialBranchingFitness",
    /// How well a fork fits one dominant and one minor child, at most 1.
    ChainSympodialMonochasialBranchingFitness = "chainSympodialMonochasialBranchingFitness",
    /// How well a fork fits two equal children, at most 1.
    ChainSympodialDichasialBranchingFitness = "chainSympodialDichasialBranchingFitness",
    /// Pairs: 0, 1, 2 for the three kinds of branching, with the fitness.
    AggregateBranchingFitness = "aggregateBranchingFitness",
    /// How near a chain is to one internode, in [0, 1].
    ChainContinuousRamificationFitness = "chainContinuousRamificationFitness",
    /// How near a chain is to the mean of internodes while that is not one, in [0, 1].
    ChainRhythmicRamificationFitness = "chainRhythmicRamificationFitness",
    /// How far a chain is from the mean of internodes, in [0, 1].
    ChainDiffuseRamificationFitness = "chainDiffuseRamificationFitness",
    /// Pairs: 0, 1, 2 for the three kinds of ramification, with the fitness.
    AggregateRamificationFitness = "aggregateRamificationFitness",
}

impl Variable {
    /// Whether samples are pairs of a position and its weight.
    #[must_use]
    pub const fn is_paired(self) -> bool {
        matches!(
            self,
            Self::SegmentVolume
                | Self::AggregateBranchingFitness
                | Self::AggregateRamificationFitness
        )
    }
}

/// Variables that are the same for all trees: the smallest angle between a child and any child is
/// that with itself.
///
/// It is 0 but for rounding, which grows as chains get shorter; comparisons should leave them out.
pub const CONSTANT: [Variable; 4] = [
    Variable::ChainMinSiblingAngle,
    Variable::ChainMinSiblingAngleTotal,
    Variable::ChainMinChildAngle,
    Variable::ChainMinChildAngleTotal,
];

/// Variables with a mean of 0 by construction: signed differences of all ordered pairs.
///
/// Only their spread tells trees apart; comparisons should leave their means out.
pub const ZERO_MEAN: [Variable; 3] =
    [Variable::ChainAsymmetryLeaf, Variable::ChainAsymmetryLength, Variable::ChainAsymmetryVolume];
