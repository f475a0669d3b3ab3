//! The tour in `docs/tour.md`: its files are written and its commands run, in order, in an empty folder.
#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test says what it ran

use assert_cmd::Command;
use std::path::Path;

/// A fenced block of the tour.
#[derive(Debug, PartialEq)]
enum Block {
    /// Name and text of a file to save.
    File(String, String),
    /// A command line.
    Command(String),
}

/// The blocks in order: ```` ```toml NAME ```` is a file, every line of ```` ```sh ```` a command.
fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut lines = text.lines();
    while let Some(line) = lines.next() {
        let Some(info) = line.strip_prefix("```") else { continue };
        let body: Vec<&str> = lines.by_ref().take_while(|l| *l != "```").collect();
        match info.split_once(' ').unwrap_or((info, "")) {
            ("toml", name) => blocks.push(Block::File(name.to_owned(), body.join("\n") + "\n")),
            ("sh", "") => blocks.extend(body.iter().filter(|l| !l.trim().is_empty()).map(|l| Block::Command((*l).to_owned()))),
            other => panic!("a block of the tour is neither a file nor commands: {other:?}"),
        }
    }
    blocks
}

#[test]
fn every_command_of_the_tour_does_what_it_says() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/tour.md")).unwrap();
    let steps: Vec<&str> = text.lines().filter(|l| l.starts_with("## ")).collect();
    assert_eq!(steps.len(), 8, "{steps:?}");
    let folder = tempfile::tempdir().unwrap();
    let mut commands = 0;
    for block in blocks(&text) {
        match block {
            Block::File(name, text) => {
                assert!(!name.is_empty() && !name.contains(['/', '\\']), "a file of the tour has no plain name: {name:?}");
                std::fs::write(folder.path().join(name), text).unwrap();
            }
            Block::Command(line) => {
                println!("{line}");
                let mut words = line.split_whitespace();
                assert_eq!(words.next(), Some("pivot-cal"), "{line}");
                let output = Command::cargo_bin("pivot-cal").unwrap().current_dir(folder.path()).args(words).output().unwrap();
                let errors = String::from_utf8_lossy(&output.stderr);
                assert!(output.status.success(), "{line}: {}\n{}{errors}", output.status, String::from_utf8_lossy(&output.stdout));
                commands += 1;
            }
        }
    }
    assert!(commands >= 9, "{commands} commands");
    // what the text names is there
    for name in [
        "monday.mcap",
        "maps/table1.csv",
        "maps/table1.json",
        "maps/table2.csv",
        "maps/table2.json",
        "maps/verify.json",
        "maps/report.html",
        "scenarios/left-90.mcap",
        "figures/table2-forward.svg",
    ] {
        assert!(folder.path().join(name).is_file(), "{name} is missing");
    }
    let page = std::fs::read_to_string(folder.path().join("maps/report.html")).unwrap();
    assert!(page.contains("It may be deployed on this vehicle."), "the tour ends with a map that passes");
}

#[test]
fn blocks_are_reported_apart() {
    let found = blocks("text\n```toml a.toml\nx = 1\n```\n```sh\npivot-cal fit a\n\npivot-cal invert\n```\n");
    let command = |text: &str| Block::Command(text.to_owned());
    assert_eq!(found, [Block::File("a.toml".into(), "x = 1\n".into()), command("pivot-cal fit a"), command("pivot-cal invert")]);
}
