//! The figures of `docs/manoeuvres.md` are those of the program: `examples/manoeuvre_figures.rs` writes them.
#![allow(clippy::unwrap_used)]

#[path = "common/map_copy.rs"]
mod map_copy;
#[path = "../examples/manoeuvre_figures/tables.rs"]
mod tables;

use map_copy::{copied, run};

#[test]
fn the_document_has_the_figures_of_the_program() {
    let (folder, _) = copied();
    let (status, said, errors) = run(folder.path(), &["verify", "--scenario", "manoeuvres", "--json"]);
    assert_eq!(status, 0, "{errors}");
    let verdict = serde_json::from_str(&said).unwrap();
    let document = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/manoeuvres.md")).unwrap();
    let wanted = tables::filled(&document, &tables::tables(&verdict));
    for name in ["polyline", "compensation", "parking", "u-turn"] {
        assert!(document.contains(&format!("<!-- table {name} -->")), "no mark for {name}");
    }
    for (found, wanted) in document.lines().zip(wanted.lines()) {
        assert_eq!(found, wanted, "made again by: cargo run --example manoeuvre_figures VERDICT.json docs/manoeuvres.md");
    }
    assert_eq!(document, wanted);
}
