//! `regrow`: a tree is pruned, and grows again from its wounds.

use std::path::Path;

use anyhow::{Context, Result, bail};
use deeptree_generate::{GenerateError, Limits, RegrowError, Regrown, Request, germ, regrow_in};
use deeptree_graph::{BranchGraph, Cut, NodeId, Passage, Room, Seed, Vec3};
use deeptree_infer::{Model, Predictor, Workspace};
use deeptree_scene::Site;
use serde_json::json;

use super::making::whole_age;
use super::render::preview;
use super::unknown_species;
use crate::args::{self, Args, UsageError};
use crate::batch::Made;
use crate::format::Format;
use crate::output::{self, Target, is_stdout};
use crate::{blend, input, report};

pub(crate) fn run(args: &Args, verb: &args::Regrow) -> Result<()> {
    let cuts = cuts(&verb.cuts)?;
    let age = verb.age.map(whole_age).transpose()?;
    let target = Target::new(&verb.out.output, verb.out.format, 1, &verb.out.mesh)?;
    if target.format == Format::Dtree {
        bail!(output::seed_files_are_generated());
    }
    let pruned = verb.pruned.as_deref().map(|path| pruned_target(path, verb)).transpose()?;
    let (site, work) = (verb.place.site()?, verb.model.workspace()?);
    let mut grower = Grower { verb, age, cuts, site, model: None, work };
    // Several trees need places for all of them.
    let holds_all = |target: &Target| target.format.is_table() || target.folder;
    let whole = verb.tree.is_none() && holds_all(&target) && pruned.iter().all(holds_all);

    preview::check(&verb.out)?;
    let mut seen = Seen::default();
    let mut first = None;
    target.write(|take| {
        let mut all = |take_pruned: &mut dyn FnMut(&Made) -> Result<()>| {
            input::read_chosen(&verb.input, &verb.model, verb.tree, whole, |number, made| {
                // The trees of a table have the seeds from the first on.
                let seed = Seed(verb.seed).of_tree(if whole { u64::from(number) } else { 0 });
                let before = made.tree.len();
                let regrown = grower.regrow(made.tree, seed)?;
                seen.add(before, &regrown);
                let made = |tree, hit_budget| {
                    let number = if target.folder { 0 } else { number };
                    Made {
                        seed: seed.0,
                        number,
                        tree,
                        at: Vec3::ZERO,
                        germ: None,
                        hit_budget,
                        avoided: None,
                    }
                };
                if verb.out.preview.is_some() && first.is_none() {
                    first = Some(regrown.tree.clone());
                }
                take_pruned(&made(regrown.pruned.tree, false))?;
                take(&made(regrown.tree, regrown.hit_budget))
            })
        };
        match &pruned {
            Some(pruned) => pruned.write(|take_pruned| all(take_pruned)),
            None => all(&mut |_| Ok(())),
        }
    })?;
    if let Some(tree) = first {
        preview::take(&verb.out, &tree)?;
    }
    seen.say(args, verb);
    Ok(())
}

/// Where the pruned trees go.
fn pruned_target(path: &Path, verb: &args::Regrow) -> Result<Target> {
    let target = Target::new(path, None, 1, &verb.out.mesh)?;
    if target.format == Format::Dtree {
        bail!(output::seed_files_are_generated());
    }
    if is_stdout(path) || Format::of_path(path)?.is_none() {
        bail!(UsageError("name the file of the pruned tree, with its extension".into()));
    }
    Ok(target)
}

/// What trees are regrown with.
struct Grower<'a> {
    verb: &'a args::Regrow,
    age: Option<u16>,
    cuts: Vec<Cut>,
    site: Option<Site>,
    /// The model of the last species.
    model: Option<(String, Model)>,
    work: Workspace,
}

impl Grower<'_> {
    fn regrow(&mut self, mut tree: BranchGraph, seed: Seed) -> Result<Regrown> {
        if let Some(species) = &self.verb.species {
            tree.info.species.clone_from(species);
        }
        let species = tree.info.species.clone();
        if self.model.as_ref().is_none_or(|known| known.0 != species) {
            self.model = Some((species.clone(), load(self.verb, &species)?));
        }
        let Some((_, model)) = &self.model else { bail!("no model of {species}") };
        // A tree of no age is from a file that does not say one.
        if tree.info.age == 0 {
            let usual = germ(model, &Request::new(&species, seed))?.root;
            tree.info.age = usual.age as u32;
            tree.info.gravitropism = usual.gravitropism;
        }
        if let Some(age) = self.age {
            tree.info.age = u32::from(age);
        }
        if let Some(gravitropism) = self.verb.gravitropism {
            tree.info.gravitropism = gravitropism;
        }
        let limits = Limits { budget: self.verb.budget as usize, batch: self.verb.batch as usize };
        let (site, mut cuts) = (self.site.as_ref(), self.cuts.clone());
        cuts.extend(site.map(|site| Cut::Nodes(in_the_way(&tree, site))));
        regrow_in(model, &tree, &cuts, seed, site, limits, &mut self.work).map_err(refused)
    }
}

/// The nodes that stand where no branch can go: a new obstacle takes them off. The root stays.
fn in_the_way(tree: &BranchGraph, site: &Site) -> Vec<NodeId> {
    let is_in_the_way = |id: &NodeId| {
        let node = tree.node(*id);
        site.passage(node.base(), node.position) != Passage::Free
    };
    (1..tree.len() as NodeId).filter(is_in_the_way).collect()
}

/// The model of a species, or of a blend of several.
fn load(verb: &args::Regrow, species: &str) -> Result<Model> {
    if species.contains(':') {
        let weights = verb.model.weights()?;
        let shares = blend::shares(species, weights.species())?;
        return blend::model(&weights, &shares);
    }
    let model = verb.model.load()?;
    if model.species().iter().any(|known| known == species) {
        return Ok(model);
    }
    let UsageError(text) = unknown_species(species, model.species());
    bail!(UsageError(format!("{}: {text}; say which it is with --species", verb.input.display())))
}

/// What no run could do is a wrong request.
fn refused(error: RegrowError) -> anyhow::Error {
    match error {
        RegrowError::Prune(_)
        | RegrowError::Generate(
            GenerateError::OutOfRange { .. }
            | GenerateError::NotFinite { .. }
            | GenerateError::NotSeen { .. },
        ) => UsageError(error.to_string()).into(),
        error => error.into(),
    }
}

/// What the command line says to cut off.
fn cuts(asked: &args::Cuts) -> Result<Vec<Cut>> {
    let mut cuts = Vec::new();
    cuts.extend(asked.keep_below.iter().map(|&height| Cut::Above(height)));
    cuts.extend(asked.keep_order.iter().map(|&order| Cut::Order(order)));
    cuts.extend(asked.keep_path.iter().map(|&fraction| Cut::Path(fraction)));
    cuts.extend(asked.cut_box.iter().map(|numbers| {
        let [x0, y0, z0, x1, y1, z1] = numbers.0;
        Cut::Box { min: Vec3::new(x0, y0, z0), max: Vec3::new(x1, y1, z1) }
    }));
    cuts.extend(asked.cut_sphere.iter().map(|numbers| {
        let [x, y, z, radius] = numbers.0;
        Cut::Sphere { center: Vec3::new(x, y, z), radius }
    }));
    cuts.extend(asked.cut_plane.iter().map(|numbers| {
        let [x, y, z, offset] = numbers.0;
        Cut::Plane { normal: Vec3::new(x, y, z), offset }
    }));
    for path in &asked.cut_nodes {
        cuts.push(Cut::Nodes(nodes(path)?));
    }
    Ok(cuts)
}

/// The node numbers in a file, between blanks, commas or line ends.
fn nodes(path: &Path) -> Result<Vec<NodeId>> {
    let text =
        std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
    let number = |word: &str| {
        word.parse().with_context(|| format!("{}: `{word}` is no node number", path.display()))
    };
    words.map(number).collect()
}

/// What was done, for the report at the end.
#[derive(Default)]
struct Seen {
    trees: u64,
    kept: usize,
    cut: usize,
    regrown: usize,
    wounds: usize,
    hit_budget: Vec<u64>,
    last: Option<serde_json::Value>,
}

impl Seen {
    fn add(&mut self, before: usize, regrown: &Regrown) {
        let kept = regrown.pruned.tree.len();
        self.trees += 1;
        self.kept += kept;
        self.cut += before - kept;
        self.regrown += regrown.tree.len() - kept;
        self.wounds += regrown.pruned.wounds.len();
        if regrown.hit_budget {
            self.hit_budget.push(regrown.tree.info.seed);
        }
        self.last = Some(report::tree_figures(&regrown.tree));
    }

    fn say(self, args: &Args, verb: &args::Regrow) {
        let Self { trees, kept, cut, regrown, wounds, hit_budget, last } = self;
        if !args.quiet && !hit_budget.is_empty() {
            eprintln!(
                "deeptree: {} of {trees} trees hit the node budget and are cut off (seeds {:?} …)",
                hit_budget.len(),
                &hit_budget[..hit_budget.len().min(5)]
            );
        }
        let done =
            format!("{kept} nodes kept, {cut} cut off, {regrown} grown from {wounds} wounds");
        let place = verb.out.output.display();
        let (mut figures, text) = match last {
            Some(tree) if trees == 1 => {
                let text = format!("{done}: {} → {place}", report::tree_text(&tree));
                (tree, text)
            }
            _ => (json!({ "trees": trees }), format!("{trees} trees: {done} → {place}")),
        };
        figures["kept"] = json!(kept);
        figures["cut"] = json!(cut);
        figures["regrown"] = json!(regrown);
        figures["wounds"] = json!(wounds);
        figures["hit_budget"] = json!(hit_budget);
        report::say(args, &figures, &text, is_stdout(&verb.out.output));
    }
}
