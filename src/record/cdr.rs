//! CDR, the encoding of ROS 2 messages: little-endian, each value aligned to its size relative to the end of the four-byte header.
//!
//! Source: OMG, *DDS Interoperability Wire Protocol* (RTPS) 2.5, §10; XCDR version 1.

/// Bytes of one message.
#[derive(Debug, Clone)]
pub(crate) struct Cdr(Vec<u8>);

/// Representation identifier of plain little-endian CDR, and two bytes of options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

impl Cdr {
    pub(crate) fn new() -> Self {
        Self(HEADER.to_vec())
    }

    fn align(&mut self, size: usize) {
        let past = (self.0.len() - HEADER.len()) % size;
        if past > 0 {
            self.0.resize(self.0.len() + size - past, 0);
        }
    }

    pub(crate) fn bool(&mut self, value: bool) {
        self.0.push(u8::from(value));
    }

    pub(crate) fn i8(&mut self, value: i8) {
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn i32(&mut self, value: i32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn u32(&mut self, value: u32) {
        self.align(4);
        self.0.extend(value.to_le_bytes());
    }

    pub(crate) fn f64(&mut self, value: f64) {
        self.align(8);
        self.0.extend(value.to_le_bytes());
    }

    /// Length including the final zero, bytes, zero.
    pub(crate) fn string(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.as_bytes());
        self.0.push(0);
    }

    /// An array of fixed length.
    pub(crate) fn f64_array(&mut self, values: &[f64]) {
        for &value in values {
            self.f64(value);
        }
    }

    /// An array preceded by its length.
    pub(crate) fn f64_sequence(&mut self, values: &[f64]) {
        self.u32(values.len() as u32);
        self.f64_array(values);
    }

    pub(crate) fn into_bytes(self) -> Vec<u8> {
        self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_aligned_from_the_end_of_the_header() {
        let mut cdr = Cdr::new();
        cdr.bool(true);
        cdr.string("ab");
        cdr.f64(1.0);
        let expected = [0, 1, 0, 0, 1, 0, 0, 0, 3, 0, 0, 0, b'a', b'b', 0, 0, 0, 0, 0, 0, 0, 0, 0xf0, 0x3f];
        assert_eq!(cdr.into_bytes()[..20], expected[..20]);
    }

    #[test]
    fn an_empty_sequence_has_only_its_length() {
        let mut cdr = Cdr::new();
        cdr.f64_sequence(&[]);
        assert_eq!(cdr.into_bytes(), [0, 1, 0, 0, 0, 0, 0, 0]);
    }
}
