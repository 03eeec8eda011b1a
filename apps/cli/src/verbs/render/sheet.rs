//! Contact sheets: trees at one scale on white paper, with their names.

use std::time::Instant;

use anyhow::{Result, bail};
use deeptree_graph::{BranchGraph, Seed, Vec3};
use deeptree_mesh::{Dressed, Look};
use deeptree_render::{
    Background, Camera, Developing, Ground, Light, Options, Picture, Scene, develop, render,
    tile_count,
};
use serde_json::json;

use super::lettering::{Letters, Paper};
use super::{FileKind, developing, light, trees, usage, write_image};
use crate::args::{self, Args, Sheet, UsageError};
use crate::dressing::dressed;
use crate::report;

const PAPER: [u8; 3] = [250, 249, 246];
const INK: [u8; 3] = [52, 48, 44];
/// Pixels around the sheet, between columns, above a column for its name, below a row for its.
const MARGIN: u32 = 28;
const GAP: u32 = 14;
const TITLE: u32 = 34;
const CAPTION: u32 = 30;
/// Pixels of the tallest tree where none are asked for.
const TALLEST: u32 = 360;
/// Metres that stay free around a tree, as a share of the tallest.
const AIR: f32 = 0.03;
/// Elevation of who looks, in radians: so the ground is seen, and the shadow on it.
const ELEVATION: f32 = 0.1;
/// How much darker a full shadow makes the paper.
const SHADOW: f32 = 0.35;
/// Light that the ground throws back.
const GROUND: Ground = Ground::Plain(Vec3::splat(0.4));

/// What stands where: one row of cells after the other, all as long.
pub(super) struct Plan {
    /// Words above the columns; none, or one each.
    pub(super) columns: Vec<String>,
    /// Words below the rows; none, or one each.
    pub(super) rows: Vec<String>,
    pub(super) cells: Vec<Vec<Cell>>,
}

/// A tree, and from where it is looked at, in radians; the sun turns with who looks.
pub(super) struct Cell {
    pub(super) tree: BranchGraph,
    pub(super) azimuth: f32,
    pub(super) elevation: f32,
}

impl Cell {
    pub(super) fn front(tree: BranchGraph) -> Self {
        Self { tree, azimuth: 0.0, elevation: ELEVATION }
    }
}

/// How far a tree reaches from its root in the picture: left, right, down, up; in metres.
type Reach = [f32; 4];

pub(super) fn run(args: &Args, verb: &args::Render, which: Sheet, kind: FileKind) -> Result<()> {
    if kind == FileKind::Exr {
        bail!(UsageError("a sheet has words on it; name a .png".to_owned()));
    }
    // What is wrong with the light is told before trees are grown.
    light(verb, 0.0)?;
    let options = Options {
        samples: verb.spp,
        error: verb.error,
        surroundings: false,
        seed: Seed(verb.seed),
        ..Options::default()
    };
    options.validate().map_err(usage)?;
    let start = Instant::now();
    let plan = trees::plan(verb, which)?;
    let look = verb.look.pictured(verb.lod)?;
    fn dress<'a>(cell: &'a Cell, look: &Look) -> Result<(Dressed, &'a Cell)> {
        Ok((dressed(&cell.tree, look)?, cell))
    }
    let cells: Vec<Vec<(Dressed, &Cell)>> = plan
        .cells
        .iter()
        .map(|row| row.iter().map(|cell| dress(cell, &look)).collect::<Result<_>>())
        .collect::<Result<_>>()?;
    let tallest = verb.size.map_or(TALLEST, |[_, height]| height);
    let layout = Layout::new(&cells, tallest, &plan);
    let bar = report::bar(args, layout.tiles(), "render");
    let mut paper = Paper::new(layout.size(), PAPER);
    let how = Developing {
        background: Background::Paper(Vec3::from(PAPER.map(f32::from)) / 255.0),
        shadow: SHADOW,
        ..developing(verb)
    };
    let mut samples = 0;
    for (r, row) in cells.iter().enumerate() {
        for (c, (tree, cell)) in row.iter().enumerate() {
            let options = Options { size: layout.pixels(r, c), ..options };
            let mut picture = picture(
                tree,
                cell,
                light(verb, cell.azimuth)?,
                layout.window(r, c),
                &options,
                || bar.inc(1),
            )?;
            samples += picture.samples;
            fade(&mut picture);
            paper.lay(&develop(&picture, &how), layout.place(r, c));
        }
    }
    bar.finish_and_clear();
    layout.write(&mut paper, &plan);
    let image = paper.into_image();
    write_image(&verb.output, &image)?;
    let trees: usize = cells.iter().map(Vec::len).sum();
    let seconds = start.elapsed().as_secs_f64();
    let (width, height) = (image.width, image.height);
    let figures =
        json!({ "trees": trees, "paths": samples, "seconds": seconds, "size": [width, height] });
    let output = verb.output.display();
    let text = format!("{trees} trees on {width} × {height} pixels in {seconds:.1} s → {output}");
    report::say(args, &figures, &text, false);
    Ok(())
}

fn picture(
    tree: &Dressed,
    cell: &Cell,
    light: Light,
    window: Reach,
    options: &Options,
    done: impl Fn() + Sync,
) -> Result<Picture> {
    let scene = Scene::new(tree, light, GROUND)?;
    let [left, right, down, up] = window;
    let size = [left + right, down + up];
    let probe = Camera::orthographic(Vec3::ZERO, cell.azimuth, cell.elevation, size);
    let [x, y, _] = probe.axes();
    let center = x * ((right - left) / 2.0) + y * ((up - down) / 2.0);
    let camera = Camera::orthographic(center, cell.azimuth, cell.elevation, size);
    Ok(render(&scene, &camera, options, |_| done())?)
}

/// Lets the shadow end softly where the cell ends.
fn fade(picture: &mut Picture) {
    let (width, height) = (picture.width, picture.height);
    let soft = |at: u32, n: u32, over: f32| {
        let edge = (at.min(n - 1 - at) as f32 / (over * n as f32)).min(1.0);
        edge * edge * (3.0 - 2.0 * edge)
    };
    for (i, shadow) in picture.shadow.iter_mut().enumerate() {
        let (x, y) = (i as u32 % width, i as u32 / width);
        *shadow *= soft(x, width, 0.15) * soft(y, height, 0.04);
    }
}

/// Where the cells of a sheet lie.
struct Layout {
    /// Pixels a metre.
    scale: f32,
    /// Metres left and right of the roots of each column.
    columns: Vec<[f32; 2]>,
    /// Metres below and above the roots of each row.
    rows: Vec<[f32; 2]>,
    has_titles: bool,
    has_captions: bool,
}

impl Layout {
    fn new(cells: &[Vec<(Dressed, &Cell)>], tallest: u32, plan: &Plan) -> Self {
        let reaches: Vec<Vec<Reach>> = cells
            .iter()
            .map(|row| row.iter().map(|(tree, cell)| reach(tree, cell)).collect())
            .collect();
        let most = reaches.iter().flatten().map(|[_, _, _, up]| *up).fold(0.1, f32::max);
        let air = AIR * most;
        let count = reaches.iter().map(Vec::len).max().unwrap_or_default();
        let widest = |column: usize, side: usize| {
            let cells = reaches.iter().filter_map(|row| row.get(column));
            cells.map(|reach| reach[side]).fold(0.0, f32::max) + air
        };
        let highest = |row: &[Reach], side: usize| {
            row.iter().map(|reach| reach[side]).fold(0.0, f32::max) + air
        };
        Self {
            scale: tallest as f32 / most,
            columns: (0..count).map(|c| [widest(c, 0), widest(c, 1)]).collect(),
            rows: reaches.iter().map(|row| [highest(row, 2), highest(row, 3)]).collect(),
            has_titles: !plan.columns.is_empty(),
            has_captions: !plan.rows.is_empty(),
        }
    }

    fn window(&self, row: usize, column: usize) -> Reach {
        let ([left, right], [down, up]) = (self.columns[column], self.rows[row]);
        [left, right, down, up]
    }

    fn pixels(&self, row: usize, column: usize) -> [u32; 2] {
        let side = |[a, b]: [f32; 2]| (((a + b) * self.scale).round() as u32).max(1);
        [side(self.columns[column]), side(self.rows[row])]
    }

    fn place(&self, row: usize, column: usize) -> [u32; 2] {
        let x = (0..column).map(|c| self.pixels(0, c)[0] + GAP).sum::<u32>();
        let caption = if self.has_captions { CAPTION } else { GAP };
        let y = (0..row).map(|r| self.pixels(r, 0)[1] + caption).sum::<u32>();
        [MARGIN + x, MARGIN + y + if self.has_titles { TITLE } else { 0 }]
    }

    fn size(&self) -> [u32; 2] {
        let (row, column) = (self.rows.len() - 1, self.columns.len() - 1);
        let ([x, y], [width, height]) = (self.place(row, column), self.pixels(row, column));
        let caption = if self.has_captions { CAPTION } else { 0 };
        [x + width + MARGIN, y + height + caption + MARGIN]
    }

    fn tiles(&self) -> u64 {
        let cells = (0..self.rows.len()).flat_map(|r| (0..self.columns.len()).map(move |c| (r, c)));
        cells.map(|(r, c)| tile_count(self.pixels(r, c))).sum()
    }

    fn write(&self, paper: &mut Paper, plan: &Plan) {
        for (c, title) in plan.columns.iter().enumerate() {
            let [left, right] = self.columns[c];
            let middle = self.place(0, c)[0] + (self.scale * (left + right) / 2.0) as u32;
            paper.write(title, [middle, MARGIN], Letters::Large, INK);
        }
        let middle = self.size()[0] / 2;
        for (r, caption) in plan.rows.iter().enumerate() {
            let below = self.place(r, 0)[1] + self.pixels(r, 0)[1] + 6;
            paper.write(caption, [middle, below], Letters::Small, INK);
        }
    }
}

/// How far a tree reaches in the picture.
fn reach(tree: &Dressed, cell: &Cell) -> Reach {
    let [x, y, _] = Camera::orthographic(Vec3::ZERO, cell.azimuth, cell.elevation, [1.0; 2]).axes();
    let mut reach = [0.0f32; 4];
    for p in deeptree_render::points(tree) {
        let (across, along) = (x.dot(p), y.dot(p));
        reach = [
            reach[0].max(-across),
            reach[1].max(across),
            reach[2].max(-along),
            reach[3].max(along),
        ];
    }
    reach
}
