//! How the trees of a species change with age and gravitropism.

use deeptree_graph::TreeTraits;

use crate::weights::{ReadWeightsError, Weights};

/// Columns of a trend: age, gravitropism, and the state.
pub const TREND_COLUMNS: usize = 2 + TreeTraits::STATES;

/// The mean state of a species' trees, as [`TreeTraits::state`] has it, over age and gravitropism: at
/// each full age between two, and at some gravitropisms.
#[derive(Clone, Debug, PartialEq)]
pub struct Trend {
    /// The lowest age, in growth cycles.
    youngest: f64,
    /// Rising.
    gravitropisms: Vec<f64>,
    /// By age, then by gravitropism.
    states: Vec<[f64; TreeTraits::STATES]>,
}

impl Trend {
    /// Reads the table `trend.<species>`, if there is one: [`TREND_COLUMNS`] numbers a row, a row for each
    /// age and gravitropism, ages one after the other and gravitropisms rising.
    ///
    /// # Errors
    ///
    /// When the table is no such grid, or has numbers that no tree has.
    pub fn read(weights: &Weights, species: &str) -> Result<Option<Self>, ReadWeightsError> {
        let name = format!("trend.{species}");
        if !weights.contains(&name) {
            return Ok(None);
        }
        let table = weights.table(&name, &[None, Some(TREND_COLUMNS)])?;
        let broken = |row: usize| ReadWeightsError::NotATrend { tensor: name.clone(), row };
        let rows: Vec<&[f32]> = (0..table.rows()).map(|row| table.row(row)).collect();
        let first = rows.first().ok_or_else(|| broken(0))?;
        let columns = rows.iter().take_while(|row| row[0].to_bits() == first[0].to_bits()).count();
        let youngest = f64::from(first[0]);
        for (number, row) in rows.iter().enumerate() {
            let (above, column) = (number / columns, number % columns);
            let is_in_place = f64::from(row[0]) == youngest + above as f64
                && row[1].to_bits() == rows[column][1].to_bits()
                && (column == 0 || rows[column - 1][1] < row[1]);
            if !(is_in_place && is_mean(&row[2..])) {
                return Err(broken(number));
            }
        }
        if !rows.len().is_multiple_of(columns) {
            return Err(broken(rows.len()));
        }
        Ok(Some(Self {
            youngest,
            gravitropisms: rows[..columns].iter().map(|row| f64::from(row[1])).collect(),
            states: rows.iter().map(|row| std::array::from_fn(|i| f64::from(row[2 + i]))).collect(),
        }))
    }

    /// The mean state at an age and a gravitropism: linear between those that are known, as at the
    /// nearest of them beyond.
    #[must_use]
    pub fn at(&self, age: f32, gravitropism: f32) -> [f64; TreeTraits::STATES] {
        let columns = self.gravitropisms.len();
        let oldest = (self.states.len() / columns - 1) as f64;
        let (row, down) = split((f64::from(age) - self.youngest).clamp(0.0, oldest));
        let (column, right) = split(self.column(f64::from(gravitropism)));
        let state = |row: usize, column: usize| {
            self.states[row.min(oldest as usize) * columns + column.min(columns - 1)]
        };
        let corners = [
            state(row, column),
            state(row, column + 1),
            state(row + 1, column),
            state(row + 1, column + 1),
        ];
        std::array::from_fn(|i| {
            let across = |k: usize| corners[k][i] + right * (corners[k + 1][i] - corners[k][i]);
            across(0) + down * (across(2) - across(0))
        })
    }

    /// Where a gravitropism lies among those that are known, in columns.
    fn column(&self, gravitropism: f64) -> f64 {
        let after = self.gravitropisms.partition_point(|known| *known <= gravitropism);
        let Some(left) = after.checked_sub(1) else { return 0.0 };
        let Some(right) = self.gravitropisms.get(after) else { return left as f64 };
        let low = self.gravitropisms[left];
        left as f64 + (gravitropism - low) / (right - low)
    }
}

/// The whole and the broken part of a number that is not negative.
fn split(x: f64) -> (usize, f64) {
    let whole = libm::floor(x);
    (whole as usize, x - whole)
}

/// Can trees have this mean state? Fits may reach a little beyond what trees can be.
fn is_mean(state: &[f32]) -> bool {
    let range = |i: usize| if i < 2 || i == 3 { -1.0..23.0 } else { -100.0..1e4 };
    state.iter().enumerate().all(|(i, x)| range(i).contains(x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::weights::{ModelKind, Table, WeightsBuilder};

    /// A trend of the ages 10, 11 and 12 and two gravitropisms.
    fn table() -> Vec<f32> {
        let rows =
            [(10.0, -0.5), (10.0, 0.5), (11.0, -0.5), (11.0, 0.5), (12.0, -0.5), (12.0, 0.5)];
        let row = |(age, v): (f32, f32)| {
            let mut row = vec![age, v];
            row.extend((0..TreeTraits::STATES).map(|i| age + i as f32 * v));
            row
        };
        rows.into_iter().flat_map(row).collect()
    }

    fn read_table(values: Vec<f32>) -> Result<Option<Trend>, ReadWeightsError> {
        let mut builder = WeightsBuilder::new(ModelKind::Situated, &["yew".to_owned()]);
        let rows = values.len() / TREND_COLUMNS;
        builder.table("trend.yew", Table::new(vec![rows, TREND_COLUMNS], values)?);
        Trend::read(&Weights::from_bytes(&builder.to_bytes()?)?, "yew")
    }

    #[test]
    fn a_trend_is_bilinear_and_ends_where_it_ends() {
        let trend = read_table(table()).unwrap().unwrap();
        for (age, v) in [(10.0f32, 0.5f32), (12.0, -0.5), (11.0, 0.0), (10.25, 0.1), (11.75, -0.3)]
        {
            let state = trend.at(age, v);
            for (i, x) in state.into_iter().enumerate() {
                assert!((x - f64::from(age) - i as f64 * f64::from(v)).abs() < 1e-6);
            }
        }
        assert_eq!(trend.at(3.0, -2.0), trend.at(10.0, -0.5));
        assert_eq!(trend.at(99.0, 2.0), trend.at(12.0, 0.5));
    }

    #[test]
    fn one_age_and_gravitropism_are_a_trend() {
        let trend = read_table(table()[..TREND_COLUMNS].to_vec()).unwrap().unwrap();
        assert_eq!(trend.at(40.0, 0.3), trend.at(10.0, -0.5));
    }

    #[test]
    fn what_is_no_grid_is_refused_with_its_row() {
        let broken = |at: usize, value: f32| {
            let mut values = table();
            values[at] = value;
            match read_table(values) {
                Err(ReadWeightsError::NotATrend { row, .. }) => row,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(broken(2 * TREND_COLUMNS, 13.0), 2);
        assert_eq!(broken(3 * TREND_COLUMNS + 1, 0.25), 3);
        assert_eq!(broken(TREND_COLUMNS + 1, -0.5), 1);
        assert_eq!(broken(4 * TREND_COLUMNS + 5, 1e9), 4);
        let short = table()[..5 * TREND_COLUMNS].to_vec();
        assert!(matches!(read_table(short), Err(ReadWeightsError::NotATrend { row: 5, .. })));
    }
}
