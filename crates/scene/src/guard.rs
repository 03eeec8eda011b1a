//! Quick answers for the many edges of a tree, few of which come near an obstacle.

use deeptree_graph::{Occupancy, Vec3, Voxel};

use crate::environment::Environment;
use crate::scene::Scene;

/// The questions of [`Environment`] that are asked of every edge, with a look at the voxels first.
#[derive(Clone, Debug)]
pub struct Guard<'a> {
    environment: &'a Environment,
    near: Occupancy,
}

impl<'a> Guard<'a> {
    /// The guard of an environment.
    #[must_use]
    pub fn new(environment: &'a Environment) -> Self {
        let near = near(&environment.scene);
        Self { environment, near }
    }

    /// The environment.
    #[must_use]
    pub fn environment(&self) -> &'a Environment {
        self.environment
    }

    /// Does the edge enter an obstacle, or lie inside one? As
    /// [`Scene::crosses`](crate::Scene::crosses).
    #[must_use]
    pub fn is_blocked(&self, base: Vec3, tip: Vec3) -> bool {
        is_blocked(&self.environment.scene, &self.near, base, tip)
    }

    /// May the edge of a node run from `base` to `tip`? As [`Environment::admits_edge`].
    #[must_use]
    pub fn admits_edge(&self, base: Vec3, tip: Vec3) -> bool {
        self.environment.volume.as_ref().is_none_or(|volume| volume.admits(tip))
            && !self.is_blocked(base, tip)
    }
}

/// The voxels within a voxel of an obstacle: from elsewhere no edge of up to 2 m enters one.
pub(crate) fn near(scene: &Scene) -> Occupancy {
    let mut near = Occupancy::EMPTY;
    for Voxel { x, y, z } in scene.occupancy().iter() {
        for i in 0..27 {
            let [dx, dy, dz] = [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1];
            let next = Voxel::at(i64::from(x) + dx, i64::from(y) + dy, i64::from(z) + dz);
            if let Some(next) = next {
                near.set(next);
            }
        }
    }
    near
}

/// Does the edge enter an obstacle, or lie inside one? `near` is that of the scene.
pub(crate) fn is_blocked(scene: &Scene, near: &Occupancy, base: Vec3, tip: Vec3) -> bool {
    if scene.is_empty() {
        return false;
    }
    // Outside of the growth space nobody knows which voxels are taken.
    let is_clear = Voxel::holding(base).is_some_and(|voxel| !near.holds(voxel))
        && Voxel::holding(tip).is_some()
        && base.distance_squared(tip) < Occupancy::VOXEL * Occupancy::VOXEL;
    !is_clear && scene.crosses(base, tip)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoxShape, Cuboid, Volume};
    use deeptree_graph::Seed;

    #[test]
    fn a_look_at_the_voxels_changes_no_answer() {
        for seed in 0..20 {
            let volume = (seed % 2 == 0).then_some(Volume::Cone);
            let environment = Environment { scene: Scene::random(Seed(seed)), volume };
            let guard = Guard::new(&environment);
            for i in 0..3000 {
                let part = |k: i32| (i * k % 701) as f32 * 0.06 - 21.0;
                let base = Vec3::new(part(37), part(59) + 21.0, part(83));
                let way = Vec3::new(part(11), part(13), part(17)).normalize_or_zero();
                for length in [0.0, 1.05, 3.0] {
                    let tip = base + way * length;
                    assert_eq!(guard.is_blocked(base, tip), environment.scene.crosses(base, tip));
                    assert_eq!(guard.admits_edge(base, tip), environment.admits_edge(base, tip));
                }
            }
        }
    }

    #[test]
    fn obstacles_just_outside_of_the_growth_space_count() {
        let (min, max) = (Vec3::new(32.0, 0.0, -32.0), Vec3::new(36.0, 64.0, 32.0));
        let wall = Cuboid::new(BoxShape::Aligned { min, max }).unwrap();
        let scene = Scene::new(vec![wall], Vec::new()).unwrap();
        let environment = Environment { scene, volume: None };
        let guard = Guard::new(&environment);
        assert!(guard.is_blocked(Vec3::new(31.5, 9.0, 0.0), Vec3::new(32.5, 9.0, 0.0)));
        assert!(!guard.is_blocked(Vec3::new(30.5, 9.0, 0.0), Vec3::new(31.5, 9.0, 0.0)));
    }
}
