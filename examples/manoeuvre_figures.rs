//! Writes the tables of `docs/manoeuvres.md` from a verdict on all manoeuvres:
//!
//! ```sh
//! pivot-cal verify --scenario manoeuvres --json > verdict.json
//! cargo run --example manoeuvre_figures verdict.json docs/manoeuvres.md
//! ```
//!
//! Without a document it prints the tables. `tests/manoeuvre_figures.rs` holds the document against the program.
#![allow(clippy::print_stdout)] // the tables are what this program is for

#[path = "manoeuvre_figures/tables.rs"]
mod tables;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let verdict = arguments.next().ok_or("usage: manoeuvre_figures VERDICT.json [DOCUMENT]")?;
    let tables = tables::tables(&serde_json::from_str(&std::fs::read_to_string(verdict)?)?);
    match arguments.next() {
        Some(document) => std::fs::write(&document, tables::filled(&std::fs::read_to_string(&document)?, &tables))?,
        None => tables.iter().for_each(|(name, table)| println!("{name}\n\n{table}")),
    }
    Ok(())
}
