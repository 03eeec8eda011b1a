//! Writing PLY.

use std::io::{self, BufWriter, Write};

use crate::cloud::{Cloud, Up};
use crate::columns::Columns;

/// The types of [`Columns::NAMES`].
const TYPES: [&str; 6] = ["float", "uchar", "uint", "ushort", "uint", "ushort"];

/// Writes little-endian binary PLY: coordinates as `float`, or as `double` where the cloud has an
/// origin, and the columns that there are.
///
/// # Errors
///
/// When the output fails.
pub fn write(cloud: &Cloud, out: &mut impl Write) -> io::Result<()> {
    let mut out = BufWriter::with_capacity(1 << 16, out);
    let is_far = cloud.origin != [0.0; 3];
    writeln!(out, "ply\nformat binary_little_endian 1.0")?;
    writeln!(out, "comment DeepTree {}", env!("CARGO_PKG_VERSION"))?;
    writeln!(out, "comment metres, {} up", if cloud.up == Up::Y { "y" } else { "z" })?;
    writeln!(out, "element vertex {}", cloud.len())?;
    for axis in ["x", "y", "z"] {
        writeln!(out, "property {} {axis}", if is_far { "double" } else { "float" })?;
    }
    let present = cloud.columns.present();
    for ((name, scalar), present) in Columns::NAMES.iter().zip(TYPES).zip(present) {
        if present {
            writeln!(out, "property {scalar} {name}")?;
        }
    }
    writeln!(out, "end_header")?;
    for i in 0..cloud.len() {
        if is_far {
            out.write_all(cloud.position(i).map(f64::to_le_bytes).as_flattened())?;
        } else {
            out.write_all(cloud.points[i].to_array().map(f32::to_le_bytes).as_flattened())?;
        }
        write_attributes(&cloud.columns, i, &mut out)?;
    }
    out.flush()
}

fn write_attributes(columns: &Columns, i: usize, out: &mut impl Write) -> io::Result<()> {
    if let Some(column) = &columns.intensity {
        out.write_all(&column[i].to_le_bytes())?;
    }
    if let Some(column) = &columns.class {
        out.write_all(&[column[i].code()])?;
    }
    if let Some(column) = &columns.branch {
        out.write_all(&column[i].to_le_bytes())?;
    }
    if let Some(column) = &columns.order {
        out.write_all(&column[i].to_le_bytes())?;
    }
    if let Some(column) = &columns.node {
        out.write_all(&column[i].to_le_bytes())?;
    }
    if let Some(column) = &columns.station {
        out.write_all(&column[i].to_le_bytes())?;
    }
    Ok(())
}
