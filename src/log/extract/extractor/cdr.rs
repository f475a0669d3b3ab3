//! CDR and ROS 1 payloads: a program of skips and takes, compiled from the schema.
//!
//! CDR aligns each number to its own size, counted from behind the four bytes of the encapsulation header; ROS 1 is the same with an
//! alignment of one. Source: OMG DDS-XTYPES 1.3, section 7.4: XCDR1, and XCDR2 for final types, where 8-byte numbers align to 4 and arrays
//! of anything but numbers have their size in bytes before them. Parameter lists and delimited types, which ROS does not write, are refused.

mod compiler;
mod number;
pub(crate) mod operation;
pub(crate) mod shortcut;
mod walk;

use crate::log::extract::extractor::cdr::operation::Operation;
use crate::log::extract::extractor::request_tree::Wish;
use crate::log::extract::extractor::taken::Taken;
use crate::log::extractor_error::PlanError;
use crate::log::schema::Structure;
use walk::{Form, Walk};

/// A compiled walk over a payload.
#[derive(Debug)]
pub(crate) struct CdrProgram {
    operations: Vec<Operation>,
}

/// The first four bytes of a CDR payload say how it is written; the last two of them do not matter here.
const HEADER: usize = 4;
const PLAIN: Form = Form { start: HEADER, max_align: 8, delimited: false };
const PLAIN_2: Form = Form { start: HEADER, max_align: 4, delimited: true };
const ROS_1: Form = Form { start: 0, max_align: 1, delimited: false };

impl CdrProgram {
    pub(crate) fn compile(structure: &Structure, wish: &Wish) -> Result<Self, PlanError> {
        let mut operations = compiler::compile(structure, wish)?;
        // nothing behind the last wanted field need be read
        let useful = operations.iter().rposition(Operation::is_wanted).map_or(0, |last| last + 1);
        operations.truncate(useful);
        Ok(Self { operations })
    }

    pub(crate) fn run_cdr<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        let header = payload.first_chunk::<HEADER>()?;
        match (header[0], header[1]) {
            (0, 0) => self.run::<true>(payload, PLAIN, taken),
            (0, 1) => self.run::<false>(payload, PLAIN, taken),
            (0, 6 | 0x10) => self.run::<true>(payload, PLAIN_2, taken),
            (0, 7 | 0x11) => self.run::<false>(payload, PLAIN_2, taken),
            _ => None,
        }
    }

    /// Why no payload that begins like this one is read, if it is of a form that is refused.
    pub(crate) fn refusal(payload: &[u8]) -> Option<&'static str> {
        match *payload.first_chunk::<HEADER>()? {
            [0, 0 | 1 | 6 | 7 | 0x10 | 0x11, ..] => None,
            [0, 2 | 3 | 0x0a | 0x0b | 0x12 | 0x13, ..] => Some("they are CDR parameter lists (PL_CDR), which are not read"),
            [0, 8 | 9 | 0x14 | 0x15, ..] => Some("they are CDR of delimited types (D_CDR2), which is not read"),
            _ => Some("their first bytes are those of no CDR"),
        }
    }

    pub(crate) fn run_ros1<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        self.run::<false>(payload, ROS_1, taken)
    }

    fn run<'a, const BE: bool>(&self, payload: &'a [u8], form: Form, taken: &mut Taken<'a>) -> Option<()> {
        let trace = taken.shortcut.learn();
        let mut walk = Walk::<BE>::new(payload, form, trace);
        walk.all(&self.operations, taken)?;
        if let Some(mut trace) = walk.into_trace() {
            if taken.again {
                trace.give_up();
            }
            taken.shortcut.keep(payload, trace);
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::log::extract::extractor::Extractor;
    use crate::log::extract::extractor::taken::Taken;
    use crate::log::file::structure::Schema;
    use crate::log::path::MessagePath;
    use crate::log::schema::Layout;
    use crate::log::value::Raw;

    fn plan() -> Extractor {
        let text = "string[] names\nfloat64 x\na/Item[] items\nint64 y\n===\nMSG: a/Item\nfloat64 v\n";
        let schema = Schema { name: "a/M".into(), encoding: "ros2msg".into(), data: text.into() };
        let paths: Vec<MessagePath> = ["/t.x", "/t.items[0].v", "/t.y"].map(|path| path.parse().unwrap()).into();
        Extractor::compile(&Layout::parse("cdr", Some(&schema)).unwrap(), &paths.iter().collect::<Vec<_>>()).unwrap()
    }

    /// One name of five bytes, x = 1.5, one item of 2.5, y = −3; `header` and the counts of bytes before the arrays of XCDR2.
    fn payload(header: [u8; 2], counts: Option<[u32; 2]>) -> Vec<u8> {
        let [names, items] = counts.map_or([vec![], vec![]], |counts| counts.map(|count| count.to_le_bytes().to_vec()));
        let mut payload = vec![header[0], header[1], 0, 0];
        for part in [&names[..], &[1, 0, 0, 0, 5, 0, 0, 0], b"abcd\0", &[0; 3]] {
            payload.extend(part);
        }
        payload.extend(1.5_f64.to_le_bytes());
        payload.extend(items);
        payload.extend(1_u32.to_le_bytes());
        if counts.is_none() {
            payload.extend([0; 4]);
        }
        payload.extend(2.5_f64.to_le_bytes());
        payload.extend((-3_i64).to_le_bytes());
        payload
    }

    #[test]
    fn both_versions_of_the_encoding_are_read() {
        let plan = plan();
        // version 1 aligns 8-byte numbers to 8, version 2 to 4, and version 2 counts the bytes of arrays of texts and messages
        for payload in [payload([0, 1], None), payload([0, 7], Some([16, 12])), payload([0, 0x11], Some([16, 12]))] {
            let mut taken = Taken::default();
            plan.decode(&payload, &mut taken).unwrap();
            assert_eq!([0, 1, 2].map(|slot| taken.get(slot).clone()), [Raw::Number(1.5), Raw::Number(2.5), Raw::Integer(-3)]);
        }
    }

    #[test]
    fn parameter_lists_and_delimited_types_are_refused_by_name() {
        for (id, name) in
            [(2, "PL_CDR"), (3, "PL_CDR"), (0x0b, "PL_CDR"), (0x13, "PL_CDR"), (9, "D_CDR2"), (0x15, "D_CDR2"), (0x77, "no CDR")]
        {
            let payload = payload([0, id], None);
            assert!(plan().decode(&payload, &mut Taken::default()).is_none());
            assert!(plan().refusal(&payload).unwrap().contains(name));
        }
        assert_eq!(plan().refusal(&payload([0, 1], None)), None);
    }
}
