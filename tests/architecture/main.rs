//! The architecture, read from the source as text: no circles, imports that point down, small files, one meaning for
//! a name.
//!
//! `docs/architecture.md` draws the floors. `cargo test --test architecture -- --nocapture` prints the counts.
#![allow(clippy::unwrap_used)]

mod arrows;
mod cut;
mod floors;
mod graph;
mod lexer;
mod picture;
mod resolve;
mod scan;
mod small_trees;
mod tree;
mod use_tree;

use arrows::{Arrows, arrows};
use graph::{Graph, described};
use picture::{Picture, pictures};
use scan::Defines;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::LazyLock;
use tree::{Tree, texts, tree};

/// Lines that a file may have without its tests.
const MOST_LINES: usize = 400;
/// Lines that half of the files may have at most.
const MEDIAN_LINES: usize = 110;

static PACKAGE: LazyLock<(Tree, Arrows)> = LazyLock::new(|| {
    let tree = tree(&texts(Path::new(env!("CARGO_MANIFEST_DIR"))));
    let arrows = arrows(&tree);
    (tree, arrows)
});

#[test]
fn every_file_and_every_import_is_understood() {
    let (tree, arrows) = &*PACKAGE;
    let faults: Vec<_> = tree.faults.iter().chain(&arrows.faults).map(String::as_str).collect();
    assert!(faults.is_empty(), "not understood:\n{}", faults.join("\n"));
    assert!(tree.lines.len() >= 300, "only {} files seen", tree.lines.len());
    assert!(arrows.ties.len() >= 700, "only {} arrows seen", arrows.ties.len());
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let ties = &PACKAGE.1.ties;
    let circles: Vec<_> = Graph::new(ties).circles().iter().map(|circle| described(circle, ties)).collect();
    assert!(circles.is_empty(), "{} circles\n{}", circles.len(), circles.join("\n"));
}

#[test]
fn rooms_import_only_rooms_on_lower_floors() {
    let pictures = drawn();
    assert!(pictures.iter().any(|picture| picture.inside.is_empty()), "docs/architecture.md draws no floors");
    let (tree, arrows) = &*PACKAGE;
    let mut described = Vec::new();
    for picture in &pictures {
        let objections = floors::objections(picture, tree.lines.keys(), &arrows.ties);
        let place = if picture.inside.is_empty() { "Floors".to_owned() } else { format!("Inside {}", picture.inside) };
        described.extend(objections.iter().map(|objection| format!("{place}: {objection}")));
    }
    assert!(described.is_empty(), "docs/architecture.md draws it otherwise:\n{}", described.join("\n"));
}

#[test]
fn no_file_is_long_and_half_of_them_are_short() {
    let lines = &PACKAGE.0.lines;
    let long: Vec<_> = lines.iter().filter(|(_, lines)| **lines > MOST_LINES).collect();
    assert!(long.is_empty(), "more than {MOST_LINES} lines without tests: {long:?}");
    assert!(median(lines) <= MEDIAN_LINES, "the median is {} lines, more than {MEDIAN_LINES}", median(lines));
}

#[test]
fn every_type_name_is_defined_in_one_file_only() {
    let shared = shared_type_names();
    let described: Vec<_> = shared.iter().map(|(name, files)| format!("  {name}: {}", listed(files))).collect();
    assert!(described.is_empty(), "{} names of types are defined in several files:\n{}", described.len(), described.join("\n"));
}

#[test]
#[allow(clippy::print_stdout)] // the counts are what it is for
fn the_counts_are_printed() {
    let (tree, arrows) = &*PACKAGE;
    let graph = Graph::new(&arrows.ties);
    let (longest, most) = tree.lines.iter().max_by_key(|(_, lines)| **lines).unwrap();
    println!(
        "{} files, median {} lines, longest {longest} with {most}; {} arrows, {} circles, {} floors of files; \
         {} names of types defined more than once",
        tree.lines.len(),
        median(&tree.lines),
        arrows.ties.len(),
        graph.circles().len(),
        graph.longest_chain(),
        shared_type_names().len(),
    );
}

fn drawn() -> Vec<Picture> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/architecture.md");
    pictures(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn median(lines: &BTreeMap<String, usize>) -> usize {
    let mut sorted: Vec<_> = lines.values().copied().collect();
    sorted.sort_unstable();
    sorted[sorted.len() / 2]
}

/// Names that every room has: its errors, and the arguments of a command.
const OF_EVERY_ROOM: [&str; 3] = ["Error", "Result", "Arguments"];

/// Names of types that several files define, with those files.
fn shared_type_names() -> BTreeMap<&'static str, BTreeSet<&'static str>> {
    let mut files: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for module in &PACKAGE.0.modules {
        for (name, _) in module.scope.items.iter().filter(|(_, defines)| defines.contains(&Defines::Type)) {
            files.entry(name).or_default().insert(&module.file);
        }
    }
    files.into_iter().filter(|(name, files)| files.len() > 1 && !OF_EVERY_ROOM.contains(name)).collect()
}

fn listed(files: &BTreeSet<&str>) -> String {
    files.iter().copied().collect::<Vec<_>>().join(", ")
}
