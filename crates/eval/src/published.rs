//! What the paper printed, to stand beside what is measured.

/// Mean and standard deviation of the seven metrics of [`crate::Metric::ALL`].
pub type Published = [(f64, f64); 7];

/// The P (procedural) and DT (DeepTree) columns of the evaluation table in the appendix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedSpecies {
    /// Name of the species.
    pub species: &'static str,
    /// Procedurally generated trees.
    pub p: Published,
    /// Trees from the networks.
    pub dt: Published,
}

/// The evaluation table of the appendix, verbatim.
///
/// The "Total" columns are left out: those of branch length are swapped in print, and those of
/// branching distance repeat the willow's.
#[rustfmt::skip]
pub const TABLE: [PublishedSpecies; 8] = [
    PublishedSpecies {
        species: "beech",
        p: [(3.3, 3.16), (777.0, 222.0), (1.98, 1.51), (1.19, 0.62), (0.15, 0.1), (0.79, 0.02), (0.79, 0.02)],
        dt: [(3.75, 3.31), (1634.0, 308.0), (2.1, 1.55), (1.06, 0.68), (0.15, 0.11), (0.79, 0.06), (0.8, 0.07)],
    },
    PublishedSpecies {
        species: "corkscrew",
        p: [(4.47, 3.48), (751.0, 224.0), (2.43, 1.79), (1.18, 0.63), (0.7, 0.17), (0.81, 0.18), (0.81, 0.18)],
        dt: [(5.92, 4.29), (566.0, 95.0), (3.16, 2.57), (1.09, 0.67), (0.69, 0.09), (0.81, 0.07), (0.8, 0.1)],
    },
    PublishedSpecies {
        species: "maple",
        p: [(3.34, 2.7), (816.0, 122.0), (1.91, 1.27), (1.2, 0.75), (0.07, 0.03), (0.89, 0.03), (0.88, 0.03)],
        dt: [(3.69, 2.75), (817.0, 42.0), (2.11, 1.38), (1.29, 0.68), (0.08, 0.04), (0.89, 0.04), (0.88, 0.05)],
    },
    PublishedSpecies {
        species: "oak",
        p: [(4.16, 3.44), (1084.0, 354.0), (2.28, 1.76), (1.18, 0.6), (0.33, 0.08), (0.54, 0.17), (0.54, 0.17)],
        dt: [(4.61, 3.97), (1738.0, 194.0), (2.5, 1.92), (1.06, 0.66), (0.33, 0.05), (0.53, 0.04), (0.56, 0.09)],
    },
    PublishedSpecies {
        species: "pine",
        p: [(2.92, 2.67), (1000.0, 129.0), (1.65, 0.98), (1.16, 0.69), (0.06, 0.04), (1.4, 0.05), (1.4, 0.05)],
        dt: [(3.41, 2.88), (839.0, 65.0), (1.96, 1.3), (1.03, 0.65), (0.06, 0.04), (1.4, 0.05), (1.4, 0.07)],
    },
    PublishedSpecies {
        species: "tulip",
        p: [(4.44, 3.56), (726.0, 49.0), (2.56, 2.06), (1.1, 0.51), (0.06, 0.04), (0.53, 0.02), (0.53, 0.02)],
        dt: [(4.8, 3.4), (773.0, 33.0), (2.79, 2.08), (1.05, 0.51), (0.06, 0.04), (0.53, 0.06), (0.53, 0.04)],
    },
    PublishedSpecies {
        species: "walnut",
        p: [(4.84, 3.81), (589.0, 175.0), (2.6, 1.82), (1.11, 0.45), (0.34, 0.1), (0.56, 0.2), (0.56, 0.2)],
        dt: [(5.13, 4.67), (677.0, 259.0), (2.79, 2.26), (1.07, 0.37), (0.32, 0.06), (0.55, 0.1), (0.57, 0.18)],
    },
    PublishedSpecies {
        species: "willow",
        p: [(4.43, 3.46), (1304.0, 440.0), (2.47, 2.03), (1.15, 0.58), (0.42, 0.15), (0.26, 0.02), (0.26, 0.02)],
        dt: [(5.19, 3.97), (1691.0, 495.0), (2.8, 2.14), (1.01, 0.52), (0.41, 0.06), (0.27, 0.01), (0.27, 0.06)],
    },
];

/// A row of the runtime table: seconds, nodes and branches a tree, means of ten trees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedRuntime {
    /// Name of the species.
    pub species: &'static str,
    /// The procedural model.
    pub p: (f64, u32, u32),
    /// The networks.
    pub dt: (f64, u32, u32),
}

/// The runtime table, verbatim; which processor ran what is not printed.
#[rustfmt::skip]
pub const RUNTIME: [PublishedRuntime; 8] = [
    PublishedRuntime { species: "beech", p: (23.0, 3376, 777), dt: (2.7, 5672, 1634) },
    PublishedRuntime { species: "corkscrew", p: (26.0, 2872, 751), dt: (2.1, 3041, 566) },
    PublishedRuntime { species: "maple", p: (25.0, 2928, 861), dt: (1.9, 2951, 817) },
    PublishedRuntime { species: "oak", p: (27.0, 4261, 1084), dt: (2.1, 6238, 1738) },
    PublishedRuntime { species: "pine", p: (26.0, 3506, 1000), dt: (1.9, 3168, 839) },
    PublishedRuntime { species: "tulip", p: (26.0, 3050, 726), dt: (1.8, 3360, 773) },
    PublishedRuntime { species: "walnut", p: (27.0, 5638, 589), dt: (2.0, 4975, 677) },
    PublishedRuntime { species: "willow", p: (30.0, 4796, 1304), dt: (2.0, 4975, 1691) },
];

/// A row of the compression table: megabytes and counts a tree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedSize {
    /// Name of the species.
    pub species: &'static str,
    /// Skeletal graph in MB.
    pub graph: f64,
    /// Nodes in thousands.
    pub nodes: f64,
    /// Surface mesh in MB.
    pub mesh: f64,
    /// Vertices in thousands.
    pub vertices: f64,
}

/// The compression table, verbatim; the formats of graph and mesh are not printed.
#[rustfmt::skip]
pub const COMPRESSION: [PublishedSize; 8] = [
    PublishedSize { species: "beech", graph: 1.85, nodes: 5.7, mesh: 24.08, vertices: 115.0 },
    PublishedSize { species: "corkscrew", graph: 1.20, nodes: 3.7, mesh: 15.66, vertices: 75.0 },
    PublishedSize { species: "maple", graph: 1.36, nodes: 4.2, mesh: 17.68, vertices: 85.0 },
    PublishedSize { species: "oak", graph: 0.78, nodes: 2.4, mesh: 10.18, vertices: 49.0 },
    PublishedSize { species: "pine", graph: 1.81, nodes: 5.5, mesh: 23.86, vertices: 114.0 },
    PublishedSize { species: "tulip", graph: 1.84, nodes: 5.6, mesh: 24.27, vertices: 115.0 },
    PublishedSize { species: "walnut", graph: 0.74, nodes: 2.3, mesh: 10.97, vertices: 53.0 },
    PublishedSize { species: "willow", graph: 1.60, nodes: 4.9, mesh: 20.96, vertices: 101.0 },
];

/// Bytes of the published seed, and of the published networks.
pub const SEED_AND_NETWORKS: (u32, u32) = (52, 913_000);

/// Mean and standard deviation over the species of graph and mesh, with seed and networks as 1.
pub const SIZE_RATIOS: [(f64, f64); 2] = [(1.58, 0.46), (20.81, 5.78)];

/// The published row of a species.
#[must_use]
pub fn find(species: &str) -> Option<&'static PublishedSpecies> {
    TABLE.iter().find(|row| row.species == species)
}

/// A row of the table "ICTree perceptual validation": species, ground truth and DeepTree, each mean
/// and standard deviation.
pub type PerceptualRow = (&'static str, (f64, f64), (f64, f64));

/// The table "ICTree perceptual validation", verbatim; the last row is of all trees.
pub const PERCEPTUAL: [PerceptualRow; 9] = [
    ("beech", (0.47, 0.10), (0.49, 0.09)),
    ("corkscrew", (0.48, 0.11), (0.48, 0.12)),
    ("maple", (0.49, 0.11), (0.46, 0.12)),
    ("oak", (0.50, 0.11), (0.48, 0.12)),
    ("pine", (0.50, 0.11), (0.48, 0.11)),
    ("tulip", (0.49, 0.11), (0.45, 0.10)),
    ("walnut", (0.49, 0.11), (0.47, 0.10)),
    ("willow", (0.49, 0.11), (0.46, 0.10)),
    ("all trees", (0.49, 0.11), (0.47, 0.11)),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn branch_numbers_of_both_tables_agree_but_for_the_maple() {
        for (runtime, row) in RUNTIME.iter().zip(&TABLE) {
            assert_eq!(runtime.species, row.species);
            assert_eq!(f64::from(runtime.dt.2), row.dt[1].0, "{}", row.species);
            let same = f64::from(runtime.p.2) == row.p[1].0;
            assert_eq!(same, row.species != "maple", "{}", row.species);
        }
    }

    #[test]
    fn the_printed_size_ratios_are_within_four_percent_of_those_of_the_printed_rows() {
        let base = f64::from(SEED_AND_NETWORKS.0 + SEED_AND_NETWORKS.1) / 1e6;
        let mean = |of: fn(&PublishedSize) -> f64| {
            COMPRESSION.iter().map(|row| of(row) / base).sum::<f64>() / 8.0
        };
        let [graph, mesh] = SIZE_RATIOS.map(|(mean, _)| mean);
        assert!((mean(|row| row.graph) / graph - 1.0).abs() < 0.04);
        assert!((mean(|row| row.mesh) / mesh - 1.0).abs() < 0.04);
        // Bytes a node and a vertex hardly depend on the species, so no row is misprinted.
        for row in &COMPRESSION {
            assert!((row.graph / row.nodes - 0.326).abs() < 0.005, "{}", row.species);
            assert!((row.mesh / row.vertices - 0.209).abs() < 0.004, "{}", row.species);
        }
    }
}
