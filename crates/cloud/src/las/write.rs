//! Writing LAS.

use std::io::{BufWriter, Seek, Write};

use crate::cloud::Cloud;

use super::header::{LENGTH, SIZES};
use super::{EXTRA_RECORD, LAZ_RECORD, WriteLasError, extra};

/// Point format: with 8 bits for the class, and without colours.
const FORMAT: u8 = 6;
/// The finest step of coordinates in metres; larger where a cloud is too wide for it.
const STEP: f64 = 1e-4;

/// Writes LAS 1.4, or LAZ when `packed`. Coordinates are rounded to 0.1 mm, intensities to whole
/// numbers from 0 to 65535; branch, order and node go into extra bytes.
///
/// LAS is z up; a cloud that is not should be [turned](Cloud::with_up) before.
///
/// # Errors
///
/// When the output fails, or `packed` is asked of a build without the feature `laz`.
pub fn write(
    cloud: &Cloud,
    packed: bool,
    out: &mut (impl Write + Seek + Send + Sync),
) -> Result<(), WriteLasError> {
    let grid = Grid::of(cloud);
    let fields = fields(cloud);
    let size = SIZES[usize::from(FORMAT)] + fields.iter().map(|field| field.size).sum::<usize>();
    let mut records = Vec::new();
    if !fields.is_empty() {
        let named: Vec<(u8, &str)> = fields.iter().map(|field| (field.kind, field.name)).collect();
        records.push((EXTRA_RECORD, extra::record(&named)));
    }
    let packing = if packed { Some(packing(size)?) } else { None };
    if let Some(packing) = &packing {
        records.push((LAZ_RECORD, packing.clone()));
    }
    let mut header = header(cloud, &grid, size, packed);
    let points_at = LENGTH + records.iter().map(|(_, data)| 54 + data.len()).sum::<usize>();
    put(&mut header, 96, &(points_at as u32).to_le_bytes());
    put(&mut header, 100, &(records.len() as u32).to_le_bytes());
    out.write_all(&header)?;
    for ((user, number), data) in &records {
        let mut head = [0; 54];
        put(&mut head, 2, user);
        put(&mut head, 18, &number.to_le_bytes());
        put(&mut head, 20, &(data.len() as u16).to_le_bytes());
        out.write_all(&head)?;
        out.write_all(data)?;
    }
    let points = (0..cloud.len()).map(|i| point(cloud, &grid, &fields, i));
    match packing {
        Some(packing) => pack(points, &packing, out),
        None => {
            let mut out = BufWriter::with_capacity(1 << 16, out);
            for point in points {
                out.write_all(&point)?;
            }
            Ok(out.flush()?)
        }
    }
}

/// The whole numbers that coordinates are written as.
struct Grid {
    step: [f64; 3],
    low: [i32; 3],
    high: [i32; 3],
}

impl Grid {
    fn of(cloud: &Cloud) -> Self {
        let (low, high) = cloud.bounds().unwrap_or_default();
        let (low, high) = (low.to_array().map(f64::from), high.to_array().map(f64::from));
        let step = std::array::from_fn(|k| {
            let mut step = STEP;
            while low[k].abs().max(high[k].abs()) / step > 2e9 {
                step *= 10.0;
            }
            step
        });
        let number = |v: [f64; 3]| std::array::from_fn(|k| (v[k] / step[k]).round() as i32);
        Self { step, low: number(low), high: number(high) }
    }
}

/// An attribute in extra bytes.
struct Field {
    /// Its type: 3 has 2 bytes, 5 has 4.
    kind: u8,
    size: usize,
    name: &'static str,
}

fn fields(cloud: &Cloud) -> Vec<Field> {
    let columns = &cloud.columns;
    let all = [
        (columns.branch.is_some(), 5, 4, "branch"),
        (columns.order.is_some(), 3, 2, "order"),
        (columns.node.is_some(), 5, 4, "node"),
    ];
    let there = all.into_iter().filter(|(there, ..)| *there);
    there.map(|(_, kind, size, name)| Field { kind, size, name }).collect()
}

fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

fn header(cloud: &Cloud, grid: &Grid, size: usize, packed: bool) -> [u8; LENGTH] {
    let mut header = [0; LENGTH];
    put(&mut header, 0, b"LASF");
    // Formats from 6 on name their reference system as text, if at all.
    put(&mut header, 6, &16u16.to_le_bytes());
    put(&mut header, 24, &[1, 4]);
    put(&mut header, 26, b"OTHER");
    put(&mut header, 58, concat!("DeepTree ", env!("CARGO_PKG_VERSION")).as_bytes());
    put(&mut header, 94, &(LENGTH as u16).to_le_bytes());
    header[104] = if packed { FORMAT | 0x80 } else { FORMAT };
    put(&mut header, 105, &(size as u16).to_le_bytes());
    for k in 0..3 {
        let place = |number: i32| f64::from(number) * grid.step[k] + cloud.origin[k];
        put(&mut header, 131 + 8 * k, &grid.step[k].to_le_bytes());
        put(&mut header, 155 + 8 * k, &cloud.origin[k].to_le_bytes());
        put(&mut header, 179 + 16 * k, &place(grid.high[k]).to_le_bytes());
        put(&mut header, 187 + 16 * k, &place(grid.low[k]).to_le_bytes());
    }
    put(&mut header, 247, &(cloud.len() as u64).to_le_bytes());
    // All are first returns.
    put(&mut header, 255, &(cloud.len() as u64).to_le_bytes());
    header
}

fn point(cloud: &Cloud, grid: &Grid, fields: &[Field], i: usize) -> Vec<u8> {
    let attributes = cloud.columns.get(i);
    let mut bytes = Vec::with_capacity(64);
    for (offset, step) in cloud.points[i].to_array().into_iter().zip(grid.step) {
        let number = (f64::from(offset) / step).round() as i32;
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend((attributes.intensity.round() as u16).to_le_bytes());
    // The first return of one; no flags; class; user data; angle.
    bytes.extend([0x11, 0, attributes.class.code(), 0, 0, 0]);
    bytes.extend(attributes.station.to_le_bytes());
    bytes.extend(0f64.to_le_bytes());
    for field in fields {
        match field.name {
            "branch" => bytes.extend(attributes.branch.to_le_bytes()),
            "order" => bytes.extend(attributes.order.to_le_bytes()),
            _ => bytes.extend(attributes.node.to_le_bytes()),
        }
    }
    bytes
}

/// The record that says how points of this size are packed.
#[cfg(feature = "laz")]
fn packing(size: usize) -> Result<Vec<u8>, WriteLasError> {
    let extra = size - SIZES[usize::from(FORMAT)];
    let items = laz::LazItemRecordBuilder::default_for_point_format_id(FORMAT, extra as u16);
    let items = items.map_err(|_| WriteLasError::Packing)?;
    let mut record = Vec::new();
    laz::LazVlr::from_laz_items(items).write_to(&mut record)?;
    Ok(record)
}

#[cfg(not(feature = "laz"))]
fn packing(_: usize) -> Result<Vec<u8>, WriteLasError> {
    Err(WriteLasError::NoLaz)
}

#[cfg(feature = "laz")]
fn pack(
    points: impl Iterator<Item = Vec<u8>>,
    packing: &[u8],
    out: &mut (impl Write + Seek + Send + Sync),
) -> Result<(), WriteLasError> {
    let packing = laz::LazVlr::from_buffer(packing).map_err(|_| WriteLasError::Packing)?;
    let mut packer =
        laz::LasZipCompressor::new(&mut *out, packing).map_err(|_| WriteLasError::Packing)?;
    for point in points {
        packer.compress_one(&point)?;
    }
    packer.done()?;
    drop(packer);
    Ok(out.flush()?)
}

#[cfg(not(feature = "laz"))]
fn pack(
    _: impl Iterator<Item = Vec<u8>>,
    _: &[u8],
    _: &mut impl Write,
) -> Result<(), WriteLasError> {
    Err(WriteLasError::NoLaz)
}
