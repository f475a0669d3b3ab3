//! Sets of channels. Equal sets are kept once: a long log has thousands of chunks but only a few sets.

use std::collections::BTreeSet;
use std::sync::Arc;

/// The channels of one chunk.
pub(crate) type ChannelSet = Arc<BTreeSet<u16>>;

/// The sets found so far.
#[derive(Debug, Default)]
pub(crate) struct ChannelSets(BTreeSet<ChannelSet>);

impl ChannelSets {
    /// The kept set that is equal to `set`.
    pub(crate) fn shared(&mut self, set: BTreeSet<u16>) -> ChannelSet {
        if let Some(known) = self.0.get(&set) {
            return known.clone();
        }
        let set = Arc::new(set);
        self.0.insert(set.clone());
        set
    }
}
