//! Plans of stands: which tree stands where.

use std::path::Path;

use anyhow::{Context, Result, anyhow, bail, ensure};
use deeptree_graph::Vec3;
use deeptree_scene::{Environment, Scene};

use crate::args::UsageError;

/// A row of a plan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) at: Vec3,
    pub(crate) species: String,
    pub(crate) seed: u64,
    /// In growth cycles, where the row says it.
    pub(crate) age: Option<f32>,
}

/// The farthest that a tree may stand from the origin, in metres.
const FARTHEST: f32 = 10_000.0;

/// The nearest that two trees may stand to each other, in metres.
pub(crate) const NEAREST: f32 = 0.1;

/// The most trees of a stand: they are all in memory at once, a megabyte or two each.
pub(crate) const MOST: usize = 2_000;

/// Reads a plan: rows of x, z, species, seed and perhaps an age, with or without a row of names
/// above. A row without a species is of the species `others`.
pub(crate) fn read(path: &Path, others: Option<&str>) -> Result<Vec<Row>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    rows(&text, others).with_context(|| format!("{} is no plan of a stand", path.display()))
}

fn rows(text: &str, others: Option<&str>) -> Result<Vec<Row>> {
    let mut rows: Vec<Row> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let is_heading = i == 0 && fields.first() == Some(&"x");
        if line.trim().is_empty() || is_heading {
            continue;
        }
        ensure!(rows.len() < MOST, "it has more than {MOST} rows; grow it in parts");
        let row = row(&fields, others).with_context(|| format!("line {}", i + 1))?;
        let close = rows.iter().any(|other| other.at.distance(row.at) < NEAREST);
        ensure!(!close, "line {}: another tree stands there; move one", i + 1);
        rows.push(row);
    }
    ensure!(!rows.is_empty(), "it has no rows; write x,z,species,seed of each tree");
    Ok(rows)
}

fn row(fields: &[&str], others: Option<&str>) -> Result<Row> {
    let (x, z, species, seed, age) = match *fields {
        [x, z, species, seed] => (x, z, species, seed, ""),
        [x, z, species, seed, age] => (x, z, species, seed, age),
        _ => bail!(
            "it has {} fields; a row is x,z,species,seed or x,z,species,seed,age",
            fields.len()
        ),
    };
    let metres = |text: &str| match text.parse::<f32>() {
        Ok(value) if value.abs() <= FARTHEST => Ok(value),
        _ => Err(anyhow!("`{text}` is no distance in metres, or above {FARTHEST}")),
    };
    let cycles = |text: &str| match text.parse::<f32>() {
        Ok(age) if age.is_finite() => Ok(age),
        _ => Err(anyhow!("`{text}` is no age: a whole number of growth cycles")),
    };
    let species = if species.is_empty() { others } else { Some(species) };
    let species =
        species.context("it names no species; name one there, or one for all such rows")?;
    Ok(Row {
        at: Vec3::new(metres(x)?, 0.0, metres(z)?),
        species: species.to_owned(),
        seed: seed.parse().map_err(|_| anyhow!("`{seed}` is no seed: a whole number from 0 on"))?,
        age: if age.is_empty() { None } else { Some(cycles(age)?) },
    })
}

/// Refuses trees that would have the same file in a folder, which is named after species and seed.
pub(crate) fn check_names(rows: &[Row]) -> Result<(), UsageError> {
    let twice = rows.iter().enumerate().find(|(i, row)| {
        rows[..*i].iter().any(|r| (&r.species, r.seed) == (&row.species, row.seed))
    });
    twice.map_or(Ok(()), |(_, row)| {
        Err(UsageError(format!(
            "two trees of {} have the seed {}; write a .csv or .parquet table, or change one",
            row.species, row.seed
        )))
    })
}

/// What stands around each tree besides trees, in its own frame.
pub(crate) fn environments(rows: &[Row], scene: &Scene) -> Result<Vec<Environment>> {
    let one = |row: &Row| {
        let scene = scene.seen_from(row.at);
        let scene = scene.with_context(|| format!("the tree at {}, {}", row.at.x, row.at.z))?;
        Ok(Environment { scene, volume: None })
    };
    rows.iter().map(one).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_reads_with_and_without_names_above() {
        let row = |x, z, species: &str, seed, age| Row {
            at: Vec3::new(x, 0.0, z),
            species: species.to_owned(),
            seed,
            age,
        };
        let expected = [
            row(1.5, -2.0, "oak", 7, None),
            row(0.0, 4.0, "pine", 8, Some(21.0)),
            row(9.0, 4.0, "elm", 9, None),
        ];
        let text = "1.5,-2,oak,7\n\n 0, 4 , pine,8,21\r\n9,4,,9,\n";
        assert_eq!(rows(text, Some("elm")).unwrap(), expected);
        assert_eq!(rows(&format!("x,z,species,seed\n{text}"), Some("elm")).unwrap(), expected);
    }

    #[test]
    fn what_is_no_plan_names_its_line() {
        for (text, part) in [
            ("", "no rows"),
            ("1,2,oak", "line 1: it has 3 fields"),
            ("x,z,species,seed\n1,two,oak,3", "line 2: `two` is no distance"),
            ("1,nan,oak,3", "is no distance"),
            ("1,1e9,oak,3", "is no distance"),
            ("1,2,oak,-3", "`-3` is no seed"),
            ("1,2,oak,3,old", "`old` is no age"),
            ("1,2,oak,3,nan", "`nan` is no age"),
            ("1,2,,3", "line 1: it names no species"),
            ("1,2,oak,3\n1,2.05,oak,4", "line 2: another tree stands there"),
        ] {
            let error = format!("{:#}", rows(text, None).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
        let many: String = (0..10_000).map(|i| format!("{i},0,oak,{i}\n")).collect();
        let error = format!("{:#}", rows(&many, None).unwrap_err());
        assert!(error.contains("more than 2000 rows"), "{error}");
    }
}
