//! Chapter 5: what the attributes of a node are worth to the networks of kind `paper`.
//!
//! Source: DeepTree §5, figures "Ablation study of the classification network" and "Ablation study
//! of regression networks".

use anyhow::{Context, Result};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_growth::Species;
use deeptree_learn::{Kind, TrainOptions};
use serde::{Deserialize, Serialize};

use super::lab::{Fit, Lab, Stand, percent};
use super::points;
use super::study::Study;
use crate::verbs::preset;
use crate::verbs::train::training::set_reads;

/// The species of the figures.
const SPECIES: &str = "beech";

/// All attributes of a node; those of the whole tree (a, v, s) are left out.
const ALL: &[&str] = &["p", "t", "dr", "ds", "qp", "lp", "o", "mp"];

/// Of the classifier: p, then d_s and m_p, then t, then o as the text has them, and all.
const CLASSIFIER: [(&str, &[&str]); 5] = [
    ("a", &["p"]),
    ("b", &["p", "ds", "mp"]),
    ("c", &["p", "ds", "mp", "t"]),
    ("d", &["p", "ds", "mp", "t", "o"]),
    ("e", ALL),
];

/// Of the regressors: the text says that (a) and (b) have few, and that (c) and (d) add "the
/// position or the order".
const REGRESSORS: [(&str, &[&str]); 4] = [
    ("a", &["ds", "mp"]),
    ("b", &["ds", "mp", "t"]),
    ("c", &["ds", "mp", "t", "p"]),
    ("d", &["ds", "mp", "t", "p", "o"]),
];

const CLASSIFIER_NETWORKS: &[&str] = &["classifier"];
const REGRESSOR_NETWORKS: &[&str] = &["regressor1", "regressor2", "regressor3"];

/// Grown and judged.
#[derive(Serialize, Deserialize)]
struct Outcome {
    fit: Fit,
    stand: Stand,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let species = preset(SPECIES)?;
    let (corpus, trees) = (study.scale(500, 20), study.scale(200, 12));
    let lab = Lab::new(study, "ablation", vec![&species], corpus, trees);
    let teacher = lab.teacher(&species)?;
    let run = |part: &str, networks: &[&str], name: &str, reads: &[&str]| {
        study
            .part(&format!("ablation-{part}-{name}"), || {
                outcome(&lab, &species, part, networks, name, reads)
            })
            .with_context(|| format!("{part} ({name})"))
    };
    let classifier = CLASSIFIER
        .map(|(name, reads)| run("classifier", CLASSIFIER_NETWORKS, name, reads))
        .into_iter()
        .collect::<Result<Vec<_>>>()?;
    let regressors = REGRESSORS
        .map(|(name, reads)| run("regressors", REGRESSOR_NETWORKS, name, reads))
        .into_iter()
        .collect::<Result<Vec<_>>>()?;
    let mut chapter = Chapter::new("ablation", "Ablations of the node's attributes");
    chapter.text(classifier_text(&classifier));
    chapter.text(regressors_text(&classifier[4], &regressors));
    chapter.text(format!(
        "{}. Species {SPECIES}, as in the paper; attributes by the paper's symbols; a, v and s are \
         left out everywhere. Networks that are not ablated read all attributes of the node and \
         are the same bits in every row. AUC: a random forest on features of whole trees, \
         generated ones against the teacher's; 0.5 is indistinguishable.",
        lab.recipe()
    ));
    let header: Vec<&str> = ["", "reads", "accuracy"].into_iter().chain(Stand::HEADER).collect();
    let mut rows = vec![teacher_row(&teacher, 1)];
    for ((name, reads), outcome) in CLASSIFIER.iter().zip(&classifier) {
        rows.push(row(name, reads, &[share(outcome.fit.accuracy)], &outcome.stand, &teacher));
    }
    chapter.heading("The classifier");
    chapter.table("Classifier; accuracy: children told right, paper 83–93 %", &header, rows);

    let header: Vec<&str> =
        ["", "reads", "MSE, m²", "cosine distance"].into_iter().chain(Stand::HEADER).collect();
    let mut rows = vec![teacher_row(&teacher, 2)];
    let all = ("all", ALL);
    for ((name, reads), outcome) in
        REGRESSORS.iter().chain([&all]).zip(regressors.iter().chain([&classifier[4]]))
    {
        let fit = [number(outcome.fit.mse), number(outcome.fit.cosine_distance)];
        rows.push(row(name, reads, &fit, &outcome.stand, &teacher));
    }
    chapter.heading("The regressors");
    chapter.table(
        "Regressors; mean over all children; paper with all: MSE 1.2e-4–3e-4, cosine 0.04–0.20",
        &header,
        rows,
    );
    let names = |part: &str, names: &[(&str, &[&str])]| -> Vec<String> {
        let kept = names.iter().filter(|(_, reads)| *reads != ALL);
        let kept = kept.map(|(name, _)| format!("{part}-{name}"));
        kept.chain(["all".to_owned()]).collect()
    };
    for (part, configurations) in
        [("classifier", CLASSIFIER.as_slice()), ("regressors", REGRESSORS.as_slice())]
    {
        let png = lab.picture(&species, &names(part, configurations))?;
        chapter.picture(
            format!("From the left: the teacher, the {part} (a) to (d), and all attributes."),
            png,
        );
    }
    let points = points::add(study, &species, &mut chapter)?;
    save(study, &teacher, &classifier, &regressors, &points)?;
    Ok(chapter)
}

/// Trains the ablated networks, and grows trees with them and with the others of the full model.
fn outcome(
    lab: &Lab<'_>,
    species: &Species,
    part: &str,
    networks: &[&str],
    name: &str,
    reads: &[&str],
) -> Result<Outcome> {
    let full = all_attributes(lab);
    let (full_bytes, full_report) = lab.train("all", &full)?;
    if reads == ALL {
        let stand = lab.stand(&full_bytes, species)?;
        return Ok(Outcome { fit: Fit::of(&full_report, None)?, stand });
    }
    let mut options = full;
    set_reads(&mut options, networks, reads);
    let label = format!("{part}-{name}");
    let (model, mut report) = lab.train_some(&label, options, networks, &full_bytes)?;
    for (network, figures) in full_report.networks {
        if !networks.contains(&network.as_str()) {
            report.networks.insert(network, figures);
        }
    }
    lab.keep(&label, &model)?;
    Ok(Outcome { fit: Fit::of(&report, None)?, stand: lab.stand(&model, species)? })
}

/// The recipe with all attributes of the node, and none of the whole tree.
fn all_attributes(lab: &Lab<'_>) -> TrainOptions {
    let mut options = lab.options(Kind::Paper);
    set_reads(&mut options, CLASSIFIER_NETWORKS, ALL);
    set_reads(&mut options, REGRESSOR_NETWORKS, ALL);
    options
}

fn classifier_text(outcomes: &[Outcome]) -> String {
    let list = |of: fn(&Outcome) -> String| {
        let named = CLASSIFIER.iter().zip(outcomes);
        named.map(|((name, _), o)| format!("({name}) {}", of(o))).collect::<Vec<_>>().join(", ")
    };
    let (without, with) = outcomes.split_at(2);
    let most = |part: &[Outcome]| part.iter().map(|o| o.stand.ended).fold(0.0, f64::max);
    format!(
        "Trees that end below the budget, by what the classifier reads: {}; children told right: \
         {}. In the paper (a) and (b) did not end and were stopped by hand, and (c) to (e) did \
         end; here at most {} of the trees of (a) and (b) end, and at most {} of (c) to (e).",
        list(|o| percent(o.stand.ended)),
        list(|o| percent(o.fit.accuracy)),
        percent(most(without)),
        percent(most(with)),
    )
}

fn regressors_text(all: &Outcome, outcomes: &[Outcome]) -> String {
    let named = REGRESSORS.iter().zip(outcomes).map(|((name, _), o)| (*name, o));
    let list: Vec<String> = named
        .chain([("all", all)])
        .map(|(name, o)| format!("({name}) {:.1e} m² and {:.4}", o.fit.mse, o.fit.cosine_distance))
        .collect();
    format!(
        "Error of the regressors, MSE of thickness and length and cosine distance, by what they \
         read: {}. The classifier reads all attributes there, as in the paper.",
        list.join(", ")
    )
}

fn teacher_row(teacher: &Stand, fits: usize) -> Vec<Cell> {
    let dash = || Cell::new("–", Tone::Quiet);
    let mut row = vec![Cell::new("teacher", Tone::Quiet), dash()];
    row.extend((0..fits).map(|_| dash()));
    row.extend(teacher.cells(None));
    row
}

fn row(name: &str, reads: &[&str], fit: &[String], stand: &Stand, teacher: &Stand) -> Vec<Cell> {
    let mut row = vec![Cell::from(format!("({name})")), Cell::from(reads.join(", "))];
    row.extend(fit.iter().map(|text| Cell::from(text.as_str())));
    row.extend(stand.cells(Some(teacher)));
    row
}

fn share(value: f64) -> String {
    format!("{:.1} %", 100.0 * value)
}

fn number(value: f64) -> String {
    format!("{value:.2e}")
}

fn save(
    study: &Study<'_>,
    teacher: &Stand,
    classifier: &[Outcome],
    regressors: &[Outcome],
    points: &[(&str, Stand)],
) -> Result<()> {
    let mut csv = format!("part,name,reads,accuracy,mse,cosine_distance,{}\n", Stand::CSV);
    csv += &format!("teacher,,,,,{}\n", teacher.csv());
    let mut list = Vec::new();
    let parts = [
        ("classifier", CLASSIFIER.as_slice(), classifier),
        ("regressors", REGRESSORS.as_slice(), regressors),
    ];
    for (part, configurations, outcomes) in parts {
        for ((name, reads), Outcome { fit, stand }) in configurations.iter().zip(outcomes) {
            let (reads_text, figures) = (reads.join(" "), stand.csv());
            csv += &format!(
                "{part},{name},{reads_text},{},{},{},{figures}\n",
                fit.accuracy, fit.mse, fit.cosine_distance
            );
            list.push(serde_json::json!({
                "part": part, "name": name, "reads": reads, "fit": fit, "trees": stand,
            }));
        }
    }
    for (name, stand) in points {
        csv += &format!("situated,{name},,,,{}\n", stand.csv());
        list.push(serde_json::json!({ "part": "situated", "name": name, "trees": stand }));
    }
    let json =
        serde_json::json!({ "species": SPECIES, "teacher": teacher, "configurations": list });
    study.save("ablation.csv", csv.as_bytes())?;
    study.save("ablation.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
