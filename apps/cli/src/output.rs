//! Writing trees: one file, a table of all, or a folder of files.

use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};

use deeptree_export::tables::{TableMeta, TableWriter};
use deeptree_export::write_atomically;
use deeptree_graph::Share;
use deeptree_graph::codec::csv::CsvWriter;
use deeptree_graph::codec::{dtree::SeedFile, tree_format};

use crate::args::{MeshArgs, UsageError};
use crate::batch::Made;
use crate::format::Format;
use crate::surfaces;

/// Where trees go.
#[derive(Debug)]
pub(crate) struct Target {
    pub(crate) path: PathBuf,
    pub(crate) format: Format,
    pub(crate) mesh: MeshArgs,
    /// The model that made the trees; none for trees of the growth model.
    pub(crate) model: Option<[u8; 16]>,
    /// The species that the trees' lies between; empty for trees of one.
    pub(crate) blend: Vec<Share>,
    /// One file a tree in the folder `path`.
    pub(crate) folder: bool,
    /// Trees that stand together in one file of surfaces.
    pub(crate) stand: bool,
}

impl Target {
    /// Decides what `path` means for `count` trees.
    pub(crate) fn new(
        path: &Path,
        format: Option<Format>,
        count: u64,
        mesh: &MeshArgs,
    ) -> Result<Self> {
        let target = Self::of_any(path, format, mesh)?;
        if count > 1 && !target.folder && !target.format.is_table() {
            bail!(UsageError(format!(
                "{count} trees do not fit into one .{} file; name a folder, or a .csv or .parquet table",
                target.format.extension()
            )));
        }
        Ok(target)
    }

    /// Decides what `path` means for `count` trees that stand together: a .glb or .gltf takes all.
    pub(crate) fn for_stand(
        path: &Path,
        format: Option<Format>,
        count: u64,
        mesh: &MeshArgs,
    ) -> Result<Self> {
        let target = Self::of_any(path, format, mesh)?;
        let stand = !target.folder && target.format.is_gltf();
        if stand {
            surfaces::stand::check(mesh)?;
        }
        if count > 1 && !target.folder && !target.format.is_table() && !stand {
            bail!(UsageError(format!(
                "a stand as one file is .glb or .gltf, or a .csv or .parquet table, not .{}; name \
                 such a file, or a folder",
                target.format.extension()
            )));
        }
        Ok(Self { stand, ..target })
    }

    fn of_any(path: &Path, format: Option<Format>, mesh: &MeshArgs) -> Result<Self> {
        let named = if is_stdout(path) || path.is_dir() { None } else { Format::of_path(path)? };
        let format = match (named, format) {
            (Some(named), Some(asked)) if named != asked => bail!(UsageError(format!(
                "{} is no .{} file; leave --format out or rename the output",
                path.display(),
                asked.extension()
            ))),
            (named, asked) => named.or(asked).unwrap_or(Format::Glb),
        };
        surfaces::check(mesh, format, is_stdout(path) || surfaces::is_stream(path))?;
        let folder = !is_stdout(path) && named.is_none() && (path.is_dir() || !path.exists());
        Ok(Self {
            path: path.to_owned(),
            format,
            mesh: mesh.clone(),
            model: None,
            blend: Vec::new(),
            folder,
            stand: false,
        })
    }

    /// Runs `make`, which hands over trees one by one, and writes them. Nothing is left behind
    /// under the target's name when it fails.
    pub(crate) fn write(
        &self,
        make: impl FnOnce(&mut dyn FnMut(&Made) -> Result<()>) -> Result<()>,
    ) -> Result<()> {
        if self.folder {
            std::fs::create_dir_all(&self.path)
                .with_context(|| format!("cannot create the folder {}", self.path.display()))?;
            return make(&mut |made| {
                // No file system minds these; a colon is a drive on some.
                let species = made.tree.info.species.replace(':', "-").replace(',', "_");
                let name = format!("{species}-{}.{}", made.seed, self.format.extension());
                self.save_one(made, &self.path.join(name))
            });
        }
        if is_stdout(&self.path) {
            let mut out = BufWriter::new(std::io::stdout());
            self.write_all(make, &mut out)?;
            return out.flush().context("cannot write to standard output");
        }
        if self.format.is_surface() {
            // Kept until nothing can fail: the files of one surface come last.
            let mut one = None;
            make(&mut |made| {
                one = Some(made.clone());
                Ok(())
            })?;
            return one.iter().try_for_each(|made| self.save_one(made, &self.path));
        }
        self.write_file(&self.path, |out| self.write_all(make, out))
    }

    /// Writes trees that stand together into one file of surfaces.
    pub(crate) fn write_stand(&self, trees: &[Made]) -> Result<()> {
        if is_stdout(&self.path) {
            let mut out = BufWriter::new(std::io::stdout());
            surfaces::stand::write(trees, &self.mesh, &mut out)?;
            return out.flush().context("cannot write to standard output");
        }
        surfaces::stand::save(trees, &self.mesh, self.format, &self.path)
            .with_context(|| format!("{} was not written", self.path.display()))
    }

    /// One tree into a file, with those that belong to it.
    fn save_one(&self, made: &Made, path: &Path) -> Result<()> {
        if self.format.is_surface() {
            return surfaces::save(&made.tree, &self.mesh, self.format, path)
                .with_context(|| format!("{} was not written", path.display()));
        }
        self.write_file(path, |out| self.write_one(made, out))
    }

    fn write_file<W>(&self, path: &Path, write: W) -> Result<()>
    where
        W: FnOnce(&mut BufWriter<std::fs::File>) -> Result<()>,
    {
        // The writer's own error is the cause; the file's errors name the file.
        let mut cause = None;
        let written = write_atomically(path, |out| {
            write(out).map_err(|error| {
                let text = format!("{error:#}");
                cause = Some(error);
                std::io::Error::other(text)
            })
        });
        match (written, cause) {
            (_, Some(cause)) => Err(cause.context(format!("{} was not written", path.display()))),
            (written, None) => Ok(written?),
        }
    }

    /// All trees into one stream.
    fn write_all(
        &self,
        make: impl FnOnce(&mut dyn FnMut(&Made) -> Result<()>) -> Result<()>,
        out: &mut (impl Write + Send),
    ) -> Result<()> {
        match self.format {
            Format::Csv => {
                let mut table = CsvWriter::new(out)?;
                make(&mut |made| Ok(table.write(made.number, &made.tree)?))?;
                table.finish()?;
            }
            Format::Parquet => {
                let mut table = TableWriter::new(out, &TableMeta { model: self.model.map(hex) })?;
                make(&mut |made| Ok(table.write(made.number, &made.tree)?))?;
                table.finish()?;
            }
            _ => make(&mut |made| self.write_one(made, &mut *out))?,
        }
        Ok(())
    }

    fn write_one(&self, made: &Made, out: &mut (impl Write + Send)) -> Result<()> {
        let tree = &made.tree;
        match self.format {
            Format::Tree => tree_format::write(out, tree)?,
            Format::Csv | Format::Parquet => self.write_all(|take| take(made), out)?,
            Format::Dtree => out.write_all(&self.seed_file(made)?.to_bytes())?,
            _ => surfaces::write(tree, &self.mesh, self.format, out)?,
        }
        Ok(())
    }

    fn seed_file(&self, made: &Made) -> Result<SeedFile> {
        let (Some(model), Some(germ)) = (self.model, made.germ) else {
            bail!(seed_files_are_generated());
        };
        ensure!(
            !made.hit_budget,
            "the tree of seed {} was cut off by its budget; a .dtree file always means a whole tree",
            made.seed
        );
        Ok(SeedFile {
            model,
            species: u8::try_from(germ.species).context("a .dtree file numbers 256 species")?,
            blend: self.blend.clone(),
            age: germ.root.age as u16,
            gravitropism: germ.root.gravitropism,
            seed: germ.seed.0,
            root: germ.root.signature,
            traits: germ.root.traits,
        })
    }
}

pub(crate) fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Bytes as hexadecimal digits.
pub(crate) fn hex(bytes: [u8; 16]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Why only `generate` writes `.dtree` files.
pub(crate) fn seed_files_are_generated() -> UsageError {
    UsageError("a .dtree file is a seed of the networks; only generate writes one".to_owned())
}
