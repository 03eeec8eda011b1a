//! Boxes around a tree, as pale outlines behind it.

use deeptree_graph::{BranchGraph, Vec3};
use tiny_skia::{FillRule, Paint, PathBuilder, Pixmap, Stroke, Transform};

use super::ink;
use super::view::View;

/// Lightness of a box, and of its outline.
const FACE: f32 = 0.88;
const EDGE: f32 = 0.68;

/// Draws the outline of a box; `origin` is the pixel of the tree's foot, `scale` pixels a metre.
pub(super) fn draw(
    pixmap: &mut Pixmap,
    tree: &BranchGraph,
    corners: &[Vec3; 8],
    view: View,
    scale: f32,
    origin: (f32, f32),
) {
    let (axes, foot) = (view.axes(), tree.root().base());
    let place = |corner: &Vec3| {
        let seen = scale * axes.look(*corner - foot);
        [origin.0 + seen.x, origin.1 - seen.y]
    };
    let mut builder = PathBuilder::new();
    for [x, y] in hull(corners.iter().map(place).collect()) {
        if builder.is_empty() {
            builder.move_to(x, y);
        } else {
            builder.line_to(x, y);
        }
    }
    builder.close();
    let Some(path) = builder.finish() else { return };
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color(ink::grey(FACE));
    pixmap.fill_path(&path, &paint, FillRule::Winding, Transform::identity(), None);
    paint.set_color(ink::grey(EDGE));
    pixmap.stroke_path(&path, &paint, &Stroke::default(), Transform::identity(), None);
}

/// The corners of the convex hull of points, all turned the same way round.
///
/// # Source
///
/// Andrew 1979, "Another efficient algorithm for convex hulls in two dimensions".
fn hull(mut points: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let half = |points: &mut dyn Iterator<Item = [f32; 2]>| {
        let mut chain: Vec<[f32; 2]> = Vec::new();
        for point in points {
            while let [.., a, b] = chain[..]
                && (b[0] - a[0]) * (point[1] - a[1]) <= (b[1] - a[1]) * (point[0] - a[0])
            {
                chain.pop();
            }
            chain.push(point);
        }
        // The last is the first of the other half.
        chain.pop();
        chain
    };
    let mut all = half(&mut points.iter().copied());
    all.extend(half(&mut points.iter().rev().copied()));
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_has_the_corners_and_nothing_within() {
        let square = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]];
        let within = [[2.0, 2.0], [2.0, 0.0], [1.0, 3.0], [4.0, 1.0]];
        let found = hull([&within[..], &square[..]].concat());
        assert_eq!(found, square);
    }
}
