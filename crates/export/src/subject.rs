//! What is written: the surfaces of a tree, and what they are made of.

use std::sync::LazyLock;

use deeptree_mesh::{Dressed, Foliage, Material, Mesh};

/// Bark without a picture: a grey brown that reflects about a tenth of the light.
static WOOD: LazyLock<Material> = LazyLock::new(|| Material {
    name: "wood".to_owned(),
    color: [0.13, 0.095, 0.07, 1.0],
    color_image: None,
    normal_image: None,
    roughness: 0.9,
    roughness_image: None,
    translucency: 0.0,
    alpha_cutoff: None,
    double_sided: false,
});

/// The surfaces of a tree, borrowed: of a bare [`Mesh`] or of a [`Dressed`] tree.
///
/// All nodes that vertices and leaves name are among [`Mesh::internodes`], and materials of different
/// looks have different names, as [`dress`](deeptree_mesh::dress) makes them; writers that need a
/// node's internode panic otherwise.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The surface of trunk and branches.
    pub wood: &'a Mesh,
    /// What it is made of.
    pub bark: &'a Material,
    /// Leaves, kind by kind.
    pub foliage: &'a [Foliage],
}

impl<'a> From<&'a Mesh> for Subject<'a> {
    /// Wood in a plain brown.
    fn from(wood: &'a Mesh) -> Self {
        Self { wood, bark: &WOOD, foliage: &[] }
    }
}

impl<'a> From<&'a Dressed> for Subject<'a> {
    fn from(dressed: &'a Dressed) -> Self {
        Self { wood: &dressed.wood, bark: &dressed.bark, foliage: &dressed.foliage }
    }
}

/// The alpha below which a file says that there is no surface.
///
/// Programs look at pictures of leaves through mipmaps, whose alpha is a mean: at the material's own
/// cutoff, 0.5, a crown loses leaves as it goes away, at half of it they become squares. Of an oak of
/// 24 m in three.js, a cutoff of a third shows what it shows without mipmaps within 7 %, with 256 and
/// with 900 rows (0.5: 57 and 4 % less; 0.25: 10 and 11 % more). From near, it makes a leaf larger by
/// a part of a texel.
pub(crate) fn cutoff(material: &Material) -> Option<f32> {
    material.alpha_cutoff.map(|cutoff| cutoff * 2.0 / 3.0)
}

impl<'a> Subject<'a> {
    /// The materials, each once: the bark, then those of the leaves.
    pub(crate) fn materials(self) -> Vec<&'a Material> {
        let mut all = vec![self.bark];
        for kind in self.leaves() {
            if !all.contains(&&kind.material) {
                all.push(&kind.material);
            }
        }
        all
    }

    /// The kinds of leaf with a name for each: that of its material, with a number from the second
    /// of the same on.
    pub(crate) fn named_leaves(self) -> Vec<(String, &'a Foliage)> {
        let mut all: Vec<(String, &Foliage)> = Vec::new();
        for kind in self.leaves() {
            let name = &kind.material.name;
            let before = all.iter().filter(|(_, known)| known.material.name == *name).count();
            let name = if before == 0 { name.clone() } else { format!("{name} {}", before + 1) };
            all.push((name, kind));
        }
        all
    }

    /// The kinds of leaf of which something is to be seen.
    pub(crate) fn leaves(self) -> impl Iterator<Item = &'a Foliage> {
        self.foliage.iter().filter(|kind| !kind.leaves.is_empty() && !kind.blade.indices.is_empty())
    }
}
