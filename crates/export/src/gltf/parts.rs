//! The properties of vertices, and their numbers.

use std::io::{self, Write};

use deeptree_mesh::Internode;
use gltf_json::accessor::Type;
use gltf_json::mesh::Semantic;

use crate::numbers::write_floats;
use crate::surface::Surface;

/// What is written of each vertex besides position, normal and texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attributes {
    /// `TANGENT`, for normal maps; what has a normal map has tangents in any case.
    pub tangents: bool,
    /// `_BRANCH`, `_ORDER` and `_NODE`: number of the Gravelius branch, its order, and number of
    /// the node in the branch graph; as floats, for vertices may not hold integers of 32 bits.
    pub labels: bool,
    /// `_PIVOT`, `_PHASE` and `_STIFFNESS`: where the branch swings about in the wind in metres,
    /// when as a share of a period, and its radius as a share of the trunk's. Leaves have those of
    /// the internode that they stand on.
    pub wind: bool,
}

/// One property of all vertices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Part {
    Position,
    Normal,
    TexCoord,
    Tangent,
    Branch,
    Order,
    Node,
    Pivot,
    Phase,
    Stiffness,
}

impl Part {
    /// The properties that are written.
    pub(super) fn all(wanted: Attributes) -> Vec<Self> {
        let mut all = vec![Self::Position, Self::Normal, Self::TexCoord];
        if wanted.tangents {
            all.push(Self::Tangent);
        }
        if wanted.labels {
            all.extend([Self::Branch, Self::Order, Self::Node]);
        }
        if wanted.wind {
            all.extend([Self::Pivot, Self::Phase, Self::Stiffness]);
        }
        all
    }

    pub(super) const fn kind(self) -> Type {
        match self {
            Self::Position | Self::Normal | Self::Pivot => Type::Vec3,
            Self::TexCoord => Type::Vec2,
            Self::Tangent => Type::Vec4,
            Self::Branch | Self::Order | Self::Node | Self::Phase | Self::Stiffness => Type::Scalar,
        }
    }

    /// Bytes a vertex.
    pub(super) fn bytes(self) -> u64 {
        4 * self.kind().multiplicity() as u64
    }

    pub(super) fn semantic(self) -> Semantic {
        let own = |name: &str| Semantic::Extras(name.to_owned());
        match self {
            Self::Position => Semantic::Positions,
            Self::Normal => Semantic::Normals,
            Self::TexCoord => Semantic::TexCoords(0),
            Self::Tangent => Semantic::Tangents,
            Self::Branch => own("BRANCH"),
            Self::Order => own("ORDER"),
            Self::Node => own("NODE"),
            Self::Pivot => own("PIVOT"),
            Self::Phase => own("PHASE"),
            Self::Stiffness => own("STIFFNESS"),
        }
    }

    /// Writes the property of all vertices; `internodes` are those of the tree, one a node.
    pub(super) fn write(
        self,
        surface: &impl Surface,
        internodes: &[Internode],
        out: &mut impl Write,
    ) -> io::Result<()> {
        let scalars = |out: &mut _, of: fn(&Internode) -> f32| {
            write_floats(out, surface.nodes().map(|node| [of(&internodes[node as usize])]))
        };
        match self {
            Self::Position => write_floats(out, surface.positions().map(|p| p.to_array())),
            Self::Normal => write_floats(out, surface.normals().map(|n| n.to_array())),
            // v runs downwards here.
            Self::TexCoord => write_floats(out, surface.uvs().map(|[u, v]| [u, 1.0 - v])),
            Self::Tangent => write_floats(out, surface.tangents()),
            Self::Branch => scalars(out, |internode| internode.branch as f32),
            Self::Order => scalars(out, |internode| f32::from(internode.order)),
            Self::Node => write_floats(out, surface.nodes().map(|node| [node as f32])),
            Self::Pivot => {
                let pivot = |node| internodes[node as usize].pivot.to_array();
                write_floats(out, surface.nodes().map(pivot))
            }
            Self::Phase => scalars(out, |internode| internode.phase),
            Self::Stiffness => scalars(out, |internode| internode.stiffness),
        }
    }
}
