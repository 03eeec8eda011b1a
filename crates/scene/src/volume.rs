//! Volumes that growth is kept in: form control.

use std::path::Path;

use deeptree_graph::{Occupancy, Vec3};

use crate::error::SceneError;
use crate::scene::SceneMesh;
use crate::{files, voxels};

/// Radius of the stump that every volume lets through, in metres.
const STUMP_RADIUS: f32 = 2.0;
/// Height of the stump in metres.
const STUMP_HEIGHT: f32 = 2.0;
/// Radius of the stem at the axis, where a volume has one, in metres.
const STEM_RADIUS: f32 = 1.0;

/// Height of the cone's tip and radius at the ground, in metres.
const CONE: [f32; 2] = [22.0, 8.0];
/// Half of the cube's side in metres; it stands on the stump's height.
const CUBE: f32 = 7.0;
/// Radius of the ring's centre line, radius of its tube and height of its centre, in metres.
const RING: [f32; 3] = [7.0, 2.5, 11.5];

/// A volume that growth is kept in.
///
/// | form | within it, in metres |
/// |---|---|
/// | cone | upright, 22 high, radius 8 at the ground |
/// | cube | sides of 14, upright, from a height of 2 on, its centre over the foot |
/// | ring | an upright hoop around the axis z at a height of 11.5: centre line of radius 7, tube of radius 2.5, so that it begins at 2 and ends at 21; and a stem |
/// | mesh | a closed mesh where it stands; and a stem up to its lowest point |
///
/// The stump, a cylinder of radius 2 up to a height of 2, belongs to all of them, and so does a
/// stem, where there is one: a cylinder of radius 1 around the vertical over the foot. Without them
/// a tree could not reach what it is to fill.
///
/// # Source
///
/// DeepTree, "Form control", names cone, cube and ring; the sizes are ours.
#[derive(Clone, Debug, PartialEq)]
pub enum Volume {
    /// A cone.
    Cone,
    /// A cube.
    Cube,
    /// A ring.
    Ring,
    /// A closed mesh.
    Mesh(Box<SceneMesh>),
}

impl Volume {
    /// The forms that have names.
    pub const NAMES: [&'static str; 3] = ["cone", "cube", "ring"];

    /// The volume of a name, or of a mesh's file, named from `folder`.
    ///
    /// # Errors
    ///
    /// When there is no form of that name, or the file holds no closed mesh.
    pub fn named(name: &str, folder: &Path) -> Result<Self, SceneError> {
        let lower = name.to_lowercase();
        Ok(match lower.as_str() {
            "cone" => Self::Cone,
            "cube" => Self::Cube,
            "ring" => Self::Ring,
            _ if lower.ends_with(".obj") || lower.ends_with(".glb") => {
                let mesh = files::mesh(folder, name)?;
                let file = name.to_owned();
                if mesh.open_edges() > 0 {
                    return Err(SceneError::OpenForm { file, open_edges: mesh.open_edges() });
                }
                let volume = Self::Mesh(Box::new(SceneMesh { file: file.clone(), mesh }));
                if volume.taken_but_for(false).count() == Occupancy::SIDE.pow(3) {
                    return Err(SceneError::EmptyForm { file });
                }
                volume
            }
            _ => return Err(SceneError::UnknownForm { name: name.to_owned() }),
        })
    }

    /// Its name, or the file of its mesh.
    #[must_use]
    pub fn name(&self) -> &str {
        match self {
            Self::Cone => "cone",
            Self::Cube => "cube",
            Self::Ring => "ring",
            Self::Mesh(mesh) => &mesh.file,
        }
    }

    /// May a branch be here?
    ///
    /// # Units  metres, the foot of the tree at the origin
    #[must_use]
    pub fn admits(&self, point: Vec3) -> bool {
        let off_axis = point.x * point.x + point.z * point.z;
        let in_stump = point.y < STUMP_HEIGHT && off_axis < STUMP_RADIUS * STUMP_RADIUS;
        let in_stem = point.y < self.stem() && off_axis < STEM_RADIUS * STEM_RADIUS;
        in_stump || in_stem || self.contains(point)
    }

    /// Does a point lie within the volume, without stump and stem?
    #[must_use]
    pub fn contains(&self, point: Vec3) -> bool {
        match self {
            Self::Cone => {
                let [height, radius] = CONE;
                let reach = radius * (1.0 - point.y / height);
                let off_axis = point.x * point.x + point.z * point.z;
                (0.0..=height).contains(&point.y) && off_axis <= reach * reach
            }
            Self::Cube => {
                let off = point - Vec3::new(0.0, STUMP_HEIGHT + CUBE, 0.0);
                off.abs().max_element() <= CUBE
            }
            Self::Ring => {
                let [radius, tube, height] = RING;
                let (x, y) = (point.x, point.y - height);
                let off_line = libm::sqrtf(x * x + y * y) - radius;
                off_line * off_line + point.z * point.z <= tube * tube
            }
            Self::Mesh(mesh) => mesh.mesh.contains(point),
        }
    }

    /// The height that the stem ends at, in metres.
    fn stem(&self) -> f32 {
        match self {
            Self::Cone | Self::Cube => 0.0,
            Self::Ring => RING[2] + RING[0],
            Self::Mesh(mesh) => mesh.mesh.bounds()[0].y,
        }
    }

    /// The voxels of the growth space that count as taken: those that lie outside for the greater
    /// part, by 4³ points of each. So form control is one more environment for the networks.
    #[must_use]
    pub fn occupancy(&self) -> Occupancy {
        self.taken_but_for(true)
    }

    /// As [`Self::occupancy`], with or without the stump and the stem.
    fn taken_but_for(&self, stump: bool) -> Occupancy {
        const POINTS: usize = 4;
        let mut grid = Occupancy::EMPTY;
        let bounds = match self {
            Self::Mesh(mesh) => mesh.mesh.bounds(),
            _ => [Occupancy::LOW, Occupancy::HIGH],
        };
        voxels::take(&mut grid, [Occupancy::LOW, Occupancy::HIGH], |centre, half| {
            let centre = centre.as_vec3();
            let half = half.as_vec3();
            // Far from a mesh nothing need be asked of its faces.
            let is_far =
                (centre + half).cmplt(bounds[0]).any() || (centre - half).cmpgt(bounds[1]).any();
            let admits = |point: Vec3| {
                if stump { self.admits(point) } else { self.contains(point) }
            };
            if is_far && !stump {
                return true;
            }
            let step = 2.0 * half / POINTS as f32;
            let admitted = (0..POINTS.pow(3))
                .filter(|i| {
                    let at = [i % POINTS, i / POINTS % POINTS, i / POINTS / POINTS];
                    let part = Vec3::from(at.map(|i| i as f32 + 0.5));
                    admits(centre - half + part * step)
                })
                .count();
            2 * admitted < POINTS.pow(3)
        });
        grid
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f32::consts::PI;

    /// Volume of what is admitted, in cubic metres, by points a quarter of a metre apart.
    fn measured(volume: &Volume, low: Vec3, high: Vec3) -> f32 {
        const STEP: f32 = 0.25;
        let cells = ((high - low) / STEP).to_array().map(|n| n as usize);
        let mut inside = 0;
        for x in 0..cells[0] {
            for y in 0..cells[1] {
                for z in 0..cells[2] {
                    let at = Vec3::new(x as f32 + 0.5, y as f32 + 0.5, z as f32 + 0.5);
                    inside += usize::from(volume.contains(low + at * STEP));
                }
            }
        }
        inside as f32 * STEP.powi(3)
    }

    #[test]
    fn volumes_have_the_contents_of_their_closed_forms() {
        let [low, high] = [Vec3::new(-10.0, 0.0, -10.0), Vec3::new(10.0, 24.0, 10.0)];
        let cone = PI * 8.0 * 8.0 * 22.0 / 3.0;
        let cube = 14.0f32.powi(3);
        // Pappus: the tube's section on the way of its centre.
        let ring = PI * 2.5 * 2.5 * 2.0 * PI * 7.0;
        for (form, content) in [(Volume::Cone, cone), (Volume::Cube, cube), (Volume::Ring, ring)] {
            let found = measured(&form, low, high);
            assert!((found / content - 1.0).abs() < 0.01, "{}: {found} {content}", form.name());
        }
    }

    #[test]
    fn stump_and_stem_are_exempt() {
        for volume in [Volume::Cone, Volume::Cube, Volume::Ring] {
            assert!(volume.admits(Vec3::ZERO) && volume.admits(Vec3::new(1.5, 1.9, 0.0)));
            assert!(!volume.admits(Vec3::new(0.0, 30.0, 0.0)));
        }
        assert!(Volume::Ring.admits(Vec3::new(0.0, 11.0, 0.0)), "the stem");
        assert!(!Volume::Ring.admits(Vec3::new(2.0, 11.0, 0.0)), "the hole");
        assert!(Volume::Ring.admits(Vec3::new(7.0, 11.0, 2.0)), "the tube");
        assert!(!Volume::Ring.admits(Vec3::new(0.0, 11.0, 7.0)), "it is no ball");
    }

    #[test]
    fn what_lies_outside_counts_as_taken() {
        let free = |volume: &Volume| Occupancy::SIDE.pow(3) - volume.occupancy().count();
        for volume in [Volume::Cone, Volume::Cube, Volume::Ring] {
            let grid = volume.occupancy();
            assert!(!grid.at(Vec3::ZERO) && grid.at(Vec3::new(0.0, 40.0, 0.0)));
        }
        // The cube's sides lie in the middle of voxels, half of which is not outside: eight by
        // eight voxels less the corners, seven layers of them, and the stump's four below.
        let cube = Volume::Cube.occupancy();
        assert!(!cube.at(Vec3::new(7.5, 9.0, 0.0)) && cube.at(Vec3::new(8.5, 9.0, 0.0)));
        assert_eq!(free(&Volume::Cube), 7 * (8 * 8 - 4) + 4);
        // A body takes about as many voxels as it fills.
        let cone = PI * 8.0 * 8.0 * 22.0 / 3.0 / 8.0;
        assert!((free(&Volume::Cone) as f32 / cone - 1.0).abs() < 0.1, "{}", free(&Volume::Cone));
    }

    #[test]
    fn names_that_are_no_form_are_told() {
        let error = |name| Volume::named(name, Path::new("")).unwrap_err();
        assert!(matches!(error("sphere"), SceneError::UnknownForm { .. }));
        assert!(matches!(error("absent.obj"), SceneError::Read { .. }));
        assert_eq!(Volume::named("Ring", Path::new("")).unwrap(), Volume::Ring);
    }
}
