//! Which column of a text file is what.

use crate::columns::{Attributes, Class, Columns};

/// Columns beyond this are not looked at.
pub(super) const MOST: usize = 64;

/// Which column of a row is which field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Layout {
    place: [usize; 3],
    attributes: [Option<usize>; 6],
}

impl Layout {
    /// The place first, and nothing else.
    pub(super) const PLAIN: Self = Self { place: [0, 1, 2], attributes: [None; 6] };

    /// The layout that a line of names describes, if it names the three coordinates.
    pub(super) fn of_names(names: &[&str]) -> Option<Self> {
        let find = |wanted: &str| names.iter().position(|name| field(name) == wanted);
        let place = [find("x")?, find("y")?, find("z")?];
        Some(Self { place, attributes: Columns::NAMES.map(find) })
    }

    pub(super) fn present(&self) -> [bool; 6] {
        self.attributes.map(|a| a.is_some())
    }

    /// How many columns of a row are looked at.
    pub(super) fn width(&self) -> usize {
        let attributes = self.attributes.into_iter().flatten();
        attributes.chain(self.place).max().unwrap_or_default() + 1
    }

    /// The point of a row of fields, if it has all three coordinates.
    pub(super) fn point(&self, row: &[Option<f64>]) -> Option<([f64; 3], Attributes)> {
        let at = |k: usize| row.get(k).copied().flatten();
        let place = [at(self.place[0])?, at(self.place[1])?, at(self.place[2])?];
        let value = |k: usize| self.attributes[k].and_then(at).unwrap_or_default();
        // Casts saturate, and NaN is 0.
        let attributes = Attributes {
            intensity: value(0) as f32,
            class: Class::from_code(value(1) as u8),
            branch: value(2) as u32,
            order: value(3) as u16,
            node: value(4) as u32,
            station: value(5) as u16,
        };
        Some((place, attributes))
    }
}

/// The field that a name means: in small letters, without the prefix of `CloudCompare`.
pub(crate) fn field(name: &str) -> String {
    let name = name.trim_matches('"').to_ascii_lowercase();
    let name = name.strip_prefix("scalar_").unwrap_or(&name);
    match name {
        "classification" | "label" => "class".to_owned(),
        other => other.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_may_stand_in_any_order() {
        let layout = Layout::of_names(&["id", "Z", "y", "X", "Scalar_Intensity"]).unwrap();
        let (place, attributes) = layout.point(&[7.0, 3.0, 2.0, 1.0, 9.0].map(Some)).unwrap();
        assert_eq!(place, [1.0, 2.0, 3.0]);
        assert_eq!(attributes.intensity, 9.0);
    }
}
