//! The controller compiles without the standard library and without an allocator.
//!
//! A build of the whole package cannot prove it: there other crates load the standard library, and with it the float functions of the standard
//! library resolve in every crate. So the crate is built alone here, with its one dependency and no features.
#![allow(clippy::unwrap_used)]

use std::path::Path;
use std::process::Command;

#[test]
fn the_controller_compiles_alone_without_the_standard_library() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).join("alone");
    let built = Command::new(env!("CARGO"))
        .args(["build", "--offline", "--package", "pivot-control", "--no-default-features", "--manifest-path"])
        .arg(package.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(&target)
        .output()
        .unwrap();
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
}
