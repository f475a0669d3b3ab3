//! Compiles message paths, once per schema, into a plan that skips to the wanted values.
//!
//! In: a channel's schema and the wanted paths. Out: an [`Extractor`] that fills one slot per path from a payload, without building
//! the message.

mod cdr;
mod index;
mod json;
pub(crate) mod json_literals;
#[cfg(test)]
mod oracle;
mod protobuf;
mod request_tree;
mod slice;
pub(crate) mod taken;

use crate::log::extract::extractor::taken::Taken;
use crate::log::extractor_error::PlanError;
use crate::log::path::{MessagePath, PathStep};
use crate::log::schema::Layout;
use crate::log::value::Raw;
use request_tree::Wishes;

/// A plan for the messages of one channel.
#[derive(Debug)]
pub(crate) struct Extractor {
    /// Number of paths. They have the first slots.
    paths: usize,
    slots: usize,
    /// Slots that hold the index of a sibling's match. They are kept for a second walk.
    registers: Vec<usize>,
    decoder: Decoder,
}

#[derive(Debug)]
enum Decoder {
    Cdr(cdr::CdrProgram),
    Ros1(cdr::CdrProgram),
    Protobuf(protobuf::ProtobufProgram),
    Json(json::JsonProgram),
}

impl Extractor {
    /// Compiles `paths` for messages of `layout`; path `i` fills slot `i`.
    ///
    /// # Errors
    /// The first path that does not lead to a value, with its index.
    pub(crate) fn compile(layout: &Layout, paths: &[&MessagePath]) -> Result<Self, (usize, PlanError)> {
        let mut wishes = Wishes::new(paths.len());
        for (slot, path) in paths.iter().enumerate() {
            wishes.add(&path.steps, slot).map_err(|error| (slot, error))?;
        }
        let decoder = Self::decoder(layout, &wishes).map_err(|error| {
            // compile each path alone to find the wrong one
            let alone = |path: &MessagePath| {
                let mut alone = Wishes::new(1);
                alone.add(&path.steps, 0).and_then(|()| Self::decoder(layout, &alone)).err()
            };
            let found = paths.iter().enumerate().find_map(|(slot, path)| Some((slot, alone(path)?)));
            found.unwrap_or((0, error))
        })?;
        Ok(Self { paths: paths.len(), slots: wishes.slots, registers: wishes.registers, decoder })
    }

    /// Whether `steps` lead to a value in messages of `layout`. JSON has no schema: the answer is whether the value in the `sample`
    /// `passes`.
    pub(crate) fn leads(layout: &Layout, steps: &[PathStep], sample: Option<&[u8]>, passes: impl Fn(&Raw<'_>) -> bool) -> bool {
        let path = MessagePath::inside(steps.to_vec());
        let Ok(plan) = Self::compile(layout, &[&path]) else { return false };
        let mut taken = Taken::default();
        !matches!(layout, Layout::Json) || sample.is_some_and(|payload| plan.decode(payload, &mut taken).is_some() && passes(taken.get(0)))
    }

    /// Number of paths in the plan.
    pub(crate) fn paths(&self) -> usize {
        self.paths
    }

    fn decoder(layout: &Layout, wishes: &Wishes) -> Result<Decoder, PlanError> {
        Ok(match layout {
            Layout::Cdr(shape) => Decoder::Cdr(cdr::CdrProgram::compile(shape, &wishes.root)?),
            Layout::Ros1(shape) => Decoder::Ros1(cdr::CdrProgram::compile(shape, &wishes.root)?),
            Layout::Protobuf(message) => Decoder::Protobuf(protobuf::ProtobufProgram::compile(message, &wishes.root)?),
            Layout::Json => Decoder::Json(json::JsonProgram::compile(&wishes.root)),
        })
    }

    /// Fills `taken` from a payload; `None` if the payload does not fit the schema. No other plan may have filled `taken` before.
    pub(crate) fn decode<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        taken.lists.iter_mut().for_each(Vec::clear);
        if taken.shortcut.run(payload, &mut taken.slots) {
            return Some(());
        }
        taken.slots.resize(self.slots, Raw::Missing);
        taken.slots.fill(Raw::Missing);
        taken.again = false;
        self.walk(payload, taken)?;
        if taken.again && self.registers.iter().any(|slot| taken.slots[*slot] != Raw::Missing) {
            self.walk(payload, taken)?;
        }
        Some(())
    }

    /// The reason why payloads of this form cannot be read at all, although they are not broken.
    pub(crate) fn refusal(&self, payload: &[u8]) -> Option<&'static str> {
        matches!(self.decoder, Decoder::Cdr(_)).then(|| cdr::CdrProgram::refusal(payload)).flatten()
    }

    fn walk<'a>(&self, payload: &'a [u8], taken: &mut Taken<'a>) -> Option<()> {
        match &self.decoder {
            Decoder::Cdr(program) => program.run_cdr(payload, taken),
            Decoder::Ros1(program) => program.run_ros1(payload, taken),
            Decoder::Protobuf(program) => program.run(payload, taken),
            Decoder::Json(program) => program.run(payload, taken),
        }
    }
}
