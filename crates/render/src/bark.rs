//! What wood is made of where nothing says it.

use deeptree_mesh::Material;

/// Bark of one colour, without pictures: grey-brown, as most barks are from afar.
#[must_use]
pub fn plain_bark() -> Material {
    Material {
        name: "plain bark".to_owned(),
        color: [0.155, 0.125, 0.1, 1.0],
        color_image: None,
        normal_image: None,
        roughness: 0.85,
        roughness_image: None,
        translucency: 0.0,
        alpha_cutoff: None,
        double_sided: false,
    }
}
