//! Points on their way from a file into a cloud: checked, counted, thinned.

use std::fmt;

use deeptree_graph::Vec3;

use crate::cloud::{Cloud, Up};
use crate::columns::{Attributes, Columns};
use crate::error::ReadCloudError;
use crate::thin;

/// How to read a cloud.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReadOptions {
    /// The most points to hold; a larger cloud is thinned while it is read. None holds all.
    pub limit: Option<usize>,
    /// Which coordinate of the file points upwards, where the file does not say.
    pub up: Up,
}

/// A cloud that was read, and what of the file is not in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// The points.
    pub cloud: Cloud,
    /// What was left out.
    pub dropped: Dropped,
}

/// What of a file is not in the cloud. As text: one line that says so.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dropped {
    /// Rows with NaN or infinite coordinates, or with any beyond 10¹² m.
    pub not_finite: u64,
    /// Points at the same place as one before them.
    pub duplicates: u64,
    /// Rows of text that are no points.
    pub malformed: u64,
    /// The first of them, counted from 1.
    pub first_malformed: u64,
    /// Points that the header promised but the file does not have.
    pub missing: u64,
    /// Points that went because another was in the same voxel.
    pub thinned: u64,
    /// Edge length of those voxels in metres; 0 when nothing was thinned.
    pub voxel: f32,
}

impl Dropped {
    /// Is everything in the cloud?
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Dropped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        if self.not_finite > 0 {
            parts.push(format!("{} without finite coordinates", self.not_finite));
        }
        if self.duplicates > 0 {
            parts.push(format!("{} at the place of another", self.duplicates));
        }
        if self.malformed > 0 {
            parts.push(format!(
                "{} lines that are no points (the first is line {})",
                self.malformed, self.first_malformed
            ));
        }
        if self.missing > 0 {
            parts.push(format!("{} that the header promised are not there", self.missing));
        }
        if self.thinned > 0 {
            parts.push(format!(
                "{} thinned out, one kept in each cube of {} m",
                self.thinned, self.voxel
            ));
        }
        write!(f, "points left out: {}", parts.join("; "))
    }
}

/// So many points decide on the origin.
const FIRST: usize = 1024;
/// Coordinates nearer to zero than this need no origin: `f32` knows them to 15 µm.
const NEAR: f64 = 256.0;
/// No place is farther; what is, was a mistake of the writer.
const FAR: f64 = 1e12;
/// Edge of the finest voxels in metres: nothing a scanner resolves is lost.
const FINEST: f32 = 1.0 / 1024.0;
/// A limit below would thin a tree to nothing.
const LEAST: usize = 1024;

/// Takes points one by one and holds no more than the limit.
pub(crate) struct Gather {
    options: ReadOptions,
    /// The first points, until they decide on the origin.
    first: Vec<([f64; 3], Attributes)>,
    has_origin: bool,
    taken: u64,
    reading: Reading,
}

impl Gather {
    /// For points with these of [`Columns::NAMES`].
    pub(crate) fn new(options: ReadOptions, present: [bool; 6]) -> Self {
        let cloud = Cloud { up: options.up, columns: Columns::with(present), ..Cloud::default() };
        let reading = Reading { cloud, dropped: Dropped::default() };
        Self { options, first: Vec::new(), has_origin: false, taken: 0, reading }
    }

    /// Counts what the reader drops by itself.
    pub(crate) fn dropped(&mut self) -> &mut Dropped {
        &mut self.reading.dropped
    }

    /// How many points were offered.
    pub(crate) fn taken(&self) -> u64 {
        self.taken
    }

    /// Takes a point.
    pub(crate) fn push(
        &mut self,
        position: [f64; 3],
        attributes: &Attributes,
    ) -> Result<(), ReadCloudError> {
        self.taken += 1;
        if !position.iter().all(|c| c.abs() <= FAR) {
            self.reading.dropped.not_finite += 1;
            return Ok(());
        }
        if self.has_origin {
            return self.place(position, attributes);
        }
        self.first.push((position, *attributes));
        if self.first.len() == FIRST { self.settle() } else { Ok(()) }
    }

    /// The cloud and what is not in it.
    pub(crate) fn finish(mut self) -> Result<Reading, ReadCloudError> {
        if !self.has_origin {
            self.settle()?;
        }
        let Reading { cloud, dropped } = &mut self.reading;
        dropped.duplicates += cloud.remove_duplicates() as u64;
        if dropped.voxel > 0.0 {
            dropped.thinned += cloud.thin(dropped.voxel) as u64;
        }
        if cloud.is_empty() { Err(ReadCloudError::Empty) } else { Ok(self.reading) }
    }

    /// Sets the origin to the median of the first points, so that one stray point does no harm.
    fn settle(&mut self) -> Result<(), ReadCloudError> {
        let first = std::mem::take(&mut self.first);
        self.has_origin = true;
        for axis in 0..3 {
            let mut along: Vec<f64> = first.iter().map(|(p, _)| p[axis]).collect();
            along.sort_unstable_by(f64::total_cmp);
            let median = along.get(along.len() / 2).copied().unwrap_or_default();
            self.reading.cloud.origin[axis] =
                if median.abs() < NEAR { 0.0 } else { median.round() };
        }
        first.iter().try_for_each(|(p, a)| self.place(*p, a))
    }

    fn place(&mut self, p: [f64; 3], attributes: &Attributes) -> Result<(), ReadCloudError> {
        let cloud = &mut self.reading.cloud;
        let offset: [f32; 3] = std::array::from_fn(|k| (p[k] - cloud.origin[k]) as f32);
        cloud.points.push(Vec3::from_array(offset));
        cloud.columns.push(attributes);
        if cloud.len() >= u32::MAX as usize {
            return Err(ReadCloudError::TooMany);
        }
        if self.options.limit.is_some_and(|limit| cloud.len() > limit.max(LEAST)) {
            self.make_room();
        }
        Ok(())
    }

    /// Thins by ever larger voxels until half of the limit is free.
    fn make_room(&mut self) {
        let Reading { cloud, dropped } = &mut self.reading;
        let half = self.options.limit.unwrap_or(usize::MAX).max(LEAST) / 2;
        dropped.duplicates += cloud.remove_duplicates() as u64;
        if dropped.voxel > 0.0 {
            dropped.thinned += cloud.thin(dropped.voxel) as u64;
        }
        while cloud.len() > half {
            dropped.voxel = if dropped.voxel > 0.0 { dropped.voxel * 2.0 } else { FINEST };
            let kept = thin::first_by_voxel(&cloud.points, dropped.voxel);
            dropped.thinned += cloud.keep(&kept) as u64;
        }
    }
}
