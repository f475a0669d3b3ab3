//! Programs by others that read what was written: Python with packages, a C compiler.
#![allow(dead_code, clippy::unwrap_used)] // every test takes what it needs

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Prints to standard error, past the test harness, what was not tested; with `PIVOT_CAL_REQUIRE_READERS=1` that is a failure.
pub(crate) fn not_tested(what: &str, why: &str) {
    let _ = writeln!(std::io::stderr(), "NOT TESTED: {what}: {why}");
    let required = std::env::var("PIVOT_CAL_REQUIRE_READERS").is_ok_and(|v| v == "1");
    assert!(!required, "{what} cannot be tested: {why}, and PIVOT_CAL_REQUIRE_READERS=1 requires it");
}

/// A Python that has `modules`: the one of the environment variable `PIVOT_CAL_PYTHON`, of `target/readers`, or on the path. When there is
/// none: `None`, and a line that says so.
pub(crate) fn python(modules: &[&str], what: &str) -> Option<PathBuf> {
    let venv = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/readers/bin/python");
    let candidates = [std::env::var_os("PIVOT_CAL_PYTHON").map(PathBuf::from), Some(venv), Some("python3".into())];
    // found, not imported: some take seconds
    let finds = "import importlib.util, sys\nsys.exit(any(importlib.util.find_spec(m) is None for m in sys.argv[1:]))";
    let has = |python: &PathBuf| {
        let run = Command::new(python).arg("-c").arg(finds).args(modules).stdout(Stdio::null()).stderr(Stdio::null()).status();
        run.is_ok_and(|status| status.success())
    };
    let found = candidates.into_iter().flatten().find(has);
    if found.is_none() {
        let packages = if modules.is_empty() { String::new() } else { format!(" with {}", modules.join(", ")) };
        not_tested(what, &format!("there is no Python{packages}"));
    }
    found
}

/// Runs a script of `tests/readers` with `input` and returns the JSON that is the last line of what it prints.
pub(crate) fn read_with(python: &Path, script: &str, args: &[&Path], input: &str) -> serde_json::Value {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/readers").join(script);
    let mut child =
        Command::new(python).arg(&script).args(args).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let bytes = input.as_bytes().to_vec();
    let feed = std::thread::spawn(move || {
        let _ = stdin.write_all(&bytes);
    });
    let output = child.wait_with_output().unwrap();
    feed.join().unwrap();
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{}: {errors}", script.display());
    // packages may print lines of their own before
    let text = String::from_utf8_lossy(&output.stdout);
    serde_json::from_str(text.lines().last().unwrap_or_default()).unwrap_or_else(|e| panic!("{e}: {text}\n{errors}"))
}
