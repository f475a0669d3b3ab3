//! Checks the stamps that a signal map names: a missing field is an error that names the nearest field.

use crate::log::extract::stamp;
use crate::log::find::candidates::json_leaves;
use crate::log::schema::{Layout, LeafKind};
use crate::log::signal_map::{SignalName, SignalSpec, Stamp};
use crate::log::{Error, Result};
use crate::spelling::edits;

/// Whether the messages of `layout` hold the stamp that `spec` names; `sample` is one of them.
///
/// # Errors
/// They do not.
pub(crate) fn check(layout: &Layout, signal: SignalName, spec: &SignalSpec, sample: Option<&[u8]>) -> Result<()> {
    let Stamp::At(steps) = &spec.stamp else { return Ok(()) };
    if stamp::find(layout, &spec.stamp, sample).is_some() || (matches!(layout, Layout::Json) && sample.is_none()) {
        return Ok(());
    }
    let stamp = steps.iter().map(ToString::to_string).collect::<String>().trim_start_matches('.').to_owned();
    let nearest = nearest(layout, &stamp, sample).into_iter().collect();
    Err(Error::NoStamp { signal: signal.key(), topic: spec.path.topic.clone(), stamp, nearest })
}

/// The field that is nearest to `wanted` in spelling and holds a number: a stamp as a whole, not one of its parts.
fn nearest(layout: &Layout, wanted: &str, sample: Option<&[u8]>) -> Option<String> {
    let leaves = if matches!(layout, Layout::Json) { json_leaves(sample) } else { layout.leaves() };
    let whole = |path: &str| {
        let path = path.trim_start_matches('.');
        let part = path.rsplit_once('.').filter(|(_, last)| stamp::SECONDS.contains(last) || stamp::NANOSECONDS.contains(last));
        part.map_or(path, |(front, _)| front).to_owned()
    };
    let fields = leaves.iter().filter(|leaf| leaf.list.is_none() && leaf.kind != LeafKind::Text).map(|leaf| whole(&leaf.path));
    fields.min_by_key(|field| (edits(wanted, field), field.clone())).filter(|field| edits(wanted, field) <= wanted.len() / 2)
}
