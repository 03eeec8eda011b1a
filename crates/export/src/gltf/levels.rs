//! Levels of detail in one file, by `MSFT_lod`.
//!
//! # Source
//!
//! The extension's specification, Microsoft, 2018.

use deeptree_graph::TreeInfo;
use gltf_json as gltf;
use serde_json::value::RawValue;

use super::document::{Document, Options, note};
use super::{GltfError, json};
use crate::subject::Subject;

const EXTENSION: &str = "MSFT_lod";

/// The share of the screen's height above which each of the four levels of detail of wood is shown:
/// so that the sides of a tree of 15 m lie beside the round wood by no more than a pixel or two of
/// 1080 rows.
pub const COVERAGE: [f32; 4] = [0.6, 0.25, 0.08, 0.002];

/// The same of the coarsest wood, and of cards with pictures of the tree, where these come after it.
pub const COVERAGE_BEFORE_CARDS: [f32; 2] = [0.04, 0.002];

/// A level of detail of a tree.
#[derive(Clone, Copy, Debug)]
pub struct Level<'a> {
    /// Its surfaces.
    pub subject: Subject<'a>,
    /// The share of the screen's height or width, 0 to 1, above which it is shown.
    pub coverage: f32,
}

impl<'a> Document<'a> {
    /// Describes levels of detail of one tree, the finest first. Programs that do not know
    /// `MSFT_lod` show the finest.
    ///
    /// # Errors
    ///
    /// As [`Document::new`].
    pub fn with_levels(
        levels: &[Level<'a>],
        info: &TreeInfo,
        options: Options,
    ) -> Result<Self, GltfError> {
        let mut document = Self::empty(info, options);
        if let Some(finest) = document.push_levels(levels, &json::name(info))? {
            document.show(vec![finest]);
        }
        Ok(document)
    }

    /// Adds levels of detail of one tree; the node of the finest stands for all of them. A level by
    /// itself is a tree as any other.
    pub(super) fn push_levels(
        &mut self,
        levels: &[Level<'a>],
        name: &str,
    ) -> Result<Option<gltf::Index<gltf::Node>>, GltfError> {
        if let [only] = levels {
            return self.push_tree(only.subject, name.to_owned()).map(Some);
        }
        let nodes = levels
            .iter()
            .enumerate()
            .map(|(i, level)| self.push_tree(level.subject, format!("{name} lod {i}")))
            .collect::<Result<Vec<_>, _>>()?;
        let Some((&finest, coarser)) = nodes.split_first() else { return Ok(None) };
        let ids: Vec<usize> = coarser.iter().map(gltf::Index::value).collect();
        let coverage: Vec<f32> = levels.iter().map(|level| level.coverage).collect();
        let node = &mut self.root.nodes[finest.value()];
        let extensions = node.extensions.get_or_insert_default();
        extensions.others.insert(EXTENSION.to_owned(), serde_json::json!({ "ids": ids }));
        let extras = serde_json::json!({ "MSFT_screencoverage": coverage });
        node.extras = RawValue::from_string(extras.to_string()).ok();
        note(&mut self.root, EXTENSION);
        Ok(Some(finest))
    }
}
