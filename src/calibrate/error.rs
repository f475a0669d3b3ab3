//! The errors between logs and a verified map: those of all modules, with the file concerned.

use crate::text::shown;
use std::path::Path;

/// Result of this module.
pub type Result<T> = std::result::Result<T, Error>;

/// An error between logs and a verified map.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A cause with its file, folder or circumstance.
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
    /// A log without usable data.
    #[error(transparent)]
    Campaign(#[from] crate::campaign::Error),
    /// The fit failed.
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
    /// No log with usable data.
    #[error("no log has usable data: {reasons}")]
    NoUsableLog {
        /// The reason of each log.
        reasons: String,
    },
    /// A folder without a readable Table 1.
    #[error("there is no Table 1; a fit of logs makes it")]
    NoTable1 {
        /// The file, and why it cannot be read.
        source: Box<Error>,
    },
    /// A requested wheel angle.
    #[error("wheel angle {angle_deg}°: {reason}")]
    WheelAngle {
        /// The angle [°].
        angle_deg: f64,
        /// Why it is not possible.
        reason: String,
    },
    /// A CSV is not the one that `table1.json` describes.
    #[error("{what}. The numbers of table1.json would be inverted, not those of the CSV: fit again", what = edited_csv(path))]
    EditedCsv {
        /// The CSV.
        path: std::path::PathBuf,
    },
}

/// Message on an edited CSV.
pub(crate) fn edited_csv(path: &Path) -> String {
    format!("{} is not the file that table1.json describes: its hash differs", shown(path))
}

/// Adds the subject of an error.
pub(crate) trait About<T> {
    /// Adds the subject of the error.
    fn about(self, what: impl FnOnce() -> String) -> Result<T>;

    /// Adds the file concerned.
    fn in_file(self, path: &Path) -> Result<T>
    where
        Self: Sized,
    {
        self.about(|| shown(path))
    }
}

impl<T, E: Into<Error>> About<T> for std::result::Result<T, E> {
    fn about(self, what: impl FnOnce() -> String) -> Result<T> {
        self.map_err(|error| Error::About { what: what(), source: Box::new(error.into()) })
    }
}
