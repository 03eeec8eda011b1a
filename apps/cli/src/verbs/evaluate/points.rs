//! Chapter 5, last part: what each of the points that make kind `situated` is worth.

use anyhow::{Context, Result};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_graph::signature::situated::{
    ATTRIBUTES, LOG_SCALE, ROTATION_COMPONENTS, ROTATION_OUTPUTS,
};
use deeptree_growth::Species;
use deeptree_infer::{Table, Weights, WeightsBuilder};
use deeptree_learn::{Kind, TrainOptions};

use super::lab::{Lab, Stand, percent};
use super::study::Study;
use crate::verbs::train::training::set_reads;

const EXISTENCE: &[&str] = &["existence"];
const ROTATIONS: &[&str] = &["rotation1", "rotation2", "rotation3"];
const ALL: &[&str] =
    &["existence", "split", "reach", "size", "rotation1", "rotation2", "rotation3"];

/// Epochs and steps an epoch of each network: less than a tenth of what the model that ships gives
/// its longest.
const EPOCHS: u32 = 4;
const STEPS_PER_EPOCH: u64 = 2_500;

/// With `--quick`.
const QUICK_STEPS: u64 = 100;

/// The rows: what is switched off, and how.
const POINTS: [(&str, &str); 5] = [
    ("none", "as it is"),
    ("balanced", "1: nodes with 0 to 3 children balanced, as the paper trains its classifier"),
    ("likeliest", "2: the likeliest rotation instead of one that is drawn"),
    ("frame", "4: node's global frame and distance to the last fork unread"),
    (
        "traits",
        "5: traits of the whole tree unread; the reach of the root still tells its longest path",
    ),
];

/// Adds the part to the chapter, and gives its figures.
pub(super) fn add(
    study: &Study<'_>,
    species: &Species,
    chapter: &mut Chapter,
) -> Result<Vec<(&'static str, Stand)>> {
    let (corpus, trees) = (study.scale(500, 20), study.scale(200, 12));
    let lab = Lab::new(study, "points", vec![species], corpus, trees);
    let teacher = lab.teacher(species)?;
    let mut stands = Vec::new();
    for (name, _) in POINTS {
        let stand = study.part(&format!("points-{name}"), || {
            let model = model(study, &lab, name)?;
            lab.keep(name, &model)?;
            lab.stand(&model, species)
        });
        stands.push((name, stand.with_context(|| format!("kind situated, {name}"))?));
    }
    chapter.heading("The points of kind situated");
    chapter.text(text(&teacher, &stands));
    let options = options(study, &lab);
    chapter.text(format!(
        "Networks of {} steps of {} samples{}, {} trees of {} to train on: less than the model \
         that ships, so only the rows are to be compared. Rows differ by the networks that the \
         point is about; the others are the same bits. Point 3, thickness as whole tips that add \
         up at forks, cannot be switched off: what the networks say is tips; kind paper, which \
         regresses thickness, shows what becomes of trees without it. Point 4 is switched off for \
         the features of the node; the frame of the slot, in which a rotation is told, stays. Point \
         6, the correction of drift, is no part of the program but how the features were found; \
         docs/fidelity.md keeps the log.",
        u64::from(options.epochs) * options.steps_per_epoch.unwrap_or(0),
        options.batch,
        if study.verb.quick { " (a quick run: far too little to judge the points by)" } else { "" },
        corpus - corpus / 5,
        species.name,
    ));
    let header: Vec<&str> = ["switched off"].into_iter().chain(Stand::HEADER).collect();
    let mut rows = vec![[vec![Cell::new("teacher", Tone::Quiet)], teacher.cells(None)].concat()];
    for ((_, what), (_, stand)) in POINTS.iter().zip(&stands) {
        rows.push([vec![Cell::from(*what)], stand.cells(Some(&teacher))].concat());
    }
    chapter.table("Kind situated with one point switched off", &header, rows);
    chapter.picture(
        "From the left: the teacher, then the rows of the table.",
        lab.picture(species, &POINTS.map(|(name, _)| name.to_owned()))?,
    );
    Ok(stands)
}

fn text(teacher: &Stand, stands: &[(&str, Stand)]) -> String {
    let list: Vec<String> = POINTS
        .iter()
        .zip(stands)
        .map(|((_, what), (_, stand))| {
            let nodes = stand.nodes.mean / teacher.nodes.mean - 1.0;
            let auc = stand.auc.map_or(f64::NAN, |[value, ..]| value);
            format!(
                "{what}: nodes {:+.0} %, {} ended, AUC {auc:.2}",
                100.0 * nodes,
                percent(stand.ended)
            )
        })
        .collect();
    format!(
        "Kind situated with one of its points switched off, against the teacher: {}.",
        list.join("; ")
    )
}

fn options(study: &Study<'_>, lab: &Lab<'_>) -> TrainOptions {
    let mut options = lab.options(Kind::Situated);
    options.networks.clear();
    if study.verb.quick {
        options.steps_per_epoch = Some(QUICK_STEPS);
    } else {
        options.epochs = EPOCHS;
        options.steps_per_epoch = Some(STEPS_PER_EPOCH);
    }
    options
}

fn model(study: &Study<'_>, lab: &Lab<'_>, name: &str) -> Result<Vec<u8>> {
    let full = options(study, lab);
    let (full_bytes, _) = lab.train("full", &full)?;
    let without = |hidden: &[&str], networks| -> Result<Vec<u8>> {
        let reads: Vec<&str> = ATTRIBUTES.into_iter().filter(|a| !hidden.contains(a)).collect();
        let mut options = full.clone();
        set_reads(&mut options, networks, &reads);
        Ok(lab.train_some(name, options, networks, &full_bytes)?.0)
    };
    match name {
        "balanced" => {
            let mut options = full.clone();
            options.networks.entry(EXISTENCE[0].to_owned()).or_default().balanced = Some(true);
            Ok(lab.train_some(name, options, EXISTENCE, &full_bytes)?.0)
        }
        "likeliest" => likeliest_rotations(&full_bytes),
        "frame" => without(&["frame", "df"], ALL),
        "traits" => without(&["traits", "standing"], ALL),
        _ => Ok(full_bytes),
    }
}

/// The model that takes the likeliest component of each mixture, and its mean: logits a thousand
/// times as far apart, and the least deviation that a head can say.
fn likeliest_rotations(bytes: &[u8]) -> Result<Vec<u8>> {
    const K: usize = ROTATION_COMPONENTS;
    const LOGITS: usize = K + 1;
    // After the logits: mean and log deviation of the aligned law; means of x and y, log deviations
    // of x and y, and slopes.
    let is_deviation =
        |o: usize| o == LOGITS + 1 || (LOGITS + 2 + 2 * K..LOGITS + 2 + 4 * K).contains(&o);
    let is_slope = |o: usize| o >= LOGITS + 2 + 4 * K;
    let weights = Weights::from_bytes(bytes)?;
    let mut model = WeightsBuilder::from_weights(&weights);
    for network in ROTATIONS {
        let layer = weights.mlp(network)?.layer_count() - 1;
        let edit = |part: &str, constant: f32| -> Result<Table> {
            let name = format!("{network}.{layer}.{part}");
            let shape = if part == "bias" {
                vec![Some(ROTATION_OUTPUTS)]
            } else {
                vec![None, Some(ROTATION_OUTPUTS)]
            };
            let table = weights.table(&name, &shape)?;
            let mut values = table.values().to_vec();
            for row in values.chunks_exact_mut(ROTATION_OUTPUTS) {
                for (o, value) in row.iter_mut().enumerate() {
                    if o < LOGITS {
                        *value *= 1000.0;
                    } else if is_deviation(o) {
                        *value = constant;
                    } else if is_slope(o) {
                        *value = 0.0;
                    }
                }
            }
            Ok(Table::new(table.shape().to_vec(), values)?)
        };
        let (weight, bias) = (edit("weight", 0.0)?, edit("bias", *LOG_SCALE.start())?);
        model.layer(network, u32::try_from(layer)?, weight, bias);
    }
    // The networks say the angles of buds, too.
    model.without_table("buds");
    Ok(model.to_bytes()?)
}
