//! Clouds for tests.

use deeptree_graph::Vec3;

use crate::{Attributes, Class, Cloud, Columns};

/// A small cloud with every column, on a grid that also LAS holds exactly.
pub(crate) fn labelled(origin: [f64; 3]) -> Cloud {
    let mut columns = Columns::with([true; 6]);
    let step = Vec3::new(1.0, -0.5, 0.25) / 1024.0;
    let points: Vec<Vec3> = (0..500).map(|i| step * (i as f32 - 70.0)).collect();
    for i in 0..500u16 {
        columns.push(&Attributes {
            intensity: f32::from(i) * 100.0,
            class: [Class::Wood, Class::Leaf, Class::Ground, Class::Other(7)][usize::from(i % 4)],
            branch: u32::MAX - u32::from(i),
            order: i,
            node: u32::from(i) << 20,
            station: 65535 - i,
        });
    }
    Cloud { origin, points, columns, ..Cloud::default() }
}

/// Far from the origin of a map.
pub(crate) const FAR: [f64; 3] = [448_262.0, 5_411_932.0, 1170.0];
