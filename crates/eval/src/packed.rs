//! Lists of numbers as text: their bytes, lowest first, in base 64. Short, quick to read, and the
//! same bits when they are read again.

use base64::prelude::{BASE64_STANDARD, Engine as _};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serializer};

/// A number of a list.
pub(crate) trait Number: Copy {
    /// The number as bytes, lowest first.
    fn put(self, out: &mut Vec<u8>);
    /// The inverse, of as many bytes as one number has.
    fn get(bytes: &[u8]) -> Option<Self>;
    /// Bytes of a number.
    const BYTES: usize;
}

macro_rules! number {
    ($($kind:ty)*) => { $(
        impl Number for $kind {
            const BYTES: usize = size_of::<$kind>();

            fn put(self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }

            fn get(bytes: &[u8]) -> Option<Self> {
                bytes.try_into().ok().map(<$kind>::from_le_bytes)
            }
        }
    )* };
}

number!(u32 f32 f64);

pub(crate) fn serialize<N: Number, S: Serializer>(
    numbers: &[N],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    let mut bytes = Vec::with_capacity(numbers.len() * N::BYTES);
    numbers.iter().for_each(|number| number.put(&mut bytes));
    serializer.serialize_str(&BASE64_STANDARD.encode(bytes))
}

pub(crate) fn deserialize<'de, N: Number, D: Deserializer<'de>>(
    deserializer: D,
) -> Result<Vec<N>, D::Error> {
    let text = String::deserialize(deserializer)?;
    let bytes = BASE64_STANDARD.decode(text).map_err(D::Error::custom)?;
    let numbers: Option<Vec<N>> = bytes.chunks(N::BYTES).map(N::get).collect();
    numbers.ok_or_else(|| D::Error::custom("a packed list ends within a number"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::de::IntoDeserializer;
    use serde::de::value::{Error, StrDeserializer};

    fn read<N: Number>(text: &str) -> Result<Vec<N>, Error> {
        let text: StrDeserializer<'_, Error> = text.into_deserializer();
        deserialize(text)
    }

    #[test]
    fn bytes_stand_lowest_first_in_base_64() {
        // 1 and 256 as four bytes each: 01 00 00 00 00 01 00 00.
        assert_eq!(read::<u32>("AQAAAAABAAA=").unwrap(), [1, 256]);
        // 0x3f800000 is 1 in float32.
        assert_eq!(read::<f32>("AACAPw==").unwrap(), [1.0]);
        assert!(read::<f64>("AACAPw==").is_err() && read::<u32>("?").is_err());
    }
}
