//! What is known of each point besides its place.

/// What a point lies on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Class {
    /// The ground.
    Ground,
    /// Trunk or branch.
    Wood,
    /// Leaf or needle.
    Leaf,
    /// Anything else, with its number in files; 0 is "never classified".
    Other(u8),
}

impl Default for Class {
    fn default() -> Self {
        Self::Other(0)
    }
}

impl Class {
    /// The class's number in files: the codes of the LAS specification (1.4 R15, table 17), where
    /// 2 is "ground", and 64 to 255 are free: 64 is wood, 65 a leaf.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Ground => 2,
            Self::Wood => 64,
            Self::Leaf => 65,
            Self::Other(code) => code,
        }
    }

    /// The class with this number.
    #[must_use]
    pub const fn from_code(code: u8) -> Self {
        match code {
            2 => Self::Ground,
            64 => Self::Wood,
            65 => Self::Leaf,
            other => Self::Other(other),
        }
    }
}

/// The attributes of one point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attributes {
    /// Strength of the echo as the scanner gives it; LAS knows whole numbers to 65535.
    pub intensity: f32,
    /// What it lies on.
    pub class: Class,
    /// Number of the Gravelius branch, as an index into `deeptree_graph::branches`.
    pub branch: u32,
    /// Gravelius order of that branch; the trunk has 0.
    pub order: u16,
    /// Node of the branch graph whose internode it lies on.
    pub node: u32,
    /// Place that the scanner stood at, counted from 0.
    pub station: u16,
}

/// The attributes of all points; those that are not known are missing as a whole.
///
/// # Shapes
///
/// Each column that is there is as long as the cloud.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Columns {
    /// See [`Attributes::intensity`].
    pub intensity: Option<Vec<f32>>,
    /// See [`Attributes::class`].
    pub class: Option<Vec<Class>>,
    /// See [`Attributes::branch`].
    pub branch: Option<Vec<u32>>,
    /// See [`Attributes::order`].
    pub order: Option<Vec<u16>>,
    /// See [`Attributes::node`].
    pub node: Option<Vec<u32>>,
    /// See [`Attributes::station`].
    pub station: Option<Vec<u16>>,
}

impl Columns {
    /// Names of the columns in files, in their order.
    pub const NAMES: [&'static str; 6] =
        ["intensity", "class", "branch", "order", "node", "station"];

    /// Columns without rows: those of [`Columns::NAMES`] whose place in `present` is true.
    #[must_use]
    pub fn with(present: [bool; 6]) -> Self {
        fn column<T>(present: bool) -> Option<Vec<T>> {
            present.then(Vec::new)
        }
        Self {
            intensity: column(present[0]),
            class: column(present[1]),
            branch: column(present[2]),
            order: column(present[3]),
            node: column(present[4]),
            station: column(present[5]),
        }
    }

    /// Which of [`Columns::NAMES`] there are.
    #[must_use]
    pub fn present(&self) -> [bool; 6] {
        [
            self.intensity.is_some(),
            self.class.is_some(),
            self.branch.is_some(),
            self.order.is_some(),
            self.node.is_some(),
            self.station.is_some(),
        ]
    }

    /// The attributes of a point; those that are not known have their defaults.
    ///
    /// # Panics
    ///
    /// When a column is too short.
    #[must_use]
    pub fn get(&self, i: usize) -> Attributes {
        fn at<T: Copy + Default>(column: Option<&Vec<T>>, i: usize) -> T {
            column.map_or_else(T::default, |c| c[i])
        }
        Attributes {
            intensity: at(self.intensity.as_ref(), i),
            class: at(self.class.as_ref(), i),
            branch: at(self.branch.as_ref(), i),
            order: at(self.order.as_ref(), i),
            node: at(self.node.as_ref(), i),
            station: at(self.station.as_ref(), i),
        }
    }

    /// Adds a point's attributes to the columns that are there.
    pub fn push(&mut self, point: &Attributes) {
        fn add<T>(column: &mut Option<Vec<T>>, value: T) {
            if let Some(column) = column {
                column.push(value);
            }
        }
        add(&mut self.intensity, point.intensity);
        add(&mut self.class, point.class);
        add(&mut self.branch, point.branch);
        add(&mut self.order, point.order);
        add(&mut self.node, point.node);
        add(&mut self.station, point.station);
    }

    /// Keeps the points with these ascending numbers.
    pub(crate) fn keep(&mut self, kept: &[u32]) {
        fn only<T: Copy>(column: &mut Option<Vec<T>>, kept: &[u32]) {
            if let Some(column) = column {
                keep(column, kept);
            }
        }
        only(&mut self.intensity, kept);
        only(&mut self.class, kept);
        only(&mut self.branch, kept);
        only(&mut self.order, kept);
        only(&mut self.node, kept);
        only(&mut self.station, kept);
    }
}

/// Keeps the entries with these ascending numbers, in place.
pub(crate) fn keep<T: Copy>(values: &mut Vec<T>, kept: &[u32]) {
    for (to, &from) in kept.iter().enumerate() {
        values[to] = values[from as usize];
    }
    values.truncate(kept.len());
}
