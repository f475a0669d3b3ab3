//! The bytes of a log: its outer structure, the records of its blocks, and what of them is lost.

pub(crate) mod block;
pub(crate) mod bytes;
pub(crate) mod channel_set;
pub(crate) mod container;
pub(crate) mod input;
pub(crate) mod lz4;
pub(crate) mod open;
pub(crate) mod record;
pub(crate) mod scan;
pub(crate) mod structure;
pub(crate) mod summary;
