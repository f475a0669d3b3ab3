//! CDR and ROS 1 payloads: a program of skips and takes, compiled from the schema.
//!
//! CDR aligns each number to its own size, counted from behind the four bytes of the encapsulation header; ROS 1 is the same with an
//! alignment of one. Source: OMG DDS-XTYPES 1.3, section 7.4: XCDR1, and XCDR2 for final types, where 8-byte numbers align to 4 and arrays
//! of anything but numbers have their size in bytes before them. Parameter lists and delimited types, which ROS does not write, are refused.

mod compiler;
mod shortcut;
mod walk;

use super::super::schema::{Kind, Size, Structure};
use super::wish::{Check, Pick, Wish};
use super::{PlanError, Taken};
pub(super) use shortcut::Shortcut;
use walk::{Form, Walk};

/// A compiled walk over a payload.
#[derive(Debug)]
pub(super) struct Program {
    operations: Vec<Operation>,
}

#[derive(Debug)]
enum Operation {
    /// Skip `count` numbers of one size.
    Skip {
        size: usize,
        count: usize,
    },
    SkipText {
        wide: bool,
    },
    /// Skip an array of numbers with its count before it.
    SkipNumbers {
        size: usize,
    },
    SkipTexts {
        size: Size,
        wide: bool,
    },
    SkipMessages {
        size: Size,
        each: Vec<Operation>,
    },
    Take {
        kind: Kind,
        slot: usize,
    },
    TakeText {
        slot: usize,
    },
    /// Elements of an array of numbers.
    Numbers {
        size: Size,
        kind: Kind,
        picks: Vec<(Pick, Vec<usize>)>,
    },
    /// Elements of an array of texts.
    Texts {
        size: Size,
        picks: Vec<(Pick, Vec<usize>)>,
    },
    /// Elements of an array of messages: `skip` passes over one, each pick has its own program.
    Messages {
        size: Size,
        skip: Vec<Operation>,
        picks: Vec<(Pick, Vec<Operation>)>,
    },
    Check(Check),
}

/// The first four bytes of a CDR payload say how it is written; the last two of them do not matter here.
const HEADER: usize = 4;
const PLAIN: Form = Form { start: HEADER, max_align: 8, delimited: false };
const PLAIN_2: Form = Form { start: HEADER, max_align: 4, delimited: true };
const ROS_1: Form = Form { start: 0, max_align: 1, delimited: false };

impl Program {
    pub(super) fn compile(structure: &Structure, wish: &Wish) -> Result<Self, PlanError> {
        let mut operations = compiler::compile(structure, wish)?;
        // nothing behind the last wanted field need be read
        let useful = operations.iter().rposition(Operation::is_wanted).map_or(0, |last| last + 1);
        operations.truncate(useful);
        Ok(Self { operations })
    }

    pub(super) fn run_cdr<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        let header = payload.first_chunk::<HEADER>()?;
        match (header[0], header[1]) {
            (0, 0) => self.run::<true>(payload, PLAIN, taken),
            (0, 1) => self.run::<false>(payload, PLAIN, taken),
            (0, 6 | 0x10) => self.run::<true>(payload, PLAIN_2, taken),
            (0, 7 | 0x11) => self.run::<false>(payload, PLAIN_2, taken),
            _ => None,
        }
    }

    pub(super) fn run_ros1<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        self.run::<false>(payload, ROS_1, taken)
    }

    fn run<'a, const BE: bool>(&self, payload: &'a [u8], form: Form, taken: &mut Taken<'a>) -> Option<()> {
        let trace = taken.shortcut.learn();
        if let Some(mut trace) = Walk::<BE>::new(payload, form, trace).finish(&self.operations, taken)? {
            if taken.again {
                trace.give_up();
            }
            taken.shortcut.keep(payload, trace);
        }
        Some(())
    }
}

impl Operation {
    fn is_wanted(&self) -> bool {
        !matches!(
            self,
            Self::Skip { .. } | Self::SkipText { .. } | Self::SkipNumbers { .. } | Self::SkipTexts { .. } | Self::SkipMessages { .. }
        )
    }
}

/// The element that an index means, if the array has it.
pub(super) fn position(index: i64, count: usize) -> Option<usize> {
    let index = if index < 0 { index + count as i64 } else { index };
    usize::try_from(index).ok().filter(|index| *index < count)
}
