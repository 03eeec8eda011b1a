//! Chapter 11: trees that are pruned and grow again, beside what they were before.

use anyhow::Result;
use deeptree_eval::report::chart::LEARNER;
use deeptree_eval::report::chart::lines::{Line, Lines, Panel, Point};
use deeptree_eval::report::picture::{Sheet, Shot, View};
use deeptree_eval::report::{Cell, Chapter, Tone};
use deeptree_eval::{Metric, TreeMetrics};
use deeptree_generate::{Limits, Regrown, regrow};
use deeptree_graph::{BranchGraph, Cut, Node, Quat, Seed, TreeTraits, Vec3};
use deeptree_growth::Species;
use deeptree_infer::{Model, Workspace};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::estimate::Estimate;
use super::study::Study;
use super::trees;

/// Trees of each species that are pruned in each way, and those that are pruned again and again.
const FULL: [u32; 2] = [200, 40];
const QUICK: [u32; 2] = [6, 3];

/// How often in a row.
const ROUNDS: [u32; 2] = [10, 3];

/// From the seed of a tree to that of its first regrowth.
const REGROWTH: u64 = 500_000;

/// A mean is as it should be within this part, and two standard errors.
const GOAL: f64 = 0.02;

/// What is measured of a tree.
const NUMBERS: [&str; 6] =
    ["nodes", "branches", "height", "crown radius", "branch length", "branching distance"];

/// How trees are pruned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Pruning {
    Height,
    Side,
    Order,
    Path,
    Root,
}

impl Pruning {
    const ALL: [Self; 5] = [Self::Height, Self::Side, Self::Order, Self::Path, Self::Root];

    const fn text(self) -> &'static str {
        match self {
            Self::Height => "above 0.3 of the height",
            Self::Side => "beyond x = 1 m",
            Self::Order => "orders above 1",
            Self::Path => "beyond half of the longest path",
            Self::Root => "all but the root",
        }
    }

    fn cut(self, tree: &BranchGraph) -> Cut {
        match self {
            Self::Height => Cut::Above(0.3 * TreeTraits::of(tree).height),
            Self::Side => Cut::Plane { normal: Vec3::X, offset: 1.0 },
            Self::Order => Cut::Order(1),
            Self::Path => Cut::Path(0.5),
            Self::Root => Cut::Nodes(tree.root().children.into_iter().flatten().collect()),
        }
    }
}

/// What became of the trees of a species that were pruned in one way.
#[derive(Serialize, Deserialize)]
struct Row {
    species: String,
    pruning: Pruning,
    /// Part of the nodes that was kept.
    kept: Estimate,
    /// Kept nodes of which a bit has changed.
    changed: u64,
    /// Trees that the budget cut off.
    cut_off: u32,
    /// Of each of [`NUMBERS`]: before, after, and the difference tree by tree.
    numbers: [[Estimate; 3]; NUMBERS.len()],
    /// Of each of [`NUMBERS`]: part of the trees within two standard deviations of the mean of those
    /// before; of the trees before themselves, and of the regrown ones.
    inside: [[f64; 2]; NUMBERS.len()],
}

/// Trees that are pruned again and again: each of [`NUMBERS`] after so many times, over what it was
/// at first.
#[derive(Serialize, Deserialize)]
struct Course {
    species: String,
    rounds: Vec<[Estimate; NUMBERS.len()]>,
}

pub(super) fn chapter(study: &Study<'_>) -> Result<Chapter> {
    let mut chapter = Chapter::new("regrowth", "Regrowth");
    let Some(model) = &study.model else {
        chapter.text("Only the growth model was measured.");
        return Ok(chapter);
    };
    let (mut rows, mut courses) = (Vec::new(), Vec::new());
    for species in &study.species {
        for pruning in Pruning::ALL {
            rows.push(measure(study, model, species, pruning)?);
        }
        courses.push(again_and_again(study, model, species)?);
    }
    say(&mut chapter, &rows, &courses);
    table(&mut chapter, &rows);
    chart(&mut chapter, &courses)?;
    picture(study, model, &mut chapter)?;
    save(study, &rows, &courses)?;
    Ok(chapter)
}

fn numbers(tree: &BranchGraph) -> [f64; NUMBERS.len()] {
    let (traits, metrics) = (TreeTraits::of(tree), TreeMetrics::of(tree));
    let mean = |metric: Metric| metrics.moments[metric as usize].mean;
    let traits = [traits.nodes, traits.branches, traits.height, traits.crown_radius];
    let [nodes, branches, height, radius] = traits.map(f64::from);
    let (length, distance) = (mean(Metric::BranchLength), mean(Metric::BranchingDistance));
    [nodes, branches, height, radius, length, distance]
}

/// The tree of a seed, regrown with another.
fn regrown(
    model: &Model,
    tree: &BranchGraph,
    cuts: &[Cut],
    seed: u64,
    work: &mut Workspace,
) -> Result<Regrown> {
    Ok(regrow(model, tree, cuts, Seed(seed), Limits::default(), work)?)
}

fn measure(study: &Study<'_>, model: &Model, species: &Species, pruning: Pruning) -> Result<Row> {
    let name = &species.name;
    study.part(&format!("regrowth-{name}-{pruning:?}"), || {
        let count = study.scale(FULL[0], QUICK[0]).min(study.trees());
        let what = format!("{name} {pruning:?}");
        let all = trees::many(study, &what, study.verb.seed, count, |work, seed| {
            let tree = trees::generated(model, name, seed, work)?.tree;
            let cut = [pruning.cut(&tree)];
            let made = regrown(model, &tree, &cut, seed.wrapping_add(REGROWTH), work)?;
            let kept = made.pruned.tree.len() as f64 / tree.len() as f64;
            let numbers = [numbers(&tree), numbers(&made.tree)];
            Ok((kept, changed(&tree, &made), made.hit_budget, numbers))
        })?;
        let of = |i: usize| {
            let sets = [0, 1].map(|set| Estimate::of(all.iter().map(|one| one.3[set][i])));
            let [before, after] = sets;
            [before, after, Estimate::of(all.iter().map(|one| one.3[1][i] - one.3[0][i]))]
        };
        let inside = |i: usize| {
            let Estimate { mean, sd, .. } = of(i)[0];
            [0, 1].map(|set| {
                let inside = |x: f64| (x - mean).abs() <= 2.0 * sd;
                all.iter().filter(|one| inside(one.3[set][i])).count() as f64 / all.len() as f64
            })
        };
        Ok(Row {
            species: name.clone(),
            pruning,
            kept: Estimate::of(all.iter().map(|one| one.0)),
            changed: all.iter().map(|one| one.1).sum(),
            cut_off: all.iter().map(|one| u32::from(one.2)).sum(),
            numbers: std::array::from_fn(of),
            inside: std::array::from_fn(inside),
        })
    })
}

/// Kept nodes that are not bit by bit what they were.
fn changed(before: &BranchGraph, made: &Regrown) -> u64 {
    let bits = |node: &Node| {
        let (p, q) = (node.position.to_array(), node.rotation.to_array());
        let numbers = [&p[..], &q, &[node.thickness, node.length]].concat();
        numbers.into_iter().map(f32::to_bits).chain([node.order.into(), node.slot.into()])
    };
    let is_other = |(node, now): (&Node, &Option<u32>)| match now {
        Some(now) => !bits(node).eq(bits(made.tree.node(*now))),
        None => false,
    };
    before.nodes().iter().zip(&made.kept).filter(|&pair| is_other(pair)).count() as u64
}

fn again_and_again(study: &Study<'_>, model: &Model, species: &Species) -> Result<Course> {
    let name = &species.name;
    study.part(&format!("regrowth-{name}-again"), || {
        let count = study.scale(FULL[1], QUICK[1]).min(study.trees());
        let rounds = u64::from(study.scale(ROUNDS[0], ROUNDS[1]));
        let all = trees::many(study, &format!("{name} again"), study.verb.seed, count, {
            |work, seed| {
                let mut tree = trees::generated(model, name, seed, work)?.tree;
                let first = numbers(&tree);
                (0..rounds)
                    .map(|round| {
                        // From another side each time, and all ends.
                        let side = Quat::from_rotation_y(2.4 * round as f32) * Vec3::X;
                        let cuts = [Cut::Plane { normal: side, offset: 2.0 }, Cut::Path(0.9)];
                        let seed = seed.wrapping_add(REGROWTH * (round + 1));
                        tree = regrown(model, &tree, &cuts, seed, work)?.tree;
                        let now = numbers(&tree);
                        Ok(std::array::from_fn(|i| now[i] / first[i]))
                    })
                    .collect::<Result<Vec<[f64; NUMBERS.len()]>>>()
            }
        })?;
        let round = |round: usize| {
            std::array::from_fn(|i| Estimate::of(all.iter().map(|tree| tree[round][i])))
        };
        Ok(Course { species: name.clone(), rounds: (0..rounds as usize).map(round).collect() })
    })
}

/// The mean difference as a part of the mean before, and its standard error.
fn difference([before, _, difference]: &[Estimate; 3]) -> (f64, f64) {
    (difference.mean / before.mean, difference.error() / before.mean)
}

fn is_good(numbers: &[Estimate; 3]) -> bool {
    let (by, error) = difference(numbers);
    by.abs() <= GOAL + 2.0 * error
}

fn say(chapter: &mut Chapter, rows: &[Row], courses: &[Course]) {
    let cells = || rows.iter().flat_map(|row| row.numbers.iter().map(move |n| (row, n)));
    let good = cells().filter(|(_, numbers)| is_good(numbers)).count();
    let changed: u64 = rows.iter().map(|row| row.changed).sum();
    let cut_off: u32 = rows.iter().map(|row| row.cut_off).sum();
    let trees: u32 = rows.iter().map(|row| row.kept.count).sum();
    let inside = |set: usize| {
        let all: f64 = rows.iter().flat_map(|row| row.inside).map(|parts| parts[set]).sum();
        100.0 * all / (rows.len() * NUMBERS.len()) as f64
    };
    chapter.text(format!(
        "Generated trees were pruned, grew again with another seed and were measured before and \
         after, {trees} in all. Kept nodes of which a bit has changed: {changed}. Trees that hit \
         the node budget: {cut_off}. Of {} means, {good} are within {:.0} % of those before, and \
         two standard errors. Within two standard deviations of their species' mean lie {:.1} % of \
         the trees' numbers before, and {:.1} % after.",
        cells().count(),
        100.0 * GOAL,
        inside(0),
        inside(1),
    ));
    let worst = cells().enumerate().max_by(|a, b| {
        let by = |numbers: &[Estimate; 3]| difference(numbers).0.abs();
        by(a.1.1).total_cmp(&by(b.1.1))
    });
    if let Some((at, (row, numbers))) = worst {
        let (by, error) = difference(numbers);
        chapter.text(format!(
            "The worst: the {} of {}, pruned {}, {:+.1} ± {:.1} %.",
            NUMBERS[at % NUMBERS.len()],
            row.species,
            row.pruning.text(),
            100.0 * by,
            100.0 * error,
        ));
    }
    let last = |course: &Course| course.rounds.last().map(|numbers| numbers[0].mean - 1.0);
    let mut drifts: Vec<(&str, f64)> =
        courses.iter().filter_map(|course| Some((&*course.species, last(course)?))).collect();
    drifts.sort_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some(least), Some(most), Some(course)) =
        (drifts.first(), drifts.last(), courses.first())
    {
        chapter.text(format!(
            "After {} regrowths in a row, the nodes of a tree have changed by {:+.1} % ({}) to \
             {:+.1} % ({}) in the mean.",
            course.rounds.len(),
            100.0 * least.1,
            least.0,
            100.0 * most.1,
            most.0,
        ));
    }
}

fn table(chapter: &mut Chapter, rows: &[Row]) {
    let header =
        ["species", "cut off", "kept"].into_iter().chain(NUMBERS).chain(["inside before", "after"]);
    let cells = |row: &Row| {
        let number = |numbers: &[Estimate; 3]| {
            let (by, error) = difference(numbers);
            let tone = if is_good(numbers) { Tone::Good } else { Tone::Bad };
            Cell::new(format!("{:+.1} ± {:.1} %", 100.0 * by, 100.0 * error), tone)
        };
        let inside = |set: usize| {
            let all: f64 = row.inside.iter().map(|parts| parts[set]).sum();
            format!("{:.0} %", 100.0 * all / NUMBERS.len() as f64)
        };
        let kept = format!("{:.0} %", 100.0 * row.kept.mean);
        let mut cells: Vec<Cell> =
            vec![row.species.as_str().into(), row.pruning.text().into(), kept.into()];
        cells.extend(row.numbers.iter().map(number));
        cells.push(Cell::new(inside(0), Tone::Quiet));
        cells.push(inside(1).into());
        cells
    };
    chapter.table(
        "Regrown trees against the same trees before they were pruned: differences of the means, \
         with standard errors, coloured where they are within 2 % and two standard errors, or not. \
         Kept: part of the nodes. Inside: how many of the numbers are within two standard \
         deviations of the mean of those before. The paper gives no figures.",
        &header.collect::<Vec<_>>(),
        rows.iter().map(cells).collect(),
    );
}

fn chart(chapter: &mut Chapter, courses: &[Course]) -> Result<()> {
    chapter.heading("Again and again");
    for (i, number) in NUMBERS.into_iter().enumerate().take(4) {
        let panel = |course: &Course| {
            let start = Point { x: 0.0, y: 1.0, error: 0.0, hollow: false };
            let point = |(round, numbers): (usize, &[Estimate; NUMBERS.len()])| Point {
                x: round as f64 + 1.0,
                y: numbers[i].mean,
                error: numbers[i].error(),
                hollow: false,
            };
            let rounds = course.rounds.iter().enumerate().map(point);
            let points = std::iter::once(start).chain(rounds).collect();
            let line = Line { name: "DT".to_owned(), colour: LEARNER, points };
            Panel { title: course.species.clone(), lines: vec![line] }
        };
        let lines = Lines {
            x: "regrowths".to_owned(),
            y: number.to_owned(),
            columns: 4,
            panels: courses.iter().map(panel).collect(),
        };
        let caption = format!(
            "{number} of trees that are pruned from another side each time, and at all ends, over \
             that of the trees at first; mean and standard error."
        );
        chapter.chart(caption, lines.svg()?);
    }
    Ok(())
}

/// The first tree of each species: before, pruned, and regrown twice.
fn picture(study: &Study<'_>, model: &Model, chapter: &mut Chapter) -> Result<()> {
    let mut work = study.verb.model.workspace()?;
    let mut columns: Vec<[BranchGraph; 4]> = Vec::new();
    for species in &study.species {
        let seed = study.verb.seed;
        let tree = trees::generated(model, &species.name, seed, &mut work)?.tree;
        let cut = [Pruning::Height.cut(&tree)];
        let mut make = |seed| regrown(model, &tree, &cut, seed, &mut work);
        let (one, other) = (make(seed)?, make(seed.wrapping_add(1))?);
        columns.push([tree, one.pruned.tree, one.tree, other.tree]);
    }
    let row = |i: usize| columns.iter().map(move |column| Shot::new(&column[i], View::FRONT));
    let shots: Vec<Shot<'_>> = (0..4).flat_map(row).collect();
    let sheet = Sheet {
        columns: columns.len(),
        width: study.scale(1600, 1000),
        row: study.scale(420, 300),
    };
    let names: Vec<&str> = study.species.iter().map(|species| species.name.as_str()).collect();
    chapter.heading("Before, pruned, and after");
    chapter.picture(
        format!(
            "From left to right {}; from above: the first tree of the set, not picked; what is \
             below 0.3 of its height; regrown from there with one seed, and with another. The \
             paper's figure \"Regrowth\", (a) to (c).",
            names.join(", ")
        ),
        sheet.png(&shots)?,
    );
    Ok(())
}

fn save(study: &Study<'_>, rows: &[Row], courses: &[Course]) -> Result<()> {
    let mut csv = String::from(
        "species,cut_off,trees,kept,changed_nodes,hit_budget,number,before,after,difference,\
         standard_error,inside_before,inside_after\n",
    );
    for row in rows {
        for (i, number) in NUMBERS.into_iter().enumerate() {
            let [before, after, difference] = row.numbers[i];
            csv += &format!(
                "{},{},{},{},{},{},{number},{},{},{},{},{},{}\n",
                row.species,
                row.pruning.text(),
                before.count,
                row.kept.mean,
                row.changed,
                row.cut_off,
                before.mean,
                after.mean,
                difference.mean,
                difference.error(),
                row.inside[i][0],
                row.inside[i][1],
            );
        }
    }
    study.save("regrowth.csv", csv.as_bytes())?;
    let json = json!({ "rows": rows, "again": courses });
    study.save("regrowth.json", serde_json::to_string_pretty(&json)?.as_bytes())
}
