//! What holds for every tree that is pruned and grown again.
#![allow(clippy::unwrap_used, reason = "a test that cannot set its stage has failed")]

mod common;

use common::{depths, shipped};
use deeptree_generate::{GenerateError, Limits, RegrowError, Regrown, Request, generate, regrow};
use deeptree_graph::signature::{TreeConditions, tip_count};
use deeptree_graph::{
    BranchGraph, ChildSignature, Cut, Lineage, Node, Quat, Seed, TreeTraits, Vec3, plans, reaches,
    senses,
};
use deeptree_infer::{Active, Branchlet, Former, Model, Predictor, Settled, SimdPath, Workspace};

fn published() -> Model {
    Model::from_bytes(include_bytes!("../../../models/paper.safetensors")).unwrap()
}

fn grown(model: &Model, species: &str, seed: u64, budget: usize) -> BranchGraph {
    let limits = Limits { budget, ..Limits::default() };
    let request = Request::new(species, Seed(seed));
    generate(model, &request, limits, &mut Workspace::default()).unwrap().tree
}

fn again(model: &Model, tree: &BranchGraph, cuts: &[Cut], seed: u64) -> Regrown {
    let limits = Limits::default();
    regrow(model, tree, cuts, Seed(seed), limits, &mut Workspace::default()).unwrap()
}

/// One of each kind of cut that leaves something of a tree.
fn cuts(tree: &BranchGraph) -> Vec<Cut> {
    let crown = Vec3::new(0.0, 0.7 * TreeTraits::of(tree).height, 0.0);
    let middle = tree.len() as u32 / 2;
    vec![
        Cut::Plane { normal: Vec3::new(1.0, 0.2, 0.5), offset: 3.0 },
        Cut::Box { min: crown - Vec3::ONE, max: crown + 4.0 },
        Cut::Sphere { center: crown + Vec3::X, radius: 3.0 },
        Cut::Above(8.0),
        Cut::Order(1),
        Cut::Path(0.6),
        Cut::Nodes(vec![5, middle, tree.len() as u32 - 1]),
    ]
}

fn bits(node: &Node) -> Vec<u32> {
    let mut numbers = node.position.to_array().to_vec();
    numbers.extend([node.thickness, node.length, node.root_distance, node.branch_distance]);
    numbers.extend(node.rotation.to_array());
    numbers.extend(node.orientation.to_array());
    numbers.into_iter().map(f32::to_bits).chain([node.order.into(), node.slot.into()]).collect()
}

#[test]
fn what_is_kept_has_the_same_bits_and_stands_where_it_stood() {
    for (model, budget) in [(shipped(), 50_000), (published(), 1500)] {
        for species in ["oak", "pine"] {
            let tree = grown(&model, species, 3, budget);
            for cut in cuts(&tree) {
                // The published recipe would not end.
                let limits = Limits { budget: 6000, ..Limits::default() };
                let work = &mut Workspace::default();
                let made = regrow(&model, &tree, std::slice::from_ref(&cut), Seed(8), limits, work)
                    .unwrap();
                let standing = made.kept.iter().flatten().count();
                assert_eq!(standing, made.pruned.tree.len(), "{cut:?}");
                assert!(!made.pruned.wounds.is_empty(), "{cut:?}");
                for (old, new) in made.kept.iter().enumerate() {
                    let node = &tree.nodes()[old];
                    let Some(new) = new else {
                        assert!(made.pruned.kept[old].is_none());
                        continue;
                    };
                    let now = made.tree.node(*new);
                    assert_eq!(bits(now), bits(node), "{species} {cut:?}");
                    let parent = |id: u32| made.kept[id as usize].unwrap();
                    assert_eq!(now.parent, node.parent.map(parent));
                }
                let levels: Vec<Option<u32>> =
                    made.tree.nodes().iter().map(|node| node.parent).collect();
                assert!(levels.is_sorted(), "{cut:?}: not in level order");
            }
        }
    }
}

#[test]
fn a_tree_of_which_nothing_is_cut_stays_as_it_is() {
    let model = shipped();
    let mut tree = grown(&model, "maple", 2, 50_000);
    let made = again(&model, &tree, &[Cut::Above(1000.0)], 5);
    tree.info.seed = 5;
    assert!(made.tree == tree);
    assert!(made.pruned.wounds.is_empty());
}

#[test]
fn every_batch_and_instruction_set_gives_the_same_tree() {
    let model = shipped();
    let tree = grown(&model, "beech", 4, 50_000);
    let cuts = [Cut::Above(12.0), Cut::Order(2)];
    let make = |batch, budget, path| {
        let limits = Limits { batch, budget };
        regrow(&model, &tree, &cuts, Seed(1), limits, &mut Workspace::new(path)).unwrap()
    };
    for budget in [50_000, 1200] {
        let expected = make(512, budget, SimdPath::Scalar);
        assert_eq!(expected.hit_budget, budget == 1200);
        for path in SimdPath::available() {
            assert!(make(512, budget, path) == expected, "on {path}");
        }
        for batch in [1, 7, 100_000] {
            assert!(make(batch, budget, SimdPath::detect()) == expected, "in batches of {batch}");
        }
    }
}

#[test]
fn another_seed_grows_another_tree() {
    let model = shipped();
    let tree = grown(&model, "oak", 4, 50_000);
    let make = |seed| again(&model, &tree, &[Cut::Above(8.0)], seed).tree;
    let places = |tree: &BranchGraph| -> Vec<[u32; 3]> {
        tree.nodes().iter().map(|node| node.position.to_array().map(f32::to_bits)).collect()
    };
    assert_eq!(places(&make(1)), places(&make(1)));
    assert_ne!(places(&make(1)), places(&make(2)));
}

#[test]
fn a_wound_grows_again_the_same_up_to_the_level_of_any_other() {
    // Nodes can see what has grown up to their level, but not what another wound will bear.
    let model = shipped();
    let tree = grown(&model, "walnut", 6, 50_000);
    let before = depths(&tree);
    let deepest = *before.iter().max().unwrap();
    let first = before.iter().rposition(|&depth| depth == deepest / 3).unwrap() as u32;
    let alone = again(&model, &tree, &[Cut::Nodes(vec![first])], 9);
    let of_first =
        |id: u32| std::iter::successors(Some(id), |&id| tree.node(id).parent).any(|id| id == first);
    for depth in [deepest / 2, deepest - 2] {
        let at = |id: &u32| before[*id as usize] == depth && !of_first(*id);
        let other = (0..tree.len() as u32).find(at).unwrap();
        let both = again(&model, &tree, &[Cut::Nodes(vec![first, other])], 9);
        let levels = |made: &Regrown| -> Vec<Vec<u32>> {
            let depths = depths(&made.tree);
            let nodes = depths.iter().zip(made.tree.nodes());
            nodes.filter(|(at, _)| **at < depth).map(|(_, node)| bits(node)).collect()
        };
        assert_eq!(levels(&alone), levels(&both));
        assert!(levels(&alone).len() > 100);
        assert_ne!(alone.tree, both.tree);
    }
}

#[test]
fn a_child_that_is_cut_comes_back_as_thick_as_it_was() {
    let model = shipped();
    let tree = grown(&model, "oak", 7, 50_000);
    let fork = tree.nodes().iter().find(|node| node.child_count() > 1).unwrap();
    let [first, second] = [0, 1].map(|i| *fork.children.iter().flatten().nth(i).unwrap());
    let made = again(&model, &tree, &[Cut::Nodes(vec![second])], 9);
    let (lost, stays) = (tree.node(second), made.kept[first as usize].unwrap());
    let fork = made.tree.node(made.tree.node(stays).parent.unwrap());
    let back = fork.children[usize::from(lost.slot)].unwrap();
    assert_eq!(made.tree.node(back).thickness.to_bits(), lost.thickness.to_bits());
    let reach = |tree: &BranchGraph, id: u32| reaches(tree)[id as usize];
    assert_eq!(reach(&made.tree, back), reach(&tree, second));
    assert_ne!(made.tree.node(back).rotation, lost.rotation);
}

#[test]
fn tips_are_conserved_and_nothing_grows_below_the_ground() {
    let model = shipped();
    for (number, species) in model.species().iter().enumerate() {
        let tree = grown(&model, species, 9, 50_000);
        for cut in cuts(&tree) {
            let made = again(&model, &tree, &[cut], 1);
            assert!(!made.hit_budget);
            let tips = |node: &Node| tip_count(node.thickness, model.tip_radius(number));
            assert_eq!(tips(made.tree.root()), tips(tree.root()));
            for node in made.tree.nodes() {
                let children = node.children.iter().flatten();
                let above: u32 = children.map(|&id| tips(made.tree.node(id))).sum();
                // A child that would end below the ground takes its tips with it.
                let near_ground = node.position.y < 1.1;
                assert!((above..=above + 3).contains(&tips(node)) || near_ground, "{species}");
                assert!(node.position.y > -1e-4, "{species}");
            }
        }
    }
}

/// The branchlets of all nodes of a tree, with what is settled of each, drawn with the tree's seed.
fn branchlets(
    model: &Model,
    tree: &BranchGraph,
    traits: TreeTraits,
    settled: &[Option<Settled>],
) -> Vec<Branchlet> {
    let species = model.species().iter().position(|name| *name == tree.info.species).unwrap();
    let tip_radius = model.tip_radius(species);
    let own = TreeConditions::of(tree, species, tip_radius, model.kin(species));
    let conditions = TreeConditions { traits, ..own };
    let mut lineages = vec![Lineage::ROOT; tree.len()];
    for (id, node) in tree.nodes().iter().enumerate().skip(1) {
        lineages[id] = lineages[node.parent.unwrap() as usize].child(node.slot);
    }
    let plans = plans(tree);
    let senses = senses(tree, tip_radius, &plans);
    let active = |id: usize| Active {
        node: &tree.nodes()[id],
        parent: tree.nodes()[id].parent.map(|id| tree.node(id)),
        lineage: lineages[id],
        seed: Seed(tree.info.seed),
        tree: conditions,
        plan: plans[id],
        sense: senses[id],
        settled: settled[id].as_ref(),
        room: None,
        points: None,
    };
    let frontier: Vec<Active<'_>> = (0..tree.len()).map(active).collect();
    let mut branchlets = Vec::new();
    model.branchlets(&frontier, &mut Workspace::default(), &mut branchlets).unwrap();
    branchlets
}

#[test]
fn with_the_seed_of_the_tree_a_child_comes_back_where_it_was() {
    // All that a child's place is drawn from is as it was, so it must be drawn the same; the turns
    // of its siblings are told from their rotations, which rounds.
    for model in [shipped(), published()] {
        let tree = grown(&model, "maple", 1, 3000);
        let traits = TreeTraits::of(&tree);
        let whole = branchlets(&model, &tree, traits, &vec![None; tree.len()]);
        for cut in 0..3 {
            let settle = |branchlet: &Branchlet| {
                let former = |slot: usize| {
                    let child = branchlet.children[slot]?;
                    let (thickness, plan) = (child.thickness, branchlet.plans[slot]);
                    let standing = (slot != cut).then_some(child);
                    Some(Former { thickness, plan, standing })
                };
                let children = [former(0), former(1), former(2)];
                let loses = children[cut].is_some() && children.iter().flatten().count() > 1;
                loses.then_some(Settled { children })
            };
            let settled: Vec<Option<Settled>> = whole.iter().map(settle).collect();
            let back = branchlets(&model, &tree, traits, &settled);
            let (mut lost, mut same) = (0, 0);
            for ((whole, back), settled) in whole.iter().zip(&back).zip(&settled) {
                let Some(settled) = settled else {
                    assert_eq!(whole, back);
                    continue;
                };
                for slot in (0..3).filter(|&slot| slot != cut) {
                    assert_eq!(back.children[slot], whole.children[slot]);
                }
                assert_eq!(back.plans, whole.plans);
                lost += 1;
                let child = settled.children[cut].unwrap();
                assert!(child.standing.is_none());
                let (was, is) = (whole.children[cut].unwrap(), back.children[cut]);
                same += usize::from(is.is_some_and(|is| {
                    is.thickness == was.thickness
                        && is.length == was.length
                        && (is.rotation - was.rotation).length()
                            < if cut == 0 { 1e-9 } else { 1e-3 }
                }));
            }
            // A draw at the border between two laws can fall to the other side.
            assert!(lost > 50 && same * 100 >= lost * 99, "slot {cut}: {same} of {lost}");
        }
    }
}

/// Mean and standard deviation.
fn moments(values: &[f32]) -> (f32, f32) {
    let n = values.len() as f32;
    let mean = values.iter().sum::<f32>() / n;
    let square = values.iter().map(|value| (value - mean).powi(2)).sum::<f32>();
    (mean, (square / (n - 1.0)).sqrt())
}

/// Nodes, branches and height.
fn metrics(tree: &BranchGraph) -> [f32; 3] {
    let traits = TreeTraits::of(tree);
    [traits.nodes, traits.branches, traits.height]
}

#[test]
fn regrown_oaks_are_oaks() {
    let model = shipped();
    let trees: Vec<BranchGraph> =
        (0..40).map(|seed| grown(&model, "oak", 100 + seed, 50_000)).collect();
    let before: Vec<[f32; 3]> = trees.iter().map(metrics).collect();
    for cut in [Cut::Above(6.0), Cut::Order(1), Cut::Path(0.5)] {
        let after: Vec<[f32; 3]> = (0..)
            .zip(&trees)
            .map(|(seed, tree)| {
                metrics(&again(&model, tree, std::slice::from_ref(&cut), 500 + seed).tree)
            })
            .collect();
        for (i, what) in ["nodes", "branches", "height"].into_iter().enumerate() {
            let of =
                |set: &[[f32; 3]]| moments(&set.iter().map(|tree| tree[i]).collect::<Vec<_>>());
            let ((mean, sd), (mean_after, sd_after)) = (of(&before), of(&after));
            // Four standard errors of the difference of two such means, and 2 % for the networks.
            let error = 4.0 * ((sd * sd + sd_after * sd_after) / 40.0).sqrt() + 0.02 * mean;
            assert!((mean_after - mean).abs() < error, "{cut:?} {what}: {mean} {mean_after}");
            assert!((0.6..1.6).contains(&(sd_after / sd)), "{cut:?} {what}: {sd} {sd_after}");
        }
    }
}

#[test]
fn ten_regrowths_in_a_row_do_not_drift() {
    let model = shipped();
    for species in ["oak", "pine", "willow"] {
        let range = |i: usize| {
            let of = |seed| metrics(&grown(&model, species, seed, 50_000))[i];
            let values: Vec<f32> = (0..30).map(of).collect();
            let (mean, sd) = moments(&values);
            mean - 4.0 * sd..mean + 4.0 * sd
        };
        let ranges = [0, 1, 2].map(range);
        let mut tree = grown(&model, species, 31, 50_000);
        let tips = tree.root().thickness;
        for seed in 0..10 {
            // From another side each time.
            let turn = Quat::from_rotation_y(2.4 * seed as f32);
            let normal = turn * Vec3::new(1.0, 0.5, 0.0);
            let cuts = [Cut::Plane { normal, offset: 4.0 }, Cut::Path(0.9)];
            let made = again(&model, &tree, &cuts, seed);
            assert!(made.pruned.tree.len() < made.tree.len() && !made.hit_budget);
            tree = made.tree;
            let metrics = metrics(&tree);
            for (value, range) in metrics.iter().zip(&ranges) {
                assert!(range.contains(value), "{species} {seed}: {metrics:?} {ranges:?}");
            }
            assert_eq!(tree.root().thickness.to_bits(), tips.to_bits());
        }
    }
}

#[test]
fn a_budget_keeps_what_was_kept() {
    let model = shipped();
    let tree = grown(&model, "oak", 1, 50_000);
    let cuts = [Cut::Above(10.0)];
    let whole = again(&model, &tree, &cuts, 3);
    let kept = whole.pruned.tree.len();
    for budget in [1, kept, kept + 100] {
        let limits = Limits { budget, ..Limits::default() };
        let work = &mut Workspace::default();
        let made = regrow(&model, &tree, &cuts, Seed(3), limits, work).unwrap();
        assert!(made.hit_budget);
        assert_eq!(made.kept.iter().flatten().count(), kept);
        assert!((kept.max(budget.saturating_sub(2))..=kept.max(budget)).contains(&made.tree.len()));
    }
    let limits = Limits { budget: whole.tree.len(), ..Limits::default() };
    let made = regrow(&model, &tree, &cuts, Seed(3), limits, &mut Workspace::default()).unwrap();
    assert!(made == whole);
}

#[test]
fn trees_that_no_model_can_regrow_are_refused() {
    let model = shipped();
    let tree = grown(&model, "oak", 1, 50_000);
    let fails = |model: &Model, change: &dyn Fn(&mut BranchGraph)| {
        let mut tree = tree.clone();
        change(&mut tree);
        let (seed, limits) = (Seed(0), Limits::default());
        regrow(model, &tree, &[Cut::Above(9.0)], seed, limits, &mut Workspace::default())
    };
    use RegrowError::{Foot, Generate, NoPipes};
    let elm = fails(&model, &|tree| tree.info.species = "elm".into());
    assert!(matches!(elm, Err(Generate(GenerateError::UnknownSpecies { .. }))));
    let old = fails(&model, &|tree| tree.info.age = 90);
    assert!(matches!(old, Err(Generate(GenerateError::OutOfRange { what: "age", .. }))));
    let up = fails(&model, &|tree| tree.info.gravitropism = f32::NAN);
    assert!(matches!(up, Err(Generate(GenerateError::NotFinite { .. }))));
    let rows = |tree: &BranchGraph| tree.rows().collect::<Vec<_>>();
    let away = fails(&model, &|tree| {
        let mut rows = rows(tree);
        rows.iter_mut().for_each(|row| row.position += Vec3::new(5.0, 0.0, 0.0));
        *tree = BranchGraph::from_rows(tree.info.clone(), &rows).unwrap();
    });
    assert!(matches!(away, Err(Foot { foot }) if (foot.x - 5.0).abs() < 1e-3));
    for radius in [0.0, 0.02, 0.3] {
        let even = |tree: &mut BranchGraph| {
            let mut rows = rows(tree);
            rows.iter_mut().for_each(|row| row.radius = radius);
            *tree = BranchGraph::from_rows(tree.info.clone(), &rows).unwrap();
        };
        assert!(matches!(fails(&model, &even), Err(NoPipes { .. })), "{radius}");
        // The published recipe does not read the radii so.
        assert!(fails(&published(), &even).is_ok());
    }
    let root = regrow(
        &model,
        &tree,
        &[Cut::Above(-1.0)],
        Seed(0),
        Limits::default(),
        &mut Workspace::default(),
    );
    assert!(matches!(root, Err(RegrowError::Prune(_))));
}

#[test]
fn a_root_alone_grows_a_whole_tree_of_its_traits() {
    // Nothing but the root is left: all is drawn anew, from the same root and to the same plan.
    let model = shipped();
    for species in ["beech", "tulip"] {
        let tree = grown(&model, species, 12, 50_000);
        let cuts = [Cut::Nodes(tree.root().children.into_iter().flatten().collect())];
        let made = again(&model, &tree, &cuts, 77);
        assert_eq!(made.pruned.tree.len(), 1);
        assert_eq!(reaches(&made.tree)[0], reaches(&tree)[0]);
        let root = |tree: &BranchGraph| -> ChildSignature { tree.root().as_child() };
        assert_eq!(root(&made.tree), root(&tree));
        let (now, before) = (metrics(&made.tree), metrics(&tree));
        for (now, before) in now.into_iter().zip(before) {
            assert!((0.75..1.33).contains(&(now / before)), "{species}: {now} {before}");
        }
    }
}
