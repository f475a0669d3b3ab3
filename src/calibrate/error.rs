//! What can go wrong on the way from logs to a verified map: the errors of all rooms, with the file that they are about.

use std::path::Path;

/// Result of this room.
pub type Result<T> = std::result::Result<T, Error>;

/// What can go wrong on the way from logs to a verified map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The file, folder or circumstance that the cause is about.
    #[error("{what}")]
    About {
        /// The file, folder or circumstance.
        what: String,
        /// The cause.
        source: Box<Error>,
    },
    /// A log cannot be read.
    #[error(transparent)]
    Log(#[from] crate::log::Error),
    /// The signals of a log do not fit together.
    #[error(transparent)]
    Signal(#[from] crate::signal::Error),
    /// A log holds nothing to use.
    #[error(transparent)]
    Campaign(#[from] crate::campaign::Error),
    /// There is no fit.
    #[error(transparent)]
    Fit(#[from] crate::fit::Error),
    /// Table 1 cannot be inverted.
    #[error(transparent)]
    Invert(#[from] crate::invert::Error),
    /// The map cannot be judged.
    #[error(transparent)]
    Verify(#[from] crate::verify::Error),
    /// A file of the map cannot be read or written.
    #[error(transparent)]
    Map(#[from] crate::map::Error),
    /// The page cannot be written.
    #[error(transparent)]
    Report(#[from] crate::report::Error),
    /// A file cannot be read or written.
    #[error(transparent)]
    Io(#[from] std::io::Error),
    /// No log holds anything to use.
    #[error("no log holds anything to use: {reasons}")]
    NoUsableLog {
        /// The reason of each log.
        reasons: String,
    },
    /// A wheel angle that was asked for.
    #[error("wheel angle {angle_deg}°: {reason}")]
    WheelAngle {
        /// The angle [°].
        angle_deg: f64,
        /// Why it cannot be had.
        reason: String,
    },
    /// A CSV is not the one that `table1.json` describes.
    #[error(
        "{what}. The numbers of table1.json would be inverted, not those of the CSV: fit again, or go on with --force",
        what = edited_csv(path)
    )]
    EditedCsv {
        /// The CSV.
        path: std::path::PathBuf,
    },
}

/// What is wrong with an edited CSV.
pub(crate) fn edited_csv(path: &Path) -> String {
    format!("{} is not the file that table1.json describes: its hash differs", path.display())
}

/// Adds what an error is about.
pub(crate) trait About<T> {
    /// Adds what the error is about.
    fn about(self, what: impl FnOnce() -> String) -> Result<T>;

    /// Adds the file that the error is about.
    fn in_file(self, path: &Path) -> Result<T>
    where
        Self: Sized,
    {
        self.about(|| path.display().to_string())
    }
}

impl<T, E: Into<Error>> About<T> for std::result::Result<T, E> {
    fn about(self, what: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|error| Error::About { what: what(), source: Box::new(error.into()) })
    }
}
