//! Fields in the wire format.
//!
//! Source: <https://protobuf.dev/programming-guides/encoding>.

/// Largest nesting depth of groups and messages.
pub(crate) const MAX_DEPTH: usize = 64;

/// A field in the wire format.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Wire<'a> {
    Varint(u64),
    Fixed64([u8; 8]),
    Bytes(&'a [u8]),
    Fixed32([u8; 4]),
}

/// The next field: its number and value, no value for a group.
pub(crate) fn next<'a>(rest: &mut &'a [u8]) -> Option<(u32, Option<Wire<'a>>)> {
    let (number, wire) = tag(rest)?;
    let value = match wire {
        0 => Wire::Varint(varint(rest)?),
        1 => Wire::Fixed64(array(rest)?),
        2 => Wire::Bytes(block(rest)?),
        3 => {
            skip_group(rest, number)?;
            return Some((number, None));
        }
        5 => Wire::Fixed32(array(rest)?),
        _ => return None,
    };
    Some((number, Some(value)))
}

fn tag(rest: &mut &[u8]) -> Option<(u32, u8)> {
    let tag = varint(rest)?;
    let number = u32::try_from(tag >> 3).ok().filter(|number| *number != 0)?;
    Some((number, (tag & 7) as u8))
}

/// Skips past the end of group `number`.
fn skip_group(rest: &mut &[u8], number: u32) -> Option<()> {
    let mut open = vec![number];
    while let Some(innermost) = open.last() {
        let (number, wire) = tag(rest)?;
        match wire {
            0 => {
                varint(rest)?;
            }
            1 => {
                array::<8>(rest)?;
            }
            2 => {
                block(rest)?;
            }
            3 if open.len() < MAX_DEPTH => open.push(number),
            4 if number == *innermost => {
                open.pop();
            }
            5 => {
                array::<4>(rest)?;
            }
            _ => return None,
        }
    }
    Some(())
}

pub(crate) fn varint(rest: &mut &[u8]) -> Option<u64> {
    let mut value = 0;
    for place in 0..10 {
        let (byte, tail) = rest.split_first()?;
        *rest = tail;
        value |= u64::from(byte & 0x7f) << (7 * place);
        if byte & 0x80 == 0 {
            return Some(value);
        }
    }
    None
}

pub(crate) fn array<const N: usize>(rest: &mut &[u8]) -> Option<[u8; N]> {
    let (head, tail) = rest.split_first_chunk::<N>()?;
    *rest = tail;
    Some(*head)
}

fn block<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let length = usize::try_from(varint(rest)?).ok()?;
    let (head, tail) = rest.split_at_checked(length)?;
    *rest = tail;
    Some(head)
}
