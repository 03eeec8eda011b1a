//! Writing text.

use std::io::{self, BufWriter, Write};

use crate::cloud::Cloud;
use crate::columns::{Class, Columns};

/// Writes one point a line, separated by blanks, after a comment that names the columns.
///
/// Where the origin is zero, each number has the digits that give its bits again; elsewhere
/// coordinates are written to a micrometre.
///
/// # Errors
///
/// When the output fails.
pub fn write(cloud: &Cloud, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    write!(out, "# x y z")?;
    let names = Columns::NAMES.iter().zip(cloud.columns.present());
    for (name, _) in names.filter(|(_, present)| *present) {
        write!(out, " {name}")?;
    }
    writeln!(out)?;
    for i in 0..cloud.len() {
        write_place(cloud, i, &mut out)?;
        write_attributes(&cloud.columns, i, &mut out)?;
        writeln!(out)?;
    }
    out.flush()
}

fn write_place(cloud: &Cloud, i: usize, out: &mut impl Write) -> io::Result<()> {
    let offset = cloud.points[i].to_array();
    for (axis, offset) in offset.into_iter().enumerate() {
        let before = if axis == 0 { "" } else { " " };
        match cloud.origin[axis] {
            0.0 => write!(out, "{before}{offset}")?,
            origin => write!(out, "{before}{:.6}", origin + f64::from(offset))?,
        }
    }
    Ok(())
}

fn write_attributes(columns: &Columns, i: usize, out: &mut impl Write) -> io::Result<()> {
    fn put<T: std::fmt::Display>(out: &mut impl Write, value: Option<T>) -> io::Result<()> {
        value.map_or(Ok(()), |value| write!(out, " {value}"))
    }
    put(out, columns.intensity.as_ref().map(|c| c[i]))?;
    put(out, columns.class.as_ref().map(|c: &Vec<Class>| c[i].code()))?;
    put(out, columns.branch.as_ref().map(|c| c[i]))?;
    put(out, columns.order.as_ref().map(|c| c[i]))?;
    put(out, columns.node.as_ref().map(|c| c[i]))?;
    put(out, columns.station.as_ref().map(|c| c[i]))
}
