//! Generated code, compiled as a controller would compile it, and run with lines of input.
#![allow(clippy::unwrap_used)]

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const WARNINGS: [&str; 6] = ["-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Werror"];

/// The C compiler of this machine.
pub(crate) fn c_compiler() -> Option<PathBuf> {
    ["cc", "gcc", "clang"].into_iter().find(|c| Command::new(c).arg("--version").output().is_ok()).map(PathBuf::from)
}

fn compile(command: &mut Command) {
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

/// A harness with a C source of the folder.
pub(crate) fn c_program(compiler: &Path, folder: &Path, harness: &str, source: &str, optimise: &str) -> PathBuf {
    c_program_of(compiler, folder, harness, &[source], optimise)
}

/// A harness with C sources of the folder and the library of mathematics.
pub(crate) fn c_program_of(compiler: &Path, folder: &Path, harness: &str, sources: &[&str], optimise: &str) -> PathBuf {
    std::fs::write(folder.join("main.c"), harness).unwrap();
    let program = folder.join(format!("c{optimise}"));
    let sources = std::iter::once(&"main.c").chain(sources).map(|name| folder.join(name));
    compile(Command::new(compiler).args(WARNINGS).args([optimise, "-ffp-contract=off"]).args(sources).arg("-o").arg(&program).arg("-lm"));
    program
}

/// A harness with the Rust modules of the folder.
pub(crate) fn rust_program(folder: &Path, harness: &str) -> PathBuf {
    std::fs::write(folder.join("main.rs"), harness).unwrap();
    let (program, rustc) = (folder.join("rust"), std::env::var_os("RUSTC").unwrap_or_else(|| "rustc".into()));
    compile(Command::new(rustc).args(["--edition", "2021", "-O", "-D", "warnings", "-o"]).arg(&program).arg(folder.join("main.rs")));
    program
}

/// Runs a harness: what its self-test prints, and an answer for each further line.
pub(crate) fn answers<T>(program: &Path, input: &str, answer: impl Fn(&str) -> T) -> (String, Vec<T>) {
    let mut child = Command::new(program).stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let bytes = input.as_bytes().to_vec();
    let feed = std::thread::spawn(move || stdin.write_all(&bytes).unwrap());
    let output = child.wait_with_output().unwrap();
    feed.join().unwrap();
    assert!(output.status.success());
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    let self_test = lines.next().unwrap().to_owned();
    (self_test, lines.map(answer).collect())
}
