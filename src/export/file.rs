//! A file of an export.

/// A file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Its name, without a folder.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Notes for the reader: factors, omissions.
    pub note: Option<String>,
}

impl File {
    pub(crate) fn new(name: impl Into<String>, text: String) -> Self {
        Self { name: name.into(), text, note: None }
    }
}
