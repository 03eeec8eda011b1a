//! Model files: what is written is read back, and nothing else gets through.
#![allow(clippy::unwrap_used, reason = "a test")]

mod common;

use common::{draws, layers, mlp, values};
use deeptree_graph::Draws;
use deeptree_infer::{
    ModelKind, ReadWeightsError, Scratch, SimdPath, Table, Weights, WeightsBuilder,
};
use safetensors::{Dtype, SafeTensorError, SafeTensors};
use sha2::{Digest, Sha256};

const WIDTHS: [usize; 4] = [5, 17, 8, 3];

fn table(shape: &[usize], draws: &mut Draws) -> Table {
    Table::new(shape.to_vec(), values(draws, shape.iter().product(), 1.0)).unwrap()
}

fn builder() -> WeightsBuilder {
    let mut draws = draws(7);
    let mut builder = WeightsBuilder::new(ModelKind::Situated, ["oak", "scots pine"]);
    for (k, (i, o, weight, bias)) in layers(&mut draws, &WIDTHS).into_iter().enumerate() {
        let weight = Table::new(vec![i, o], weight).unwrap();
        builder.layer("existence", k as u32, weight, Table::new(vec![o], bias).unwrap());
    }
    builder
        .table("tip_radius", table(&[2], &mut draws))
        .table("roots.oak", table(&[3, 8], &mut draws))
        .table("roots.scots pine", table(&[1, 8], &mut draws))
        .table("rotation_mean", table(&[2, 3, 4], &mut draws));
    builder
}

/// A file with this header and so many bytes of data.
fn file(header: &str, data: &[u8]) -> Vec<u8> {
    [&(header.len() as u64).to_le_bytes(), header.as_bytes(), data].concat()
}

/// A file of one tensor `t`, described by `info`.
fn one_tensor(info: &str, data: &[u8]) -> Result<Weights, ReadWeightsError> {
    let metadata = r#"{"format":"1","kind":"paper","species":"oak"}"#;
    Weights::from_bytes(&file(&format!(r#"{{"__metadata__":{metadata},"t":{{{info}}}}}"#), data))
}

fn with_metadata(metadata: &str) -> ReadWeightsError {
    Weights::from_bytes(&file(&format!(r#"{{"__metadata__":{{{metadata}}}}}"#), &[])).unwrap_err()
}

#[test]
fn what_is_written_is_read_back() {
    let bytes = builder().to_bytes().unwrap();
    assert_eq!(bytes, builder().to_bytes().unwrap(), "the same content gave other bytes");
    let weights = Weights::from_bytes(&bytes).unwrap();
    assert_eq!(weights.kind(), ModelKind::Situated);
    assert_eq!(weights.species(), ["oak", "scots pine"]);
    assert_eq!(weights.sha256(), <[u8; 32]>::from(Sha256::digest(&bytes)));
    assert_eq!(weights.names().count(), 10);
    assert!(weights.contains("roots.oak") && !weights.contains("roots.ash"));
    let roots = weights.table("roots.oak", &[None, Some(8)]).unwrap();
    assert_eq!((roots.rows(), roots.row(2)), (3, &roots.values()[16..]));
}

#[test]
fn a_network_read_back_gives_the_bits_of_the_one_written() {
    let weights = Weights::from_bytes(&builder().to_bytes().unwrap()).unwrap();
    let mut draws = draws(7);
    let expected = mlp(&layers(&mut draws, &WIDTHS));
    let read = weights.mlp("existence").unwrap();
    assert_eq!(read, expected);
    assert_eq!((read.inputs(), read.outputs(), read.weight_count()), (5, 3, 273));
    let out = read.forward(SimdPath::detect(), &[0.5; 10], &mut Scratch::new()).to_vec();
    assert_eq!(out, expected.forward(SimdPath::Scalar, &[0.5; 10], &mut Scratch::new()));
}

#[test]
fn the_reference_implementation_reads_what_is_written() {
    let bytes = builder().to_bytes().unwrap();
    let (header_len, header) = SafeTensors::read_metadata(&bytes).unwrap();
    assert_eq!(header_len % 8, 0);
    assert_eq!(header.metadata().as_ref().unwrap()["species"], "oak,scots pine");
    let tensors = SafeTensors::deserialize(&bytes).unwrap();
    assert_eq!(tensors.tensor("rotation_mean").unwrap().shape(), [2, 3, 4]);
    assert_eq!(tensors.tensor("tip_radius").unwrap().dtype(), Dtype::F32);
}

#[test]
fn missing_and_misshapen_tensors_are_named() {
    let weights = Weights::from_bytes(&builder().to_bytes().unwrap()).unwrap();
    let message = |result: Result<&Table, ReadWeightsError>| result.unwrap_err().to_string();
    assert_eq!(
        message(weights.table("tip_radius", &[Some(2), None])),
        "tensor `tip_radius` has shape [2], expected [2, _]"
    );
    assert_eq!(
        message(weights.table("roots.ash", &[None, Some(8)])),
        "the model has no tensor `roots.ash`; it is incomplete or of another kind"
    );
    let missing = weights.mlp("length").unwrap_err().to_string();
    assert!(missing.contains("`length.0.weight`"), "{missing}");
}

#[test]
fn networks_that_do_not_chain_are_refused() {
    let mut draws = draws(3);
    let mut network = |layers: &[(u32, usize, usize, usize)]| {
        let mut builder = WeightsBuilder::new(ModelKind::Paper, ["oak"]);
        for &(k, inputs, outputs, biases) in layers {
            let (weight, bias) =
                (table(&[inputs, outputs], &mut draws), table(&[biases], &mut draws));
            builder.layer("net", k, weight, bias);
        }
        Weights::from_bytes(&builder.to_bytes().unwrap()).unwrap().mlp("net")
    };
    assert!(network(&[(0, 2, 3, 3), (1, 3, 1, 1)]).is_ok());
    assert!(matches!(
        network(&[(0, 2, 3, 3), (1, 4, 1, 1)]),
        Err(ReadWeightsError::Network { .. })
    ));
    assert!(matches!(network(&[(0, 2, 3, 2)]), Err(ReadWeightsError::Shape { .. })));
    assert!(matches!(network(&[(0, 0, 3, 3)]), Err(ReadWeightsError::Network { .. })));
    for gap in [1, 2, u32::MAX] {
        assert!(matches!(
            network(&[(0, 2, 3, 3), (gap + u32::from(gap == 1), 3, 1, 1)]),
            Err(ReadWeightsError::MissingTensor { .. })
        ));
    }
}

#[test]
fn numbers_that_are_not_finite_are_named() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut builder = builder();
        builder.table("tip_radius", Table::new(vec![2], vec![0.0, bad]).unwrap());
        assert!(matches!(
            builder.to_bytes().unwrap_err(),
            ReadWeightsError::NotFinite { tensor, index: 1, .. } if tensor == "tip_radius"
        ));
    }
}

#[test]
fn metadata_of_other_files_are_refused() {
    use ReadWeightsError as E;
    assert!(matches!(Weights::from_bytes(&file("{}", &[])), Err(E::MissingMetadata { .. })));
    assert!(matches!(with_metadata(r#""format":"pt""#), E::UnknownFormat { .. }));
    assert!(matches!(with_metadata(r#""format":1"#), E::Container(_)));
    assert!(matches!(
        with_metadata(r#""format":"1","kind":"situated""#),
        E::MissingMetadata { key: "species" }
    ));
    assert!(matches!(
        with_metadata(r#""format":"1","kind":"other","species":"oak""#),
        E::UnknownKind { .. }
    ));
    for list in ["", "oak,", "oak,oak", "oak, ash"] {
        let metadata = format!(r#""format":"1","kind":"paper","species":"{list}""#);
        assert!(matches!(with_metadata(&metadata), E::SpeciesName { .. }), "{list}");
    }
}

#[test]
fn hostile_lengths_are_refused() {
    use SafeTensorError as S;
    let container = |bytes: &[u8]| match Weights::from_bytes(bytes).unwrap_err() {
        ReadWeightsError::Container(error) => error,
        other => panic!("{other}"),
    };
    assert!(matches!(container(&[]), S::HeaderTooSmall));
    assert!(matches!(container(&[1, 0, 0, 0, 0, 0, 0]), S::HeaderTooSmall));
    assert!(matches!(container(&u64::MAX.to_le_bytes()), S::HeaderTooLarge));
    assert!(matches!(container(&99_999_999u64.to_le_bytes()), S::InvalidHeaderLength));
    assert!(matches!(container(&file("\u{0}", &[])), S::InvalidHeaderDeserialization(_)));
    assert!(matches!(
        container(&file(&"[".repeat(100_000), &[])),
        S::InvalidHeaderDeserialization(_)
    ));
    assert!(matches!(
        Weights::from_bytes(&vec![0; (64 << 20) + 1]),
        Err(ReadWeightsError::TooLarge { .. })
    ));
}

#[test]
fn hostile_tensors_are_refused() {
    use ReadWeightsError as E;
    let ok = one_tensor(r#""dtype":"F32","shape":[2],"data_offsets":[0,8]"#, &[0; 8]);
    assert!(ok.is_ok());
    assert!(matches!(
        one_tensor(r#""dtype":"F16","shape":[4],"data_offsets":[0,8]"#, &[0; 8]),
        Err(E::DataType { tensor, found: Dtype::F16 }) if tensor == "t"
    ));
    for info in [
        r#""dtype":"F33","shape":[2],"data_offsets":[0,8]"#,
        r#""dtype":"F32","shape":[3],"data_offsets":[0,8]"#,
        r#""dtype":"F32","shape":[-2],"data_offsets":[0,8]"#,
        r#""dtype":"F32","shape":[2],"data_offsets":[8,0]"#,
        r#""dtype":"F32","shape":[1],"data_offsets":[4,8]"#,
        r#""dtype":"F32","shape":[1],"data_offsets":[0,4]"#,
        r#""dtype":"F32","shape":[4],"data_offsets":[0,16]"#,
        r#""dtype":"F32","shape":[4294967296,4294967296],"data_offsets":[0,8]"#,
        r#""dtype":"F32","shape":[4611686018427387904],"data_offsets":[0,0]"#,
        r#""dtype":"F32","shape":[2],"data_offsets":[0,18446744073709551615]"#,
        r#""dtype":"F32","shape":[2]"#,
    ] {
        assert!(matches!(one_tensor(info, &[0; 8]), Err(E::Container(_))), "{info}");
    }
    let half = r#"{"dtype":"F32","shape":[2],"data_offsets":[0,8]}"#;
    let overlap = file(&format!(r#"{{"a":{half},"b":{half}}}"#), &[0; 8]);
    assert!(matches!(Weights::from_bytes(&overlap), Err(E::Container(_))));
}

#[test]
fn files_cut_short_are_refused() {
    let bytes = builder().to_bytes().unwrap();
    for len in 0..bytes.len() {
        assert!(Weights::from_bytes(&bytes[..len]).is_err(), "{len} bytes");
    }
}

#[test]
fn no_mutation_of_a_file_panics() {
    let original = builder().to_bytes().unwrap();
    let mut draws = draws(11);
    for case in 0..5000 {
        let mut bytes = original.clone();
        // Mostly in the header, where a byte matters most.
        let range = if case % 4 == 0 { bytes.len() } else { 900 };
        for _ in 0..=draws.index(4) {
            let at = draws.index(range);
            bytes[at] =
                if draws.index(2) == 0 { draws.bits() as u8 } else { b'0' + draws.index(10) as u8 };
        }
        let Ok(weights) = Weights::from_bytes(&bytes) else { continue };
        if let Ok(mlp) = weights.mlp("existence") {
            let inputs = vec![0.0; 2 * mlp.inputs()];
            mlp.forward(SimdPath::detect(), &inputs, &mut Scratch::new());
        }
    }
}
