//! Why a scene file cannot be used.

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a scene file cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("line {line}: {message}{}", nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    Toml { line: usize, message: String, nearest: Option<String> },
    #[error("{}the name {found:?} is not allowed: 1 to 40 letters, digits, - and _, since logs are named by it", place(*line))]
    Name { line: Option<usize>, found: String },
    #[error(
        "the file holds {found} of the sections [parking], [u_turn], [polyline] and [lateral]; one scene is one of them: put each into a file of its own"
    )]
    Sections { found: usize },
    #[error("{}[{section}] has no meaning in a scene with [{kind}]; leave it out", place(*line))]
    Unused { line: Option<usize>, section: &'static str, kind: &'static str },
    #[error("{}{key} is {found}; allowed: {allowed}", place(*line))]
    Range { line: Option<usize>, key: String, found: f64, allowed: String },
    #[error("{}{key} is {low} to {high}; the first number is the lower end: exchange them", place(*line))]
    Order { line: Option<usize>, key: String, low: f64, high: f64 },
    #[error("{}{key}: {problem}", place(*line))]
    Shape { line: Option<usize>, key: String, problem: String },
    #[error("{}{key}: {message}", place(*line))]
    Planning { line: Option<usize>, key: &'static str, message: String },
}

/// The line in front of a message, where it is known.
fn place(line: Option<usize>) -> String {
    line.map(|line| format!("line {line}: ")).unwrap_or_default()
}
