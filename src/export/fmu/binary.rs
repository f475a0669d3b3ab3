//! The binary of a unit for this machine, by the C compiler on the path.

use std::path::Path;
use std::process::{Command, Stdio};

/// The C compiler that is looked for on the path.
const COMPILER: &str = "cc";

/// What the compiler made.
pub(crate) enum Compiled {
    /// A shared library, and what made it.
    Binary {
        /// Its content.
        bytes: Vec<u8>,
        /// Name and version of the compiler.
        by: String,
    },
    /// None, and why.
    None(String),
}

/// Compiles the `.c` files among `sources`, names and texts, into a shared library.
pub(crate) fn compiled(sources: &[(String, String)]) -> Compiled {
    made(sources).map_or_else(Compiled::None, |(bytes, by)| Compiled::Binary { bytes, by })
}

fn made(sources: &[(String, String)]) -> Result<(Vec<u8>, String), String> {
    let version = Command::new(COMPILER)
        .arg("--version")
        .stdin(Stdio::null())
        .output()
        .map_err(|fault| format!("there is no C compiler {COMPILER} on the path ({fault})"))?;
    let by = String::from_utf8_lossy(&version.stdout).lines().next().unwrap_or(COMPILER).to_owned();
    let folder = tempfile::tempdir().map_err(|fault| format!("no temporary folder: {fault}"))?;
    for (name, text) in sources {
        std::fs::write(folder.path().join(name), text).map_err(|fault| format!("{name} cannot be written to be compiled: {fault}"))?;
    }
    let library = folder.path().join("pivot_plant.so");
    let is_c = |name: &str| Path::new(name).extension().is_some_and(|extension| extension == "c");
    // no folder in the binary: the same compiler makes the same bytes
    let output = Command::new(COMPILER)
        .current_dir(folder.path())
        .args(["-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden", "-ffp-contract=off", "-o", "pivot_plant.so"])
        .args(sources.iter().map(|(name, _)| name).filter(|name| is_c(name)))
        .arg("-lm")
        .stdin(Stdio::null())
        .output()
        .map_err(|fault| format!("{COMPILER} cannot be run: {fault}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr).lines().next().unwrap_or_default().to_owned();
        return Err(format!("{COMPILER} failed with {}: {said}", output.status));
    }
    let bytes = std::fs::read(&library).map_err(|fault| format!("{COMPILER} left no library: {fault}"))?;
    Ok((bytes, by))
}
