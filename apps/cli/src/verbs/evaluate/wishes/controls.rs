//! Trees that were asked for by one number of the whole tree.

use anyhow::Result;
use deeptree_generate::{GenerateError, Limits, Request, Wishes, clamp_wishes, generate, germ};
use deeptree_graph::{BranchGraph, Seed, TreeTraits};
use deeptree_infer::{Model, Workspace};
use serde::{Deserialize, Serialize};

use crate::verbs::evaluate::estimate::Estimate;
use crate::verbs::evaluate::study::Study;
use crate::verbs::evaluate::trees;

/// Trees of each setting.
const FULL: u32 = 40;
const QUICK: u32 = 3;

/// What lies outside of a range is asked for as so many times its ends.
const OUTSIDE: [f32; 2] = [0.5, 1.5];

/// What can be asked of a whole tree.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Control {
    Height,
    CrownRadius,
    Branches,
    Trunk,
}

impl Control {
    pub(super) const ALL: [Self; 4] =
        [Self::Height, Self::CrownRadius, Self::Branches, Self::Trunk];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Height => "height",
            Self::CrownRadius => "crown radius",
            Self::Branches => "branches",
            Self::Trunk => "trunk",
        }
    }

    /// Decimals and unit of the number.
    pub(super) fn write(self, value: f64) -> String {
        match self {
            Self::Branches => format!("{value:.0}"),
            _ => format!("{value:.1} m"),
        }
    }

    /// From one setting to the next.
    const fn step(self) -> f32 {
        match self {
            Self::Branches => 250.0,
            _ => 3.0,
        }
    }

    fn wishes(self, value: f32) -> Wishes {
        let (value, open) = (Some(value), Wishes::default());
        match self {
            Self::Height => Wishes { height: value, ..open },
            Self::CrownRadius => Wishes { crown_radius: value, ..open },
            Self::Branches => Wishes { branches: value, ..open },
            Self::Trunk => Wishes { trunk_length: value, ..open },
        }
    }

    /// What was wished of this control.
    const fn wished(self, wishes: &Wishes) -> Option<f32> {
        match self {
            Self::Height => wishes.height,
            Self::CrownRadius => wishes.crown_radius,
            Self::Branches => wishes.branches,
            Self::Trunk => wishes.trunk_length,
        }
    }

    /// The number of a tree that has grown.
    fn of(self, tree: &BranchGraph) -> f64 {
        let traits = TreeTraits::of(tree);
        f64::from(match self {
            Self::Height => traits.height,
            Self::CrownRadius => traits.crown_radius,
            Self::Branches => traits.branches,
            Self::Trunk => traits.trunk_length,
        })
    }

    fn request(self, species: &str, value: f32, seed: u64) -> Request {
        Request { wishes: self.wishes(value), ..Request::new(species, Seed(seed)) }
    }
}

/// A value that was asked for, and the trees that came.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Setting {
    pub(super) asked: f32,
    /// The number that was asked for, of the trees as they have grown.
    pub(super) came: Estimate,
    /// Mean age of the trees, in growth cycles: a wish may move it.
    pub(super) age: f64,
    /// Trees that their budget cut short; they are in the numbers as far as they got.
    pub(super) cut: u32,
}

impl Setting {
    /// How far the mean is from what was asked for, as a part of it.
    pub(super) fn deviation(&self) -> f64 {
        self.came.mean / f64::from(self.asked) - 1.0
    }

    /// The standard error of [`Self::deviation`].
    pub(super) fn error(&self) -> f64 {
        self.came.error() / f64::from(self.asked)
    }

    /// How far single trees scatter, as a part of what was asked for.
    pub(super) fn scatter(&self) -> f64 {
        self.came.sd / f64::from(self.asked)
    }
}

/// A request beyond the range: what is said, and what `--force` makes of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Outside {
    pub(super) asked: f32,
    /// What the request is refused with; none when it was not refused.
    pub(super) refusal: Option<String>,
    /// Trees of the request moved into the range.
    pub(super) forced: Setting,
}

/// All of one control of a species.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Controlled {
    pub(super) control: Control,
    /// What the model grants.
    pub(super) range: (f32, f32),
    pub(super) settings: Vec<Setting>,
    pub(super) outside: Vec<Outside>,
}

/// The controls of a species.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct SpeciesControls {
    pub(super) species: String,
    pub(super) controls: Vec<Controlled>,
}

pub(super) fn measure(study: &Study<'_>, model: &Model, species: &str) -> Result<SpeciesControls> {
    let one = |control: Control| {
        study.part(&format!("wishes-{species}-{}", control.name().replace(' ', "-")), || {
            measure_one(study, model, species, control)
        })
    };
    let controls: Result<_> = Control::ALL.into_iter().map(one).collect();
    Ok(SpeciesControls { species: species.to_owned(), controls: controls? })
}

fn measure_one(
    study: &Study<'_>,
    model: &Model,
    species: &str,
    control: Control,
) -> Result<Controlled> {
    let range = range(model, species, control)?;
    let settings = values(control, range, study.verb.quick)
        .into_iter()
        .map(|asked| setting(study, model, species, control, asked));
    let asked = [OUTSIDE[0] * range.0, OUTSIDE[1] * range.1];
    let outside = asked.into_iter().map(|asked| outside(study, model, species, control, asked));
    Ok(Controlled {
        control,
        range,
        settings: settings.collect::<Result<_>>()?,
        outside: outside.collect::<Result<_>>()?,
    })
}

/// What the model says that it grants, when asked for more than any tree has.
fn range(model: &Model, species: &str, control: Control) -> Result<(f32, f32)> {
    match germ(model, &control.request(species, f32::MAX, 0)) {
        Err(GenerateError::OutOfRange { low, high, .. }) => Ok((low, high)),
        Err(error) => Err(error.into()),
        Ok(_) => anyhow::bail!("the model grants a {species} any {}", control.name()),
    }
}

/// The multiples of the control's step within the range; of a quick run the first, one in the
/// middle and the last.
fn values(control: Control, (low, high): (f32, f32), quick: bool) -> Vec<f32> {
    let step = control.step();
    let first = (low / step).ceil().max(1.0) as u32;
    let last = (high / step).floor() as u32;
    let mut steps: Vec<u32> = (first..=last).collect();
    if quick && steps.len() > 3 {
        steps = vec![first, first.midpoint(last), last];
    }
    steps.into_iter().map(|k| k as f32 * step).collect()
}

fn setting(
    study: &Study<'_>,
    model: &Model,
    species: &str,
    control: Control,
    asked: f32,
) -> Result<Setting> {
    let count = study.scale(FULL, QUICK).min(study.trees());
    let what = format!("{species} {} {asked}", control.name());
    let trees = trees::many(study, &what, study.verb.seed, count, |work, seed| {
        let request = control.request(species, asked, seed);
        let grown = generate(model, &request, Limits::default(), work)?;
        Ok((control.of(&grown.tree), f64::from(grown.germ.root.age), grown.hit_budget))
    })?;
    let ages: f64 = trees.iter().map(|tree| tree.1).sum();
    Ok(Setting {
        asked,
        came: Estimate::of(trees.iter().map(|tree| tree.0)),
        age: ages / trees.len().max(1) as f64,
        cut: trees.iter().filter(|tree| tree.2).count() as u32,
    })
}

fn outside(
    study: &Study<'_>,
    model: &Model,
    species: &str,
    control: Control,
    asked: f32,
) -> Result<Outside> {
    let request = control.request(species, asked, study.verb.seed);
    let refusal = germ(model, &request).err().map(|error| error.to_string());
    let moved = control.wished(&clamp_wishes(model, &request)?).unwrap_or(asked);
    let forced = setting(study, model, species, control, moved)?;
    Ok(Outside { asked, refusal, forced })
}

/// The tree of a wish, for the picture.
pub(super) fn tree(
    model: &Model,
    species: &str,
    (control, asked): (Control, f32),
    seed: u64,
    work: &mut Workspace,
) -> Result<BranchGraph> {
    let request = control.request(species, asked, seed);
    Ok(generate(model, &request, Limits::default(), work)?.tree)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_are_the_round_values_of_the_range_and_a_quick_run_has_three() {
        let values = |range, quick| values(Control::Height, range, quick);
        assert_eq!(values((11.3, 21.0), false), [12.0, 15.0, 18.0, 21.0]);
        assert_eq!(values((12.0, 23.9), true), [12.0, 15.0, 21.0]);
        assert_eq!(values((12.5, 14.5), false), [0.0f32; 0]);
        assert_eq!(super::values(Control::Branches, (240.0, 510.0), true), [250.0, 500.0]);
    }

    #[test]
    fn a_deviation_is_a_part_of_what_was_asked_for() {
        let came = Estimate { count: 4, mean: 19.0, sd: 2.0 };
        let setting = Setting { asked: 20.0, came, age: 30.0, cut: 0 };
        assert!((setting.deviation() + 0.05).abs() < 1e-12);
        assert!((setting.error() - 0.05).abs() < 1e-12);
        assert!((setting.scatter() - 0.1).abs() < 1e-12);
    }
}
