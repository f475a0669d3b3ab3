//! The program as a process, and the files of the repository.

#![allow(dead_code, clippy::unwrap_used)] // every test takes what it needs

use assert_cmd::Command;
use std::path::Path;

/// The place of a file of the repository.
pub(crate) fn repo(path: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path).to_str().unwrap().to_owned()
}

/// The text of a file of the repository.
pub(crate) fn text(path: &str) -> String {
    std::fs::read_to_string(repo(path)).unwrap()
}

/// Runs the program in `folder`; exit status, standard output, standard error.
pub(crate) fn run(folder: &Path, args: &[&str]) -> (i32, String, String) {
    run_with(folder, &[], args)
}

/// The same with variables of the environment.
pub(crate) fn run_with(folder: &Path, variables: &[(&str, &str)], args: &[&str]) -> (i32, String, String) {
    let mut command = Command::cargo_bin("pivot-cal").unwrap();
    let output = command.current_dir(folder).envs(variables.iter().copied()).args(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let errors = text(&output.stderr);
    assert!(!errors.contains("panicked"), "{errors}");
    (output.status.code().unwrap(), text(&output.stdout), errors)
}
