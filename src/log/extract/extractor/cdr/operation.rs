//! One step of a compiled CDR extractor.

use crate::log::extract::extractor::request_tree::{ElementCheck, Pick};
use crate::log::schema::{Kind, Size};

#[derive(Debug)]
pub(crate) enum Operation {
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
    Check(ElementCheck),
}

impl Operation {
    pub(crate) fn is_wanted(&self) -> bool {
        !matches!(
            self,
            Self::Skip { .. } | Self::SkipText { .. } | Self::SkipNumbers { .. } | Self::SkipTexts { .. } | Self::SkipMessages { .. }
        )
    }
}
