//! Plans of stands: which tree stands where.

use std::path::Path;

use anyhow::{Context, Result, anyhow, ensure};
use deeptree_graph::Vec3;

/// A row of a plan.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Row {
    pub(crate) at: Vec3,
    pub(crate) species: String,
    pub(crate) seed: u64,
}

/// The farthest that a tree may stand from the origin, in metres.
const FARTHEST: f32 = 10_000.0;

/// The nearest that two trees may stand to each other, in metres.
const NEAREST: f32 = 0.1;

/// Reads a plan: rows of x, z, species and seed, with or without a row of names above.
pub(crate) fn read(path: &Path) -> Result<Vec<Row>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    rows(&text).with_context(|| format!("{} is no plan of a stand", path.display()))
}

fn rows(text: &str) -> Result<Vec<Row>> {
    let mut rows: Vec<Row> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let fields: Vec<&str> = line.split(',').map(str::trim).collect();
        let is_heading = i == 0 && fields.first() == Some(&"x");
        if line.trim().is_empty() || is_heading {
            continue;
        }
        let row = row(&fields).with_context(|| format!("line {}", i + 1))?;
        let close = rows.iter().any(|other| other.at.distance(row.at) < NEAREST);
        ensure!(!close, "line {}: another tree stands there; move one", i + 1);
        rows.push(row);
    }
    ensure!(!rows.is_empty(), "it has no rows; write x,z,species,seed of each tree");
    Ok(rows)
}

fn row(fields: &[&str]) -> Result<Row> {
    let &[x, z, species, seed] = fields else {
        return Err(anyhow!("it has {} fields; a row is x,z,species,seed", fields.len()));
    };
    let metres = |text: &str| match text.parse::<f32>() {
        Ok(value) if value.abs() <= FARTHEST => Ok(value),
        _ => Err(anyhow!("`{text}` is no distance in metres, or above {FARTHEST}")),
    };
    Ok(Row {
        at: Vec3::new(metres(x)?, 0.0, metres(z)?),
        species: species.to_owned(),
        seed: seed.parse().map_err(|_| anyhow!("`{seed}` is no seed: a whole number from 0 on"))?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_reads_with_and_without_names_above() {
        let expected = [
            Row { at: Vec3::new(1.5, 0.0, -2.0), species: "oak".to_owned(), seed: 7 },
            Row { at: Vec3::new(0.0, 0.0, 4.0), species: "pine".to_owned(), seed: 8 },
        ];
        let text = "1.5,-2,oak,7\n\n 0, 4 , pine,8\r\n";
        assert_eq!(rows(text).unwrap(), expected);
        assert_eq!(rows(&format!("x,z,species,seed\n{text}")).unwrap(), expected);
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
            ("1,2,oak,3\n1,2.05,oak,4", "line 2: another tree stands there"),
        ] {
            let error = format!("{:#}", rows(text).unwrap_err());
            assert!(error.contains(part), "{error}");
        }
    }
}
