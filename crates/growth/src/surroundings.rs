//! What a growing tree meets outside itself: light, and places where nothing can grow.

use std::cell::RefCell;

use deeptree_graph::{Occupancy, Vec3};
use deeptree_scene::{Environment, Guard, Sky};

/// The light at a tip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// I: the free part of the sky, 1 in the open.
    pub availability: f32,
    /// d: the direction to grow towards; none where no direction is better than another.
    pub direction: Option<Vec3>,
}

/// Surroundings that a tree responds to.
pub trait Surroundings {
    /// The light at `position`, where `outward` points away from the crown's centre.
    fn light(&self, position: Vec3, outward: Option<Vec3>) -> Light;

    /// May an internode reach from `base` to `tip`? One that may not is removed with all it bears.
    fn admits(&self, base: Vec3, tip: Vec3) -> bool;

    /// The least exponent of the light on a lateral bud's chance to flush.
    fn least_lighting_factor(&self) -> f32 {
        0.0
    }
}

/// Nothing around: full light from outside the crown, and room above the ground.
#[derive(Clone, Copy, Debug, Default)]
pub struct OpenField;

impl Surroundings for OpenField {
    fn light(&self, _: Vec3, outward: Option<Vec3>) -> Light {
        Light { availability: 1.0, direction: outward }
    }

    fn admits(&self, _: Vec3, _: Vec3) -> bool {
        true
    }
}

/// The least light that any tip gets.
const LEAST_LIGHT: f32 = 0.05;

/// Exponent of the light on a lateral bud's chance where a species has a smaller one and there are
/// obstacles: without one a willow would not mind the shade.
const LEAST_LIGHTING_FACTOR: f32 = 0.5;

/// How much hidden sky turns a shoot to the free side, against the way out of the crown.
const TURN_TO_SKY: f32 = 2.0;

/// Side of the cells that share one sky, in metres.
const CELL: f32 = 1.0;

/// Cells along each side of the growth space.
const CELLS: usize = 64;

/// The obstacles and the volume of an environment.
///
/// An internode goes when its base lies in an obstacle or outside of the volume, or when it enters
/// an obstacle. Light is the free part of the sky, `I = max(0.05, free)`, and its direction
/// `normalise(outward + 2 (1 − I) · toward)` with the horizontal direction to the free part. Light
/// acts through the buds' chances to flush, not through the length of shoots.
///
/// The sky is looked up in cells of 1 m, each of which sees what its middle does; where the middle
/// lies in an obstacle, and outside of the growth space, it is asked for at the tip itself. What is
/// looked up does not depend on the order of the questions.
pub struct Around<'a> {
    environment: &'a Environment,
    has_obstacles: bool,
    guard: Guard<'a>,
    /// Share of the free sky and the direction to it by x and z; NaN where nobody asked yet.
    skies: RefCell<Vec<[f32; 3]>>,
}

impl std::fmt::Debug for Around<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Around").field("environment", self.environment).finish_non_exhaustive()
    }
}

impl<'a> Around<'a> {
    /// The surroundings of trees at the origin of an environment.
    #[must_use]
    pub fn new(environment: &'a Environment) -> Self {
        let has_obstacles = !environment.scene.is_empty();
        let cells = if has_obstacles { CELLS * CELLS * CELLS } else { 0 };
        let skies = RefCell::new(vec![[f32::NAN; 3]; cells]);
        Self { environment, has_obstacles, guard: Guard::new(environment), skies }
    }

    fn sky(&self, position: Vec3) -> Sky {
        let scene = &self.environment.scene;
        let cell = ((position - Occupancy::LOW) / CELL).to_array().map(|x| libm::floorf(x) as i64);
        if cell.iter().any(|&c| !(0..CELLS as i64).contains(&c)) {
            return scene.sky(position);
        }
        let [x, y, z] = cell.map(|c| c as usize);
        let index = (z * CELLS + y) * CELLS + x;
        let [free, tx, tz] = self.skies.borrow()[index];
        if !free.is_nan() {
            let toward = (tx != 0.0 || tz != 0.0).then_some(Vec3::new(tx, 0.0, tz));
            return Sky { free, toward };
        }
        let middle = Occupancy::LOW + CELL * (Vec3::from(cell.map(|c| c as f32)) + 0.5);
        if self.guard.is_blocked(middle, middle) {
            return scene.sky(position);
        }
        let sky = scene.sky(middle);
        let [tx, _, tz] = sky.toward.unwrap_or_default().to_array();
        self.skies.borrow_mut()[index] = [sky.free, tx, tz];
        sky
    }
}

impl Surroundings for Around<'_> {
    fn light(&self, position: Vec3, outward: Option<Vec3>) -> Light {
        if !self.has_obstacles {
            return OpenField.light(position, outward);
        }
        let sky = self.sky(position);
        let availability = sky.free.max(LEAST_LIGHT);
        let direction = match sky.toward {
            None => outward,
            Some(toward) => {
                let turn = TURN_TO_SKY * (1.0 - availability);
                (outward.unwrap_or_default() + turn * toward).try_normalize()
            }
        };
        Light { availability, direction }
    }

    fn admits(&self, base: Vec3, tip: Vec3) -> bool {
        self.environment.volume.as_ref().is_none_or(|volume| volume.admits(base))
            && !self.guard.is_blocked(base, tip)
    }

    fn least_lighting_factor(&self) -> f32 {
        if self.has_obstacles { LEAST_LIGHTING_FACTOR } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use deeptree_graph::Seed;
    use deeptree_scene::{BoxShape, Cuboid, Scene};

    /// A scene whose cells can be told by hand: a wall at x ≥ 3, too high and wide to look past.
    fn wall() -> Environment {
        let (min, max) = (Vec3::new(3.0, 0.0, -5000.0), Vec3::new(4.0, 5000.0, 5000.0));
        let wall = Cuboid::new(BoxShape::Aligned { min, max }).unwrap();
        Environment { scene: Scene::new(vec![wall], Vec::new()).unwrap(), volume: None }
    }

    #[test]
    fn beside_a_wall_there_is_half_the_light_and_it_comes_from_the_other_side() {
        let environment = wall();
        let around = Around::new(&environment);
        let light = around.light(Vec3::new(1.2, 5.0, 0.0), Some(Vec3::Z));
        assert_eq!(light.availability, 0.5);
        // outward + 2 · (1 − 0.5) · toward = z − x, normalised.
        let direction = light.direction.unwrap();
        assert!((direction - Vec3::new(-1.0, 0.0, 1.0).normalize()).length() < 0.1, "{direction}");
        assert!(around.admits(Vec3::X, 2.0 * Vec3::X));
        assert!(!around.admits(2.5 * Vec3::X, 3.1 * Vec3::X));
        assert!(!around.admits(3.5 * Vec3::X, 3.5 * Vec3::X));
        assert!(around.least_lighting_factor() > 0.0);
    }

    #[test]
    fn what_was_asked_before_changes_no_answer() {
        let environment = Environment { scene: Scene::random(Seed(3)), volume: None };
        let asked = Around::new(&environment);
        let points: Vec<Vec3> = (0..4000)
            .map(|i| {
                let x = |k: i32| (i * k % 401) as f32 * 0.1 - 20.0;
                Vec3::new(x(37), x(59) + 20.0, x(83))
            })
            .collect();
        let first: Vec<Light> = points.iter().map(|&p| asked.light(p, None)).collect();
        let fresh = Around::new(&environment);
        for (&point, &light) in points.iter().zip(&first).rev() {
            assert_eq!(fresh.light(point, None), light, "{point}");
        }
    }

    #[test]
    fn in_a_volume_the_light_is_that_of_the_open_field() {
        let environment =
            Environment { volume: Some(deeptree_scene::Volume::Cone), ..Environment::default() };
        let around = Around::new(&environment);
        let far = Vec3::new(20.0, 5.0, 0.0);
        assert_eq!(around.light(far, None), OpenField.light(far, None));
        assert!(!around.admits(far, far) && around.admits(Vec3::Y, 2.0 * Vec3::Y));
        assert_eq!(around.least_lighting_factor(), 0.0);
    }
}
