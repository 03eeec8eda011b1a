//! `render`: pictures of trees.

mod impostor;
mod lettering;
pub(crate) mod preview;
mod sheet;
mod stand;
mod trees;

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result, bail};
use deeptree_export::write_atomically;
use deeptree_graph::{BranchGraph, Seed, Vec3};
use deeptree_mesh::{Image, Look};
use deeptree_render::files::{Channel, exr_bytes, write_channel_png, write_png};
use deeptree_render::{
    Background, Camera, Developing, Ground, Light, Mark, Mosaic, Options, Picture, RenderError,
    Scene, Tone, View, develop, marks, render, tile_count,
};
use serde_json::json;

use crate::args::{self, Aov, Args, Curve, Surroundings, UsageError};
use crate::dressing::{all_dressed, standing};
use crate::{batch, input, report};

/// Pixels between two views.
const GAP: u32 = 4;
/// Elevation of the sun and its azimuth from the front to the right, in degrees; turbidity; angle
/// of view in degrees, where nothing else is asked for.
pub(crate) const SUN: [f32; 2] = [40.0, -50.0];
pub(crate) const HAZE: f32 = 3.0;
pub(crate) const ANGLE: f32 = 32.0;

pub(crate) fn run(args: &Args, verb: &args::Render) -> Result<()> {
    let kind = FileKind::of(&verb.output)?;
    batch::on_threads(verb.threads, || match (verb.sheet, &verb.input) {
        (Some(which), _) => sheet::run(args, verb, which, kind),
        (None, Some(input)) => {
            // What is asked for wrongly is told before anything is read.
            let ask = Ask::new(verb)?;
            if verb.all {
                return views(args, verb, &stand::read(verb, input, &ask)?, &ask, kind);
            }
            let tree = read(verb, input)?;
            match verb.impostor {
                Some(cards) => impostor::run(args, verb, &tree, cards, kind),
                None => views(args, verb, &[(tree, Vec3::ZERO)], &ask, kind),
            }
        }
        (None, None) => bail!(UsageError("name a tree, or a sheet with --sheet".to_owned())),
    })
}

/// A file that pictures are written to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FileKind {
    Png,
    Exr,
}

impl FileKind {
    fn of(path: &Path) -> Result<Self, UsageError> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        match extension.as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(UsageError(format!(
                "{}: pictures are .png or .exr; name the output so",
                path.display()
            ))),
        }
    }
}

/// What of a picture is the same for all views.
struct Ask {
    views: Vec<View>,
    options: Options,
    light: Light,
    look: Look,
    angle: f32,
}

impl Ask {
    fn new(verb: &args::Render) -> Result<Self> {
        let views: Result<Vec<View>, RenderError> =
            verb.views.iter().map(|name| name.parse()).collect();
        let options = Options {
            size: verb.size.unwrap_or([512, 512]),
            samples: verb.spp,
            error: verb.error,
            surroundings: verb.background == Surroundings::Sky,
            seed: Seed(verb.seed),
            ..Options::default()
        };
        options.validate().map_err(usage)?;
        Ok(Self {
            views: views.map_err(usage)?,
            options,
            light: light(verb, 0.0)?,
            look: verb.look.pictured(verb.lod)?,
            angle: verb.angle.to_radians(),
        })
    }
}

/// The light that is asked for, turned about the vertical.
fn light(verb: &args::Render, turn: f32) -> Result<Light, UsageError> {
    let [elevation, azimuth] = verb.sun.0.map(f32::to_radians);
    Light::daylight(elevation, azimuth + turn, verb.haze).map_err(usage)
}

/// What no run could do is a wrong request.
fn usage(error: RenderError) -> UsageError {
    UsageError(error.to_string())
}

/// The tree of the input.
fn read(verb: &args::Render, input: &Path) -> Result<BranchGraph> {
    let mut tree = None;
    input::read_chosen(input, &verb.model, verb.tree, false, |_, made| {
        tree = Some(made.tree);
        Ok(())
    })?;
    tree.with_context(|| format!("{} holds no tree", input.display()))
}

/// Pictures of trees, each at its place, from the views, side by side.
fn views(
    args: &Args,
    verb: &args::Render,
    trees: &[(BranchGraph, Vec3)],
    ask: &Ask,
    kind: FileKind,
) -> Result<()> {
    let start = Instant::now();
    let trees: Vec<(&BranchGraph, Vec3)> = trees.iter().map(|(tree, at)| (tree, *at)).collect();
    let trees = all_dressed(&trees, &ask.look)?;
    let scene = Scene::of(&standing(&trees), ask.light.clone(), Ground::Meadow)?;
    let built = start.elapsed();
    let (options, size) = (&ask.options, ask.options.size);
    let bar = report::bar(args, tile_count(size) * ask.views.len() as u64, "render");
    let (mut pictures, mut all_marks) = (Vec::new(), Vec::new());
    for &view in &ask.views {
        let aspect = size[0] as f32 / size[1] as f32;
        let camera = Camera::framing(scene.points(), view, aspect, ask.angle).map_err(usage)?;
        let camera = camera.with_aperture(verb.aperture);
        pictures.push(render(&scene, &camera, options, |_| bar.inc(1))?);
        if !verb.aov.is_empty() {
            all_marks.push(marks(&scene, &camera, options)?);
        }
    }
    bar.finish_and_clear();
    let count = ask.views.len() as u32;
    let mosaic = Mosaic { cell: size, count, columns: count.min(3), gap: GAP };
    let picture = mosaic.pictures(&pictures);
    let traced = start.elapsed() - built;
    write(verb, kind, &picture, &mosaic.marks(&all_marks))?;

    let per_pixel =
        picture.samples as f64 / (f64::from(size[0]) * f64::from(size[1]) * f64::from(count));
    let foliage = trees.iter().flat_map(|(tree, _)| &tree.foliage);
    let leaves: usize = foliage.map(|foliage| foliage.leaves.len()).sum();
    let triangles: usize = trees.iter().map(|(tree, _)| tree.wood.triangle_count()).sum();
    let figures = json!({
        "trees": trees.len(),
        "triangles_of_wood": triangles,
        "copies_of_leaves": leaves,
        "paths": picture.samples,
        "paths_a_pixel": per_pixel,
        "seconds_to_prepare": built.as_secs_f64(),
        "seconds_to_trace": traced.as_secs_f64(),
        "mean_radiance": picture.mean(),
    });
    let several = if verb.all { format!("{} trees, ", trees.len()) } else { String::new() };
    let text = format!(
        "{several}{triangles} triangles of wood, {leaves} shoots: {per_pixel:.0} paths a pixel in {:.1} s → {}",
        traced.as_secs_f64(),
        verb.output.display()
    );
    report::say(args, &figures, &text, false);
    Ok(())
}

/// Writes the picture, and what is known of its pixels in it or beside it.
fn write(verb: &args::Render, kind: FileKind, picture: &Picture, marks: &[Mark]) -> Result<()> {
    let channels = channels(verb);
    match kind {
        FileKind::Exr => {
            let marks: Vec<_> = channels.iter().map(|&channel| (channel, marks)).collect();
            write_bytes(&verb.output, &exr_bytes(picture, &marks)?)
        }
        FileKind::Png => {
            for &channel in &channels {
                let mut bytes = Vec::new();
                let size = [picture.width, picture.height];
                write_channel_png(&mut bytes, size, marks, channel)?;
                write_bytes(&beside(&verb.output, channel.name()), &bytes)?;
            }
            let background = match verb.background {
                Surroundings::Transparent => Background::Transparent,
                _ => Background::Paper(Vec3::ONE),
            };
            let how = Developing { background, ..developing(verb) };
            write_image(&verb.output, &develop(picture, &how))
        }
    }
}

/// How light becomes bytes.
fn developing(verb: &args::Render) -> Developing {
    let tone = match verb.tone {
        Curve::Filmic => Tone::Filmic,
        Curve::Linear => Tone::Linear,
    };
    Developing { exposure: verb.exposure, tone, shadow: 0.8, ..Developing::default() }
}

/// The channels of what is asked for.
fn channels(verb: &args::Render) -> Vec<Channel> {
    let (asked, mut channels) = (&verb.aov, Vec::new());
    for (aov, of) in [
        (Aov::Depth, &[Channel::Depth][..]),
        (Aov::Normal, &[Channel::Normal]),
        (Aov::Labels, &[Channel::Kind, Channel::Branch, Channel::Order, Channel::Node]),
    ] {
        if asked.contains(&aov) {
            channels.extend(of);
        }
    }
    if verb.all && asked.contains(&Aov::Labels) {
        channels.push(Channel::Tree);
    }
    channels
}

/// `tree.png` with a word before the extension: `tree.depth.png`.
fn beside(path: &Path, word: &str) -> PathBuf {
    path.with_extension(format!("{word}.png"))
}

fn write_image(path: &Path, image: &Image) -> Result<()> {
    let mut bytes = Vec::new();
    let software = concat!("DeepTree ", env!("CARGO_PKG_VERSION")).to_owned();
    write_png(&mut bytes, image, &[("Software", software)])?;
    write_bytes(path, &bytes)
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    Ok(write_atomically(path, |out| std::io::Write::write_all(out, bytes))?)
}
