//! Numbers as source code and as decimal text.

/// Floating-point type of the exported tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 64 bits. Default: look-ups are those of the library, bit for bit.
    #[default]
    Double,
    /// 32 bits, for processors without a double-precision unit.
    Float,
}

impl Precision {
    /// The shortest literal, in C and Rust alike, that reads back to the same number of this type. Zero has no sign.
    pub(crate) fn literal(self, value: f64) -> String {
        let value = if value == 0.0 { 0.0 } else { value };
        match self {
            Self::Double => format!("{value:?}"),
            Self::Float => format!("{:?}", value as f32),
        }
    }

    /// The bytes of the number of this type, least significant first.
    pub(crate) fn bytes(self, value: f64) -> Vec<u8> {
        let value = if value == 0.0 { 0.0 } else { value };
        match self {
            Self::Double => value.to_le_bytes().to_vec(),
            Self::Float => (value as f32).to_le_bytes().to_vec(),
        }
    }
}

/// Plain decimal with a point and no exponent that reads back to the same number.
pub(crate) fn plain(value: f64) -> String {
    let text = crate::map::decimal(value);
    if text.contains('.') { text } else { text + ".0" }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_are_floating_point_and_read_back() {
        assert_eq!(Precision::Double.literal(-0.0), "0.0");
        assert_eq!(Precision::Double.literal(1e-9), "1e-9");
        assert_eq!(Precision::Float.literal(0.1), "0.1");
        assert_eq!((plain(3.0), plain(1e-7)), ("3.0".to_owned(), "0.0000001".to_owned()));
    }
}
