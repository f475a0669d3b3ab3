//! Circles and floors of the files.

use crate::arrows::Ties;
use std::collections::{BTreeMap, BTreeSet};

/// Files and what each imports.
#[derive(Debug, Default)]
pub(crate) struct Graph<'a> {
    below: BTreeMap<&'a str, BTreeSet<&'a str>>,
    /// Files that can be reached from each.
    reach: BTreeMap<&'a str, BTreeSet<&'a str>>,
}

impl<'a> Graph<'a> {
    /// The graph of these ties.
    pub(crate) fn new(ties: &'a Ties) -> Self {
        let mut below: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for (from, to) in ties.keys() {
            below.entry(from).or_default().insert(to);
            below.entry(to).or_default();
        }
        let reach = below.keys().map(|file| (*file, reached(&below, file))).collect();
        Self { below, reach }
    }

    /// The sets of files of which each can be reached from each other.
    pub(crate) fn circles(&self) -> Vec<BTreeSet<&'a str>> {
        let circles: BTreeSet<_> = self.below.keys().map(|file| self.circle(file)).collect();
        circles.into_iter().filter(|circle| circle.len() > 1).collect()
    }

    /// The number of files on the longest way down; a circle counts as one.
    pub(crate) fn longest_chain(&self) -> usize {
        let mut known = BTreeMap::new();
        self.below.keys().map(|file| self.chain(file, &mut known)).max().unwrap_or(0)
    }

    /// `file` and all that reach it and that it reaches.
    fn circle(&self, file: &'a str) -> BTreeSet<&'a str> {
        let back = self.reach[file].iter().copied().filter(|other| self.reach[other].contains(file));
        back.chain([file]).collect()
    }

    fn chain(&self, file: &'a str, known: &mut BTreeMap<&'a str, usize>) -> usize {
        if let Some(length) = known.get(file) {
            return *length;
        }
        let circle = self.circle(file);
        let below: BTreeSet<&str> = circle.iter().flat_map(|member| self.below[member].iter().copied()).collect();
        let length = 1 + below.difference(&circle).map(|next| self.chain(next, known)).max().unwrap_or(0);
        known.insert(file, length);
        length
    }
}

/// A circle as text: each tie within it on a line of its own.
pub(crate) fn described(circle: &BTreeSet<&str>, ties: &Ties) -> String {
    let within = ties.iter().filter(|((from, to), _)| circle.contains(from.as_str()) && circle.contains(to.as_str()));
    let lines: Vec<_> = within.map(|((from, to), names)| tie(from, to, names)).collect();
    format!("a circle of {} files:\n{}", circle.len(), lines.join("\n"))
}

/// One tie as text.
pub(crate) fn tie(from: &str, to: &str, names: &BTreeSet<String>) -> String {
    let names: Vec<_> = names.iter().map(String::as_str).collect();
    format!("  {from} → {to}: {}", names.join(", "))
}

fn reached<'a>(below: &BTreeMap<&'a str, BTreeSet<&'a str>>, file: &str) -> BTreeSet<&'a str> {
    let mut reach = BTreeSet::new();
    let mut next: Vec<&str> = below[file].iter().copied().collect();
    while let Some(file) = next.pop() {
        if reach.insert(file) {
            next.extend(&below[file]);
        }
    }
    reach
}
