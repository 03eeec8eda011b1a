//! `convert`: a tree or a point cloud from one format to another.

use std::str::FromStr;

use anyhow::{Result, bail};

use crate::args::{self, Args, UsageError};
use crate::format::Format;
use crate::output::{self, Target, is_stdout};
use crate::{clouds, input, report};

pub(crate) fn run(args: &Args, verb: &args::Convert) -> Result<()> {
    if clouds::holds_points(&verb.input) {
        return clouds::convert(args, &verb.input, &verb.out.output, verb.out.format.as_deref());
    }
    let format =
        verb.out.format.as_deref().map(Format::from_str).transpose().map_err(UsageError)?;
    let mut target = Target::new(&verb.out.output, format, 1, &verb.out.mesh)?;
    if target.format == Format::Dtree {
        bail!(output::seed_files_are_generated());
    }
    if !is_stdout(&verb.out.output) && Format::of_path(&verb.out.output)?.is_none() {
        bail!(UsageError("name the file to write, with its extension".into()));
    }
    target.model = None;
    // A table goes into a table whole; into any other format goes one tree.
    let whole = target.format.is_table() && verb.tree.is_none();
    let mut last = None;
    target.write(|take| {
        input::read_chosen(&verb.input, &verb.model, verb.tree, whole, |_, made| {
            take(&made)?;
            last = Some(report::tree_figures(&made.tree));
            Ok(())
        })
    })?;
    if let Some(figures) = last {
        let text = format!("{} → {}", report::tree_text(&figures), verb.out.output.display());
        report::say(args, &figures, &text, is_stdout(&verb.out.output));
    }
    Ok(())
}
