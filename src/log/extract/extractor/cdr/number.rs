//! Numbers and texts of a CDR payload.

use crate::log::schema::Kind;
use crate::log::value::Raw;

/// The number at the front of `data`.
#[inline]
pub(crate) fn number<'a, const BE: bool>(kind: Kind, data: &[u8]) -> Option<Raw<'a>> {
    Some(match kind {
        Kind::Bool | Kind::U8 => Raw::Integer(i64::from(*data.first()?)),
        Kind::I8 => Raw::Integer(i64::from(data.first()?.cast_signed())),
        Kind::I16 => Raw::Integer(i64::from(i16::from_le_bytes(bytes::<BE, _>(data)?))),
        Kind::U16 => Raw::Integer(i64::from(u16::from_le_bytes(bytes::<BE, _>(data)?))),
        Kind::I32 => Raw::Integer(i64::from(i32::from_le_bytes(bytes::<BE, _>(data)?))),
        Kind::U32 => Raw::Integer(i64::from(u32::from_le_bytes(bytes::<BE, _>(data)?))),
        Kind::I64 => Raw::Integer(i64::from_le_bytes(bytes::<BE, _>(data)?)),
        Kind::U64 => Raw::unsigned(u64::from_le_bytes(bytes::<BE, _>(data)?)),
        Kind::F32 => Raw::Number(f64::from(f32::from_le_bytes(bytes::<BE, _>(data)?))),
        Kind::F64 => Raw::Number(f64::from_le_bytes(bytes::<BE, _>(data)?)),
    })
}

/// The first `N` bytes, the lowest first.
#[inline]
pub(crate) fn bytes<const BE: bool, const N: usize>(data: &[u8]) -> Option<[u8; N]> {
    let mut bytes = *data.first_chunk::<N>()?;
    if BE {
        bytes.reverse();
    }
    Some(bytes)
}

/// A text without the zero byte that CDR puts behind it.
pub(crate) fn ended(text: &[u8]) -> &[u8] {
    text.strip_suffix(&[0]).unwrap_or(text)
}

/// A text as a value.
pub(crate) fn shown(text: &[u8]) -> Raw<'_> {
    Raw::Text(String::from_utf8_lossy(ended(text)))
}
