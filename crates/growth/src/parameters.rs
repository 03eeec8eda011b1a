//! The one table of the growth model's parameters: it makes the struct, checks presets, and feeds
//! the documentation.

/// One row of the parameter table.
#[derive(Debug)]
pub struct Parameter {
    /// The field of [`Parameters`] and the key in a preset.
    pub key: &'static str,
    /// The symbol in the paper's appendix, or of the constant that the paper does not print.
    pub symbol: &'static str,
    /// Unit; "–" for pure numbers.
    pub unit: &'static str,
    /// Smallest sensible value.
    pub min: f32,
    /// Largest sensible value.
    pub max: f32,
    /// What a preset that leaves it out gets.
    pub default: f32,
    /// Must it be a whole number?
    pub whole: bool,
    /// What it means, and what it does at its extremes.
    pub meaning: &'static str,
    /// Reads the field.
    pub get: fn(&Parameters) -> f32,
    /// Writes the field.
    pub set: fn(&mut Parameters, f32),
}

/// A value outside the table.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ParameterError {
    #[error("{key} ({symbol}) is {value}; it must be between {min} and {max}")]
    OutOfRange { key: &'static str, symbol: &'static str, value: f32, min: f32, max: f32 },
    #[error("{key} ({symbol}) is {value}; it must be a whole number")]
    NotWhole { key: &'static str, symbol: &'static str, value: f32 },
}

macro_rules! parameters {
    ($($key:ident $symbol:literal $unit:literal $min:literal .. $max:literal = $default:literal
       $whole:literal $meaning:literal)*) => {
        /// Everything a species is made of. Angles in degrees, lengths in metres.
        #[derive(Clone, Debug, PartialEq)]
        pub struct Parameters {
            $(#[doc = concat!($symbol, ": ", $meaning, " Unit: ", $unit, ".")] pub $key: f32,)*
        }

        impl Default for Parameters {
            fn default() -> Self {
                Self { $($key: $default,)* }
            }
        }

        /// All parameters: the 24 of the paper's appendix, then the constants it does not print.
        pub const TABLE: &[Parameter] = &[$(Parameter {
            key: stringify!($key),
            symbol: $symbol,
            unit: $unit,
            min: $min,
            max: $max,
            default: $default,
            whole: $whole,
            meaning: $meaning,
            get: |p| p.$key,
            set: |p, value| p.$key = value,
        },)*];
    };
}

parameters! {
    lateral_buds "G_NLB" "–" 0.0 .. 2.0 = 2.0 true "Lateral buds of an internode."
    apical_angle_mean "G_AAM" "°" -180.0 .. 180.0 = 0.0 false "Mean angle between an internode and its apical child."
    apical_angle_variance "G_AAV" "√°" 0.0 .. 10.0 = 0.0 false "Root of the standard deviation of the apical angle: the deviation is its square in degrees."
    branching_angle_mean "G_BAM" "°" 0.0 .. 180.0 = 45.0 false "Mean angle between an internode and a lateral child."
    branching_angle_variance "G_BAV" "√°" 0.0 .. 10.0 = 1.0 false "Root of the standard deviation of the branching angle."
    roll_angle_mean "G_RAM" "°" -360.0 .. 360.0 = 120.0 false "Mean roll from one internode to the next: the divergence angle of phyllotaxis."
    roll_angle_variance "G_RAV" "√°" 0.0 .. 10.0 = 3.0 false "Root of the standard deviation of the roll."
    apical_kill_probability "F_AKP" "1/cycle" 0.0 .. 1.0 = 0.0 false "Chance that an apical bud of order 1 or more dies in a cycle."
    lateral_kill_probability "F_LKP" "1/cycle" 0.0 .. 1.0 = 0.0 false "Chance that a lateral bud dies in a cycle."
    apical_lighting_factor "F_ALF" "–" 0.0 .. 10.0 = 0.0 false "Exponent of the light on an apical bud's chance to grow; no effect in the open field."
    lateral_lighting_factor "F_LLF" "–" 0.0 .. 10.0 = 0.0 false "Exponent of the light on a lateral bud's chance to flush; no effect in the open field."
    apical_dominance_base "F_ADB" "–" 0.0 .. 10.0 = 0.2 false "Auxin of a tip; it holds back the lateral buds below."
    apical_dominance_distance_factor "F_ADF" "1/cycle" 0.0 .. 1.0 = 1.0 false "What is left of a tip's auxin for each cycle of its age (the printed name says distance)."
    apical_dominance_age_factor "F_AAF" "1/m" 0.0 .. 1.0 = 0.3 false "What is left of the auxin for each metre of its way down (the printed name says age)."
    growth_rate "F_GR" "1/cycle" 0.1 .. 10.0 = 1.0 false "Internodes a shoot would grow in a cycle; counts only times the growth scale."
    internode_length "F_ILB" "m" 0.01 .. 10.0 = 1.0 false "Mean length of an internode."
    apical_control_base "F_ACB" "–" 1.0 .. 20.0 = 1.0 false "A shoot's elongation is divided by this to the power of its level; 1 grows all alike."
    phototropism "E_PHO" "–" -1.0 .. 1.0 = 0.0 false "Part of the angle to the light that a new shoot turns by."
    gravitropism "E_GGB" "–" -1.0 .. 1.0 = 0.0 false "Part of the angle to the vertical that a new shoot turns by: negative grows up, positive droops."
    pruning_factor "E_PPF" "1/cycle" 0.0 .. 1.0 = 0.0 false "As printed; what acts is the shedding slope."
    low_branch_pruning_factor "E_LPF" "–" 0.0 .. 1.0 = 0.0 false "Branches that start below this part of the longest root path are pruned."
    gravity_bending_strength "E_GBS" "–" 0.0 .. 100.0 = 0.0 false "How far a branch sags under its biomass."
    gravity_bending_angle_factor "E_GAF" "–" 0.0 .. 10.0 = 2.0 false "Exponent of the thickness that resists the sag."
    age "t" "cycles" 1.0 .. 100.0 = 35.0 true "Growth cycles of the tree."

    growth_scale "ν" "–" 0.01 .. 10.0 = 1.0 false "Elongation of a shoot in a cycle over the growth rate; 1/F_GR makes it one internode length."
    internode_length_deviation "–" "m" 0.0 .. 1.0 = 0.01 false "Standard deviation of the length of an internode."
    crown_density "κ" "–" 0.001 .. 100.0 = 0.1 false "Divides a lateral bud's chance to flush, times the density around it: limits the crown."
    density_radius "–" "m" 1.0 .. 64.0 = 16.0 false "How far an internode looks for others."
    shedding_base "b_0" "1/cycle" -1.0 .. 1.0 = -0.1 false "Chance that a tip of age 0 is shed; below 0 it is safe until it is older."
    shedding_slope "b_1" "1/cycle²" 0.0 .. 1.0 = 0.007 false "How much that chance grows with each cycle of the tip's age."
    shedding_cap "b_max" "1/cycle" 0.0 .. 1.0 = 0.5 false "Most that chance can be."
    shedding_protection "–" "–" 0.0 .. 20.0 = 1.0 true "Tips of this order or below are never shed."
    tip_radius "θ_end" "m" 0.0001 .. 1.0 = 0.01 false "Radius of a tip."
    pipe_exponent "–" "–" 1.0 .. 4.0 = 2.0 false "θ^n of a parent is the sum over its children."
    sag_cap "S_max" "–" 0.0 .. 10.0 = 1.0 false "Most that the sag coefficient can be."
}

impl Parameter {
    /// Checks one value of this parameter.
    ///
    /// # Errors
    ///
    /// When it is NaN, out of range, or not whole where it must be.
    pub fn check(&self, value: f32) -> Result<(), ParameterError> {
        let Self { key, symbol, min, max, .. } = *self;
        if !(min..=max).contains(&value) {
            return Err(ParameterError::OutOfRange { key, symbol, value, min, max });
        }
        if self.whole && libm::floorf(value).to_bits() != value.to_bits() {
            return Err(ParameterError::NotWhole { key, symbol, value });
        }
        Ok(())
    }
}

impl Parameters {
    /// Checks every value against [`TABLE`].
    ///
    /// # Errors
    ///
    /// The first value that is NaN, out of range, or not whole where it must be.
    pub fn validate(&self) -> Result<(), ParameterError> {
        TABLE.iter().try_for_each(|row| row.check((row.get)(self)))
    }
}

/// The row of a key.
#[must_use]
pub fn find(key: &str) -> Option<&'static Parameter> {
    TABLE.iter().find(|row| row.key == key)
}

/// [`TABLE`] as the Markdown of `docs/parameters.md`.
#[must_use]
pub fn markdown() -> String {
    let mut out = "# Parameters of the growth model\n\n\
        Made from the table in `crates/growth/src/parameters.rs` by\n\
        `cargo run -p deeptree-growth --example parameters > docs/parameters.md`.\n\n\
        | symbol | key | unit | range | default | meaning |\n|---|---|---|---|---|---|\n"
        .to_owned();
    for row in TABLE {
        let Parameter { key, symbol, unit, min, max, default, meaning, .. } = row;
        out +=
            &format!("| {symbol} | `{key}` | {unit} | {min} to {max} | {default} | {meaning} |\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_24_rows_are_the_symbols_of_the_papers_appendix_in_its_order() {
        let symbols: Vec<_> = TABLE.iter().take(24).map(|row| row.symbol).collect();
        assert_eq!(
            symbols.join(" "),
            "G_NLB G_AAM G_AAV G_BAM G_BAV G_RAM G_RAV F_AKP F_LKP F_ALF F_LLF F_ADB F_ADF F_AAF \
             F_GR F_ILB F_ACB E_PHO E_GGB E_PPF E_LPF E_GBS E_GAF t"
        );
    }

    #[test]
    fn the_document_is_the_table() {
        let document = include_str!("../../../docs/parameters.md");
        assert!(document == markdown(), "make docs/parameters.md again; its head says how");
    }

    #[test]
    fn nan_and_out_of_range_values_are_named() {
        let nan = Parameters { gravitropism: f32::NAN, ..Default::default() };
        assert!(nan.validate().unwrap_err().to_string().starts_with("gravitropism (E_GGB) is NaN"));
        let half = Parameters { age: 3.5, ..Default::default() };
        assert!(half.validate().unwrap_err().to_string().contains("whole number"));
        assert_eq!(Parameters::default().validate(), Ok(()));
    }
}
