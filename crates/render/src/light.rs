//! Where light comes from: a dome that is the sky, and a sun in it.

use std::f32::consts::{FRAC_1_PI, PI, TAU};

use glam::Vec3;

use crate::error::RenderError;
use crate::sky::ClearSky;
use crate::tone::luminance;

/// Radius of the sun's disc in radians: 0.53° across.
const SUN_RADIUS: f32 = 0.004_65;
/// Rows and columns of the table by which the dome is sampled, by equal solid angle.
const ROWS: usize = 96;
const COLUMNS: usize = 96;

/// The light of a scene, as radiance in linear sRGB.
///
/// # Units
///
/// 1 is the radiance of a white card that lies in the open: all lights are scaled so that they
/// shed π on level ground, in red, green and blue. So a picture is exposed and balanced as with a
/// grey card.
#[derive(Clone, Debug)]
pub struct Light {
    dome: Dome,
    sun: Option<Sun>,
    table: Table,
    /// What the dome alone sheds on level ground.
    dome_irradiance: Vec3,
}

#[derive(Clone, Debug)]
enum Dome {
    Uniform(Vec3),
    Clear { sky: Box<ClearSky>, scale: Vec3 },
}

#[derive(Clone, Copy, Debug)]
struct Sun {
    direction: Vec3,
    tangent: Vec3,
    bitangent: Vec3,
    /// Sine of the disc's radius, squared.
    sine_square: f32,
    /// One less the radius's cosine.
    drop: f32,
    radiance: Vec3,
}

/// Light from one direction.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Incident {
    pub(crate) direction: Vec3,
    pub(crate) radiance: Vec3,
    /// Per steradian.
    pub(crate) pdf: f32,
}

impl Light {
    /// The same light from everywhere, below as well: a white furnace.
    #[must_use]
    pub fn uniform() -> Self {
        Self::of(Dome::Uniform(Vec3::ONE), None)
    }

    /// Light from everywhere with a sun: `share` of what falls on level ground is the sun's.
    ///
    /// # Errors
    ///
    /// When the sun is not above the horizon, or the share not from 0 to below 1.
    pub fn overcast(elevation: f32, azimuth: f32, share: f32) -> Result<Self, RenderError> {
        let direction = towards(elevation, azimuth)?;
        if !(0.0..1.0).contains(&share) {
            return Err(RenderError::Range {
                what: "the sun's share",
                value: share,
                low: 0.0,
                high: 1.0,
            });
        }
        let sun = Sun::new(direction, Vec3::splat(PI * share / direction.y));
        Ok(Self::of(Dome::Uniform(Vec3::splat(1.0 - share)), Some(sun)))
    }

    /// A clear sky with the sun at an elevation above the horizon and an azimuth about the
    /// vertical, from +z towards +x, both in radians; turbidity 2 (very clear) to 10 (hazy).
    ///
    /// # Errors
    ///
    /// When the sun is not above the horizon, or the turbidity out of its range.
    pub fn daylight(elevation: f32, azimuth: f32, turbidity: f32) -> Result<Self, RenderError> {
        let direction = towards(elevation, azimuth)?;
        if !(2.0..=10.0).contains(&turbidity) {
            return Err(RenderError::Range {
                what: "the turbidity",
                value: turbidity,
                low: 2.0,
                high: 10.0,
            });
        }
        let sky = Box::new(ClearSky::new(direction, turbidity));
        let sun = sky.sun_irradiance();
        let raw = Self::of(Dome::Clear { sky: sky.clone(), scale: Vec3::ONE }, None);
        let scale = Vec3::splat(PI) / (raw.dome_irradiance + sun * direction.y);
        Ok(Self::of(Dome::Clear { sky, scale }, Some(Sun::new(direction, sun * scale))))
    }

    fn of(dome: Dome, sun: Option<Sun>) -> Self {
        let (table, dome_irradiance) = Table::new(&dome);
        Self { dome, sun, table, dome_irradiance }
    }

    /// What a ray that leaves the scene meets: the sky behind the sun, without it.
    pub(crate) fn dome(&self, direction: Vec3) -> Vec3 {
        self.dome.radiance(direction)
    }

    /// The disc of the sun, if the ray meets it.
    pub(crate) fn sun(&self, direction: Vec3) -> Option<Vec3> {
        self.sun.filter(|sun| sun.contains(direction)).map(|sun| sun.radiance)
    }

    /// Draws a direction that light comes from.
    pub(crate) fn sample(&self, choice: f32, u: [f32; 2]) -> Incident {
        let share = self.sun_share();
        let direction = match self.sun {
            Some(sun) if choice < share => sun.sample(u),
            _ => self.table.sample((choice - share) / (1.0 - share), u),
        };
        let radiance = self.dome(direction) + self.sun(direction).unwrap_or_default();
        Incident { direction, radiance, pdf: self.pdf(direction) }
    }

    /// The density with which [`Light::sample`] draws a direction, per steradian.
    pub(crate) fn pdf(&self, direction: Vec3) -> f32 {
        let share = self.sun_share();
        let dome = (1.0 - share) * self.table.pdf(direction);
        match self.sun {
            Some(sun) if sun.contains(direction) => dome + share / (TAU * sun.drop),
            _ => dome,
        }
    }

    /// Sun and dome are drawn equally often: in the shade the dome is all there is.
    fn sun_share(&self) -> f32 {
        if self.sun.is_some() { 0.5 } else { 0.0 }
    }
}

/// Unit vector towards a point of the sky.
fn towards(elevation: f32, azimuth: f32) -> Result<Vec3, RenderError> {
    if !(elevation > 0.01 && elevation <= PI / 2.0 && azimuth.is_finite()) {
        return Err(RenderError::Sun { elevation: elevation.to_degrees() });
    }
    let (sin, cos) = libm::sincosf(azimuth);
    let (up, flat) = libm::sincosf(elevation);
    Ok(Vec3::new(flat * sin, up, flat * cos))
}

impl Dome {
    fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::Uniform(radiance) => *radiance,
            Self::Clear { sky, scale } => sky.radiance(direction) * *scale,
        }
    }

    fn is_closed(&self) -> bool {
        matches!(self, Self::Uniform(_))
    }
}

impl Sun {
    fn new(direction: Vec3, irradiance: Vec3) -> Self {
        let (tangent, bitangent) = direction.any_orthonormal_pair();
        let square = |x: f32| x * x;
        let sine_square = square(libm::sinf(SUN_RADIUS));
        let drop = 2.0 * square(libm::sinf(0.5 * SUN_RADIUS));
        // ∫ cos over the disc is π sin² of its radius.
        let radiance = irradiance / (PI * sine_square);
        Self { direction, tangent, bitangent, sine_square, drop, radiance }
    }

    /// Is the direction within the disc? By the sine, which keeps its digits where the cosine
    /// does not.
    fn contains(&self, direction: Vec3) -> bool {
        self.direction.dot(direction) > 0.0
            && self.direction.cross(direction).length_squared() <= self.sine_square
    }

    /// A direction of the disc, all equally likely.
    fn sample(&self, [u, v]: [f32; 2]) -> Vec3 {
        let drop = u * self.drop;
        let flat = (drop * (2.0 - drop)).max(0.0).sqrt();
        let (sin, cos) = libm::sincosf(TAU * v);
        let flat = self.tangent * (flat * cos) + self.bitangent * (flat * sin);
        (self.direction * (1.0 - drop) + flat).normalize()
    }
}

/// Cells of equal solid angle with the light that comes from each; the lower half only where the
/// dome is closed.
#[derive(Clone, Debug)]
struct Table {
    /// Sums of the weights up to and with each cell; the last is 1.
    sums: Vec<f32>,
    /// Height of the lowest row's lower edge: −1 or 0.
    floor: f32,
}

impl Table {
    /// The table of a dome, and what the dome sheds on level ground.
    fn new(dome: &Dome) -> (Self, Vec3) {
        let floor = if dome.is_closed() { -1.0 } else { 0.0 };
        let mut table = Self { sums: Vec::with_capacity(ROWS * COLUMNS), floor };
        let (mut sum, mut irradiance) = (0.0, Vec3::ZERO);
        let angle = table.cell_angle();
        for cell in 0..ROWS * COLUMNS {
            const SUB: usize = 4;
            let mut mean = Vec3::ZERO;
            for i in 0..SUB * SUB {
                let at = [i % SUB, i / SUB].map(|k| (k as f32 + 0.5) / SUB as f32);
                let direction = table.direction(cell, at);
                let radiance = dome.radiance(direction) / (SUB * SUB) as f32;
                mean += radiance;
                irradiance += radiance * (direction.y.max(0.0) * angle);
            }
            sum += luminance(mean);
            table.sums.push(sum);
        }
        table.sums.iter_mut().for_each(|one| *one /= sum);
        if let Dome::Uniform(radiance) = dome {
            irradiance = *radiance * PI;
        }
        (table, irradiance)
    }

    /// Solid angle of a cell.
    fn cell_angle(&self) -> f32 {
        TAU * (1.0 - self.floor) / (ROWS * COLUMNS) as f32
    }

    fn direction(&self, cell: usize, [u, v]: [f32; 2]) -> Vec3 {
        let y = self.floor + (1.0 - self.floor) * ((cell / COLUMNS) as f32 + v) / ROWS as f32;
        let (sin, cos) = libm::sincosf(TAU * ((cell % COLUMNS) as f32 + u) / COLUMNS as f32);
        let flat = (1.0 - y * y).max(0.0).sqrt();
        Vec3::new(flat * sin, y, flat * cos)
    }

    fn sample(&self, choice: f32, u: [f32; 2]) -> Vec3 {
        let cell = self.sums.partition_point(|&sum| sum <= choice).min(self.sums.len() - 1);
        self.direction(cell, u)
    }

    fn pdf(&self, direction: Vec3) -> f32 {
        let row = (direction.y - self.floor) / (1.0 - self.floor) * ROWS as f32;
        if row < 0.0 {
            return 0.0;
        }
        let turn = libm::atan2f(direction.x, direction.z) * (0.5 * FRAC_1_PI);
        let column = (if turn < 0.0 { turn + 1.0 } else { turn }) * COLUMNS as f32;
        let cell = (row as usize).min(ROWS - 1) * COLUMNS + (column as usize).min(COLUMNS - 1);
        let below = if cell == 0 { 0.0 } else { self.sums[cell - 1] };
        (self.sums[cell] - below) / self.cell_angle()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::Sampler;
    use deeptree_graph::Seed;

    fn lights() -> [Light; 3] {
        [
            Light::uniform(),
            Light::overcast(0.7, 1.0, 0.6).unwrap(),
            Light::daylight(0.7, -0.6, 3.0).unwrap(),
        ]
    }

    /// Mean of radiance · cos / pdf, over what falls on a plane with this normal.
    fn irradiance(light: &Light, normal: Vec3) -> Vec3 {
        let draws = 1 << 16;
        let one = |index| {
            let mut sampler = Sampler::new(Seed(5), 0, 0, index);
            let drawn = light.sample(sampler.one(), sampler.pair());
            drawn.radiance * (normal.dot(drawn.direction).max(0.0) / drawn.pdf)
        };
        (0..draws).map(one).sum::<Vec3>() / draws as f32
    }

    #[test]
    fn every_light_sheds_pi_on_level_ground() {
        for light in lights() {
            let found = irradiance(&light, Vec3::Y) / PI;
            assert!((found - Vec3::ONE).abs().max_element() < 0.01, "{found}");
        }
    }

    /// Lambert's cosine law, and the view factor (1 + cos β)/2 of a tilted plane to a sky that is
    /// the same everywhere.
    #[test]
    fn a_tilted_plane_gets_what_the_cosine_law_says() {
        let (elevation, share) = (0.7f32, 0.6);
        let light = Light::overcast(elevation, 0.0, share).unwrap();
        for tilt in [0.3f32, 0.8, 1.4] {
            let normal = Vec3::new(0.0, libm::cosf(tilt), libm::sinf(tilt));
            let direct = PI * share / libm::sinf(elevation);
            let sun = direct * libm::cosf(elevation - (PI / 2.0 - tilt)).max(0.0);
            // The dome is closed: it shines on the plane from below as well.
            let expected = sun + PI * (1.0 - share);
            let found = irradiance(&light, normal).x;
            assert!((found / expected - 1.0).abs() < 0.01, "{tilt}: {found} {expected}");
        }
    }

    #[test]
    fn directions_are_drawn_with_the_density_that_is_said() {
        for light in lights() {
            // ∫ pdf = 1, by directions of equal solid angle; the sun's disc is added by hand.
            let n = 1000;
            let mut sum = 0.0;
            for i in 0..n * n {
                let y = 2.0 * ((i / n) as f32 + 0.5) / n as f32 - 1.0;
                let (sin, cos) = libm::sincosf(TAU * ((i % n) as f32 + 0.5) / n as f32);
                let flat = (1.0 - y * y).sqrt();
                sum += f64::from(light.table.pdf(Vec3::new(flat * sin, y, flat * cos)));
            }
            let whole = sum * 2.0 * std::f64::consts::TAU / f64::from(n * n);
            assert!((whole - 1.0).abs() < 2e-3, "{whole}");
            for index in 0..1000 {
                let mut sampler = Sampler::new(Seed(6), 0, 0, index);
                let drawn = light.sample(sampler.one(), sampler.pair());
                assert!(drawn.pdf > 0.0 && drawn.radiance.is_finite());
                assert!((drawn.direction.length() - 1.0).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn a_sun_below_the_horizon_and_thick_air_are_refused() {
        assert!(Light::daylight(-0.1, 0.0, 3.0).is_err());
        assert!(Light::daylight(f32::NAN, 0.0, 3.0).is_err());
        assert!(Light::daylight(0.5, 0.0, 1.0).is_err());
        assert!(Light::overcast(0.5, 0.0, 1.0).is_err());
    }
}
