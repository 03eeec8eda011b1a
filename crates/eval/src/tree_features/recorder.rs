//! Names and values side by side, and the statistics that a distribution is reduced to.

/// The features recorded so far.
#[derive(Default)]
pub(super) struct Recorder {
    pub(super) names: Vec<String>,
    pub(super) values: Vec<f64>,
}

impl Recorder {
    /// Records a feature; a value that is not finite becomes 0.
    pub(super) fn push(&mut self, name: impl Into<String>, value: f64) {
        self.names.push(name.into());
        self.values.push(if value.is_finite() { value } else { 0.0 });
    }

    /// Records mean, standard deviation, skewness and three quantiles of a distribution.
    pub(super) fn distribution(&mut self, name: &str, mut samples: Vec<f64>) {
        samples.sort_by(f64::total_cmp);
        let mean = mean(&samples);
        let central = |power| samples.iter().map(|x| (x - mean).powi(power)).sum::<f64>();
        let sd = (central(2) / samples.len() as f64).sqrt();
        // Rounding leaves equal samples a spread that no skewness should be read from.
        let flat = sd <= 1e-7 * mean.abs();
        let skewness = central(3) / samples.len() as f64 / sd.powi(3);
        self.push(format!("{name}/mean"), mean);
        self.push(format!("{name}/sd"), sd);
        self.push(format!("{name}/skewness"), if flat { 0.0 } else { skewness });
        for percent in [10u32, 50, 90] {
            let value = quantile(&samples, f64::from(percent) / 100.0).unwrap_or(0.0);
            self.push(format!("{name}/q{percent}"), value);
        }
    }

    /// Records the moments of directions on a circle, in radians.
    ///
    /// The mean cosine and sine of the angle, and of twice the angle the mean cosine.
    pub(super) fn circular(&mut self, name: &str, angles: &[f64]) {
        let moment = |part: fn(f64) -> f64| ratio(angles.iter().map(|&x| part(x)).sum(), angles);
        self.push(format!("{name}/cos"), moment(f64::cos));
        self.push(format!("{name}/sin"), moment(f64::sin));
        self.push(format!("{name}/cos2"), moment(|x| (2.0 * x).cos()));
    }

    /// Records Pearson's correlation of pairs; 0 where one side does not vary.
    pub(super) fn correlation(&mut self, name: &str, pairs: &[(f64, f64)]) {
        let n = pairs.len() as f64;
        let x = pairs.iter().map(|pair| pair.0).sum::<f64>() / n;
        let y = pairs.iter().map(|pair| pair.1).sum::<f64>() / n;
        let (mut xx, mut yy, mut xy) = (0.0, 0.0, 0.0);
        for pair in pairs {
            let (dx, dy) = (pair.0 - x, pair.1 - y);
            (xx, yy, xy) = (xx + dx * dx, yy + dy * dy, xy + dx * dy);
        }
        let varies = xx > 1e-14 * n * x * x && yy > 1e-14 * n * y * y;
        self.push(name, if varies { xy / (xx * yy).sqrt() } else { 0.0 });
    }
}

/// `sum` by the number of samples; 0 without samples.
fn ratio(sum: f64, samples: &[f64]) -> f64 {
    if samples.is_empty() { 0.0 } else { sum / samples.len() as f64 }
}

/// The mean; 0 without samples.
pub(super) fn mean(samples: &[f64]) -> f64 {
    ratio(samples.iter().sum(), samples)
}

/// The quantile `q` in [0, 1] of sorted samples, linear between the ranks (n − 1) q.
///
/// # Source
///
/// Definition 7 of Hyndman and Fan 1996, "Sample quantiles in statistical packages".
pub(crate) fn quantile(sorted: &[f64], q: f64) -> Option<f64> {
    let rank = q * sorted.len().checked_sub(1)? as f64;
    let (low, high) = (sorted[rank.floor() as usize], sorted[rank.ceil() as usize]);
    Some(low + (high - low) * rank.fract())
}
