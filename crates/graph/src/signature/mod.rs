//! What a network reads of one node: the only definition, for training and for inference.
//!
//! Two encodings of the same node, one a model kind:
//!
//! - [`paper`]: the attributes of Eq. 1, each scaled to about 1;
//! - [`situated`]: the same place told so that a small network can use it: integer tip counts of
//!   the pipe model, the reach and the nodes below the node ([`inheritance`] and [`size`]: how its
//!   children inherit them), one-hots of distances that are nearly whole numbers, and all directions
//!   in the node's own frame, so that nothing depends on the yaw of the tree.
//!
//! [`outlook`] is what is read of a tree's environment as a whole, [`competition`] what is read of
//! the trees around it, [`points`] what is heard of a cloud around a node.

pub mod competition;
pub mod inheritance;
pub mod outlook;
pub mod paper;
pub mod points;
pub mod situated;
pub mod size;

use glam::Vec3;

use crate::graph::BranchGraph;
use crate::kin::{Kin, Kinsman};
use crate::traits::TreeTraits;

/// Side of the growth space in metres: positions over this lie in the paper's unit cube.
pub const GROWTH_SPACE: f32 = 64.0;

/// What all nodes of a tree share, as the networks read it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TreeConditions {
    /// a: age in growth cycles.
    pub age: f32,
    /// v: gravitropism.
    pub gravitropism: f32,
    /// s: index of the species in the model's list.
    pub species: usize,
    /// Radius of a twig that bears one tip, in metres: the unit of the pipe model.
    pub tip_radius: f32,
    /// Tips of the whole tree: those above its root.
    pub root_tips: u32,
    /// What the tree as a whole is like; kind `situated` only.
    pub traits: TreeTraits,
    /// Where the tree stands among its kin; zeros where nothing is known of them. Kind `situated`
    /// only.
    pub standing: [f32; Kin::NUMBERS],
}

impl TreeConditions {
    /// Those of a finished tree, of species number `species`, whose twigs of one tip have the radius
    /// `tip_radius`, in metres, among its kin.
    #[must_use]
    pub fn of(tree: &BranchGraph, species: usize, tip_radius: f32, kin: Option<&Kin>) -> Self {
        let root_tips = tip_count(tree.root().thickness, tip_radius);
        let standing = kin.map(|kin| kin.standing(&Kinsman::of(tree, root_tips)));
        Self {
            age: tree.info.age as f32,
            gravitropism: tree.info.gravitropism,
            species,
            tip_radius,
            root_tips,
            traits: TreeTraits::of(tree),
            standing: standing.unwrap_or_default(),
        }
    }
}

/// The integer tip count N of the pipe model: `N = (t / t_tip)²`, at least 1.
///
/// All tips have the same radius, and a parent's cross-section is the sum of its children's, so N
/// counts the tips of the whole tree above a node, the ones an export dropped included.
#[must_use]
pub fn tip_count(thickness: f32, tip_radius: f32) -> u32 {
    let ratio = thickness / tip_radius;
    libm::roundf(ratio * ratio).clamp(1.0, 16_777_216.0) as u32
}

/// The radius of a branch that bears `tips` tips: `t = t_tip · √N`, in metres.
#[must_use]
pub fn thickness_of(tips: u32, tip_radius: f32) -> f32 {
    tip_radius * libm::sqrtf(tips as f32)
}

/// Writes features one after another.
struct Writer<'a> {
    out: &'a mut [f32],
    at: usize,
}

impl Writer<'_> {
    fn put(&mut self, value: f32) {
        self.out[self.at] = value;
        self.at += 1;
    }

    fn put3(&mut self, v: Vec3) {
        v.to_array().into_iter().for_each(|x| self.put(x));
    }

    /// `len` values, 1 at `index`, which is clamped into the range.
    fn one_hot(&mut self, index: usize, len: usize) {
        self.out[self.at..self.at + len].fill(0.0);
        self.out[self.at + index.min(len - 1)] = 1.0;
        self.at += len;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::crowding::{Crowd, Sense};
    use crate::graph::{ChildSignature, TreeInfo};
    use crate::plan::Plan;
    use crate::surround::Surround;
    use glam::{Quat, Vec2};

    const PLAN: Plan = Plan { reach: 4, nodes: 9 };

    fn conditions() -> TreeConditions {
        let traits = TreeTraits::of(&tree(0.0));
        let (species, tip_radius, root_tips) = (2, 0.01, 9);
        let standing = std::array::from_fn(|i| 0.25 * i as f32 - 1.0);
        let (age, gravitropism) = (35.0, -0.1);
        TreeConditions { age, gravitropism, species, tip_radius, root_tips, traits, standing }
    }

    /// What has grown so far, turned by `yaw` about the vertical.
    fn sense(yaw: f32) -> Sense {
        let turned = |x, y, z| Quat::from_rotation_y(yaw) * Vec3::new(x, y, z);
        Sense {
            centre: turned(0.3, 4.0, -0.2),
            outlook: turned(1.5, 9.0, 0.7),
            near: Crowd { nodes: 7, towards: turned(0.2, -0.4, 0.1) },
            wide: Crowd { nodes: 80, towards: turned(-1.0, 3.0, 2.0) },
            surround: Surround { taken: 9, shade: 0.3, bright: turned(0.6, 0.0, 0.8) },
        }
    }

    /// A trunk of two internodes with one lateral, turned by `yaw` about the vertical.
    fn tree(yaw: f32) -> BranchGraph {
        let info = TreeInfo { species: "oak".into(), age: 35, gravitropism: -0.1, seed: 0 };
        let upright =
            Quat::from_rotation_y(yaw) * Quat::from_rotation_x(core::f32::consts::FRAC_PI_2);
        let node = |rotation, thickness| ChildSignature { rotation, thickness, length: 1.0 };
        let mut tree = BranchGraph::new(info, Vec3::ZERO, node(upright, 0.03));
        tree.grow(
            0,
            [
                Some(node(Quat::from_rotation_x(0.1), 0.02)),
                Some(node(Quat::from_rotation_x(0.8), 0.02)),
                None,
            ],
        );
        tree
    }

    #[test]
    fn situated_features_do_not_depend_on_the_yaw_of_the_tree() {
        let mut features = [vec![0.0; situated::len(8)], vec![0.0; situated::len(8)]];
        for id in 1..3 {
            for (yaw, out) in [0.0, 2.1].into_iter().zip(&mut features) {
                situated::encode(tree(yaw).node(id), &conditions(), PLAN, &sense(yaw), 8, out);
            }
            for (a, b) in features[0].iter().zip(&features[1]) {
                assert!((a - b).abs() < 1e-5, "{a} {b}");
            }
        }
    }

    #[test]
    fn situated_attributes_stand_where_they_are_said_to() {
        use situated::{ATTRIBUTES, attribute};
        let (node, tree) = (tree(0.3).node(2).clone(), conditions());
        let features = |node: &crate::Node, tree: &TreeConditions, plan: Plan, sense: &Sense| {
            let mut out: Vec<f32> = vec![0.0; situated::len(8)];
            situated::encode(node, tree, plan, sense, 8, &mut out);
            out
        };
        let before = features(&node, &tree, PLAN, &sense(0.3));
        let mut end = 0;
        for name in ATTRIBUTES {
            let (mut node, mut tree, mut plan) = (node.clone(), tree, PLAN);
            let mut sense = sense(0.3);
            match name {
                "s" => tree.species = 3,
                "a" => tree.age += 1.0,
                "v" => tree.gravitropism += 0.1,
                "traits" => tree.traits.nodes += 9.0,
                "standing" => tree.standing[3] += 1.0,
                "n" => node.thickness *= 3.0,
                "reach" => (plan.reach, plan.nodes) = (plan.reach + 1, plan.nodes + 1),
                "size" => plan.nodes += 1,
                "ds" => node.branch_distance += 4.0,
                "df" => node.fork_distance += 4.0,
                "dr" => node.root_distance += 4.0,
                "o" => node.order += 1,
                "mp" => node.sibling_count = if node.sibling_count == 1 { 2 } else { 1 },
                "slot" => node.slot = (node.slot + 1) % 3,
                "qp" => node.rotation = Quat::from_xyzw(0.5, 0.5, 0.5, 0.5),
                "lp" => node.length += 1.0,
                // A point on the axis, seen from a node that looks along it: only heights change.
                "place" => continue_at(&mut end, attribute("place", 8)),
                "frame" => node.orientation *= Quat::from_rotation_x(0.4),
                "sense" => sense.outlook.x += 1.0,
                "env" => sense.surround.taken ^= 1,
                other => panic!("{other}"),
            }
            let mut range = attribute(name, 8).unwrap();
            if name != "place" {
                assert_eq!(range.start, end, "{name}");
                end = range.end;
                // Of two attributes, a part is told in the light of another.
                match name {
                    "n" => range.end = attribute("size", 8).unwrap().end,
                    "reach" => range.end = attribute("size", 8).unwrap().end,
                    "frame" => range.end = attribute("env", 8).unwrap().end,
                    _ => {}
                }
                let after = features(&node, &tree, plan, &sense);
                let changed: Vec<usize> = (0..after.len())
                    .filter(|&i| after[i].to_bits() != before[i].to_bits())
                    .collect();
                assert!(!changed.is_empty(), "{name}");
                assert!(changed.iter().all(|i| range.contains(i)), "{name}: {changed:?} {range:?}");
            }
        }
        assert_eq!(end, situated::len(8));
        assert_eq!(attribute("traits", 8), Some(situated::traits(8)));
    }

    /// The position is part of two attributes: only where the first of them stands is looked at.
    fn continue_at(end: &mut usize, range: Option<std::ops::Range<usize>>) {
        let range = range.unwrap();
        assert_eq!(range.start, *end);
        *end = range.end;
    }

    #[test]
    fn tip_counts_survive_the_way_through_a_radius() {
        for tips in (1..5000).chain([65_535, 1_000_000, 1 << 22]) {
            assert_eq!(tip_count(thickness_of(tips, 0.01), 0.01), tips);
        }
    }

    #[test]
    fn encodings_fill_every_feature() {
        let mut out = vec![f32::NAN; situated::len(8)];
        situated::encode(tree(0.3).node(2), &conditions(), PLAN, &sense(0.3), 8, &mut out);
        assert!(out.iter().all(|x| x.is_finite()));
        let mut out = vec![f32::NAN; paper::len(8)];
        paper::encode(tree(0.3).node(2), &conditions(), 8, &mut out);
        assert!(out.iter().all(|x| x.is_finite()));
    }

    #[test]
    fn of_the_32_classes_19_are_possible_for_some_tip_count() {
        let possible = |tips| {
            (0..situated::CLASSES)
                .filter(|&c| situated::Branching::from_class(c).is_possible(tips))
                .count()
        };
        // With many tips: 3 single children x 3, 3 pairs x 2, one triple; no end.
        assert_eq!(possible(100), 16);
        // With one tip: the end, or one child that bears it.
        assert_eq!(possible(1), 1 + 3);
        let ever = (0..situated::CLASSES)
            .filter(|&c| (1..10).any(|n| situated::Branching::from_class(c).is_possible(n)));
        assert_eq!(ever.count(), 19);
    }

    #[test]
    fn turns_and_rotations_are_inverse() {
        let slot = situated::Slot {
            mean: Vec2::new(0.1, 0.4),
            roll: 4.2,
            scale: Vec2::new(0.2, 0.1),
            roll_scale: 0.15,
        };
        let straight = situated::Slot { mean: Vec2::ZERO, ..slot };
        let tree = tree(0.3);
        for i in 0..50 {
            let f = i as f32;
            let swing = Vec2::new((f * 0.7).sin(), (f * 1.3).cos()) * 3.0;
            let turn = situated::Turn { swing, roll: (f * 2.1).sin() * 3.0 };
            for slot in [slot, straight] {
                for node in tree.nodes() {
                    for sign in [1.0, -1.0] {
                        let q = slot.rotation(turn, node, -0.2) * sign;
                        let back = slot.turn(q, node, -0.2);
                        assert!(back.swing.distance(swing) < 1e-4, "{turn:?} {back:?}");
                        assert!((back.roll - turn.roll).abs() < 1e-4, "{turn:?} {back:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn a_shoot_that_is_rolled_then_bent_about_one_axis_is_told_so() {
        // As the growth model makes an apical child: a roll of −120°, then the apical angle.
        let apical = Quat::from_rotation_z(-2.0) * Quat::from_rotation_y(0.35);
        let slot =
            situated::Slot { mean: Vec2::new(0.0, 0.3), roll: -2.1, ..situated::Slot::PLAIN };
        let turn = slot.turn(apical, tree(0.0).node(2), 0.0);
        assert!((turn.roll - 0.1).abs() < 1e-6, "{turn:?}");
        assert!(turn.swing.distance(Vec2::new(0.0, 0.05)) < 1e-6, "{turn:?}");
    }

    #[test]
    fn a_shoot_that_gravity_turns_by_its_part_of_the_angle_to_the_vertical_has_no_swing() {
        let slot = situated::Slot { roll: -2.0, scale: Vec2::ONE * 0.1, ..situated::Slot::PLAIN };
        let tree = tree(0.4);
        let parent = tree.node(2);
        let front = parent.orientation * Vec3::NEG_Z;
        let angle = front.angle_between(Vec3::Y);
        // A third of the way up to the vertical, about the level axis.
        let up = Quat::from_axis_angle(front.cross(Vec3::Y).normalize(), angle / 3.0);
        let child = up * parent.orientation * Quat::from_rotation_z(-2.1);
        let turn = slot.turn(parent.orientation.inverse() * child, parent, -1.0 / 3.0);
        assert!(turn.swing.length() < 1e-5, "{turn:?}");
        assert!((turn.roll + 0.1).abs() < 1e-5, "{turn:?}");
    }

    #[test]
    fn a_shoot_that_gravity_alone_bends_stays_in_the_upright_plane_of_its_parent() {
        use situated::Alignment;
        let slot = situated::Slot { roll: -2.0, scale: Vec2::ONE * 0.1, ..situated::Slot::PLAIN };
        let tree = tree(0.4);
        let parent = tree.node(2);
        let front = parent.orientation * Vec3::NEG_Z;
        let alignment = slot.alignment(0.3, parent);
        assert_eq!(alignment, Alignment::Gravity);
        let turn = situated::Turn { swing: Vec2::new(-0.7, 0.0), roll: 0.3 };
        let rotation = slot.rotation(turn, parent, 0.2);
        let bent = parent.orientation * (rotation * Vec3::NEG_Z);
        assert!(bent.distance(front) > 0.01);
        assert!(bent.dot(front.cross(Vec3::Y)).abs() < 1e-6, "{bent} {front}");
        assert!(slot.is_aligned(alignment, slot.turn(rotation, parent, 0.2)));
        assert!(!slot.is_aligned(Alignment::Straight, turn));
        // With an angle of its own, and upright: straight on or not at all.
        let angled = situated::Slot { mean: Vec2::new(0.0, 0.3), ..slot };
        assert_eq!(angled.alignment(0.0, parent), Alignment::Straight);
        let mut upright = parent.clone();
        upright.orientation = Quat::from_rotation_x(1.5);
        assert_eq!(slot.alignment(0.0, &upright), Alignment::Straight);
        let lateral = situated::Slot { roll_scale: 0.0, ..angled };
        assert_eq!(lateral.alignment(0.0, parent), Alignment::Bud);
    }

    #[test]
    fn a_lateral_keeps_its_front() {
        let slot = situated::Slot {
            mean: Vec2::new(0.8, 0.0),
            roll: core::f32::consts::PI,
            scale: Vec2::new(0.1, 0.05),
            roll_scale: 0.0,
        };
        // Upright, where a bud's plane hides what its shoot sags, and rolled by more and less.
        let tree = tree(0.0);
        let parents = [0.0, 5e-3, 0.02, 0.7, 2.0].map(|roll| {
            let mut parent = tree.node(1).clone();
            parent.orientation *= Quat::from_rotation_z(roll);
            parent
        });
        let shows = parents.each_ref().map(|parent| slot.shows_bud(parent));
        assert_eq!(shows, [false, true, true, true, true]);
        for (i, parent) in (0..50).flat_map(|i| parents.iter().map(move |parent| (i, parent))) {
            let f = i as f32;
            let bent = Vec3::new((f * 0.7).sin(), (f * 1.3).cos(), 0.2 * (f * 2.1).sin()) * 0.1;
            let q = Quat::from_rotation_z(core::f32::consts::PI)
                * Quat::from_rotation_x(0.9)
                * Quat::from_scaled_axis(bent);
            let back = slot.rotation(slot.turn(q, parent, -0.3), parent, -0.3);
            let off = (back * Vec3::NEG_Z).distance(q * Vec3::NEG_Z);
            // Where the plane is nearly upright, what rounding does is as many times larger.
            let bud = parent.orientation * slot.rotation(situated::Turn::default(), parent, 0.0);
            let level = (bud * Vec3::X).y.abs().max(1e-4);
            assert!(off < 1e-6 / level.min(0.3) && off < 1e-3, "{i}: {off} {level}");
        }
    }
}
