//! Means with their errors, and how they are written.

use serde::{Deserialize, Serialize};

/// What a sample says of a mean; trees are what is drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Estimate {
    pub(super) count: u32,
    pub(super) mean: f64,
    /// Standard deviation, of a sample (n − 1).
    pub(super) sd: f64,
}

/// A difference, and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Difference {
    pub(super) by: f64,
    pub(super) error: f64,
}

impl Estimate {
    pub(super) fn of(values: impl Iterator<Item = f64> + Clone) -> Self {
        let count = values.clone().count();
        let mean = values.clone().sum::<f64>() / count.max(1) as f64;
        let squares: f64 = values.map(|x| (x - mean) * (x - mean)).sum();
        let sd = (squares / count.saturating_sub(1).max(1) as f64).sqrt();
        Self { count: count as u32, mean, sd }
    }

    /// Standard error of the mean.
    pub(super) fn error(&self) -> f64 {
        self.sd / f64::from(self.count.max(1)).sqrt()
    }

    /// How far this mean is from another of an independent sample.
    pub(super) fn beside(&self, other: &Self) -> Difference {
        let error = self.error().hypot(other.error());
        Difference { by: self.mean - other.mean, error }
    }

    /// The same as a part of the other mean, its error by the delta method.
    pub(super) fn relative_to(&self, other: &Self) -> Difference {
        let ratio = self.mean / other.mean;
        let error = self.error().hypot(ratio * other.error()) / other.mean.abs();
        Difference { by: ratio - 1.0, error }
    }
}

impl Difference {
    /// In percent, with its error.
    pub(super) fn percent(&self) -> String {
        format!("{:+.1} ± {:.1} %", 100.0 * self.by, 100.0 * self.error)
    }

    /// With its error and this many decimals.
    pub(super) fn plain(&self, decimals: usize) -> String {
        format!("{:+.decimals$} ± {:.decimals$}", self.by, self.error)
    }
}

/// Bytes as kB or MB, of 1000.
pub(super) fn bytes(count: f64) -> String {
    if count >= 1e6 {
        format!("{:.2} MB", count / 1e6)
    } else if count >= 1e3 {
        format!("{:.1} kB", count / 1e3)
    } else {
        format!("{count:.0} B")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_estimate_and_its_differences_are_those_worked_out_by_hand() {
        let a = Estimate::of([1.0, 2.0, 3.0, 6.0].into_iter());
        // Squares of the distances from 3: 4 + 1 + 0 + 9 = 14, over 3.
        assert_eq!((a.count, a.mean), (4, 3.0));
        assert!((a.sd - (14f64 / 3.0).sqrt()).abs() < 1e-12);
        assert!((a.error() - a.sd / 2.0).abs() < 1e-12);
        let b = Estimate { count: 4, mean: 2.0, sd: 4.0 };
        let difference = a.relative_to(&b);
        assert!((difference.by - 0.5).abs() < 1e-12);
        let error = (a.error().powi(2) + (1.5 * 2.0f64).powi(2)).sqrt() / 2.0;
        assert!((difference.error - error).abs() < 1e-12);
        assert_eq!(a.beside(&b).by, 1.0);
        assert_eq!(Estimate::of([7.0].into_iter()), Estimate { count: 1, mean: 7.0, sd: 0.0 });
    }

    #[test]
    fn sizes_are_told_in_the_unit_that_fits() {
        assert_eq!(bytes(92.0), "92 B");
        assert_eq!(bytes(760_123.0), "760.1 kB");
        assert_eq!(bytes(1_850_000.0), "1.85 MB");
    }
}
