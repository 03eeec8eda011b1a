//! Chapter 6: one network with shared layers against the cascade of four.
//!
//! Source: DeepTree §6, paragraph "Network Comparison".

use anyhow::Result;
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_learn::Kind;
use serde::{Deserialize, Serialize};

use super::lab::{Fit, Lab, Stand, percent};
use super::study::Study;

/// The paper's ranges over species: accuracy, MSE, cosine distance.
const PUBLISHED: [(&str, [&str; 3]); 2] = [
    ("cascade", ["83–93 %", "1.2e-4–3e-4", "0.04–0.20"]),
    ("joint", ["89–90 %", "0.28–0.51", "0.51–1.03"]),
];

/// One architecture on one species.
#[derive(Serialize, Deserialize)]
struct Outcome {
    species: String,
    fit: Fit,
    stand: Stand,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let species: Vec<_> = study.species.iter().collect();
    let (corpus, trees) = (study.scale(100, 10), study.scale(100, 10));
    let lab = Lab::new(study, "joint", species.clone(), corpus, trees);
    let teachers =
        species.iter().map(|species| lab.teacher(species)).collect::<Result<Vec<_>>>()?;
    let run = |name: &str, kind| -> Result<Vec<Outcome>> {
        let options = lab.options(kind);
        let one = |species: &&deeptree_growth::Species| {
            study.part(&format!("joint-{name}-{}", species.name), || {
                let (model, report) = lab.train(name, &options)?;
                let fit = Fit::of(&report, Some(&species.name))?;
                let stand = lab.stand(&model, species)?;
                Ok(Outcome { species: species.name.clone(), fit, stand })
            })
        };
        species.iter().map(one).collect()
    };
    let outcomes = [run("cascade", Kind::Paper)?, run("joint", Kind::Joint)?];
    save(study, &teachers, &outcomes)?;

    let mut chapter = Chapter::new("joint", "One joint network against the cascade");
    chapter.text(text(&teachers, &outcomes));
    chapter.text(format!(
        "{}. The joint network has the classifier's hidden layers and samples, and heads for the \
         children's existence, thickness and length, and quaternions; its loss is the sum of the \
         published ones.",
        lab.recipe()
    ));
    let mut rows = Vec::new();
    for ((name, published), outcomes) in PUBLISHED.iter().zip(&outcomes) {
        let [accuracy, mse, cosine] = ranges(outcomes);
        rows.push(vec![
            Cell::from(*name),
            Cell::from(accuracy),
            Cell::new(published[0], Tone::Quiet),
            Cell::from(mse),
            Cell::new(published[1], Tone::Quiet),
            Cell::from(cosine),
            Cell::new(published[2], Tone::Quiet),
        ]);
    }
    chapter.table(
        "Validation trees, least and most of the species; beside the paper's ranges",
        &["", "accuracy", "paper", "MSE, m²", "paper", "cosine distance", "paper"],
        rows,
    );
    let header: Vec<&str> = ["species", "", "accuracy", "MSE, m²", "cosine distance"]
        .into_iter()
        .chain(Stand::HEADER)
        .collect();
    let mut rows = Vec::new();
    for (i, teacher) in teachers.iter().enumerate() {
        let dash = || Cell::new("–", Tone::Quiet);
        let mut row = vec![Cell::from(species[i].name.as_str()), Cell::new("teacher", Tone::Quiet)];
        row.extend([dash(), dash(), dash()]);
        row.extend(teacher.cells(None));
        rows.push(row);
        for ((name, _), outcomes) in PUBLISHED.iter().zip(&outcomes) {
            let Outcome { fit, stand, .. } = &outcomes[i];
            let mut row = vec![Cell::default(), Cell::from(*name)];
            row.push(Cell::from(format!("{:.1} %", 100.0 * fit.accuracy)));
            row.push(Cell::from(format!("{:.1e}", fit.mse)));
            row.push(Cell::from(format!("{:.4}", fit.cosine_distance)));
            row.extend(stand.cells(Some(teacher)));
            rows.push(row);
        }
    }
    chapter.table("By species, and the trees they grow", &header, rows);
    let names = PUBLISHED.map(|(name, _)| name.to_owned());
    for species in &species {
        chapter.picture(
            format!("{}, from the left: teacher, cascade, joint.", species.name),
            lab.picture(species, &names)?,
        );
    }
    Ok(chapter)
}

/// Least and most of each figure over the species.
fn ranges(outcomes: &[Outcome]) -> [String; 3] {
    let range = |of: fn(&Fit) -> f64| {
        let values = outcomes.iter().map(|outcome| of(&outcome.fit));
        let least = values.clone().fold(f64::INFINITY, f64::min);
        (least, values.fold(f64::NEG_INFINITY, f64::max))
    };
    let (accuracy, mse) = (range(|fit| fit.accuracy), range(|fit| fit.mse));
    let cosine = range(|fit| fit.cosine_distance);
    [
        format!("{:.0}–{:.0} %", 100.0 * accuracy.0, 100.0 * accuracy.1),
        format!("{:.1e}–{:.1e}", mse.0, mse.1),
        format!("{:.4}–{:.4}", cosine.0, cosine.1),
    ]
}

fn mean(outcomes: &[Outcome], of: impl Fn(&Outcome) -> f64) -> f64 {
    outcomes.iter().map(of).sum::<f64>() / outcomes.len() as f64
}

fn text(teachers: &[Stand], [cascade, joint]: &[Vec<Outcome>; 2]) -> String {
    let [of_cascade, of_joint] = [cascade, joint].map(|outcomes| ranges(outcomes));
    let times = |of: fn(&Outcome) -> f64| mean(joint, of) / mean(cascade, of);
    let nodes = |outcomes: &[Outcome]| {
        let ratios = outcomes.iter().zip(teachers).map(|(o, t)| o.stand.nodes.mean / t.nodes.mean);
        ratios.sum::<f64>() / teachers.len() as f64
    };
    format!(
        "The joint network tells {} of the children right, the cascade {}. Its MSE is {:.1} times \
         the cascade's and its cosine distance {:.1} times (paper: about two thousand times and \
         about seven). {} of its trees end by themselves, of the cascade's {}, and they have {:.1} \
         and {:.1} times the teacher's nodes; the paper's joint network predicted erroneous \
         branching that ended the trees at once.",
        of_joint[0],
        of_cascade[0],
        times(|outcome| outcome.fit.mse),
        times(|outcome| outcome.fit.cosine_distance),
        percent(mean(joint, |outcome| outcome.stand.ended)),
        percent(mean(cascade, |outcome| outcome.stand.ended)),
        nodes(joint),
        nodes(cascade),
    )
}

fn save(study: &Study<'_>, teachers: &[Stand], outcomes: &[Vec<Outcome>; 2]) -> Result<()> {
    let header = "species,architecture,accuracy,mse,cosine_distance";
    let mut csv = format!("{header},{}\n", Stand::CSV);
    for (i, teacher) in teachers.iter().enumerate() {
        csv += &format!("{},teacher,,,,{}\n", outcomes[0][i].species, teacher.csv());
        for ((name, _), outcomes) in PUBLISHED.iter().zip(outcomes) {
            let Outcome { species, fit, stand } = &outcomes[i];
            let Fit { accuracy, mse, cosine_distance } = fit;
            let figures = stand.csv();
            csv += &format!("{species},{name},{accuracy},{mse},{cosine_distance},{figures}\n");
        }
    }
    let json = serde_json::json!({
        "teacher": teachers, "cascade": &outcomes[0], "joint": &outcomes[1],
    });
    study.save("joint.csv", csv.as_bytes())?;
    study.save("joint.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
