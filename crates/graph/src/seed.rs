//! Keyed randomness: every draw is a hash of (seed, lineage of the node, purpose).
//!
//! No generator is carried along, so neither the order of traversal, nor the number of threads,
//! nor what grows elsewhere in the tree can change a draw. The mixing function is the finaliser of
//! SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number generators").

/// The number a tree is stored as. Tree `k` of a batch has the seed `first + k`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Seed(pub u64);

/// A hash of the path of child slots from the root to a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Lineage(u64);

/// What a draw decides. The numbers are part of the determinism contract: never renumber.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[repr(u64)]
pub enum Purpose {
    /// Yaw of the first internode of a grown tree.
    RootYaw = 1,
    /// Does an apical bud die in this cycle?
    ApicalKill = 2,
    /// Does an apical bud rest in this cycle for want of light?
    ApicalRest = 3,
    /// Target length of an internode, drawn each cycle until it is reached.
    InternodeLength = 4,
    /// Roll and apical angle of an apical child.
    ApicalAngles = 5,
    /// Branching angles of the lateral buds of an internode.
    BranchingAngles = 6,
    /// Does a lateral bud die in this cycle?
    LateralKill = 7,
    /// Does a lateral bud flush in this cycle?
    LateralFlush = 8,
    /// Is an end internode shed in this cycle?
    Shedding = 9,
    /// Age and gravitropism of a tree in a corpus of priors.
    Priors = 10,
    /// The obstacles of a random scene.
    Scenery = 11,
    /// The plan of a random stand.
    Planting = 12,
    /// Which root signature a generated tree starts from.
    RootSignature = 32,
    /// Which children a node has.
    Existence = 33,
    /// How the tips above a node are split among its children.
    TipSplit = 34,
    /// Length of a child's edge.
    ChildLength = 35,
    /// Rotation of a child.
    ChildRotation = 36,
    /// How far the children of a node reach.
    ChildReach = 37,
    /// How many nodes grow below the children of a node.
    ChildSize = 38,
    /// How hard the trees around bear on a tree.
    Competition = 39,
    /// What a tree's habit is.
    Habit = 40,
    /// The angle of a lateral in the plane of its bud.
    BudAngle = 41,
    /// Initial weights of a network.
    InitialWeights = 64,
    /// Order of the branchlets in a training epoch.
    EpochOrder = 65,
    /// Noise on the inputs of a training batch.
    TrainingNoise = 66,
    /// Which trees an evaluation looks at.
    Evaluation = 67,
    /// Where the flutes of a trunk stand, and the long side of a branch's cross-section.
    CrossSection = 96,
    /// When a branch swings in the wind.
    WindPhase = 97,
    /// Where and how the leafy shoots of an internode stand.
    Shoots = 112,
    /// Where a scanner stands.
    ScanPlace = 128,
    /// Where a scanner's random ray goes.
    ScanRay = 129,
    /// How far a beam's measured range is off.
    ScanRange = 130,
    /// How many points a scan has, and which of too many stay.
    ScanPoints = 131,
}

const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// SplitMix64's finaliser: a bijection of 64 bits in which each input bit moves half of the output.
const fn mix(z: u64) -> u64 {
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Folds one more word into a key.
const fn fold(key: u64, word: u64) -> u64 {
    mix(mix(key).wrapping_add(GOLDEN) ^ word.wrapping_mul(0xd6e8_feb8_6659_fd93))
}

impl Lineage {
    /// The root's lineage.
    pub const ROOT: Self = Self(GOLDEN);

    /// The lineage of the child in `slot`.
    #[must_use]
    pub const fn child(self, slot: u8) -> Self {
        Self(fold(self.0, slot as u64 + 1))
    }
}

impl Seed {
    /// The draws that one node needs for one purpose.
    #[must_use]
    pub const fn draws(self, lineage: Lineage, purpose: Purpose) -> Draws {
        Draws { key: fold(fold(fold(0, self.0), lineage.0), purpose as u64), next: 0 }
    }

    /// The seed of tree `k` of a batch that starts at this one.
    #[must_use]
    pub const fn of_tree(self, k: u64) -> Self {
        Self(self.0.wrapping_add(k))
    }
}

/// The sequence of draws of one key: draw `i` is a hash of (key, i).
#[derive(Clone, Debug)]
pub struct Draws {
    key: u64,
    next: u64,
}

impl Draws {
    /// The draws of the same key at one more coordinate, such as a growth cycle or a child slot.
    #[must_use]
    pub const fn at(self, coordinate: u64) -> Self {
        Self { key: fold(self.key, coordinate.wrapping_add(GOLDEN)), next: 0 }
    }

    /// 64 random bits.
    pub const fn bits(&mut self) -> u64 {
        self.next = self.next.wrapping_add(GOLDEN);
        mix(self.key ^ mix(self.next))
    }

    /// Uniform in [0, 1), on a grid of 2⁻⁵³.
    pub const fn uniform(&mut self) -> f64 {
        (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64)
    }

    /// Uniform in the open interval (0, 1): safe to take a logarithm of.
    pub const fn open_uniform(&mut self) -> f64 {
        ((self.bits() >> 12) as f64 + 0.5) * (1.0 / (1u64 << 52) as f64)
    }

    /// A whole number in 0..`n`; 0 when `n` is 0. The bias is below n · 2⁻⁶⁴.
    pub const fn index(&mut self, n: usize) -> usize {
        ((self.bits() as u128 * n as u128) >> 64) as usize
    }

    /// Standard normal (Box and Muller 1958), of two uniform draws.
    pub fn normal(&mut self) -> f64 {
        let radius = libm::sqrt(-2.0 * libm::log(self.open_uniform()));
        radius * libm::cos(core::f64::consts::TAU * self.uniform())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_outputs_of_splitmix64_match_the_published_sequence() {
        // SplitMix64 seeded with 0: mix(golden), mix(2 golden) … as in the reference C code.
        assert_eq!(mix(GOLDEN), 0xe220_a839_7b1d_cdaf);
        assert_eq!(mix(GOLDEN.wrapping_mul(2)), 0x6e78_9e6a_a1b9_65f4);
    }

    #[test]
    fn uniform_draws_over_lineages_have_the_moments_of_a_uniform_law() {
        let n = 100_000;
        let (mut sum, mut squares, mut product) = (0.0, 0.0, 0.0);
        let mut lineage = Lineage::ROOT;
        for i in 0..n {
            lineage = lineage.child((i % 3) as u8);
            let mut draws = Seed(5).draws(lineage, Purpose::Existence);
            let (a, b) = (draws.uniform(), draws.uniform());
            sum += a;
            squares += a * a;
            product += (a - 0.5) * (b - 0.5);
        }
        let n = n as f64;
        // Five standard errors of the mean, of the second moment and of the covariance.
        assert!((sum / n - 0.5).abs() < 5.0 * (1.0f64 / 12.0 / n).sqrt());
        assert!((squares / n - 1.0 / 3.0).abs() < 5.0 * (4.0f64 / 45.0 / n).sqrt());
        assert!((product / n).abs() < 5.0 / 12.0 / n.sqrt());
    }

    #[test]
    fn normal_draws_have_mean_zero_variance_one_and_gaussian_kurtosis() {
        let n = 200_000;
        let (mut m1, mut m2, mut m4) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let x = Seed(i).draws(Lineage::ROOT, Purpose::ChildRotation).normal();
            m1 += x;
            m2 += x * x;
            m4 += x * x * x * x;
        }
        let n = n as f64;
        assert!((m1 / n).abs() < 5.0 / n.sqrt());
        assert!((m2 / n - 1.0).abs() < 5.0 * (2.0 / n).sqrt());
        assert!((m4 / n - 3.0).abs() < 5.0 * (96.0 / n).sqrt());
    }

    #[test]
    fn purposes_lineages_and_coordinates_give_unrelated_draws() {
        let first = |p, l, c| Seed(1).draws(l, p).at(c).bits();
        let root = Lineage::ROOT;
        let mut all = vec![
            first(Purpose::Existence, root, 0),
            first(Purpose::TipSplit, root, 0),
            first(Purpose::Existence, root.child(0), 0),
            first(Purpose::Existence, root.child(1), 0),
            first(Purpose::Existence, root.child(0).child(1), 0),
            first(Purpose::Existence, root.child(1).child(0), 0),
            first(Purpose::Existence, root, 1),
            Seed(2).draws(root, Purpose::Existence).at(0).bits(),
        ];
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), 8);
    }
}
