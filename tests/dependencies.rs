//! The list of dependencies and their reasons is the one that is built.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

fn text(name: &str) -> String {
    std::fs::read_to_string(std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(name)).unwrap()
}

/// Names of the dependencies in a section of `Cargo.toml`.
fn declared(section: &str) -> BTreeSet<String> {
    let manifest: toml::Table = text("Cargo.toml").parse().unwrap();
    manifest[section].as_table().unwrap().keys().cloned().collect()
}

/// Names in the first column of the tables under a heading of `docs/dependencies.md`.
fn explained(heading: &str) -> BTreeSet<String> {
    let text = text("docs/dependencies.md");
    let part = text.split("\n## ").find(|part| part.starts_with(heading)).unwrap();
    let rows = part.lines().filter_map(|line| line.strip_prefix("| ")?.split(" | ").next());
    rows.filter(|cell| *cell != "package").flat_map(|cell| cell.split(", ")).map(str::to_owned).collect()
}

#[test]
fn every_dependency_has_its_reason() {
    assert_eq!(explained("In the program"), declared("dependencies"));
    let known = explained("In the program");
    let tests: BTreeSet<String> = declared("dev-dependencies").into_iter().filter(|name| !known.contains(name)).collect();
    assert_eq!(explained("In tests and benchmarks"), tests);
}

#[test]
fn every_package_comes_from_the_registry() {
    let lock: toml::Table = text("Cargo.lock").parse().unwrap();
    for package in lock["package"].as_array().unwrap() {
        let source = package.get("source").and_then(toml::Value::as_str);
        let is_ours = package["name"].as_str().unwrap().starts_with("pivot-");
        assert_eq!(source, (!is_ours).then_some("registry+https://github.com/rust-lang/crates.io-index"), "{package}");
    }
}
