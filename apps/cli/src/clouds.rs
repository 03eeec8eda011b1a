//! Point clouds in files.

use std::io::{BufRead, BufReader, Cursor, Seek, Write};
use std::path::Path;
use std::str::FromStr;

use anyhow::{Context, Result, bail};
use deeptree_cloud::{Class, Cloud, Columns, ReadOptions, Reading, Up, las, ply, table, xyz};
use deeptree_export::write_atomically;
use serde_json::{Value, json};

use crate::args::{Args, UsageError};
use crate::output::is_stdout;

/// A file format of point clouds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum CloudFormat {
    Xyz,
    Ply,
    Las,
    Laz,
    Parquet,
}

impl CloudFormat {
    /// The extensions of each.
    const NAMES: [(&'static str, Self); 9] = [
        ("xyz", Self::Xyz),
        ("txt", Self::Xyz),
        ("asc", Self::Xyz),
        ("pts", Self::Xyz),
        ("csv", Self::Xyz),
        ("ply", Self::Ply),
        ("las", Self::Las),
        ("laz", Self::Laz),
        ("parquet", Self::Parquet),
    ];

    /// The format that a path or else `asked` names.
    pub(crate) fn of(path: &Path, asked: Option<Self>) -> Result<Self, UsageError> {
        let named = path.extension().map(|extension| extension.to_string_lossy().to_lowercase());
        if is_stdout(path) {
            return asked.ok_or_else(|| UsageError("name the format of - with --format".into()));
        }
        let named: Self = named
            .ok_or_else(|| UsageError("name the file to write, with its extension".into()))?
            .parse()
            .map_err(|problem| UsageError(format!("{}: {problem}", path.display())))?;
        if asked.is_some_and(|asked| asked != named) {
            let path = path.display();
            return Err(UsageError(format!("{path} is of another format than --format says")));
        }
        Ok(named)
    }
}

impl FromStr for CloudFormat {
    type Err = String;

    fn from_str(name: &str) -> Result<Self, String> {
        let name = name.trim_start_matches('.');
        let found = Self::NAMES.into_iter().find(|(known, _)| *known == name);
        found.map(|(_, format)| format).ok_or_else(|| {
            let known = Self::NAMES.map(|(name, _)| format!(".{name}")).join(" ");
            format!("there is no format '.{name}' of point clouds; the formats are {known}")
        })
    }
}

/// Does a file hold points rather than trees? By its extension, and what it says where that can
/// be either.
pub(crate) fn holds_points(path: &Path) -> bool {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "csv" => !has_parents(path),
        "parquet" => std::fs::File::open(path).is_ok_and(table::holds_points),
        other => other.parse::<CloudFormat>().is_ok(),
    }
}

/// Does the first line name the column of a skeleton that no cloud has?
fn has_parents(path: &Path) -> bool {
    let Ok(file) = std::fs::File::open(path) else { return true };
    let mut line = Vec::new();
    let read = BufReader::new(std::io::Read::take(file, 1 << 12)).read_until(b'\n', &mut line);
    let line = String::from_utf8_lossy(&line).to_lowercase();
    read.is_err() || line.split(',').any(|name| name.trim().trim_matches('"') == "parent")
}

/// Reads a cloud, and says on standard error what of the file is not in it.
pub(crate) fn read(args: &Args, path: &Path, options: &ReadOptions) -> Result<Cloud> {
    let Reading { cloud, dropped } = deeptree_cloud::read_file(path, options)
        .with_context(|| format!("{} is not usable", path.display()))?;
    if !dropped.is_empty() && !args.quiet {
        eprintln!("deeptree: {}: {dropped}", path.display());
    }
    Ok(cloud)
}

/// Writes a cloud.
pub(crate) fn write(path: &Path, format: CloudFormat, cloud: &Cloud) -> Result<()> {
    if is_stdout(path) {
        // Formats that are written forth and back need a place for it.
        let mut bytes = Cursor::new(Vec::new());
        encode(cloud, format, &mut bytes)?;
        let mut out = std::io::stdout();
        return Ok(out.write_all(bytes.get_ref()).and_then(|()| out.flush())?);
    }
    Ok(write_atomically(path, |out| encode(cloud, format, out))?)
}

fn encode(
    cloud: &Cloud,
    format: CloudFormat,
    out: &mut (impl Write + Seek + Send + Sync),
) -> Result<()> {
    match format {
        CloudFormat::Xyz => xyz::write(cloud, out)?,
        CloudFormat::Ply => ply::write(cloud, out)?,
        // LAS is z up.
        CloudFormat::Las => las::write(&cloud.clone().with_up(Up::Z), false, out)?,
        CloudFormat::Laz => las::write(&cloud.clone().with_up(Up::Z), true, out)?,
        CloudFormat::Parquet => table::write(cloud, out)?,
    }
    Ok(())
}

/// What there is to say of a cloud.
pub(crate) fn figures(cloud: &Cloud) -> Value {
    let (low, high) = cloud.bounds().unwrap_or_default();
    let place = |v: deeptree_graph::Vec3| -> [f64; 3] {
        let v = v.to_array();
        std::array::from_fn(|k| cloud.origin[k] + f64::from(v[k]))
    };
    let names: Vec<&str> = Columns::NAMES
        .iter()
        .zip(cloud.columns.present())
        .filter_map(|(name, present)| present.then_some(*name))
        .collect();
    let classes = cloud.columns.class.as_ref().map(|classes| {
        let count = |class| classes.iter().filter(|c| **c == class).count();
        json!({
            "wood": count(Class::Wood),
            "leaf": count(Class::Leaf),
            "ground": count(Class::Ground),
            "other": classes.iter().filter(|c| matches!(c, Class::Other(_))).count(),
        })
    });
    let stations = cloud.columns.station.as_ref().map(|stations| {
        let mut stations = stations.clone();
        stations.sort_unstable();
        stations.dedup();
        stations.len()
    });
    json!({
        "points": cloud.len(),
        "low_m": place(low),
        "high_m": place(high),
        "size_m": (high - low).to_array(),
        "columns": names,
        "classes": classes,
        "stations": stations,
    })
}

/// The same in words.
pub(crate) fn text(figures: &Value) -> String {
    let size = |k: usize| figures["size_m"][k].as_f64().unwrap_or_default();
    let low = |k: usize| figures["low_m"][k].as_f64().unwrap_or_default();
    let mut text = format!(
        "{} points in {:.2} m × {:.2} m × {:.2} m from ({:.2}, {:.2}, {:.2})",
        figures["points"],
        size(0),
        size(1),
        size(2),
        low(0),
        low(1),
        low(2)
    );
    if let Some(classes) = figures["classes"].as_object() {
        let counts = classes.iter().filter(|(_, count)| **count != 0);
        let counts: Vec<String> = counts.map(|(name, count)| format!("{count} {name}")).collect();
        text.push_str(&format!("; {}", counts.join(", ")));
    }
    if let Some(stations) = figures["stations"].as_u64().filter(|stations| *stations > 1) {
        text.push_str(&format!("; from {stations} stations"));
    }
    text
}

/// Writes a cloud that was read into another format.
pub(crate) fn convert(args: &Args, from: &Path, to: &Path, format: Option<&str>) -> Result<()> {
    let asked = format.map(CloudFormat::from_str).transpose().map_err(UsageError)?;
    let format = CloudFormat::of(to, asked)?;
    let cloud = read(args, from, &ReadOptions::default())?;
    write(to, format, &cloud)?;
    let figures = figures(&cloud);
    let said = format!("{} → {}", text(&figures), to.display());
    crate::report::say(args, &figures, &said, is_stdout(to));
    Ok(())
}

/// Refuses a cloud without points before it is written.
pub(crate) fn not_empty(cloud: &Cloud) -> Result<()> {
    if cloud.is_empty() {
        bail!("the scanner sees nothing of the tree; take a finer --step or more --stations");
    }
    Ok(())
}
