//! Whether the files keep to the picture: rooms import only rooms on lower floors.

use crate::arrows::Ties;
use crate::graph::tie;
use crate::picture::Picture;
use std::collections::BTreeSet;

/// What speaks against `picture`: rooms that are missing on one side, imports that do not point down.
pub(crate) fn objections<'a>(picture: &Picture, files: impl Iterator<Item = &'a String>, ties: &Ties) -> Vec<String> {
    let inside = &picture.inside;
    let built: BTreeSet<&str> = files.filter_map(|file| room(file, inside)).collect();
    let drawn = picture.rooms();
    let undrawn = built.difference(&drawn).map(|room| format!("{room:?} is not drawn"));
    let unbuilt = drawn.difference(&built).map(|room| format!("{room:?} is drawn and not there"));
    let mut objections: Vec<_> = undrawn.chain(unbuilt).collect();
    for ((from, to), names) in ties {
        if let (Some(upper), Some(lower)) = (room(from, inside), room(to, inside))
            && let (Some(from_floor), Some(to_floor)) = (picture.floor(upper), picture.floor(lower))
            && upper != lower
            && from_floor >= to_floor
        {
            objections.push(format!("{upper} imports {lower}, which is not below it:\n{}", tie(from, to, names)));
        }
    }
    objections
}

/// The room within `inside` (the whole package if that is empty) to which `file` belongs. The roots of the library and
/// of a room belong to none.
pub(crate) fn room<'a>(file: &'a str, inside: &str) -> Option<&'a str> {
    let mut rest = file.strip_prefix("src/")?;
    if !inside.is_empty() {
        rest = rest.strip_prefix(inside)?.strip_prefix('/')?;
    }
    let name = rest.split('/').next()?;
    let name = name.strip_suffix(".rs").unwrap_or(name);
    (name != "lib" && name != "mod").then_some(name)
}
