//! Wood of at most so many triangles.

use deeptree_graph::BranchGraph;

use crate::mesh::Mesh;
use crate::options::WoodOptions;
use crate::tubes::MIN_RADIUS;

/// Steps from one level of detail to the next, and those beyond the last, that leave out laterals.
const STEPS: u32 = 10;
const LEAVING_OUT: u32 = 20;

/// Why there is no mesh of so few triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{asked} triangles are too few: the trunk alone takes {least}; ask for that many or more")]
pub struct BudgetError {
    /// How many it was to have at most.
    pub asked: usize,
    /// How many it takes at least.
    pub least: usize,
}

/// Meshes a tree with at most `triangles` triangles, as finely as that allows.
///
/// Between and beyond the levels of detail there is a row of ever coarser options; beyond the
/// last level, laterals are left out, the thinnest first. The finest of the row that keeps within
/// the budget is found by halving; `mesh` is [`wood`](crate::wood()) or [`tubes`](crate::tubes()).
/// Bark and the like are as in `options`.
///
/// # Errors
///
/// When the coarsest mesh has more triangles.
pub fn within(
    tree: &BranchGraph,
    triangles: usize,
    options: &WoodOptions,
    mesh: fn(&BranchGraph, &WoodOptions) -> Mesh,
) -> Result<Mesh, BudgetError> {
    let fits = |step: u32| {
        let mesh = mesh(tree, &step_options(tree, step, options));
        let count = mesh.triangle_count();
        if count <= triangles { Ok(mesh) } else { Err(count) }
    };
    // The finest step that is known to fit, and the coarsest known not to.
    let last = 3 * STEPS + LEAVING_OUT;
    if let Ok(mesh) = fits(0) {
        return Ok(mesh);
    }
    let mut best = fits(last).map_err(|least| BudgetError { asked: triangles, least })?;
    let (mut over, mut under) = (0, last);
    while over + 1 < under {
        let step = u32::midpoint(over, under);
        match fits(step) {
            Ok(mesh) => (best, under) = (mesh, step),
            Err(_) => over = step,
        }
    }
    Ok(best)
}

/// The options of a step: 0 is the finest.
fn step_options(tree: &BranchGraph, step: u32, options: &WoodOptions) -> WoodOptions {
    let level = (step / STEPS).min(3);
    let share = if level < 3 { (step % STEPS) as f32 / STEPS as f32 } else { 0.0 };
    let (fine, coarse) = (WoodOptions::lod(level as u8), WoodOptions::lod(level as u8 + 1));
    let sides = |a: u32, b: u32| (a as f32 + (b as f32 - a as f32) * share + 0.5) as u32;
    let between = |a: f32, b: f32| a * libm::powf(b / a, share);
    let mut min_radius = options.min_radius;
    if step > 3 * STEPS {
        // From the thinnest lateral to beyond the thickest.
        let radii = || tree.nodes().iter().map(|node| node.thickness.max(MIN_RADIUS));
        let (low, high) = radii().fold((f32::INFINITY, 0.0f32), |(a, b), r| (a.min(r), b.max(r)));
        let share = (step - 3 * STEPS) as f32 / LEAVING_OUT as f32;
        min_radius = min_radius.max(1.01 * low * libm::powf(high / low, share));
    }
    WoodOptions {
        min_sides: sides(fine.min_sides, coarse.min_sides),
        max_sides: sides(fine.max_sides, coarse.max_sides),
        tolerance: between(fine.tolerance, coarse.tolerance),
        axis_tolerance: between(fine.axis_tolerance, coarse.axis_tolerance),
        collar_rings: sides(fine.collar_rings, coarse.collar_rings),
        min_radius,
        ..*options
    }
}
