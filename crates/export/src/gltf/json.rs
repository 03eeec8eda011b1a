//! Entries of a description that have few fields of interest.

use deeptree_graph::TreeInfo;
use gltf_json as json;
use json::accessor::{ComponentType, GenericComponentType, Type};
use json::buffer::Target;
use json::validation::{Checked, USize64};
use json::{Accessor, Index};
use serde_json::value::RawValue;

use crate::numbers::one_line;

/// Says who made the file, and of what.
pub(super) fn asset(extras: &serde_json::Value) -> json::Asset {
    json::Asset {
        generator: Some(format!("DeepTree {}", env!("CARGO_PKG_VERSION"))),
        extras: RawValue::from_string(extras.to_string()).ok(),
        ..json::Asset::default()
    }
}

/// What is known of a tree, and its number in a stand.
pub(super) fn extras(info: &TreeInfo, number: Option<usize>) -> serde_json::Value {
    let mut extras = serde_json::json!({
        "species": info.species,
        "age": info.age,
        "gravitropism": info.gravitropism,
        "seed": info.seed.to_string(),
    });
    if let Some(number) = number {
        extras["number"] = number.into();
    }
    extras
}

/// The tree's name: species and seed.
pub(super) fn name(info: &TreeInfo) -> String {
    let species = one_line(&info.species);
    format!("{} {}", if species.is_empty() { "tree" } else { &species }, info.seed)
}

/// The only buffer.
pub(super) fn buffer(length: u64, uri: Option<String>) -> json::Buffer {
    json::Buffer { byte_length: USize64(length), name: None, uri, extensions: None, extras: None }
}

/// A part of the only buffer.
pub(super) fn view(offset: u64, length: u64, target: Option<Target>) -> json::buffer::View {
    json::buffer::View {
        buffer: Index::new(0),
        byte_length: USize64(length),
        byte_offset: Some(USize64(offset)),
        byte_stride: None,
        target: target.map(Checked::Valid),
        name: None,
        extensions: None,
        extras: None,
    }
}

/// All of a view.
pub(super) fn accessor(
    view: Index<json::buffer::View>,
    count: usize,
    component: ComponentType,
    kind: Type,
) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: None,
        count: USize64(count as u64),
        component_type: Checked::Valid(GenericComponentType(component)),
        type_: Checked::Valid(kind),
        min: None,
        max: None,
        normalized: false,
        sparse: None,
        name: None,
        extensions: None,
        extras: None,
    }
}
