//! The `.tree` text format of ICTree: positions and thicknesses in turtle notation.
//!
//! ```text
//! file  := [metadata "#####"] nodes
//! nodes := (node | '[' nodes ']')*
//! node  := '(' x ',' y ',' z ',' w ')'
//! ```
//!
//! A node is the child of the one before it; `[` remembers the node, `]` goes back to it. y is up,
//! lengths are in metres, w is the radius. Species, rotations, slots and the foot of the root are
//! not in the format: children get slots in the order of the text, the root's edge is read as
//! straight up from the ground.
//!
//! # Source
//!
//! Polasek et al. 2021, "ICTree: automatic perceptual metrics for tree models", and the files of
//! its library. Metadata is skipped when reading and left out when writing, which ICTree allows.

use std::io::{self, Write};

use glam::Vec3;

use crate::graph::{BranchGraph, NodeId, TreeInfo};
use crate::rows::{GraphError, Row};

/// Stands between the metadata and the nodes.
const SEPARATOR: &[u8] = b"#####";

/// Why bytes are not a `.tree` file. Offsets count bytes from the start of the file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadTreeError {
    #[error("byte {offset}: expected a node `(x,y,z,w)`, `[` or `]`, found {found}")]
    Unexpected { offset: usize, found: char },
    #[error("byte {offset}: the node that starts here has no closing `)`")]
    UnclosedNode { offset: usize },
    #[error("byte {offset}: this is not a number; a node is up to four numbers and commas")]
    BadNumber { offset: usize },
    #[error("byte {offset}: a fifth number; a node has x, y, z and a thickness")]
    FifthNumber { offset: usize },
    #[error("byte {offset}: this `[` has no closing `]`; the file may be cut off")]
    UnclosedBracket { offset: usize },
    #[error("byte {offset}: this `]` has no opening `[`")]
    UnopenedBracket { offset: usize },
    #[error("byte {offset}: more nodes than 2^32 - 1, the most a tree can have")]
    TooManyNodes { offset: usize },
    #[error("the nodes, counted as rows in the order of the text, are not a tree")]
    Graph(#[from] GraphError),
}

/// Writes a tree on one line, without metadata.
///
/// Children stand in slot order, all but the last in brackets.
///
/// # Errors
///
/// When `out` cannot be written to.
pub fn write(mut out: impl Write, tree: &BranchGraph) -> io::Result<()> {
    enum Token {
        Node(NodeId),
        Open,
        Close,
    }
    let mut stack = vec![Token::Node(0)];
    while let Some(token) = stack.pop() {
        match token {
            Token::Open => write!(out, "[")?,
            Token::Close => write!(out, "]")?,
            Token::Node(id) => {
                let node = tree.node(id);
                let p = node.position;
                write!(out, "({},{},{},{})", p.x, p.y, p.z, node.thickness)?;
                let mut last = true;
                for &child in node.children.iter().rev().flatten() {
                    if last {
                        stack.push(Token::Node(child));
                    } else {
                        stack.extend([Token::Close, Token::Node(child), Token::Open]);
                    }
                    last = false;
                }
            }
        }
    }
    writeln!(out)
}

/// Reads a tree; `info` is what the file does not say.
///
/// Missing trailing numbers of a node are 0.
///
/// # Errors
///
/// When the bytes are not in the format, or not a tree with at most three children a node.
pub fn read(bytes: &[u8], info: TreeInfo) -> Result<BranchGraph, ReadTreeError> {
    let rows = parse(bytes, start_of_nodes(bytes))?;
    Ok(BranchGraph::from_rows(info, &rows)?)
}

fn start_of_nodes(bytes: &[u8]) -> usize {
    let separator = bytes.windows(SEPARATOR.len()).position(|window| window == SEPARATOR);
    match separator {
        Some(at) => at + SEPARATOR.len(),
        None if bytes.starts_with(b"\xef\xbb\xbf") => 3,
        None => 0,
    }
}

fn parse(bytes: &[u8], start: usize) -> Result<Vec<Row>, ReadTreeError> {
    let mut rows: Vec<Row> = Vec::new();
    let mut parent = -1;
    // Where each open bracket stands, and the node it goes back to.
    let mut open: Vec<(usize, i64)> = Vec::new();
    let mut at = start;
    while at < bytes.len() {
        match bytes[at] {
            b'(' => {
                if rows.len() >= u32::MAX as usize {
                    return Err(ReadTreeError::TooManyNodes { offset: at });
                }
                let (numbers, end) = node(bytes, at)?;
                let id = rows.len() as i64;
                let [x, y, z, radius] = numbers;
                let position = Vec3::new(x, y, z);
                rows.push(Row { id, parent, slot: None, position, radius, edge: None });
                parent = id;
                at = end;
                continue;
            }
            b'[' => open.push((at, parent)),
            b']' => {
                (_, parent) = open.pop().ok_or(ReadTreeError::UnopenedBracket { offset: at })?;
            }
            byte if byte.is_ascii_whitespace() => {}
            byte => {
                let found = char_at(bytes, at).unwrap_or(char::from(byte));
                return Err(ReadTreeError::Unexpected { offset: at, found });
            }
        }
        at += 1;
    }
    match open.pop() {
        Some((offset, _)) => Err(ReadTreeError::UnclosedBracket { offset }),
        None => Ok(rows),
    }
}

/// The numbers of the node that opens at `start`, and where the text goes on after it.
fn node(bytes: &[u8], start: usize) -> Result<([f32; 4], usize), ReadTreeError> {
    let mut numbers = [0.0; 4];
    let mut at = start + 1;
    for count in 0.. {
        let Some(length) = bytes[at..].iter().position(|byte| matches!(byte, b',' | b')' | b'('))
        else {
            return Err(ReadTreeError::UnclosedNode { offset: start });
        };
        let end = at + length;
        let text = std::str::from_utf8(&bytes[at..end]).map(str::trim).unwrap_or("?");
        let closes = bytes[end] == b')';
        if bytes[end] == b'(' {
            return Err(ReadTreeError::UnclosedNode { offset: start });
        }
        // Nothing before the bracket: `()` and `(1,2,)` leave the rest at 0.
        if !(closes && text.is_empty()) {
            let number = text.parse().map_err(|_| ReadTreeError::BadNumber { offset: at })?;
            *numbers.get_mut(count).ok_or(ReadTreeError::FifthNumber { offset: at })? = number;
        }
        at = end + 1;
        if closes {
            break;
        }
    }
    Ok((numbers, at))
}

fn char_at(bytes: &[u8], at: usize) -> Option<char> {
    let end = bytes.len().min(at + 4);
    (at + 1..=end)
        .find_map(|end| std::str::from_utf8(&bytes[at..end]).ok())
        .and_then(|text| text.chars().next())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::graph::ChildSignature;
    use crate::testing::{mutated, random_tree};
    use glam::Quat;
    use proptest::prelude::*;

    fn info() -> TreeInfo {
        TreeInfo { species: "unknown".into(), age: 0, gravitropism: 0.0, seed: 0 }
    }

    fn parsed(text: &str) -> Result<BranchGraph, ReadTreeError> {
        read(text.as_bytes(), info())
    }

    fn written(tree: &BranchGraph) -> String {
        let mut out = Vec::new();
        write(&mut out, tree).unwrap();
        String::from_utf8(out).unwrap()
    }

    /// The positions along the ways from the root, children in order: topology without numbers.
    fn depth_first(tree: &BranchGraph) -> Vec<(usize, Vec3, f32)> {
        let mut stack = vec![(0, 0)];
        let mut out = Vec::new();
        while let Some((depth, id)) = stack.pop() {
            let node = tree.node(id);
            out.push((depth, node.position, node.thickness));
            stack.extend(node.children.iter().rev().flatten().map(|&child| (depth + 1, child)));
        }
        out
    }

    #[test]
    fn children_stand_in_order_and_all_but_the_last_in_brackets() {
        let ahead =
            |length, thickness| ChildSignature { rotation: Quat::IDENTITY, thickness, length };
        let mut tree = BranchGraph::new(info(), Vec3::ZERO, ahead(1.0, 0.5));
        tree.grow(0, [Some(ahead(1.0, 0.25)), Some(ahead(3.0, 0.125)), Some(ahead(1.5, 0.1))]);
        tree.grow(1, [None, Some(ahead(1.0, 0.25)), None]);
        let text = "(0,0,-1,0.5)[(0,0,-2,0.25)(0,0,-3,0.25)][(0,0,-4,0.125)](0,0,-2.5,0.1)\n";
        assert_eq!(written(&tree), text);
        let back = parsed(text).unwrap();
        assert_eq!(back.root().children, [Some(1), Some(2), Some(3)]);
        assert_eq!(back.node(4).parent, Some(1));
    }

    #[test]
    fn metadata_whitespace_exponents_and_missing_numbers_are_read() {
        let text = "TreeID,Scale\n1,2\n<DynamicData>\n{\"a\": [1]}\n</DynamicData>\n\n#####\n\
                    ( 0, 1e0 ,0) \n [ (1,1,)\t]\n(0 , 2.5E+0, 0, 1e-2 )\r\n[]";
        let tree = parsed(text).unwrap();
        assert_eq!(tree.len(), 3);
        assert_eq!((tree.node(1).thickness, tree.node(2).thickness), (0.0, 0.01));
        assert!(tree.node(2).position.distance(Vec3::new(0.0, 2.5, 0.0)) < 1e-6);
    }

    #[test]
    fn errors_name_the_byte() {
        let error = |text| parsed(text).unwrap_err();
        let root = GraphError::SecondRoot { row: 2, first: 1 };
        assert_eq!(error("hello"), ReadTreeError::Unexpected { offset: 0, found: 'h' });
        assert_eq!(error("(0)é"), ReadTreeError::Unexpected { offset: 3, found: 'é' });
        assert_eq!(error("(0,0"), ReadTreeError::UnclosedNode { offset: 0 });
        assert_eq!(error("(0,(1,2,3,4)"), ReadTreeError::UnclosedNode { offset: 0 });
        assert_eq!(error("(0,x)"), ReadTreeError::BadNumber { offset: 3 });
        assert_eq!(error("(,1)"), ReadTreeError::BadNumber { offset: 1 });
        assert_eq!(error("(1,2,3,4,5)"), ReadTreeError::FifthNumber { offset: 9 });
        assert_eq!(error("(0)[(1)"), ReadTreeError::UnclosedBracket { offset: 3 });
        assert_eq!(error("(0)]"), ReadTreeError::UnopenedBracket { offset: 3 });
        assert_eq!(error(" \n"), ReadTreeError::Graph(GraphError::Empty));
        assert_eq!(error("[(0)](1)"), ReadTreeError::Graph(root));
        assert!(matches!(
            error("(0,inf)"),
            ReadTreeError::Graph(GraphError::NotFinite { row: 1, .. })
        ));
        assert_eq!(
            error("(0)[(1)][(2)][(3)(4)][(5)]"),
            ReadTreeError::Graph(GraphError::FourthChild { row: 6, parent: 0 })
        );
    }

    #[test]
    fn a_million_open_brackets_do_not_exhaust_the_stack() {
        let deep = format!("(0){}(1){}", "[".repeat(1_000_000), "]".repeat(1_000_000));
        assert_eq!(parsed(&deep).unwrap().len(), 2);
        let cut = &deep[..1_000_000];
        assert!(matches!(parsed(cut), Err(ReadTreeError::UnclosedBracket { .. })));
        let chain = "(0,1,0,1)".repeat(100_000);
        assert_eq!(written(&parsed(&chain).unwrap()).trim_end(), chain);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn topology_positions_and_radii_come_back(seed: u64, nodes in 1usize..200) {
            let tree = random_tree(seed, nodes);
            let back = parsed(&written(&tree)).unwrap();
            let (a, b) = (depth_first(&tree), depth_first(&back));
            prop_assert_eq!(a.len(), b.len());
            for (a, b) in a.iter().zip(&b) {
                prop_assert_eq!((a.0, a.2), (b.0, b.2));
                prop_assert!(a.1.distance(b.1) < 1e-3, "{} {}", a.1, b.1);
            }
        }

        #[test]
        fn noise_is_an_error_and_never_a_panic(bytes: Vec<u8>) {
            prop_assert!(read(&bytes, info()).is_err());
        }
    }

    #[test]
    fn mutated_files_never_panic() {
        let valid = written(&random_tree(1, 12));
        for seed in 0..5000 {
            let _ = read(&mutated(valid.as_bytes(), seed), info());
        }
    }
}
