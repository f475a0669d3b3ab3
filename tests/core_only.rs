//! The controller and the look-up use `core` arithmetic alone: what `examples/core_only.rs`, which compiles them without the standard library,
//! cannot tell, since float functions of the standard library resolve wherever any dependency links it.
#![allow(clippy::unwrap_used)]

use std::path::{Path, PathBuf};

/// Methods of `f64` that need a mathematics library, and everything that allocates, reads a clock or does input or output.
const FORBIDDEN: [&str; 37] = [
    ".sqrt(",
    ".sin(",
    ".cos(",
    ".tan(",
    ".sin_cos(",
    ".asin(",
    ".acos(",
    ".atan(",
    ".atan2(",
    ".exp(",
    ".ln(",
    ".log10(",
    ".powi(",
    ".powf(",
    ".hypot(",
    ".floor(",
    ".ceil(",
    ".round(",
    ".trunc(",
    ".fract(",
    ".mul_add(",
    ".rem_euclid(",
    ".cbrt(",
    "f64::hypot",
    "std::",
    "alloc::",
    "Vec<",
    "vec!",
    "String",
    "Box<",
    "format!",
    "println!",
    ".to_vec(",
    ".collect(",
    "Instant",
    "unwrap(",
    "panic!",
];

/// The program text of a file, without its tests and comments.
fn program(path: &Path) -> Vec<(usize, String)> {
    let text = std::fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]").next().unwrap();
    code.lines().enumerate().map(|(k, line)| (k + 1, line.split("//").next().unwrap().to_owned())).collect()
}

#[test]
fn the_controller_and_the_look_up_use_core_arithmetic_alone() {
    let room = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    // routes and manoeuvres are planned on a computer
    let of_vehicle = |path: &PathBuf| path.is_file() && !path.ends_with("route.rs") && !path.ends_with("manoeuvre.rs");
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(room.join("control")).unwrap().map(|entry| entry.unwrap().path()).filter(of_vehicle).collect();
    files.extend(["map/lookup.rs", "map/angle_lookup.rs"].map(|name| room.join(name)));
    assert!(files.len() > 15, "{files:?}");
    for file in files {
        for (line, text) in program(&file) {
            let found = FORBIDDEN.iter().find(|word| text.contains(**word));
            assert!(found.is_none(), "{}:{line}: {} is not core arithmetic: {text}", file.display(), found.unwrap());
        }
    }
}

#[test]
fn the_example_compiles_every_file_of_the_controller() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let [room, example] = ["src/control.rs", "examples/core_only.rs"].map(|name| std::fs::read_to_string(root.join(name)).unwrap());
    for module in room.lines().filter(|line| line.starts_with("mod ")) {
        assert!(example.contains(module), "{module} is not in examples/core_only.rs");
    }
}
