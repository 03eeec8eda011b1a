//! Fields by their names in files.

use crate::columns::{Attributes, Class, Columns};

/// The field that a name means: in small letters, without the prefix of `CloudCompare`.
pub(crate) fn field(name: &str) -> String {
    let name = name.trim_matches('"').to_ascii_lowercase();
    let name = name.strip_prefix("scalar_").unwrap_or(&name);
    match name {
        "classification" | "label" => "class".to_owned(),
        other => other.to_owned(),
    }
}

/// Which column is which field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Layout {
    place: [usize; 3],
    attributes: [Option<usize>; 6],
}

impl Layout {
    /// The place first, and nothing else.
    pub(crate) const PLAIN: Self = Self { place: [0, 1, 2], attributes: [None; 6] };

    /// The layout of columns of these names, if they name the three coordinates.
    pub(crate) fn of_names(names: &[&str]) -> Option<Self> {
        let find = |wanted: &str| names.iter().position(|name| field(name) == wanted);
        let place = [find("x")?, find("y")?, find("z")?];
        Some(Self { place, attributes: Columns::NAMES.map(find) })
    }

    /// Which of [`Columns::NAMES`] there are.
    pub(crate) fn present(&self) -> [bool; 6] {
        self.attributes.map(|a| a.is_some())
    }

    /// How many columns of a row are looked at.
    pub(crate) fn width(&self) -> usize {
        let attributes = self.attributes.into_iter().flatten();
        attributes.chain(self.place).max().unwrap_or_default() + 1
    }

    /// The point of a row of fields, if it has all three coordinates.
    pub(crate) fn point(&self, row: &[Option<f64>]) -> Option<([f64; 3], Attributes)> {
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
