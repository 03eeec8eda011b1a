//! The figures of the chapter in words, charts and tables.

use std::fmt::Write as _;

use anyhow::Result;
use deeptree_eval::ORDERS;
use deeptree_eval::calibration::{BinPoint, Reliability, TreeMean, Uniformity};
use deeptree_eval::report::chart::lines::{Line, Lines, Panel as LinePanel, Point};
use deeptree_eval::report::chart::{GUIDE, LEARNER, PAPER, Panel, Series, histograms};
use deeptree_eval::report::{Cell, Chapter, Tone};

use super::{CHANCES, DEPTH, DEPTHS, Judged, LAWS, Law, Said};

/// How much of the probability of a law may be in the wrong place before its cell is red, and how
/// little makes it green.
const WRONG: f64 = 0.05;
const RIGHT: f64 = 0.02;

/// Standard errors beyond which a difference is not of chance.
const CHANCE: f64 = 3.0;

/// How many of the cells that are furthest off are listed.
const FURTHEST: usize = 12;

pub(super) fn write(chapter: &mut Chapter, all: &[Judged], total: &Judged) -> Result<()> {
    chapter.text(summary(all, total));
    chapter.text(format!(
        "{} trees of each species that no training saw are taken apart node by node. Each network \
         is told the true state of the node and all that was decided before it as it truly was, \
         and what it says is held against what the growth model did. So errors cannot add up from \
         node to node: what is wrong here is wrong in the network itself, and what is wrong only \
         in the other chapters comes of states that drift. All errors are standard errors from tree \
         to tree; red differs by more than {CHANCE:.0} of them.",
        all.first().map_or(0, |one| one.model.trees),
    ));
    chapter.heading("Reliability of the existence head");
    reliability(chapter, all)?;
    existence(chapter, all, total);
    places(chapter, all, total);
    let laws = total.model.laws.iter().map(|law| law.all.count()).sum::<f64>();
    if laws > 0.0 {
        chapter.heading("The other laws");
        uniformity(chapter, total)?;
        gaps(chapter, all, total);
        law_places(chapter, total);
        furthest(chapter, all);
        chances(chapter, all, total);
    } else {
        chapter.text(
            "The other networks of this kind regress one value and say no law that could be judged.",
        );
    }
    Ok(())
}

fn summary(all: &[Judged], total: &Judged) -> String {
    let said = &total.model;
    let mut text = format!(
        "On {:.0} nodes of fresh teacher's trees the existence head expects {:.4} children a node; \
         there are {:.4} ({:+.4} ± {:.4}). Its calibration error is {:.2} %, of which chance alone \
         makes {:.2} %",
        said.children.count(),
        said.children.mean() + said.excess.mean(),
        said.children.mean(),
        said.excess.mean(),
        said.excess.error(),
        100.0 * said.existence.calibration_error(),
        100.0 * said.existence.calibration_chance(),
    );
    let worst = all.iter().max_by(|a, b| {
        let error = |one: &Judged| one.model.existence.calibration_error();
        error(a).total_cmp(&error(b))
    });
    if let Some(Judged { species, model, .. }) = worst {
        let error = 100.0 * model.existence.calibration_error();
        let _ = write!(text, "; it is largest in {species}, {error:.2} %.");
    }
    if let Some(paper) = &total.paper {
        let _ = write!(
            text,
            " The kind paper expects {:+.4} ± {:.4} children a node too many, with a calibration \
             error of {:.2} %.",
            paper.excess.mean(),
            paper.excess.error(),
            100.0 * paper.existence.calibration_error(),
        );
    }
    let laws = all.iter().flat_map(|one| {
        LAWS.iter().zip(&one.model.laws).map(|(name, law)| (&one.species, *name, &law.all))
    });
    let mut laws: Vec<(&String, &str, &Uniformity)> =
        laws.filter(|(.., law)| law.count() > 0.0).collect();
    laws.sort_by(|a, b| b.2.gap().total_cmp(&a.2.gap()));
    if let Some((species, name, law)) = laws.first() {
        let wrong = laws.iter().filter(|(.., law)| is_wrong(law)).count();
        let _ = write!(
            text,
            " Of {} other laws (one a species), {wrong} have more than {:.0} % of their probability \
             in the wrong place; the furthest is {name} of {species}, {:.1} %.",
            laws.len(),
            100.0 * WRONG,
            100.0 * law.gap(),
        );
    }
    text
}

fn reliability(chapter: &mut Chapter, all: &[Judged]) -> Result<()> {
    let line = |name: &str, colour, found: &Reliability| {
        let point = |BinPoint { told, happened, error, .. }| Point {
            x: told,
            y: happened,
            error: 2.0 * error,
            hollow: false,
        };
        Line { name: name.to_owned(), colour, points: found.points().map(point).collect() }
    };
    let equal = || {
        let point = |x| Point { x, y: x, error: 0.0, hollow: false };
        Line { name: "right".into(), colour: GUIDE, points: vec![point(0.0), point(1.0)] }
    };
    let panel = |one: &Judged| {
        let mut lines = vec![equal()];
        if let Some(paper) = &one.paper {
            lines.push(line("kind paper", PAPER, &paper.existence));
        }
        lines.push(line("networks", LEARNER, &one.model.existence));
        LinePanel { title: one.species.clone(), lines }
    };
    let lines = Lines {
        x: "told".into(),
        y: "happened".into(),
        columns: 4,
        panels: all.iter().map(panel).collect(),
    };
    chapter.chart(
        "Reliability: the probability that there is a child in a slot, in tenths, and the share of \
         slots that have one; bars are two standard errors. A point above the line: more children \
         than told.",
        lines.svg()?,
    );
    let order = |order: usize| {
        let of = |all: &[Judged]| {
            let mut sum = Reliability::default();
            all.iter().for_each(|one| sum.merge(&one.model.by_order[order]));
            sum
        };
        LinePanel {
            title: order_name(order),
            lines: vec![equal(), line("networks", LEARNER, &of(all))],
        }
    };
    let lines = Lines {
        x: "told".into(),
        y: "happened".into(),
        columns: ORDERS,
        panels: (0..ORDERS).map(order).collect(),
    };
    chapter.chart("The same by branch order, all species together.", lines.svg()?);
    Ok(())
}

fn order_name(order: usize) -> String {
    if order + 1 == ORDERS { format!("order {order} and more") } else { format!("order {order}") }
}

fn depth_name(depth: usize) -> String {
    let low = depth as f32 * DEPTH;
    if depth + 1 == DEPTHS {
        format!("{low:.0} m …")
    } else {
        format!("{low:.0}–{:.0} m", low + DEPTH)
    }
}

/// A difference with its error; red where it is not of chance.
fn difference(mean: &TreeMean, decimals: usize) -> Cell {
    if mean.count() < 1.0 {
        return Cell::new("–", Tone::Quiet);
    }
    let text = format!("{:+.decimals$} ± {:.decimals$}", mean.mean(), mean.error());
    Cell::new(text, tone(mean.mean(), mean.error(), decimals))
}

/// Red where a difference is not of chance, and large enough to be printed.
fn tone(difference: f64, error: f64, decimals: usize) -> Tone {
    let least = 0.5 * 0.1f64.powi(decimals as i32);
    if difference.abs() > (CHANCE * error).max(least) { Tone::Bad } else { Tone::Good }
}

fn error(found: &Reliability, tone: Tone) -> Cell {
    let text = format!(
        "{:.2} ({:.2})",
        100.0 * found.calibration_error(),
        100.0 * found.calibration_chance()
    );
    Cell::new(text, tone)
}

fn existence(chapter: &mut Chapter, all: &[Judged], total: &Judged) {
    let row = |one: &Judged| {
        let said = &one.model;
        let mut cells = vec![
            Cell::from(one.species.as_str()),
            format!("{:.0}", said.children.count()).into(),
            format!("{:.4}", said.children.mean()).into(),
            difference(&said.excess, 4),
            error(&said.existence, Tone::Plain),
        ];
        cells.extend(said.by_slot.iter().map(|slot| error(slot, Tone::Plain)));
        let surprise = &said.surprise;
        cells.push(match surprise.count() {
            0.0 => Cell::new("–", Tone::Quiet),
            _ => format!("{:.4} ± {:.4}", surprise.mean(), surprise.error()).into(),
        });
        cells.extend(match &one.paper {
            None => [Cell::new("–", Tone::Quiet), Cell::new("–", Tone::Quiet)],
            Some(paper) => {
                let excess = format!("{:+.4} ± {:.4}", paper.excess.mean(), paper.excess.error());
                [Cell::new(excess, Tone::Quiet), error(&paper.existence, Tone::Quiet)]
            }
        });
        cells
    };
    chapter.table(
        "Children of a node: the teacher's mean, and how many more are expected; calibration error \
         in percent, and what chance makes of it, over all slots and slot by slot; cross-entropy of \
         the whole branching in nats; the kind paper, which says nothing of the latter",
        &[
            "species",
            "nodes",
            "children",
            "expected more",
            "error, %",
            "slot 1",
            "slot 2",
            "slot 3",
            "cross-entropy",
            "paper: expected more",
            "error, %",
        ],
        all.iter().chain([total]).map(row).collect(),
    );
}

/// The expected excess of children by order and by depth.
fn places(chapter: &mut Chapter, all: &[Judged], total: &Judged) {
    fn row<const N: usize>(one: &Judged, of: fn(&Said) -> &[Reliability; N]) -> Vec<Cell> {
        // Reliability tells what came less what was told.
        let cell = |found: &Reliability| {
            let share =
                -100.0 * found.excess.mean() / (found.told() + found.excess.mean()).max(1e-12);
            let error =
                100.0 * found.excess.error() / (found.told() + found.excess.mean()).max(1e-12);
            if found.count() < 1.0 || !share.is_finite() || share.abs() > 1e4 {
                return Cell::new("–", Tone::Quiet);
            }
            Cell::new(format!("{share:+.2} ± {error:.2}"), tone(share, error, 2))
        };
        std::iter::once(Cell::from(one.species.as_str()))
            .chain(of(&one.model).iter().map(cell))
            .collect()
    }
    let rows = || all.iter().chain([total]);
    let header = |names: Vec<String>| -> Vec<String> {
        std::iter::once("species".to_owned()).chain(names).collect()
    };
    let orders = header((0..ORDERS).map(order_name).collect());
    let depths = header((0..DEPTHS).map(depth_name).collect());
    let names = |header: &[String]| -> Vec<String> { header.to_vec() };
    for (what, header, rows) in [
        (
            "branch order of the node",
            names(&orders),
            rows().map(|one| row(one, |said| &said.by_order)).collect::<Vec<_>>(),
        ),
        (
            "way from the foot to the node",
            names(&depths),
            rows().map(|one| row(one, |said| &said.by_depth)).collect(),
        ),
    ] {
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        chapter.table(
            format!("Children expected too many, in percent of those there are, by {what}"),
            &header,
            rows,
        );
    }
}

fn uniformity(chapter: &mut Chapter, total: &Judged) -> Result<()> {
    chapter.text(
        "Where the true value stands in the law that was told, from 0 (least) to 1 (most), is \
         uniform if the law is right (probability integral transform). Low at both ends: the law \
         is too wide; high at both ends: too narrow; higher on the right: true values are larger \
         than told. split is the share of tips of a child, reach the longest path below one that is \
         not the heir, size all nodes below it, roll and swing the two parts of a child's rotation, x and y the axes of a \
         swing, the numbers the slots. Near the ground growth draws a swing anew that leads into \
         it; here it is not.",
    );
    let panel = |(name, law): (&&str, &Law)| {
        let shares = law.all.shares().to_vec();
        let even = vec![1.0 / shares.len() as f64; shares.len()];
        Panel {
            title: (*name).to_owned(),
            low: 0.0,
            high: 1.0,
            series: vec![
                Series { colour: GUIDE, shares: even },
                Series { colour: LEARNER, shares },
            ],
        }
    };
    let laws = LAWS.iter().zip(&total.model.laws).filter(|(_, law)| law.all.count() > 0.0);
    chapter.chart(
        "Ranks of the true values in the laws told, all species together. Filled: uniform, as it is \
         where the law is right; orange: the networks",
        histograms(&laws.map(panel).collect::<Vec<_>>(), 5)?,
    );
    Ok(())
}

/// Is more of the probability in the wrong place than may be, and than chance puts there?
fn is_wrong(law: &Uniformity) -> bool {
    law.gap() > WRONG + by_chance(law)
}

/// What the gap of a right law exceeds in 5 % of all cases, for independent values (Kolmogorov).
fn by_chance(law: &Uniformity) -> f64 {
    1.36 / law.count().sqrt()
}

fn gap(law: &Uniformity) -> Cell {
    if law.count() < 1.0 {
        return Cell::new("–", Tone::Quiet);
    }
    let tone = match law.gap() {
        gap if gap <= RIGHT => Tone::Good,
        _ if is_wrong(law) => Tone::Bad,
        _ if by_chance(law) > WRONG => Tone::Quiet,
        _ => Tone::Plain,
    };
    let text = format!(
        "{:.1} ({:+.1}, {:+.0})",
        100.0 * law.gap(),
        100.0 * law.bias.mean(),
        100.0 * law.spread.mean()
    );
    Cell::new(text, tone)
}

const GAP: &str = "percent of the probability in the wrong place; in brackets the mean rank less a \
                   half (above 0: true values are larger than told) and the variance of the ranks \
                   over that of uniform ones less one (above 0: they scatter more than told), in \
                   percent";

fn gaps(chapter: &mut Chapter, all: &[Judged], total: &Judged) {
    let header: Vec<&str> = std::iter::once("species").chain(LAWS).collect();
    let row = |one: &Judged| {
        std::iter::once(Cell::from(one.species.as_str()))
            .chain(one.model.laws.iter().map(|law| gap(&law.all)))
            .collect()
    };
    chapter.table(
        format!(
            "By species: {GAP}. Green up to {:.0} %, red above {:.0} % and what chance makes of so \
             many independent values, grey where that alone is more",
            100.0 * RIGHT,
            100.0 * WRONG
        ),
        &header,
        all.iter().chain([total]).map(row).collect(),
    );
}

/// The laws by order and by depth of the node.
fn law_places(chapter: &mut Chapter, total: &Judged) {
    let header: Vec<&str> = std::iter::once("").chain(LAWS).collect();
    let row = |name: String, of: &dyn Fn(&Law) -> Cell| {
        let laws = total.model.laws.iter().map(of);
        std::iter::once(Cell::from(name)).chain(laws).collect::<Vec<Cell>>()
    };
    let mut rows: Vec<Vec<Cell>> =
        (0..ORDERS).map(|order| row(order_name(order), &|law| gap(&law.by_order[order]))).collect();
    rows.extend((0..DEPTHS).map(|depth| row(depth_name(depth), &|law| gap(&law.by_depth[depth]))));
    chapter.table(
        format!("By order of the parent, and by its way from the foot, all species: {GAP}"),
        &header,
        rows,
    );
}

/// The laws of single species and orders that are furthest off.
fn furthest(chapter: &mut Chapter, all: &[Judged]) {
    let mut cells = Vec::new();
    for one in all {
        for (name, law) in LAWS.iter().zip(&one.model.laws) {
            let orders = law.by_order.iter().enumerate();
            cells.extend(orders.map(|(order, of)| (one.species.as_str(), *name, order, of)));
        }
    }
    // Of few values chance alone may move more than would be wrong.
    cells.retain(|(.., law)| law.count() > 0.0 && by_chance(law) <= WRONG);
    cells.sort_by(|a, b| {
        let beyond = |law: &Uniformity| law.gap() - by_chance(law);
        beyond(b.3).total_cmp(&beyond(a.3))
    });
    let row = |(species, name, order, law): &(&str, &str, usize, &Uniformity)| {
        vec![
            Cell::from(format!("{name} of {species}, {}", order_name(*order))),
            format!("{:.0}", law.count()).into(),
            gap(law),
        ]
    };
    chapter.table(
        format!("The laws of single species and orders that are furthest beyond chance: {GAP}"),
        &["", "values", "wrong"],
        cells.iter().take(FURTHEST).map(row).collect(),
    );
}

fn chances(chapter: &mut Chapter, all: &[Judged], total: &Judged) {
    let row = |one: &Judged| {
        let mut cells = vec![Cell::from(one.species.as_str())];
        for found in &one.model.chances {
            if found.count() < 1.0 {
                cells.extend(["–", "–", "–"].map(|text| Cell::new(text, Tone::Quiet)));
                continue;
            }
            cells.push(format!("{:.4}", found.told() + found.excess.mean()).into());
            cells.push(difference(&found.excess, 4));
            cells.push(error(found, Tone::Plain));
        }
        cells
    };
    let names: Vec<String> = CHANCES
        .iter()
        .flat_map(|name| [(*name).to_owned(), "more than told".to_owned(), "error, %".to_owned()])
        .collect();
    let header: Vec<&str> =
        std::iter::once("species").chain(names.iter().map(String::as_str)).collect();
    chapter.table(
        "Whether a child has the longest path below (heir), and whether it goes exactly straight on, \
         is bent exactly about the level axis or lies exactly in the plane of its bud (aligned, by \
         slot): share that does, how much more than told, and calibration error (of chance)",
        &header,
        all.iter().chain([total]).map(row).collect(),
    );
}

/// The chapter as CSV: every bin of the diagrams, and every law.
pub(super) fn csv(all: &[Judged]) -> String {
    let mut out = "species,set,what,place,count,told,happened,error,gap,bias,spread\n".to_owned();
    let mut reliability = |species: &str, set, what: &str, found: &Reliability| {
        for BinPoint { told, happened, error, count } in found.points() {
            let _ =
                writeln!(out, "{species},{set},{what},bin,{count},{told},{happened},{error},,,");
        }
    };
    for one in all {
        let sets = [("DT", Some(&one.model)), ("paper", one.paper.as_ref())];
        for (set, said) in sets.into_iter().filter_map(|(set, said)| Some((set, said?))) {
            reliability(&one.species, set, "children", &said.existence);
            for (slot, found) in said.by_slot.iter().enumerate() {
                reliability(&one.species, set, &format!("child {}", slot + 1), found);
            }
            for (order, found) in said.by_order.iter().enumerate() {
                reliability(
                    &one.species,
                    set,
                    &format!("children of {}", order_name(order)),
                    found,
                );
            }
            for (name, found) in CHANCES.iter().zip(&said.chances) {
                reliability(&one.species, set, name, found);
            }
        }
    }
    for one in all {
        let mut law = |name: &str, place: &str, law: &Uniformity| {
            if law.count() > 0.0 {
                let (gap, bias, spread) = (law.gap(), law.bias.mean(), law.spread.mean());
                let (species, count) = (&one.species, law.count());
                let _ =
                    writeln!(out, "{species},DT,{name},{place},{count},,,,{gap},{bias},{spread}");
            }
        };
        for (name, found) in LAWS.iter().zip(&one.model.laws) {
            law(name, "all", &found.all);
            for (order, of) in found.by_order.iter().enumerate() {
                law(name, &order_name(order), of);
            }
            for (depth, of) in found.by_depth.iter().enumerate() {
                law(name, &depth_name(depth), of);
            }
        }
    }
    out
}
