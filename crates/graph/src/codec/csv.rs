//! Skeleton tables as comma-separated values: one row a node, several trees a table.
//!
//! | column | | unit |
//! |---|---|---|
//! | `tree` | number of the tree; 0 where the column is missing | – |
//! | `id`, `parent` | the node and its parent; −1 at the root | – |
//! | `x`, `y`, `z` | tip of the internode, y up | m |
//! | `radius` | | m |
//! | `order` | Gravelius order; written, never read: it follows from the slots | – |
//! | `slot` | 0 apical, 1 and 2 lateral; by order of the rows where the column is missing | – |
//! | `length` | of the edge from the parent | m |
//! | `qx`, `qy`, `qz`, `qw` | rotation against the parent's frame; with `length` from the positions where the columns are missing | unit quaternion |
//!
//! Columns may stand in any order, others are ignored. Fields are numbers, so there is no quoting.
//! Numbers are written with the fewest digits that read back as the same bits.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::str::FromStr;

use glam::{Quat, Vec3};

use crate::graph::{BranchGraph, TreeInfo};
use crate::rows::{GraphError, Row};

/// The first line of a table, as it is written.
pub const HEADER: &str = "tree,id,parent,x,y,z,radius,order,slot,length,qx,qy,qz,qw";

/// Why bytes are not a skeleton table. Lines count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadCsvError {
    #[error("line {line}: byte {offset} of the file is not UTF-8; save the table as UTF-8")]
    NotUtf8 { line: usize, offset: usize },
    #[error("the table is empty; its first line must name the columns, such as {HEADER}")]
    NoHeader,
    #[error("line {line}: there is no column `{column}`; the table needs one")]
    MissingColumn { line: usize, column: &'static str },
    #[error("line {line}: two columns are called `{column}`; rename or remove one")]
    DuplicateColumn { line: usize, column: &'static str },
    #[error("line {line}: it has {found} fields where the header names {expected} columns")]
    FieldCount { line: usize, found: usize, expected: usize },
    #[error("line {line}, column `{column}`: `{text}` is not {wanted}")]
    BadField { line: usize, column: &'static str, text: String, wanted: &'static str },
    #[error("tree {tree}, whose first row is line {line}, is not a tree")]
    Graph { tree: u32, line: usize, source: GraphError },
}

/// Writes a skeleton table tree by tree.
#[derive(Debug)]
pub struct CsvWriter<W: Write> {
    out: W,
}

impl<W: Write> CsvWriter<W> {
    /// Starts a table with its header.
    ///
    /// # Errors
    ///
    /// When `out` cannot be written to.
    pub fn new(mut out: W) -> io::Result<Self> {
        writeln!(out, "{HEADER}")?;
        Ok(Self { out })
    }

    /// Appends the rows of one tree under the number `tree`, which no other tree may have.
    ///
    /// # Errors
    ///
    /// When the output cannot be written to.
    pub fn write(&mut self, tree: u32, graph: &BranchGraph) -> io::Result<()> {
        for (id, node) in graph.nodes().iter().enumerate() {
            let parent = node.parent.map_or(-1, i64::from);
            let (p, q) = (node.position, node.rotation);
            writeln!(
                self.out,
                "{tree},{id},{parent},{},{},{},{},{},{},{},{},{},{},{}",
                p.x,
                p.y,
                p.z,
                node.thickness,
                node.order,
                node.slot,
                node.length,
                q.x,
                q.y,
                q.z,
                q.w
            )?;
        }
        Ok(())
    }

    /// Flushes the table and gives the output back.
    ///
    /// # Errors
    ///
    /// When the output cannot be written to.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}

/// Reads the trees of a table, by rising number.
///
/// `info` is what the table does not hold; every tree gets a copy. A tree whose nodes stand in
/// level order, as all trees of [`CsvWriter`] do, reads back as the same bits.
///
/// # Errors
///
/// When the bytes are not a table, or the rows of one of its trees are not a tree.
pub fn read(bytes: &[u8], info: &TreeInfo) -> Result<Vec<(u32, BranchGraph)>, ReadCsvError> {
    let text = utf8(bytes)?;
    let mut lines =
        text.lines().enumerate().map(|(i, l)| (i + 1, l)).filter(|(_, l)| !l.trim().is_empty());
    let (line, header) = lines.next().ok_or(ReadCsvError::NoHeader)?;
    let names: Vec<&str> = header.split(',').map(str::trim).collect();
    let columns = Columns::find(line, &names)?;

    // By number: the first line and the rows of each tree.
    let mut trees: BTreeMap<u32, (usize, Vec<Row>)> = BTreeMap::new();
    let mut fields = Vec::with_capacity(names.len());
    for (line, text) in lines {
        fields.clear();
        fields.extend(text.split(',').map(str::trim));
        if fields.len() != names.len() {
            let (found, expected) = (fields.len(), names.len());
            return Err(ReadCsvError::FieldCount { line, found, expected });
        }
        let (tree, row) = columns.row(&Fields { line, fields: &fields })?;
        trees.entry(tree).or_insert_with(|| (line, Vec::new())).1.push(row);
    }
    trees
        .into_iter()
        .map(|(tree, (line, rows))| match BranchGraph::from_rows(info.clone(), &rows) {
            Ok(graph) => Ok((tree, graph)),
            Err(source) => Err(ReadCsvError::Graph { tree, line, source }),
        })
        .collect()
}

fn utf8(bytes: &[u8]) -> Result<&str, ReadCsvError> {
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let offset = error.valid_up_to();
        let line = 1 + bytes[..offset].iter().filter(|&&byte| byte == b'\n').count();
        ReadCsvError::NotUtf8 { line, offset }
    })?;
    // Spreadsheets put a byte order mark in front.
    Ok(text.strip_prefix('\u{feff}').unwrap_or(text))
}

/// A column's place in the line and its name.
type Column = (usize, &'static str);

/// Where the columns stand.
struct Columns {
    tree: Option<Column>,
    id: Column,
    parent: Column,
    position: [Column; 3],
    radius: Column,
    slot: Option<Column>,
    edge: Option<(Column, [Column; 4])>,
}

impl Columns {
    fn find(line: usize, names: &[&str]) -> Result<Self, ReadCsvError> {
        let optional = |column: &'static str| {
            let mut places = (0..names.len()).filter(|&i| names[i] == column);
            match (places.next(), places.next()) {
                (_, Some(_)) => Err(ReadCsvError::DuplicateColumn { line, column }),
                (place, None) => Ok(place.map(|place| (place, column))),
            }
        };
        let required = |column: &'static str| {
            optional(column)?.ok_or(ReadCsvError::MissingColumn { line, column })
        };
        // Half a rotation is a slip of the header, not a table without rotations.
        let rotated = names.iter().any(|name| matches!(*name, "qx" | "qy" | "qz" | "qw"));
        let edge = if rotated {
            let rotation = [required("qx")?, required("qy")?, required("qz")?, required("qw")?];
            Some((required("length")?, rotation))
        } else {
            None
        };
        Ok(Self {
            tree: optional("tree")?,
            id: required("id")?,
            parent: required("parent")?,
            position: [required("x")?, required("y")?, required("z")?],
            radius: required("radius")?,
            slot: optional("slot")?,
            edge,
        })
    }

    fn row(&self, fields: &Fields) -> Result<(u32, Row), ReadCsvError> {
        let whole = "a whole number";
        let tree = match self.tree {
            Some(column) => fields.parse(column, "a whole number from 0 to 4294967295")?,
            None => 0,
        };
        let slot = match self.slot {
            Some(column) => Some(fields.parse(column, "0 (apical), 1 or 2 (lateral)")?),
            None => None,
        };
        let edge = match self.edge {
            Some((length, q)) => {
                Some((Quat::from_array(fields.numbers(q)?), fields.number(length)?))
            }
            None => None,
        };
        let row = Row {
            id: fields.parse(self.id, whole)?,
            parent: fields.parse(self.parent, whole)?,
            slot,
            position: Vec3::from_array(fields.numbers(self.position)?),
            radius: fields.number(self.radius)?,
            edge,
        };
        Ok((tree, row))
    }
}

/// The fields of one line.
struct Fields<'a> {
    line: usize,
    fields: &'a [&'a str],
}

impl Fields<'_> {
    fn parse<T: FromStr>(
        &self,
        (place, column): Column,
        wanted: &'static str,
    ) -> Result<T, ReadCsvError> {
        let text = self.fields[place];
        text.parse().map_err(|_| {
            // A hostile field may be as long as the file.
            let text = text.chars().take(40).collect();
            ReadCsvError::BadField { line: self.line, column, text, wanted }
        })
    }

    fn number(&self, column: Column) -> Result<f32, ReadCsvError> {
        self.parse(column, "a number, such as 0.25")
    }

    fn numbers<const N: usize>(&self, columns: [Column; N]) -> Result<[f32; N], ReadCsvError> {
        let mut out = [0.0; N];
        for (out, column) in out.iter_mut().zip(columns) {
            *out = self.number(column)?;
        }
        Ok(out)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{mutated, random_tree};
    use proptest::prelude::*;

    /// A trunk of two internodes with one lateral.
    const TABLE: &str = "\
tree,id,parent,x,y,z,radius,order,slot,length,qx,qy,qz,qw
7,0,-1,0,1,0.00000005960464,0.25,0,0,1,0.70710677,0,0,0.70710677
7,1,0,0,2,0.00000005960464,0.125,0,0,1,0,0,0,1
7,2,0,0,1,-0.49999994,0.0625,1,1,0.5,-0.70710677,0,0,0.70710677
";

    fn info() -> TreeInfo {
        TreeInfo { species: "oak".into(), age: 3, gravitropism: -0.25, seed: 9 }
    }

    fn written(trees: &[(u32, BranchGraph)]) -> Vec<u8> {
        let mut writer = CsvWriter::new(Vec::new()).unwrap();
        trees.iter().for_each(|(number, tree)| writer.write(*number, tree).unwrap());
        writer.finish().unwrap()
    }

    fn error(text: &str) -> ReadCsvError {
        read(text.as_bytes(), &info()).unwrap_err()
    }

    #[test]
    fn a_table_keeps_its_bytes() {
        let trees = read(TABLE.as_bytes(), &info()).unwrap();
        assert_eq!(trees[0].1.nodes()[2].order, 1);
        assert_eq!(String::from_utf8(written(&trees)).unwrap(), TABLE);
    }

    #[test]
    fn columns_may_stand_in_any_order_and_derived_ones_may_be_missing() {
        let table = "\u{feff}z, y, x, radius, parent, note, id\r\n\r\n0,1,0,0.1,-1,a,5\r\n0,3,0,0.1,5,b,6\r\n0,1,2,0.1,5,c,7\r\n\r\n";
        let trees = read(table.as_bytes(), &info()).unwrap();
        let tree = &trees[0].1;
        assert_eq!((trees[0].0, tree.len(), &tree.info), (0, 3, &info()));
        assert_eq!((tree.node(1).length, tree.node(2).length), (2.0, 2.0));
        assert_eq!((tree.node(1).order, tree.node(2).order), (0, 1));
    }

    #[test]
    fn errors_name_the_line_and_the_column() {
        assert_eq!(error(" \n\n"), ReadCsvError::NoHeader);
        assert_eq!(error("id,x"), ReadCsvError::MissingColumn { line: 1, column: "parent" });
        assert_eq!(
            error("\nid,id,parent"),
            ReadCsvError::DuplicateColumn { line: 2, column: "id" }
        );
        assert_eq!(error("id,qx,qz"), ReadCsvError::MissingColumn { line: 1, column: "qy" });
        let short = format!("{TABLE}\n7,3");
        assert_eq!(error(&short), ReadCsvError::FieldCount { line: 6, found: 2, expected: 14 });
        let bad = TABLE.replace("0.125", "12 cm");
        assert!(matches!(error(&bad), ReadCsvError::BadField { line: 3, column: "radius", .. }));
        let bad = TABLE.replace("7,1,0,", "-7,1,0,");
        assert!(matches!(error(&bad), ReadCsvError::BadField { line: 3, column: "tree", .. }));
        let orphan = TABLE.replace("7,2,0,", "7,2,4,");
        let source = GraphError::Orphan { row: 3, parent: 4 };
        assert_eq!(error(&orphan), ReadCsvError::Graph { tree: 7, line: 2, source });
        let bytes = [TABLE.as_bytes(), b"7,\xff"].concat();
        let offset = TABLE.len() + 2;
        assert_eq!(read(&bytes, &info()).unwrap_err(), ReadCsvError::NotUtf8 { line: 5, offset });
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn tables_read_back_as_the_same_bits(seed: u64, nodes in 1usize..200, count in 1u64..4) {
            let trees: Vec<_> = (0..count)
                .map(|k| (k as u32 * 5, random_tree(seed.wrapping_add(k), nodes)))
                .collect();
            let bytes = written(&trees);
            let back = read(&bytes, &trees[0].1.info).unwrap();
            prop_assert_eq!(back.len(), trees.len());
            for ((number, tree), (expected, original)) in back.iter().zip(&trees) {
                prop_assert_eq!(number, expected);
                prop_assert_eq!(tree.nodes(), original.nodes());
            }
            // Equal bits, not only equal numbers: 0 and −0 are written differently.
            prop_assert_eq!(written(&back), bytes);
        }

        #[test]
        fn noise_is_an_error_and_never_a_panic(bytes: Vec<u8>) {
            prop_assert!(read(&bytes, &info()).is_err());
        }
    }

    #[test]
    fn mutated_tables_never_panic() {
        let valid = written(&[(0, random_tree(1, 8)), (1, random_tree(2, 8))]);
        for seed in 0..5000 {
            let _ = read(&mutated(&valid, seed), &info());
        }
    }
}
