use std::error::Error;

use deeptree_graph::testing::{mutated, random_tree};
use deeptree_graph::{BranchGraph, GraphError, TreeInfo};
use proptest::prelude::*;

use super::*;

fn info() -> TreeInfo {
    TreeInfo { species: "unknown".into(), age: 0, gravitropism: 0.0, seed: 0 }
}

fn written(trees: &[(u32, BranchGraph)]) -> Vec<u8> {
    let meta = TableMeta { model: Some("00ff".into()) };
    let mut writer = TableWriter::new(Vec::new(), &meta).unwrap();
    trees.iter().for_each(|(number, tree)| writer.write(*number, tree).unwrap());
    writer.finish().unwrap()
}

fn read(bytes: &[u8]) -> Result<Vec<(u32, BranchGraph)>, ReadTableError> {
    TableReader::from_bytes(bytes.to_vec(), info())?.collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn tables_read_back_as_the_same_bits(seed: u64, nodes in 1usize..200, count in 0u64..4) {
        let trees: Vec<_> = (0..count)
            .map(|k| (u32::MAX - k as u32, random_tree(seed.wrapping_add(k), nodes)))
            .collect();
        let bytes = written(&trees);
        let back = read(&bytes).unwrap();
        prop_assert_eq!(&back, &trees);
        // Equal bits, not only equal numbers: 0 and −0 are written differently.
        prop_assert_eq!(written(&back), bytes);
    }

    #[test]
    fn noise_is_an_error_and_never_a_panic(bytes: Vec<u8>) {
        prop_assert!(read(&bytes).is_err());
    }
}

#[test]
fn the_model_is_in_the_metadata() {
    let reader = TableReader::from_bytes(written(&[]), info()).unwrap();
    assert_eq!(reader.model(), Some("00ff"));
}

#[test]
fn what_stood_around_each_tree_is_in_the_metadata() {
    let meta = TableMeta { model: Some("00ff".into()) };
    let mut writer = TableWriter::new(Vec::new(), &meta).unwrap();
    for (number, text) in [(1, "form = \"cone\"\n"), (12, "")] {
        writer.write(number, &random_tree(3, 9)).unwrap();
        writer.note_environment(number, text);
    }
    let reader = TableReader::from_bytes(writer.finish().unwrap(), info()).unwrap();
    assert_eq!(reader.environment(1), Some("form = \"cone\"\n"));
    assert_eq!((reader.environment(12), reader.environment(2)), (Some(""), None));
    assert_eq!(reader.model(), Some("00ff"));
}

#[test]
fn trees_of_several_row_groups_and_batches_come_back() {
    let trees: Vec<_> = (0..4).map(|k| (k, random_tree(u64::from(k), 60_000))).collect();
    assert!(trees.iter().map(|(_, tree)| tree.len()).sum::<usize>() > 200_000);
    assert_eq!(read(&written(&trees)).unwrap(), trees);
}

#[test]
fn rows_of_a_tree_apart_are_an_error_that_names_the_row() {
    let trees = [(3, random_tree(1, 5)), (4, random_tree(2, 5)), (3, random_tree(3, 5))];
    let row = 1 + (trees[0].1.len() + trees[1].1.len()) as u64;
    let error = read(&written(&trees)).unwrap_err();
    assert!(matches!(error, ReadTableError::TreeApart { row: r, tree: 3 } if r == row), "{error}");
}

#[test]
fn two_trees_under_one_number_are_an_error() {
    let one = random_tree(1, 5);
    let error = read(&written(&[(3, one.clone()), (3, one)])).unwrap_err();
    assert!(matches!(error, ReadTableError::Graph { tree: 3, row: 1, .. }), "{error}");
    let source = error.source().unwrap().downcast_ref::<GraphError>().unwrap();
    assert!(matches!(source, GraphError::DuplicateId { row: 6, id: 0, first: 1 }), "{source}");
    let error = read(&written(&[(3, random_tree(1, 5)), (3, random_tree(2, 5))])).unwrap_err();
    assert!(matches!(error, ReadTableError::InfoChanges { row: 6, tree: 3 }), "{error}");
}

#[test]
fn mutated_tables_never_panic() {
    let valid = written(&[(0, random_tree(1, 40)), (1, random_tree(2, 40))]);
    for seed in 0..20_000 {
        let _ = read(&mutated(&valid, seed));
    }
}

/// A table as other programs write it: 64-bit numbers, columns that may hold nulls, other order,
/// the columns that can be derived left out.
mod foreign {
    use std::sync::Arc;

    use parquet::data_type::{DoubleType, Int64Type};
    use parquet::file::properties::WriterProperties;
    use parquet::file::writer::SerializedFileWriter;
    use parquet::schema::parser::parse_message_type;

    use super::*;

    fn table(schema: &str, parents: &[i64], levels: &[i16]) -> Vec<u8> {
        let schema = Arc::new(parse_message_type(schema).unwrap());
        let properties = Arc::new(WriterProperties::builder().build());
        let mut file = SerializedFileWriter::new(Vec::new(), schema, properties).unwrap();
        let mut group = file.next_row_group().unwrap();
        let mut ints = |values: &[i64], levels: &[i16]| {
            let mut column = group.next_column().unwrap().unwrap();
            column.typed::<Int64Type>().write_batch(values, Some(levels), None).unwrap();
            column.close().unwrap();
        };
        ints(parents, levels);
        ints(&[7, 5, 6], &[1, 1, 1]);
        while let Some(mut column) = group.next_column().unwrap() {
            let values = [1.0, 2.0, 3.0];
            column.typed::<DoubleType>().write_batch(&values, Some(&[1, 1, 1]), None).unwrap();
            column.close().unwrap();
        }
        group.close().unwrap();
        file.into_inner().unwrap()
    }

    const SCHEMA: &str = "message m { OPTIONAL INT64 parent; OPTIONAL INT64 id; \
        OPTIONAL DOUBLE x; OPTIONAL DOUBLE y; OPTIONAL DOUBLE z; OPTIONAL DOUBLE radius; }";

    #[test]
    fn tables_of_other_programs_are_read() {
        let trees = read(&table(SCHEMA, &[-1, 7, 5], &[1, 1, 1])).unwrap();
        let (number, tree) = &trees[0];
        assert_eq!((*number, tree.len(), &tree.info), (0, 3, &info()));
        assert_eq!(tree.node(2).thickness, 3.0);
        assert!((tree.node(1).length - 3f32.sqrt()).abs() < 1e-6);
    }

    #[test]
    fn errors_name_the_column_and_the_row() {
        let error = read(&table(SCHEMA, &[-1, 7], &[1, 1, 0])).unwrap_err();
        assert!(matches!(error, ReadTableError::Null { row: 3, column: "parent" }), "{error}");
        let schema = SCHEMA.replace("radius", "r");
        let error = read(&table(&schema, &[-1, 7, 5], &[1, 1, 1])).unwrap_err();
        assert!(matches!(error, ReadTableError::MissingColumn { column: "radius" }), "{error}");
        let schema = SCHEMA.replace("DOUBLE radius", "DOUBLE qx; OPTIONAL DOUBLE radius");
        let error = read(&table(&schema, &[-1, 7, 5], &[1, 1, 1])).unwrap_err();
        assert!(matches!(error, ReadTableError::MissingColumn { column: "qy" }), "{error}");
        let schema = SCHEMA.replace("DOUBLE radius", "DOUBLE slot; OPTIONAL DOUBLE radius");
        let error = read(&table(&schema, &[-1, 7, 5], &[1, 1, 1])).unwrap_err();
        assert!(matches!(error, ReadTableError::ColumnType { column: "slot", .. }), "{error}");
    }
}
