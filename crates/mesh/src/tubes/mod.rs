//! The simple way: one closed tube along each Gravelius branch, pushed into one another at forks.

mod stations;
mod tube;

use deeptree_graph::{BranchGraph, Path, branches};

pub use stations::{MIN_EDGE, MIN_RADIUS};

use crate::internode::Internode;
use crate::mesh::{Mesh, Tube};
use crate::options::WoodOptions;
use stations::{Station, push_branch};
use tube::{Shape, Writer};

use crate::circle::circle;

/// A branch that has a tube.
struct Plan {
    branch: u32,
    order: u16,
    /// Where its stations end; they start where those of the plan before end.
    stations_end: usize,
    shape: Shape,
}

/// Meshes the wood of a tree the simple way: one closed tube along each Gravelius branch.
///
/// For low budgets, and where speed is all: fewer vertices than [`wood`](crate::wood()), but tubes
/// interpenetrate where branches fork.
///
/// - Rings stand where the branch starts and at its nodes, in the plane that halves the bend;
///   radii go linearly from node to node, at least [`MIN_RADIUS`].
/// - A lateral starts on the axis of its parent, never thicker than it, so there is no gap.
/// - Tips are closed by a cone, or by a dome where they are thick or laterals leave from them; both
///   end one radius beyond the node. The foot of the trunk is a flat disc.
/// - Nodes closer than [`MIN_EDGE`] or half a radius share a ring; a branch without any extent has
///   no tube.
///
/// Each tube is closed and manifold once it is [welded](Mesh::welded).
///
/// # Panics
///
/// When `options` do not pass [`WoodOptions::validate`], or the mesh would have 2³² indices.
#[must_use]
pub fn tubes(tree: &BranchGraph, options: &WoodOptions) -> Mesh {
    if let Err(error) = options.validate() {
        panic!("wood options: {error}");
    }
    let (stations, plans) = plan(tree, options);
    let mut mesh = reserve(&plans);
    mesh.internodes = Internode::all(tree);
    let circles: Vec<_> =
        (0..=options.max_sides).map(|n| if n < 3 { Vec::new() } else { circle(n) }).collect();
    let mut start = 0;
    for plan in &plans {
        let first = (mesh.positions.len() as u32, mesh.indices.len() as u32);
        let mut writer = Writer { mesh: &mut mesh, texture_size: options.texture_size };
        let sides = plan.shape.sides as usize;
        writer.tube(&stations[start..plan.stations_end], &plan.shape, &circles[sides]);
        start = plan.stations_end;
        mesh.tubes.push(Tube {
            branch: plan.branch,
            order: plan.order,
            vertices: first.0..mesh.positions.len() as u32,
            indices: first.1..mesh.indices.len() as u32,
        });
    }
    mesh
}

/// The stations of all branches, and what is to be built along them.
fn plan(tree: &BranchGraph, options: &WoodOptions) -> (Vec<Station>, Vec<Plan>) {
    let branches = branches(tree);
    let mut stations = Vec::with_capacity(tree.len() + branches.len());
    let mut plans = Vec::with_capacity(branches.len());
    for (branch, path) in branches.iter().enumerate() {
        let first = tree.node(path.nodes[0]);
        // The root's own branch is never left out.
        if first.parent.is_some() && first.thickness < options.min_radius {
            continue;
        }
        let start = stations.len();
        push_branch(tree, path, options, &mut stations);
        if stations.len() == start {
            continue;
        }
        plans.push(Plan {
            branch: branch as u32,
            order: first.order,
            stations_end: stations.len(),
            shape: Shape::new(
                &stations[start..],
                options,
                first.parent.is_none(),
                forks_at_tip(tree, path),
            ),
        });
    }
    (stations, plans)
}

/// Whether laterals leave from the end of a branch, as where an apical bud has died.
fn forks_at_tip(tree: &BranchGraph, path: &Path) -> bool {
    tree.node(path.nodes[path.nodes.len() - 1]).child_count() > 0
}

/// An empty mesh with room for exactly what is planned.
fn reserve(plans: &[Plan]) -> Mesh {
    let (mut vertices, mut indices, mut start) = (0, 0, 0);
    for plan in plans {
        let stations = plan.stations_end - start;
        vertices += plan.shape.vertex_count(stations);
        indices += plan.shape.index_count(stations);
        start = plan.stations_end;
    }
    assert!(u32::try_from(indices).is_ok(), "{vertices} vertices and {indices} indices: too many");
    Mesh {
        positions: Vec::with_capacity(vertices),
        normals: Vec::with_capacity(vertices),
        uvs: Vec::with_capacity(vertices),
        nodes: Vec::with_capacity(vertices),
        indices: Vec::with_capacity(indices),
        tubes: Vec::with_capacity(plans.len()),
        ..Mesh::default()
    }
}
