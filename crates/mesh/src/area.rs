//! How much leaf there is.

use deeptree_graph::Vec3;

use crate::dressed::{Blade, Dressed, Foliage, Leaf};
use crate::material::Image;

/// Side of the squares of ground that a crown is over, in metres.
const SQUARE: f32 = 0.5;

impl Leaf {
    /// From the blade's own frame to the world.
    #[must_use]
    pub fn place(&self, p: Vec3) -> Vec3 {
        self.position + self.rotation * (p * self.scale)
    }
}

impl Foliage {
    /// The area of all leaves, one side of each, in square metres: what of the blades' triangles
    /// their texture shows. The twigs of shoots count with half of their surface.
    #[must_use]
    pub fn area(&self) -> f64 {
        let shown = match (&self.material.color_image, self.material.alpha_cutoff) {
            (Some(image), Some(cutoff)) if image.channels == 4 => {
                shown_area(&self.blade, image, cutoff)
            }
            _ => corners(&self.blade).map(|(corners, _)| area(corners)).sum(),
        };
        self.leaves.iter().map(|leaf| f64::from(leaf.scale) * f64::from(leaf.scale) * shown).sum()
    }
}

impl Dressed {
    /// The area of all leaves, one side of each, in square metres.
    #[must_use]
    pub fn leaf_area(&self) -> f64 {
        self.leafy().map(Foliage::area).sum()
    }

    fn leafy(&self) -> impl Iterator<Item = &Foliage> {
        self.foliage.iter().filter(|foliage| !foliage.woody)
    }

    /// Leaf area over the ground that the crown is above; 0 without leaves.
    ///
    /// The ground is counted in squares of half a metre above which there is a shoot.
    #[must_use]
    pub fn leaf_area_index(&self) -> f64 {
        let mut squares: Vec<[i32; 2]> = self
            .leafy()
            .flat_map(|foliage| &foliage.leaves)
            .flat_map(|leaf| [leaf.position, leaf.place(Vec3::NEG_Z)])
            .map(|p| [p.x, p.z].map(|x| libm::floorf(x / SQUARE) as i32))
            .collect();
        squares.sort_unstable();
        squares.dedup();
        let ground = squares.len() as f64 * f64::from(SQUARE * SQUARE);
        if ground > 0.0 { self.leaf_area() / ground } else { 0.0 }
    }
}

fn corners(blade: &Blade) -> impl Iterator<Item = ([Vec3; 3], [[f32; 2]; 3])> + '_ {
    blade
        .indices
        .as_chunks::<3>()
        .0
        .iter()
        .map(|t| (t.map(|i| blade.positions[i as usize]), t.map(|i| blade.uvs[i as usize])))
}

fn area([a, b, c]: [Vec3; 3]) -> f64 {
    f64::from((b - a).cross(c - a).length()) / 2.0
}

/// The area of a blade's triangles where the picture's alpha reaches `cutoff`.
fn shown_area(blade: &Blade, image: &Image, cutoff: f32) -> f64 {
    const STEPS: u32 = 48;
    let shows = |[u, v]: [f32; 2]| {
        let column = (u.clamp(0.0, 1.0) * image.width as f32) as u32;
        let row = ((1.0 - v).clamp(0.0, 1.0) * image.height as f32) as u32;
        let at = row.min(image.height - 1) * image.width + column.min(image.width - 1);
        f32::from(image.pixels[4 * at as usize + 3]) >= 255.0 * cutoff
    };
    let share = |uvs: [[f32; 2]; 3]| {
        let (mut seen, mut all) = (0u32, 0u32);
        // The middles of the small triangles of a grid over the triangle.
        for i in 0..STEPS {
            for j in 0..STEPS - i {
                let (a, b) = ((i as f32 + 0.33) / STEPS as f32, (j as f32 + 0.33) / STEPS as f32);
                let at = |k: usize| {
                    uvs[0][k] + (uvs[1][k] - uvs[0][k]) * a + (uvs[2][k] - uvs[0][k]) * b
                };
                seen += u32::from(shows([at(0), at(1)]));
                all += 1;
            }
        }
        f64::from(seen) / f64::from(all)
    };
    corners(blade).map(|(corners, uvs)| area(corners) * share(uvs)).sum()
}
