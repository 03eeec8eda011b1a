//! What is known of leaves from outside this code: how they are arranged on their axes, how much of
//! them there is, what pruning does not change.

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use deeptree_graph::{
    BranchGraph, ChildSignature, Cut, Quat, Seed, TreeInfo, Vec3, prune, reaches,
};
use deeptree_growth::{Profile, SPECIES, Species, grow};
use deeptree_mesh::{Dressed, Look, LookError, Mesh, Season, dress};
use sha2::{Digest, Sha256};

fn grown(name: &str, seed: u64) -> BranchGraph {
    let species = Species::named(name).unwrap();
    grow(name, species.parameters(Profile::default()), Seed(seed)).unwrap().tree
}

/// Small textures, and no wood, which nothing here looks at.
fn dressed(tree: &BranchGraph, look: &Look) -> Dressed {
    let look = Look { texture_size: 256, ..look.clone() };
    dress(tree, Mesh::default(), &look).unwrap()
}

/// A straight level twig of one long internode with a stub as its foot.
fn twig(species: &str, length: f32) -> BranchGraph {
    let info = TreeInfo { species: species.into(), age: 1, gravitropism: 0.0, seed: 7 };
    let edge = |length| ChildSignature { rotation: Quat::IDENTITY, thickness: 0.01, length };
    let mut tree = BranchGraph::new(info, Vec3::Y, edge(0.0));
    tree.grow(0, [Some(edge(length)), None, None]);
    tree
}

/// Angles around the twig's axis of its shoots' feet, from its foot to its tip, in degrees.
fn azimuths(species: &str) -> Vec<f32> {
    let tree = twig(species, 6.0);
    let node = tree.node(1);
    let (front, up) = (node.front(), node.up());
    let right = front.cross(up);
    let dressed = dressed(&tree, &Look::default());
    let mut feet: Vec<(f32, f32)> = dressed
        .foliage
        .iter()
        .flat_map(|foliage| &foliage.leaves)
        .map(|leaf| leaf.position - node.base())
        // Not the shoot at the tip.
        .filter(|p| (*p - front * p.dot(front)).length() > 1e-3)
        .map(|p| (p.dot(front), p.dot(up).atan2(p.dot(right)).to_degrees()))
        .collect();
    feet.sort_by(|a, b| a.0.total_cmp(&b.0));
    feet.into_iter().map(|(_, angle)| angle).collect()
}

/// The least turn between two directions, from 0 to 180 degrees.
fn between(a: f32, b: f32) -> f32 {
    let turn = (a - b).rem_euclid(360.0);
    turn.min(360.0 - turn)
}

#[test]
fn shoots_diverge_by_the_angles_of_their_phyllotaxis() {
    for (species, divergence) in [
        ("oak", 137.508),
        ("tulip", 137.508),
        ("walnut", 137.508),
        ("willow", 137.508),
        ("corkscrew", 137.508),
        ("beech", 180.0),
    ] {
        let azimuths = azimuths(species);
        assert!(azimuths.len() > 15, "{species}: {}", azimuths.len());
        for pair in azimuths.windows(2) {
            let turn = between(pair[0], pair[1]);
            assert!((turn - divergence).abs() < 0.1, "{species}: {turn}°");
        }
    }
}

#[test]
fn opposite_and_whorled_shoots_stand_in_the_gaps_of_those_before() {
    for (species, many) in [("maple", 2), ("pine", 4)] {
        let azimuths = azimuths(species);
        assert!(azimuths.len() > 15 && azimuths.len().is_multiple_of(many), "{species}");
        let neighbours = 360.0 / many as f32;
        for (k, &angle) in azimuths.iter().enumerate() {
            // In units of half the angle between neighbours, from the first: even in even whorls.
            let steps = between(angle, azimuths[0]) / (neighbours / 2.0);
            assert!((steps - steps.round()).abs() < 0.01, "{species}: {steps}");
            assert_eq!(steps.round() as usize % 2, k / many % 2, "{species} {k}");
        }
    }
}

#[test]
fn the_leaf_area_index_is_that_of_real_crowns_at_every_level_of_detail() {
    // Closed stands of deciduous broad-leaved and of coniferous trees: mostly 3 to 8 (Asner,
    // Scurlock and Hicke 2003, "Global synthesis of leaf area index observations").
    for species in SPECIES {
        let tree = grown(species, 1);
        let fine = dressed(&tree, &Look::default());
        let index = fine.leaf_area_index();
        let shoots = fine.foliage.iter().map(|f| f.leaves.len()).sum::<usize>();
        println!("{species}: index {index:.1}, {:.0} m², {shoots} shoots", fine.leaf_area());
        assert!((3.0..8.0).contains(&index), "{species}: {index}");
        for lod in 1..=3 {
            let coarse = dressed(&tree, &Look { lod, ..Look::default() });
            let share = coarse.leaf_area() / fine.leaf_area();
            assert!((0.9..1.1).contains(&share), "{species} at level {lod}: {share}");
            let fewer = coarse.foliage.iter().map(|f| f.leaves.len()).sum::<usize>();
            assert!(fewer < shoots * 6 / 10, "{species} at level {lod}: {fewer} of {shoots}");
        }
    }
}

#[test]
fn leaf_density_is_a_factor_of_the_leaf_area() {
    let tree = grown("maple", 3);
    let area = dressed(&tree, &Look::default()).leaf_area();
    for density in [0.3, 2.0] {
        let other = dressed(&tree, &Look { density, ..Look::default() }).leaf_area();
        let share = other / area / f64::from(density);
        assert!((0.93..1.07).contains(&share), "{density}: {share}");
    }
}

#[test]
fn only_pines_have_leaves_in_winter_others_bare_twigs() {
    for species in SPECIES {
        let tree = grown(species, 2);
        let count = |season| -> usize {
            let look = Look { season, ..Look::default() };
            let dressed = dressed(&tree, &look);
            let leafy = dressed.foliage.iter().filter(|foliage| !foliage.woody);
            assert_eq!(dressed.leaf_area() > 0.0, leafy.clone().count() > 0);
            leafy.map(|foliage| foliage.leaves.len()).sum()
        };
        let [spring, summer, autumn, winter] = Season::ALL.map(count);
        if species == "pine" {
            assert_eq!([spring, autumn, winter], [summer; 3]);
        } else {
            assert!(winter == 0 && autumn < summer && spring < summer, "{species}");
            // Every shoot of summer is a twig in winter.
            let winter = dressed(&tree, &Look { season: Season::Winter, ..Look::default() });
            let twigs = winter.foliage.iter().map(|twigs| twigs.leaves.len()).sum::<usize>();
            assert_eq!(twigs, summer, "{species}");
        }
        let bare = dressed(&tree, &Look { leaves: false, ..Look::default() });
        assert!(bare.foliage.is_empty() && bare.bark.color_image.is_some());
    }
}

#[test]
fn a_sick_tree_has_fewer_leaves() {
    let tree = grown("oak", 2);
    let area = |health| dressed(&tree, &Look { health, ..Look::default() }).leaf_area();
    assert!(area(0.0) < 0.5 * area(1.0) && area(0.5) < area(1.0));
}

#[test]
fn blades_and_leaves_are_sound() {
    for species in SPECIES {
        let tree = grown(species, 4);
        let reaches = reaches(&tree);
        let winter = Look { season: Season::Winter, ..Look::default() };
        let both = [Look::default(), winter].map(|look| dressed(&tree, &look).foliage);
        for foliage in both.into_iter().flatten() {
            let blade = &foliage.blade;
            let count = blade.positions.len();
            assert_eq!((blade.normals.len(), blade.uvs.len()), (count, count));
            assert!(blade.indices.iter().all(|&i| (i as usize) < count));
            assert!(blade.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-4));
            assert!(blade.uvs.iter().flatten().all(|x| (0.0..=1.0).contains(x)));
            // A shoot has the length of its scale, give or take a leaf.
            let far = blade.positions.iter().map(|p| p.length()).fold(0.0, f32::max);
            let least = if foliage.woody { 0.5 } else { 0.9 };
            assert!((least..1.6).contains(&far), "{species} {far}");
            for t in blade.indices.chunks(3) {
                let [a, b, c] = [t[0], t[1], t[2]].map(|i| blade.positions[i as usize]);
                let normal = blade.normals[t[0] as usize];
                assert!((b - a).cross(c - a).dot(normal) > 0.0, "{species}: turned over");
            }
            for leaf in &foliage.leaves {
                assert!((leaf.rotation.length() - 1.0).abs() < 1e-4);
                assert!(leaf.scale > 0.05 && leaf.scale < 2.0, "{species} {}", leaf.scale);
                // On its internode, near its tip.
                let node = tree.node(leaf.node);
                let middle = (node.base() + node.position) / 2.0;
                let within = 0.5 * node.length + node.thickness + 0.1;
                assert!(leaf.position.distance(middle) < within);
                assert!(reaches[leaf.node as usize] < 5);
            }
        }
    }
}

/// Where shoots stand, with the number that `number` gives their node; not those it gives none.
fn places(dressed: &Dressed, number: impl Fn(u32) -> Option<u32>) -> Vec<(u32, [u32; 8])> {
    let leaves = dressed.foliage.iter().flat_map(|foliage| &foliage.leaves);
    let mut all: Vec<_> = leaves
        .filter_map(|leaf| {
            let (p, q) = (leaf.position, leaf.rotation);
            let bits = [p.x, p.y, p.z, q.x, q.y, q.z, q.w, leaf.scale].map(f32::to_bits);
            number(leaf.node).map(|node| (node, bits))
        })
        .collect();
    all.sort_unstable();
    all
}

#[test]
fn pruning_changes_no_leaf_elsewhere() {
    let tree = grown("oak", 5);
    let pruned = prune(&tree, &[Cut::Above(10.0)]).unwrap();
    // Untouched is a node that keeps all that it bears, and whose parent keeps its children.
    let mut whole: Vec<bool> = pruned.kept.iter().map(Option::is_some).collect();
    for (id, node) in tree.nodes().iter().enumerate().rev() {
        whole[id] &= node.children.iter().flatten().all(|&child| whole[child as usize]);
    }
    let siblings = |id: u32| tree.node(id).parent.map(|parent| &tree.node(parent).children);
    let untouched = |id: u32| {
        whole[id as usize]
            && siblings(id).is_some_and(|all| all.iter().flatten().all(|&s| whole[s as usize]))
    };
    let before = dressed(&tree, &Look::default());
    let before = places(&before, |id| pruned.kept[id as usize].filter(|_| untouched(id)));
    let same: Vec<u32> = before.iter().map(|place| place.0).collect();
    let after = dressed(&pruned.tree, &Look::default());
    let after = places(&after, |id| Some(id).filter(|id| same.binary_search(id).is_ok()));
    assert!(before.len() > 500, "{}", before.len());
    assert_eq!(before, after);
}

#[test]
fn looks_out_of_range_are_refused() {
    let tree = twig("oak", 1.0);
    let refused = |look: Look| dress(&tree, Mesh::default(), &look).unwrap_err();
    let zero = refused(Look { texture_size: 0, ..Look::default() });
    assert_eq!(zero, LookError::TextureSize { value: 0 });
    assert!(zero.to_string().contains("from 256 to 2048"));
    assert!(refused(Look { health: 2.0, ..Look::default() }).to_string().contains("health is 2"));
}

#[test]
fn trees_that_are_no_plants_are_dressed_without_a_panic() {
    for seed in 0..30 {
        let tree = deeptree_graph::testing::random_tree(seed, 200);
        let dressed = dressed(&tree, &Look { health: 0.5, ..Look::default() });
        for leaf in dressed.foliage.iter().flat_map(|foliage| &foliage.leaves) {
            assert!(leaf.position.is_finite() && leaf.rotation.is_normalized());
        }
    }
}

/// SHA-256 of where leaves of one oak stand, and of the pictures of all species, 256 pixels a side.
///
/// A change here changes leaves and textures of the same seed: if it is meant, take what the test
/// prints, and list the change in CHANGELOG.md under "Results changed".
const GOLDEN: [&str; 2] = [
    "9acbbf13cf8392533a2685317d829dee644c64d48a6f6d6da6a0f4b8c0470d82",
    "d2dba9ea9ea07ab00ff521519890ae9bdec04ad88ac3b5ea71a406ad6cce3055",
];

#[test]
fn leaves_and_pictures_have_the_golden_bits() {
    let (mut stand, mut painted) = (Sha256::new(), Sha256::new());
    for (_, bits) in places(&dressed(&grown("oak", 9), &Look::default()), Some) {
        bits.iter().for_each(|word| stand.update(word.to_le_bytes()));
    }
    for (species, season) in SPECIES.iter().zip(Season::ALL.iter().cycle()) {
        let look = Look { season: *season, health: 0.8, texture_size: 256, ..Look::default() };
        let tree = twig(species, 1.0);
        let dressed = dress(&tree, Mesh::default(), &look).unwrap();
        let leaves = dressed.foliage.first().map(|foliage| &foliage.material);
        for material in core::iter::once(&dressed.bark).chain(leaves) {
            for image in [&material.color_image, &material.normal_image, &material.roughness_image]
            {
                // Bare twigs have none.
                image.iter().for_each(|image| painted.update(&image.pixels));
            }
        }
    }
    let hex = |hash: Sha256| -> String {
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    };
    assert_eq!([stand, painted].map(hex), GOLDEN, "leaves or pictures have changed");
}
