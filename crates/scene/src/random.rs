//! Random scenes to learn from.

use deeptree_graph::{Draws, Lineage, Purpose, Seed, Vec3};

use crate::boxes::{BoxShape, Cuboid};
use crate::scene::{FOOT, Scene};

/// Half of a wall's thickness in metres.
const WALL_HALF: f32 = 2.0;

impl Scene {
    /// The scene of a seed: a wall, an L of two walls, boxes, or a wall and boxes.
    ///
    /// Of ten scenes four have one wall, two an L, two one to four boxes, and two a wall and as many
    /// boxes. Walls stand at 2 to 10 m from the foot, are 4 m thick, and 10 to 40 m high and wide.
    /// Boxes have sides of 1 to 6 m, stand at 1.5 to 8 m from the foot with any yaw, and half of
    /// them hang at a height of 2 to 12 m.
    ///
    /// # Source
    ///
    /// The walls are those of the paper's scenes; the boxes stand for "obstacles randomly placed in
    /// the vicinity", of which it says no more.
    #[must_use]
    pub fn random(seed: Seed) -> Self {
        let mut draws = seed.draws(Lineage::ROOT, Purpose::Scenery);
        let kind = draws.index(10);
        let (walls, has_boxes) = match kind {
            0..4 => (1, false),
            4..6 => (2, false),
            6..8 => (0, true),
            _ => (1, true),
        };
        let yaw = uniform(&mut draws, -180.0, 180.0);
        let mut boxes: Vec<Cuboid> = Vec::new();
        for k in 0..walls {
            boxes.extend(wall(&mut draws, yaw + 90.0 * k as f32));
        }
        if has_boxes {
            for _ in 0..=draws.index(4) {
                boxes.extend(block(&mut draws));
            }
        }
        // Nothing stands nearer than 1.5 m to the axis, so the foot is always free.
        Self::new(boxes, Vec::new()).unwrap_or_default()
    }
}

fn uniform(draws: &mut Draws, low: f32, high: f32) -> f32 {
    low + (high - low) * draws.uniform() as f32
}

/// The unit vector that a yaw turns +x to.
fn facing(yaw: f32) -> Vec3 {
    let yaw = f64::from(yaw).to_radians();
    Vec3::new(libm::cos(yaw) as f32, 0.0, -libm::sin(yaw) as f32)
}

/// A wall that faces the tree: its near face is the given way off.
fn wall(draws: &mut Draws, yaw: f32) -> Option<Cuboid> {
    let distance = uniform(draws, 2.0, 10.0);
    let (height, width) = (uniform(draws, 5.0, 20.0), uniform(draws, 5.0, 20.0));
    let center = (distance + WALL_HALF) * facing(yaw) + height * Vec3::Y;
    let half = Vec3::new(WALL_HALF, height, width);
    Cuboid::new(BoxShape::Turned { center, half, yaw }).ok()
}

/// A box near the tree, on the ground or above it.
fn block(draws: &mut Draws) -> Option<Cuboid> {
    let half = Vec3::from(std::array::from_fn(|_| uniform(draws, 0.5, 3.0)));
    let distance = uniform(draws, 1.5, 8.0) + libm::sqrtf(half.x * half.x + half.z * half.z);
    let place = distance * facing(uniform(draws, -180.0, 180.0));
    let hangs = draws.index(2) == 1;
    let lowest = if hangs { uniform(draws, 2.0 * FOOT, 12.0) } else { 0.0 };
    let center = place + (lowest + half.y) * Vec3::Y;
    Cuboid::new(BoxShape::Turned { center, half, yaw: uniform(draws, -180.0, 180.0) }).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const N: u64 = 2000;

    #[test]
    fn every_scene_has_obstacles_and_a_free_foot() {
        for seed in 0..N {
            let scene = Scene::random(Seed(seed));
            assert!((1..=5).contains(&scene.boxes().len()), "{seed}");
            assert!(!scene.crosses(Vec3::ZERO, Vec3::Y));
            let grid = scene.occupancy();
            // A box with sides of a metre takes a voxel at least, unless it hangs out of the space.
            assert!(!grid.is_empty(), "{seed}");
        }
        assert_eq!(Scene::random(Seed(5)), Scene::random(Seed(5)));
        assert_ne!(Scene::random(Seed(5)), Scene::random(Seed(6)));
    }

    #[test]
    fn walls_stand_between_two_and_ten_metres_away_all_around() {
        let mut sum = 0.0;
        let mut count = 0.0;
        let mut quarters = [0u32; 4];
        for seed in 0..N {
            for cuboid in Scene::random(Seed(seed)).boxes() {
                let BoxShape::Turned { center, half, .. } = cuboid.shape() else { panic!() };
                if half.y < 5.0 {
                    continue;
                }
                let distance = f64::from(center.x.hypot(center.z) - WALL_HALF);
                assert!((1.999..10.001).contains(&distance), "{distance}");
                assert!((center.y - half.y).abs() < 1e-4, "it stands on the ground");
                // The near face: just before it is free, just behind it is not.
                let way = Vec3::new(center.x, 0.0, center.z).normalize();
                let at = |d: f32| cuboid.contains(way * d + Vec3::Y);
                assert!(!at(distance as f32 - 0.01) && at(distance as f32 + 0.01));
                sum += distance;
                count += 1.0;
                quarters[usize::from(center.x > 0.0) + 2 * usize::from(center.z > 0.0)] += 1;
            }
        }
        // The mean of U(2, 10) is 6, its variance 64 / 12; five standard errors.
        let error = (64.0f64 / 12.0 / count).sqrt();
        assert!((sum / count - 6.0).abs() < 5.0 * error, "{} ± {error}", sum / count);
        for quarter in quarters {
            assert!((f64::from(quarter) / count - 0.25).abs() < 5.0 * (0.1875 / count).sqrt());
        }
    }
}
