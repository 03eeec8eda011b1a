//! A stand: many trees in one description, each at its place, written one after the other.

use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::Path;

use deeptree_graph::{TreeInfo, Vec3};
use gltf_json as gltf;
use serde_json::value::RawValue;

use super::document::{Document, Options, Out};
use super::materials::Materials;
use super::{GltfError, Level, container, json};
use crate::atomic::{Spool, write_atomically};

/// Trees that are to be one file.
///
/// Each tree is a node at its place, with its surfaces around its own foot. Trees that are made of
/// equal materials share them and their pictures. The numbers of a tree go to the spool when it is
/// added, so no more than one tree needs to be in memory, besides the pictures and the description,
/// a few kilobytes a tree.
///
/// `asset.extras` holds the number of `trees`; the `extras` of a tree's node are its `number`,
/// `species`, `age`, `gravitropism` and `seed`, as [`Document::new`] says.
pub struct Stand<S> {
    root: gltf::Root,
    materials: Materials,
    options: Options,
    bytes: u64,
    trees: Vec<gltf::Index<gltf::Node>>,
    spool: S,
}

impl Stand<Spool> {
    /// A stand without trees, whose numbers wait in a hidden file beside `path` until it is written.
    ///
    /// # Errors
    ///
    /// When no file can be made there.
    pub fn beside(path: &Path, options: Options) -> Result<Self, GltfError> {
        Ok(Self::new(Spool::beside(path)?, options))
    }
}

impl<S: Read + Write + Seek> Stand<S> {
    /// A stand without trees, whose numbers wait in an empty spool until it is written.
    pub fn new(spool: S, options: Options) -> Self {
        let (root, materials) = (gltf::Root::default(), Materials::default());
        Self { root, materials, options, bytes: 0, trees: Vec::new(), spool }
    }

    /// Adds the next tree with its foot at a place: at one level of detail or at several, as
    /// [`Document::with_levels`]. Its name is its number in the stand, its species and its seed.
    ///
    /// # Errors
    ///
    /// When a picture of a material is not sound or the spool fails; then the stand is not usable.
    pub fn add(
        &mut self,
        levels: &[Level<'_>],
        info: &TreeInfo,
        at: Vec3,
    ) -> Result<(), GltfError> {
        let mut document = Document {
            root: std::mem::take(&mut self.root),
            materials: std::mem::take(&mut self.materials),
            options: self.options,
            blocks: Vec::new(),
            bytes: self.bytes,
        };
        let number = self.trees.len();
        let name = format!("{number} {}", json::name(info));
        // The levels of detail have no place of their own: what holds them has.
        let children = document.push_levels(levels, &name)?.map(|finest| vec![finest]);
        let extras = json::extras(info, Some(number));
        let node = gltf::Node {
            name: Some(name),
            translation: Some(at.to_array()),
            children,
            extras: RawValue::from_string(extras.to_string()).ok(),
            ..gltf::Node::default()
        };
        self.trees.push(document.root.push(node));
        let mut out: Out<'_> = BufWriter::with_capacity(1 << 16, &mut self.spool);
        document.write_blocks(&mut out)?;
        out.flush()?;
        drop(out);
        Document { root: self.root, materials: self.materials, bytes: self.bytes, .. } = document;
        Ok(())
    }

    /// Bytes of the numbers so far, without pictures and description: a GLB file ends at 4 GiB.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Writes the stand as binary glTF, with the pictures in it.
    ///
    /// # Errors
    ///
    /// When the file would pass the 4 GiB that the format can count, or the output or the spool
    /// fails.
    pub fn write_glb(self, out: &mut impl Write) -> Result<(), GltfError> {
        let (mut document, mut spool) = self.finish()?;
        let numbers = document.bytes;
        document.embed_pictures();
        let text = document.text_with_buffer(None)?;
        container::write_head(text, document.bytes, out)?;
        if io::copy(&mut (&mut spool).take(numbers), out)? != numbers {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
        }
        let mut out: Out<'_> = BufWriter::with_capacity(1 << 16, out);
        document.write_blocks(&mut out)?;
        Ok(out.flush()?)
    }

    /// Writes the stand as `.gltf`, with its numbers and pictures in files beside it, as
    /// [`Document::save`].
    ///
    /// # Errors
    ///
    /// When the name is no UTF-8, or a file cannot be written.
    pub fn save(self, path: &Path) -> Result<(), GltfError> {
        let (document, mut spool) = self.finish()?;
        document.save_with(path, |out| io::copy(&mut spool, out).map(drop))
    }

    /// Writes the stand as binary glTF to a file, which appears whole or not at all.
    ///
    /// # Errors
    ///
    /// As [`Stand::write_glb`].
    pub fn save_glb(self, path: &Path) -> Result<(), GltfError> {
        Ok(write_atomically(path, |out| self.write_glb(out))?)
    }

    /// The description of all trees, without blocks, and the spool from its start.
    fn finish(mut self) -> Result<(Document<'static>, S), GltfError> {
        let mut root = self.root;
        root.asset = json::asset(&serde_json::json!({ "trees": self.trees.len() }));
        let mut document = Document {
            root,
            materials: self.materials,
            options: self.options,
            blocks: Vec::new(),
            bytes: self.bytes,
        };
        // A scene may not be empty.
        if !self.trees.is_empty() {
            document.show(self.trees);
        }
        self.spool.rewind()?;
        Ok((document, self.spool))
    }
}
