//! From messages to columns of values: a compiled extractor per schema, one pass over the messages, times and units.

pub(crate) mod column;
pub(crate) mod convert;
pub(crate) mod extractor;
pub(crate) mod fields;
pub(crate) mod message_pass;
pub(crate) mod stamp;
