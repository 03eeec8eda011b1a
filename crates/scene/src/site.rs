//! An environment as growth by network asks it: what each node sees, and where no branch can go.

use std::sync::OnceLock;

use deeptree_graph::{Node, Occupancy, Passage, Room, Surround, Vec3, Voxel};

use crate::environment::Environment;
use crate::guard;
use crate::sky::Sky;

/// Voxels of the growth space.
const VOXELS: usize = Occupancy::SIDE * Occupancy::SIDE * Occupancy::SIDE;

/// An environment with what has been asked of it. The sky is that of the middle of a voxel of 2 m,
/// or of the node itself where that middle lies in an obstacle, and outside of the growth space.
#[derive(Debug)]
pub struct Site {
    environment: Environment,
    taken: Occupancy,
    shading: Occupancy,
    /// See [`guard::near`].
    near: Occupancy,
    /// None where the middle of the voxel lies in an obstacle.
    skies: Vec<OnceLock<Option<Sky>>>,
}

impl Site {
    /// The site of trees at the origin of an environment.
    #[must_use]
    pub fn new(environment: Environment) -> Self {
        let (taken, shading) = (environment.occupancy(), environment.scene.occupancy());
        let near = guard::near(&environment.scene);
        let cells = if environment.scene.is_empty() { 0 } else { VOXELS };
        let skies = std::iter::repeat_with(OnceLock::new).take(cells).collect();
        Self { environment, taken, shading, near, skies }
    }

    /// The environment.
    #[must_use]
    pub const fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Y: the voxels that obstacles take or that lie outside of the volume.
    #[must_use]
    pub const fn taken(&self) -> &Occupancy {
        &self.taken
    }

    /// The voxels that obstacles take: those that shade.
    #[must_use]
    pub const fn shading(&self) -> &Occupancy {
        &self.shading
    }

    /// What a node sees of what stands around.
    #[must_use]
    pub fn surround(&self, node: &Node) -> Surround {
        let sky = self.sky(node.position);
        Surround {
            taken: Surround::taken_around(node, &self.taken),
            shade: 1.0 - sky.free,
            bright: sky.toward.unwrap_or(Vec3::ZERO),
        }
    }

    fn sky(&self, position: Vec3) -> Sky {
        let scene = &self.environment.scene;
        if self.skies.is_empty() {
            return Sky::OPEN;
        }
        let Some(voxel) = Voxel::holding(position) else { return scene.sky(position) };
        let look = || {
            let middle = voxel.centre();
            (!scene.contains(middle)).then(|| scene.sky(middle))
        };
        self.skies[voxel.index()].get_or_init(look).unwrap_or_else(|| scene.sky(position))
    }
}

impl Room for Site {
    fn passage(&self, base: Vec3, tip: Vec3) -> Passage {
        let Environment { scene, volume } = &self.environment;
        if guard::is_blocked(scene, &self.near, base, tip) {
            return Passage::Blocked;
        }
        match volume {
            Some(volume) if !volume.admits(tip) => {
                if volume.contains(base) {
                    Passage::Outside
                } else {
                    Passage::Astray
                }
            }
            _ => Passage::Free,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoxShape, Cuboid, Scene, Volume};
    use deeptree_graph::Seed;
    use deeptree_graph::testing::random_tree;

    #[test]
    fn the_open_field_shows_nothing_and_admits_all() {
        let site = Site::new(Environment::default());
        for node in random_tree(1, 50).nodes() {
            assert_eq!(site.surround(node), Surround::default());
            assert_eq!(site.passage(node.base(), node.position), Passage::Free);
        }
    }

    #[test]
    fn what_is_near_is_found_as_by_asking_the_scene_itself() {
        for seed in 0..10 {
            let environment = Environment { scene: Scene::random(Seed(seed)), volume: None };
            let site = Site::new(environment.clone());
            for i in 0..2000 {
                let x = |k: i32| (i * k % 701) as f32 * 0.06 - 21.0;
                let base = Vec3::new(x(37), x(59) + 21.0, x(83));
                let tip = base + Vec3::new(x(11), x(13), x(17)).normalize_or_zero() * 1.05;
                let is_free = site.passage(base, tip) == Passage::Free;
                assert_eq!(is_free, environment.admits_edge(base, tip));
            }
        }
    }

    #[test]
    fn an_obstacle_beyond_the_growth_space_is_met_too() {
        let (min, max) = (Vec3::new(32.5, 0.0, -5.0), Vec3::new(34.0, 9.0, 5.0));
        let wall = Cuboid::new(BoxShape::Aligned { min, max }).unwrap();
        let scene = Scene::new(vec![wall], Vec::new()).unwrap();
        let site = Site::new(Environment { scene, volume: None });
        assert!(site.taken().is_empty());
        let base = Vec3::new(31.8, 4.0, 0.0);
        assert_eq!(site.passage(base, base + Vec3::X), Passage::Blocked);
        assert_eq!(site.passage(base, base - Vec3::X), Passage::Free);
    }

    #[test]
    fn a_volume_shades_nothing() {
        let volume = Some(Volume::Cone);
        let site = Site::new(Environment { volume, ..Environment::default() });
        assert!(site.shading().is_empty() && !site.taken().is_empty());
        let far = Vec3::new(20.0, 5.0, 0.0);
        assert_eq!(site.passage(far, far), Passage::Astray);
        assert_eq!(site.passage(Vec3::Y, far), Passage::Outside);
        assert_eq!(site.passage(Vec3::Y, 2.0 * Vec3::Y), Passage::Free);
        assert_eq!(site.sky(far), Sky::OPEN);
    }
}
