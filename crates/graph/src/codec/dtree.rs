//! `.dtree`: a tree as its seed, in 92 bytes; of a blend of n species in 92 + 3 n.
//!
//! The networks named by the model hash grow the same tree from it, bit for bit.
//!
//! | bytes | field | |
//! |---|---|---|
//! | 0..4 | magic | `DTRE` |
//! | 4 | version | 2; of a blend 3 |
//! | 5 | species | index in the model's list; of a blend n |
//! | 6..8 | age | u16, growth cycles |
//! | 8..24 | model | first 16 bytes of the SHA-256 of the weights |
//! | 24..32 | seed | u64 |
//! | 32..36 | gravitropism | f32 |
//! | 36..52 | rotation of the root | x y z w, f32, unit quaternion |
//! | 52..56 | thickness of the root | f32, m |
//! | 56..60 | length of the root's edge | f32, m |
//! | 60..88 | traits of the tree | 7 × f32, in the order of [`TreeTraits`] |
//! | 88.. | of a blend, n times | species u8, weight u16 |
//! | last 4 | CRC-32 (IEEE 802.3) of all bytes before | u32 |
//!
//! Little endian. The foot of the tree is the origin.

use glam::Quat;

use crate::blend::Share;
use crate::graph::ChildSignature;
use crate::traits::TreeTraits;

/// Length of the `.dtree` file of a tree of one species, in bytes.
pub const LEN: usize = 92;

/// The first bytes of a `.dtree` file.
pub const MAGIC: [u8; 4] = *b"DTRE";

/// The version of a tree of one species.
pub const VERSION: u8 = 2;

/// The version of a tree of a blend.
pub const BLEND_VERSION: u8 = 3;

/// Most species of a blend.
pub const MOST_SHARES: usize = 11;

/// Bytes of a species of a blend.
const SHARE: usize = 3;

/// How far from 1 the length of the root's quaternion may be, as in a skeleton table.
const UNIT_TOLERANCE: f32 = 1e-3;

/// Bytes before the species of a blend and the checksum.
const BODY: usize = LEN - 4;

/// All that the networks need to grow one tree.
#[derive(Clone, Debug, PartialEq)]
pub struct SeedFile {
    /// The model: the first 16 bytes of the SHA-256 of its weights.
    pub model: [u8; 16],
    /// s: index of the species in the model's list; 0 of a blend.
    pub species: u8,
    /// The species that the tree's lies between, at most [`MOST_SHARES`]; empty when it is one.
    pub blend: Vec<Share>,
    /// a: age in growth cycles.
    pub age: u16,
    /// v: gravitropism.
    pub gravitropism: f32,
    /// The seed of all draws.
    pub seed: u64,
    /// The root signature; its edge starts at the origin.
    pub root: ChildSignature,
    /// What the tree as a whole is to be like.
    pub traits: TreeTraits,
}

/// Why bytes are not a `.dtree` file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[expect(missing_docs, reason = "the messages say what the fields are")]
pub enum ReadSeedFileError {
    #[error("the file has {found} bytes; a seed file like it has {expected}")]
    Length { found: usize, expected: usize },
    #[error("the file starts with {found:?}, not with \"DTRE\"; it is no seed file")]
    Magic { found: [u8; 4] },
    #[error(
        "the file has version {found}; this program reads versions {VERSION} and {BLEND_VERSION}"
    )]
    Version { found: u8 },
    #[error("the checksum is {found:08x} where the bytes give {expected:08x}; the file is damaged")]
    Checksum { found: u32, expected: u32 },
    #[error("{field} is {value}; it must be a finite number")]
    NotFinite { field: &'static str, value: f32 },
    #[error("{field} is {value}; it must not be negative")]
    Negative { field: &'static str, value: f32 },
    #[error("the file is of a blend of {found} species; it must be of 1 to {MOST_SHARES}")]
    Shares { found: u8 },
    #[error("the weight of species {species} in the blend is 0; it must be above")]
    NoWeight { species: u8 },
    #[error("the root's rotation has length {norm}; it must be a unit quaternion")]
    NotUnit { norm: f32 },
}

impl SeedFile {
    /// The bytes of the file.
    ///
    /// # Panics
    ///
    /// When the blend has more than [`MOST_SHARES`] species.
    #[must_use]
    pub fn to_bytes(&self) -> Vec<u8> {
        assert!(self.blend.len() <= MOST_SHARES, "a blend of {} species", self.blend.len());
        let kind = match self.blend.len() {
            0 => [VERSION, self.species],
            n => [BLEND_VERSION, n as u8],
        };
        let mut out = Vec::with_capacity(LEN + SHARE * self.blend.len());
        out.extend(MAGIC);
        out.extend(kind);
        out.extend(self.age.to_le_bytes());
        out.extend(self.model);
        out.extend(self.seed.to_le_bytes());
        out.extend(self.gravitropism.to_le_bytes());
        let ChildSignature { rotation, thickness, length } = self.root;
        let root = rotation.to_array().into_iter().chain([thickness, length]);
        for number in root.chain(self.traits.to_array()) {
            out.extend(number.to_le_bytes());
        }
        for share in &self.blend {
            out.push(share.species);
            out.extend(share.weight.to_le_bytes());
        }
        out.extend(crc32(&out).to_le_bytes());
        out
    }

    /// Reads the bytes of a file.
    ///
    /// # Errors
    ///
    /// When they are not those of a seed file of these versions, are damaged, or hold numbers that
    /// no tree starts from.
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, ReadSeedFileError> {
        // Magic first: "no seed file" says more than "wrong length".
        if let Some(&found) = bytes.first_chunk::<4>()
            && found != MAGIC
        {
            return Err(ReadSeedFileError::Magic { found });
        }
        let length = |expected| ReadSeedFileError::Length { found: bytes.len(), expected };
        let &[_, _, _, _, version, kind, ..] = bytes else { return Err(length(LEN)) };
        let (species, shares) = match version {
            VERSION => (kind, 0),
            BLEND_VERSION if (1..=MOST_SHARES).contains(&usize::from(kind)) => {
                (0, usize::from(kind))
            }
            BLEND_VERSION => return Err(ReadSeedFileError::Shares { found: kind }),
            found => return Err(ReadSeedFileError::Version { found }),
        };
        let expected = LEN + SHARE * shares;
        if bytes.len() != expected {
            return Err(length(expected));
        }
        let (content, checksum) = bytes.split_at(expected - 4);
        let found = u32::from_le_bytes(field(checksum, 0));
        let expected = crc32(content);
        if found != expected {
            return Err(ReadSeedFileError::Checksum { found, expected });
        }
        let number = |at| f32::from_le_bytes(field(bytes, at));
        let share = |share: &[u8; SHARE]| Share {
            species: share[0],
            weight: u16::from_le_bytes([share[1], share[2]]),
        };
        let file = Self {
            model: field(bytes, 8),
            species,
            blend: content[BODY..].as_chunks().0.iter().map(share).collect(),
            age: u16::from_le_bytes(field(bytes, 6)),
            gravitropism: number(32),
            seed: u64::from_le_bytes(field(bytes, 24)),
            root: ChildSignature {
                rotation: Quat::from_xyzw(number(36), number(40), number(44), number(48)),
                thickness: number(52),
                length: number(56),
            },
            traits: TreeTraits::from_array(std::array::from_fn(|i| number(60 + 4 * i))),
        };
        file.check()?;
        Ok(file)
    }

    fn check(&self) -> Result<(), ReadSeedFileError> {
        let ChildSignature { rotation: q, thickness, length } = self.root;
        let fields = [
            ("gravitropism", self.gravitropism),
            ("qx", q.x),
            ("qy", q.y),
            ("qz", q.z),
            ("qw", q.w),
            ("thickness", thickness),
            ("length", length),
        ];
        for (field, value) in fields {
            if !value.is_finite() {
                return Err(ReadSeedFileError::NotFinite { field, value });
            }
        }
        if let Some(&value) = self.traits.to_array().iter().find(|x| !x.is_finite()) {
            return Err(ReadSeedFileError::NotFinite { field: "traits", value });
        }
        for (field, value) in [("thickness", thickness), ("length", length)] {
            if value < 0.0 {
                return Err(ReadSeedFileError::Negative { field, value });
            }
        }
        if let Some(share) = self.blend.iter().find(|share| share.weight == 0) {
            return Err(ReadSeedFileError::NoWeight { species: share.species });
        }
        let norm = q.length();
        if (norm - 1.0).abs() <= UNIT_TOLERANCE {
            Ok(())
        } else {
            Err(ReadSeedFileError::NotUnit { norm })
        }
    }
}

fn field<const N: usize>(bytes: &[u8], at: usize) -> [u8; N] {
    let mut out = [0; N];
    out.copy_from_slice(&bytes[at..at + N]);
    out
}

/// CRC-32 of IEEE 802.3, bit by bit: sixty bytes need no table.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            if crc & 1 == 1 { crc >> 1 ^ 0xedb8_8320 } else { crc >> 1 }
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{mutated, random_tree};
    use proptest::prelude::*;

    fn sample() -> SeedFile {
        SeedFile {
            model: *b"0123456789abcdef",
            species: 3,
            blend: Vec::new(),
            age: 35,
            gravitropism: -0.25,
            seed: 0x1122_3344_5566_7788,
            root: ChildSignature { rotation: Quat::IDENTITY, thickness: 0.5, length: 1.0 },
            traits: TreeTraits::from_array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]),
        }
    }

    /// The bytes with the checksum that fits them.
    fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
        let end = bytes.len() - 4;
        let checksum = crc32(&bytes[..end]);
        bytes[end..].copy_from_slice(&checksum.to_le_bytes());
        bytes
    }

    fn blended() -> SeedFile {
        let share = |species, weight| Share { species, weight };
        SeedFile { species: 0, blend: vec![share(3, 7000), share(7, 3000)], ..sample() }
    }

    #[test]
    fn crc_of_the_standard_check_string_is_the_published_one() {
        assert_eq!(crc32(b"123456789"), 0xcbf4_3926);
    }

    /// Should these bytes change, files written before can no longer be read: raise [`VERSION`].
    #[test]
    fn version_2_keeps_its_bytes() {
        let mut expected = Vec::new();
        expected.extend(b"DTRE\x02\x03\x23\x000123456789abcdef");
        expected.extend(b"\x88\x77\x66\x55\x44\x33\x22\x11\x00\x00\x80\xbe");
        expected.extend([0; 12]);
        expected.extend(b"\x00\x00\x80\x3f\x00\x00\x00\x3f\x00\x00\x80\x3f");
        expected.extend(b"\x00\x00\x80\x3f\x00\x00\x00\x40\x00\x00\x40\x40\x00\x00\x80\x40");
        expected.extend(b"\x00\x00\xa0\x40\x00\x00\xc0\x40\x00\x00\xe0\x40");
        expected.extend(b"\x73\x32\xde\x43");
        assert_eq!(sample().to_bytes(), expected);
        assert_eq!(expected.len(), LEN);
    }

    #[test]
    fn version_3_is_version_2_with_the_species_of_the_blend() {
        let (one, blend) = (sample().to_bytes(), blended().to_bytes());
        assert_eq!(blend.len(), 98);
        assert_eq!(blend[..6], *b"DTRE\x03\x02");
        assert_eq!(blend[6..BODY], one[6..BODY]);
        assert_eq!(blend[BODY..94], [3, 0x58, 0x1b, 7, 0xb8, 0x0b]);
        assert_eq!(SeedFile::from_bytes(&blend).unwrap(), blended());
        let full = SeedFile { blend: vec![Share { species: 1, weight: 1 }; 11], ..blended() };
        assert!(full.to_bytes().len() < 128);
        assert_eq!(SeedFile::from_bytes(&full.to_bytes()).unwrap(), full);
    }

    #[test]
    fn damage_of_a_blend_is_told() {
        let error = |bytes: &[u8]| SeedFile::from_bytes(bytes).unwrap_err();
        let with = |at: usize, value: &[u8]| {
            let mut bytes = blended().to_bytes();
            bytes[at..at + value.len()].copy_from_slice(value);
            error(&sealed(bytes))
        };
        assert_eq!(with(5, &[0]), ReadSeedFileError::Shares { found: 0 });
        assert_eq!(with(5, &[12]), ReadSeedFileError::Shares { found: 12 });
        assert_eq!(with(5, &[3]), ReadSeedFileError::Length { found: 98, expected: 101 });
        assert_eq!(with(92, &[0, 0]), ReadSeedFileError::NoWeight { species: 7 });
        let bytes = blended().to_bytes();
        let cut = ReadSeedFileError::Length { found: 97, expected: 98 };
        assert_eq!(error(&bytes[..97]), cut);
    }

    #[test]
    fn each_kind_of_damage_has_its_error() {
        let good = sample().to_bytes();
        let error = |bytes: &[u8]| SeedFile::from_bytes(bytes).unwrap_err();
        let with = |at: usize, number: f32| {
            let mut bytes = good.clone();
            bytes[at..at + 4].copy_from_slice(&number.to_le_bytes());
            error(&sealed(bytes))
        };
        let length = |found| ReadSeedFileError::Length { found, expected: LEN };
        assert_eq!(error(&[]), length(0));
        assert_eq!(error(&good[..91]), length(91));
        assert_eq!(error(&[&good[..], &good].concat()), length(184));
        assert_eq!(error(b"glTF...."), ReadSeedFileError::Magic { found: *b"glTF" });
        let mut newer = good.clone();
        newer[4] = 4;
        assert_eq!(error(&newer), ReadSeedFileError::Version { found: 4 });
        let mut damaged = good.clone();
        damaged[30] ^= 4;
        assert!(matches!(error(&damaged), ReadSeedFileError::Checksum { .. }));
        assert!(matches!(
            with(32, f32::NAN),
            ReadSeedFileError::NotFinite { field: "gravitropism", .. }
        ));
        assert!(matches!(
            with(36, f32::INFINITY),
            ReadSeedFileError::NotFinite { field: "qx", .. }
        ));
        assert!(matches!(with(60, f32::NAN), ReadSeedFileError::NotFinite { field: "traits", .. }));
        assert!(matches!(with(56, -1.0), ReadSeedFileError::Negative { field: "length", .. }));
        assert_eq!(with(48, 2.0), ReadSeedFileError::NotUnit { norm: 2.0 });
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(500))]

        #[test]
        fn files_read_back_as_the_same_bits(
            model: [u8; 16],
            species: u8,
            age: u16,
            gravitropism in -10f32..10.0,
            seed: u64,
            parts: Vec<(u8, u16)>,
        ) {
            let root = random_tree(seed, 1).nodes()[0].clone();
            let (rotation, thickness, length) = (root.rotation, root.thickness, root.length);
            let root = ChildSignature { rotation, thickness, length };
            let traits = TreeTraits::of(&random_tree(seed, 9));
            let share = |(species, weight): (u8, u16)| Share { species, weight: weight.max(1) };
            let blend: Vec<Share> = parts.into_iter().take(MOST_SHARES).map(share).collect();
            let species = if blend.is_empty() { species } else { 0 };
            let file = SeedFile { model, species, blend, age, gravitropism, seed, root, traits };
            let back = SeedFile::from_bytes(&file.to_bytes()).unwrap();
            prop_assert_eq!(&back, &file);
            prop_assert_eq!(back.to_bytes(), file.to_bytes());
        }

        #[test]
        fn noise_is_an_error_and_never_a_panic(bytes: Vec<u8>, body: [u8; 32]) {
            prop_assert!(SeedFile::from_bytes(&bytes).is_err());
            // Noise that passes for a whole file: only the numbers can be wrong.
            let mut file = sample().to_bytes();
            file[28..60].copy_from_slice(&body);
            if let Ok(file) = SeedFile::from_bytes(&sealed(file)) {
                prop_assert!(file.root.rotation.is_finite());
            }
        }
    }

    #[test]
    fn mutated_files_never_panic_and_are_never_taken_for_whole() {
        for good in [sample().to_bytes(), blended().to_bytes()] {
            for seed in 0..5000 {
                let bad = mutated(&good, seed);
                assert!(bad == good || SeedFile::from_bytes(&bad).is_err());
            }
        }
    }
}
