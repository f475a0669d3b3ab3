//! The proof that an exported map may be deployed: the verdict of `verify.json` beside it, or the reason why there is none.

use crate::controller::ControllerFile;
use crate::export::Result;
use crate::map::{CsvRef, MapFolder};
use crate::verify::deployment::deployment;
use crate::verify::{MapVerdict, Status};

/// Whether a map may be deployed. It is written into the header of every exported file.
#[derive(Debug, Clone, PartialEq)]
pub struct Proof {
    /// Whether a verdict on every pivot belongs to the map and passes.
    pub is_verified: bool,
    /// The first line of the verdict, or the reason why the map is not verified.
    pub reason: String,
    /// Settings of the controller that the verdict is about.
    pub(crate) controller: Option<ControllerFile>,
}

impl Proof {
    /// From the files of a folder that belong together. A `verify.json` that is missing, broken, or of another map is a reason, not an error.
    ///
    /// # Errors
    /// A `verify.json` that is there and cannot be read from disk.
    pub(crate) fn of(files: &MapFolder, csvs: &[CsvRef]) -> Result<Self> {
        let not = |reason: String| Self { is_verified: false, reason, controller: None };
        let Some(json) = files.other("verify.json")? else {
            let (_, reason) = deployment(&files.table1, None);
            return Ok(not(if reason.starts_with("not judged") { "there is no verify.json".to_owned() } else { reason }));
        };
        let verdict = match json.text().map_err(|e| e.to_string()).and_then(|text| MapVerdict::from_json(text).map_err(|e| e.to_string())) {
            Ok(verdict) => verdict.on(&files.table1),
            Err(error) => return Ok(not(format!("verify.json is no verdict: {error}"))),
        };
        let csvs: Vec<String> = csvs.iter().map(|csv| csv.sha256.clone()).collect();
        if !verdict.is_about(&files.table1.generation, &csvs) {
            return Ok(not("verify.json is the verdict on another map".to_owned()));
        }
        if let Some(command) = &verdict.controller_command {
            let reason =
                format!("the verdict is about {}, not about this map with the bundled controller: run pivot-cal verify", command.label());
            return Ok(not(reason));
        }
        let (status, reason) = deployment(&files.table1, Some(&verdict));
        Ok(Self { is_verified: status == Status::Pass, reason, controller: verdict.controller_settings })
    }

    /// The line of a header.
    pub(crate) fn line(&self) -> String {
        let state = if self.is_verified { "Verdict" } else { "UNVERIFIED, not for deployment" };
        format!("{state}: {}.", self.reason)
    }
}
