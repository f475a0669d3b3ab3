//! Why a controller file cannot be used.

/// Result of this room.
pub(crate) type Result<T> = std::result::Result<T, Error>;

/// Why a controller file cannot be used.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
#[allow(missing_docs)] // the message explains the fields
pub enum Error {
    #[error("line {line}: {message}{}", nearest.as_ref().map(|n| format!("; did you mean `{n}`?")).unwrap_or_default())]
    Toml { line: usize, message: String, nearest: Option<String> },
    #[error("{}{key} is {found}; allowed: {allowed}", line.map(|line| format!("line {line}: ")).unwrap_or_default())]
    Range { line: Option<usize>, key: String, found: f64, allowed: String },
    #[error("{key} is {found}, and {other} is {limit}: {rule}")]
    Contradiction { key: &'static str, found: f64, other: &'static str, limit: f64, rule: &'static str },
}
