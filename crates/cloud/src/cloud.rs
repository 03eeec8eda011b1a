//! Points and where they are.

use deeptree_graph::Vec3;

use crate::columns::Columns;
use crate::thin;

/// Which coordinate points upwards.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Up {
    /// As in the files of renderers, and of this project's trees.
    Y,
    /// As scanners write.
    #[default]
    Z,
}

/// A point cloud.
///
/// # Units
///
/// Metres. Point `i` is at `origin + points[i]`; the origin has whole metres, so that `f32` offsets
/// of a tree are exact to some micrometres wherever on the map it stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cloud {
    /// What the points are relative to.
    pub origin: [f64; 3],
    /// Places relative to the origin.
    pub points: Vec<Vec3>,
    /// Which coordinate of both points upwards.
    pub up: Up,
    /// What else is known of each point.
    pub columns: Columns,
}

impl Cloud {
    /// How many points there are.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Is there no point?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Where a point is, in the coordinates of the file.
    ///
    /// # Panics
    ///
    /// When there is no such point.
    #[must_use]
    pub fn position(&self, i: usize) -> [f64; 3] {
        let offset = self.points[i].to_array();
        std::array::from_fn(|k| self.origin[k] + f64::from(offset[k]))
    }

    /// The lowest and highest coordinates relative to the origin, or none for an empty cloud.
    #[must_use]
    pub fn bounds(&self) -> Option<(Vec3, Vec3)> {
        let first = *self.points.first()?;
        let widen = |(low, high): (Vec3, Vec3), &p: &Vec3| (low.min(p), high.max(p));
        Some(self.points.iter().fold((first, first), widen))
    }

    /// The same points with another coordinate upwards, turned about x: z up to y up is
    /// `(x, y, z) ↦ (x, z, −y)`. No digit is lost, and the way back gives the same bits.
    #[must_use]
    pub fn with_up(mut self, up: Up) -> Self {
        match (self.up, up) {
            (Up::Z, Up::Y) => {
                let [x, y, z] = self.origin;
                self.origin = [x, z, 0.0 - y];
                self.points.iter_mut().for_each(|p| *p = Vec3::new(p.x, p.z, 0.0 - p.y));
            }
            (Up::Y, Up::Z) => {
                let [x, y, z] = self.origin;
                self.origin = [x, 0.0 - z, y];
                self.points.iter_mut().for_each(|p| *p = Vec3::new(p.x, 0.0 - p.z, p.y));
            }
            (Up::Y, Up::Y) | (Up::Z, Up::Z) => {}
        }
        self.up = up;
        self
    }

    /// Keeps the first point of each cube of a grid with this edge length in metres, and says how
    /// many points went. A length that is not positive keeps all.
    pub fn thin(&mut self, voxel: f32) -> usize {
        if voxel > 0.0 { self.keep(&thin::first_by_voxel(&self.points, voxel)) } else { 0 }
    }

    /// Removes points at the same place as one before them, and says how many.
    pub fn remove_duplicates(&mut self) -> usize {
        self.keep(&thin::first_by_place(&self.points))
    }

    /// Keeps the points with these ascending numbers, and says how many went.
    pub(crate) fn keep(&mut self, kept: &[u32]) -> usize {
        let gone = self.points.len() - kept.len();
        crate::columns::keep(&mut self.points, kept);
        self.columns.keep(kept);
        gone
    }
}
