//! What one message teaches about the next: where the wanted values stand, as long as counts, text lengths and compared names are the same.
//!
//! A walk over a payload depends on nothing but a few of its bytes: the counts, the lengths of the texts before the last wanted value,
//! and the names that it compared. The messages of one channel hardly ever differ there, so the next payload is first compared with the
//! last one at those bytes, and if they are equal its values are taken from the same places.

use crate::log::extract::extractor::cdr::number::number;
use crate::log::schema::Kind;
use crate::log::value::Raw;

/// Places that are compared at most; a walk that depends on more of them is as fast as comparing.
const MAX_PLACES: usize = 32;
/// Bytes of padding that may be compared with what stands around them.
const PADDING: usize = 3;
/// How often messages may differ, without ever being alike, before the comparison is given up.
const PATIENCE: u8 = 8;

/// The places of the last message that was walked.
#[derive(Debug)]
pub(crate) struct Shortcut<'a> {
    /// The message; empty while nothing is known.
    template: &'a [u8],
    trace: Trace,
    /// Falls when messages differ and rises when they are alike; at zero no more is learnt.
    patience: u8,
}

/// What a walk depends on and where it found the values.
#[derive(Debug, Default)]
pub(crate) struct Trace {
    /// Bytes that the walk depends on: from, to.
    places: Vec<(usize, usize)>,
    takes: Vec<Take>,
    /// Bytes that the payload has at least.
    end: usize,
    big_endian: bool,
    /// The walk depends on more than can be compared.
    hopeless: bool,
}

#[derive(Debug)]
enum Take {
    Number { at: usize, kind: Kind, slot: usize },
    Text { at: usize, length: usize, slot: usize },
}

impl Default for Shortcut<'_> {
    fn default() -> Self {
        Self { template: &[], trace: Trace::default(), patience: PATIENCE }
    }
}

impl<'a> Shortcut<'a> {
    /// Fills `slots` from `payload` if it is like the last one. The slots that the last one left empty stay as they are.
    pub(crate) fn run(&mut self, payload: &'a [u8], slots: &mut [Raw<'a>]) -> bool {
        let Self { template, trace, .. } = self;
        let alike = !template.is_empty()
            && payload.len() >= trace.end
            && trace.places.iter().all(|(from, to)| payload[*from..*to] == template[*from..*to]);
        if !alike {
            return false;
        }
        for take in &trace.takes {
            match *take {
                Take::Number { at, kind, slot } => {
                    let value = if trace.big_endian { number::<true>(kind, &payload[at..]) } else { number::<false>(kind, &payload[at..]) };
                    slots[slot] = value.unwrap_or_default();
                }
                Take::Text { at, length, slot } => {
                    slots[slot] = crate::log::extract::extractor::cdr::number::shown(&payload[at..at + length])
                }
            }
        }
        self.patience = self.patience.saturating_add(1);
        true
    }

    /// Forgets the last message; gives what the next walk notes, if there is still hope.
    pub(crate) fn learn(&mut self) -> Option<Trace> {
        self.template = &[];
        self.patience = self.patience.saturating_sub(1);
        (self.patience > 0).then(|| {
            let mut trace = std::mem::take(&mut self.trace);
            trace.clear();
            trace
        })
    }

    /// Keeps what a walk over `payload` noted.
    pub(crate) fn keep(&mut self, payload: &'a [u8], trace: Trace) {
        if trace.hopeless {
            self.patience = 0;
        } else {
            self.template = payload;
        }
        self.trace = trace;
    }
}

impl Trace {
    fn clear(&mut self) {
        self.places.clear();
        self.takes.clear();
        self.hopeless = false;
    }

    /// Notes that the walk depends on the bytes between `from` and `to`.
    pub(crate) fn depends_on(&mut self, from: usize, to: usize) {
        let full = self.places.len() == MAX_PLACES;
        match self.places.last_mut() {
            Some((_, last)) if from >= *last && from - *last <= PADDING => *last = to,
            _ if full => self.hopeless = true,
            _ => self.places.push((from, to)),
        }
    }

    pub(crate) fn number(&mut self, at: usize, kind: Kind, slot: usize) {
        self.takes.push(Take::Number { at, kind, slot });
    }

    pub(crate) fn text(&mut self, at: usize, length: usize, slot: usize) {
        self.takes.push(Take::Text { at, length, slot });
    }

    /// Notes that the walk depends on values.
    pub(crate) fn give_up(&mut self) {
        self.hopeless = true;
    }

    /// Notes the end of a walk.
    pub(crate) fn close(&mut self, end: usize, big_endian: bool) {
        (self.end, self.big_endian) = (end, big_endian);
    }
}
