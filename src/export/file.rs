//! A file of an export.

/// A file to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Its name, without a folder.
    pub name: String,
    /// Its text; empty for a file that is none.
    pub text: String,
    /// Its content, if it is not text.
    pub bytes: Option<Vec<u8>>,
    /// Notes for the reader: factors, omissions.
    pub note: Option<String>,
}

impl File {
    pub(crate) fn new(name: impl Into<String>, text: String) -> Self {
        Self { name: name.into(), text, bytes: None, note: None }
    }

    /// A file that is not text.
    pub(crate) fn binary(name: impl Into<String>, bytes: Vec<u8>) -> Self {
        Self { name: name.into(), text: String::new(), bytes: Some(bytes), note: None }
    }

    /// Its content.
    pub fn content(&self) -> &[u8] {
        self.bytes.as_deref().unwrap_or(self.text.as_bytes())
    }
}
