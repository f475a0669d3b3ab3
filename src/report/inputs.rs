//! The files in a folder of maps, and whether they belong together.

use crate::check::campaign_checks::all_checks;
use crate::manoeuvre::ManoeuvreTraces;
use crate::map::{
    Check, FitTraces, FolderError, FolderView, MapFolder, Mismatch, PlanFile, StoredFile, Table1File, Table2File, read_settled,
};
use crate::report::{Error, Result};
use crate::verify::deployment::deployment;
use crate::verify::{ClosedLoop, MapVerdict, Status};
use std::path::{Path, PathBuf};

/// The input files of a report. Only `table1.json` is needed.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportFiles {
    /// `table1.json`.
    pub table1: Table1File,
    /// `table2.json`.
    pub table2: Option<Table2File>,
    /// `verify.json`.
    pub verdict: Option<MapVerdict>,
    /// `fit_traces.json`, of the same fit.
    pub fit_traces: Option<FitTraces>,
    /// `verify_traces.json`, of the same Table 2.
    pub(crate) closed_loop: Option<ClosedLoop>,
    /// `manoeuvre_traces.json`, of the same Table 2.
    pub(crate) manoeuvres: Option<ManoeuvreTraces>,
    /// `plan.json`, of the same Table 1.
    pub(crate) plan: Option<PlanFile>,
    /// Name and SHA-256 of every file that was read, and of the tables' CSVs.
    pub files: Vec<(String, String)>,
    /// Missing files and mismatches; empty if there are none.
    pub notes: Vec<String>,
    /// Whether the verdict is about these tables.
    pub verdict_is_current: bool,
    /// The checks on the campaign and the fit.
    pub(crate) checks: Vec<Check>,
    /// Other wheel angles [°] with maps in the files. They are not shown: the page is about the test angle.
    pub other_angles_deg: Vec<f64>,
}

impl ReportFiles {
    /// Reads the folder. A file that is missing or belongs to other tables is skipped and noted.
    ///
    /// # Errors
    /// No `table1.json`, or an existing file that cannot be read.
    pub fn read(folder: &Path) -> Result<Self> {
        Self::read_from(&folder.into())
    }

    /// The same for a folder that this process has the right to write into.
    ///
    /// # Errors
    /// As [`ReportFiles::read`].
    pub(crate) fn read_own(folder: &Path) -> Result<Self> {
        Self::read_once(&FolderView::own(folder))
    }

    /// The same for a folder whose files may not be written yet. While another process writes there, it is read again.
    ///
    /// # Errors
    /// As [`ReportFiles::read`].
    pub(crate) fn read_from(view: &FolderView) -> Result<Self> {
        read_settled(view, || Self::read_once(view), |read| read.as_ref().is_ok_and(|files| files.notes.is_empty()))
    }

    fn read_once(view: &FolderView) -> Result<Self> {
        let folder = &view.path;
        let (maps, mismatches) = MapFolder::read(view).map_err(|error| unread(folder, error))?;
        let mut beside = Beside { maps: &maps, files: Vec::new() };
        let verdict = beside.read("verify.json", MapVerdict::from_json, verdict_error)?;
        let fit_traces = beside.read("fit_traces.json", FitTraces::from_json, map_error)?;
        let closed_loop = beside.read("verify_traces.json", ClosedLoop::from_json, verdict_error)?;
        let manoeuvres = beside.read("manoeuvre_traces.json", ManoeuvreTraces::from_json, verdict_error)?;
        let plan = beside.read("plan.json", PlanFile::from_json, map_error)?;
        let others = beside.files;

        let described = |file: &StoredFile| (file.name.clone(), file.sha256.clone());
        let tables = std::iter::once(&maps.table1_json).chain(maps.table2.as_ref().map(|(_, json)| json));
        let files = tables.map(described).chain(others).chain(maps.csvs.iter().map(described)).collect();

        let mut notes: Vec<String> = mismatches.iter().filter_map(|m| mismatch_note(m, &maps)).collect();
        let fits_together = notes.is_empty();
        let MapFolder { mut table1, table1_json, table2, .. } = maps;
        let mut table2 = table2.map(|(file, _)| file);
        let sha1 = table1_json.sha256;
        let csvs: Option<Vec<String>> = table2.as_ref().map(|t| t.maps.iter().map(|m| m.csv.sha256.clone()).collect());
        let generation = table1.generation.clone();
        let of_table2 = |of: &str, judged: &[String]| {
            of == generation && csvs.as_ref().is_some_and(|csvs| judged.iter().all(|sha256| csvs.contains(sha256)))
        };
        let is_judged = verdict.as_ref().zip(csvs.as_ref()).is_some_and(|(v, csvs)| v.is_about(&generation, csvs));
        let verdict_is_current = fits_together && is_judged;
        notes.extend(verdict_note(table2.is_some(), verdict.as_ref(), is_judged));

        let mut left_out = |belongs: bool, note: &str| {
            if !belongs {
                notes.push(note.to_owned());
            }
            belongs
        };
        let fit_traces = fit_traces.filter(|t| {
            let note = "fit_traces.json belongs to another table1.json and is left out: run `pivot-cal fit` again";
            left_out(t.generation == generation && t.table1.sha256 == sha1, note)
        });
        let closed_loop = closed_loop.filter(|t| {
            let note = "verify_traces.json belongs to another Table 2 and is left out: run `pivot-cal verify` again";
            left_out(of_table2(&t.generation, &t.table2_csv_sha256), note)
        });
        let manoeuvres = manoeuvres.filter(|t| {
            let note =
                "manoeuvre_traces.json belongs to another Table 2 and is left out: run `pivot-cal verify --scenario manoeuvres` again";
            left_out(of_table2(&t.generation, &t.table2_csv_sha256), note)
        });
        let plan = plan.filter(|p| {
            let note = "plan.json was made from another table1.json and is left out: run `pivot-cal plan` again";
            left_out(p.generation == generation && p.table1_sha256 == sha1, note)
        });
        let checks = all_checks(&table1);
        let verdict = verdict.map(|v| if verdict_is_current { v.on(&table1) } else { v });
        let other_angles_deg = keep_test_angle(&mut table1, table2.as_mut());
        Ok(Self {
            table1,
            table2,
            verdict,
            fit_traces,
            closed_loop,
            manoeuvres,
            plan,
            files,
            notes,
            verdict_is_current,
            checks,
            other_angles_deg,
        })
    }

    /// Whether the map may be deployed, and the reason as one line. An objection of Table 1 counts without a verdict too.
    pub(crate) fn judgement(&self) -> (Status, String) {
        deployment(&self.table1, self.verdict.as_ref().filter(|_| self.verdict_is_current))
    }
}

/// The files beside the tables, with the name and the hash of each that was read.
struct Beside<'a> {
    maps: &'a MapFolder,
    files: Vec<(String, String)>,
}

impl Beside<'_> {
    /// Reads a file; `None` if it does not exist.
    fn read<T, E>(
        &mut self,
        name: &str,
        from_json: impl Fn(&str) -> std::result::Result<T, E>,
        error: impl Fn(PathBuf, E) -> Error,
    ) -> Result<Option<T>> {
        let path = || self.maps.view.path.join(name);
        let Some(file) = self.maps.other(name).map_err(|e| unread(&self.maps.view.path, e))? else { return Ok(None) };
        let text = file.text().map_err(|source| Error::Read { path: path(), source })?;
        let read = from_json(text).map_err(|e| error(path(), e))?;
        self.files.push((file.name, file.sha256));
        Ok(Some(read))
    }
}

fn map_error(path: PathBuf, source: crate::map::Error) -> Error {
    Error::Map { path, source }
}

fn verdict_error(path: PathBuf, source: crate::verify::Error) -> Error {
    Error::Verdict { path, source }
}

fn unread(folder: &Path, error: FolderError) -> Error {
    match error {
        FolderError::Read { path, source } if path == folder.join("table1.json") => Error::NoTable1 { path, source },
        FolderError::Read { path, source } => Error::Read { path, source },
        FolderError::File { path, source } => Error::Map { path, source },
    }
}

/// Note on a mismatch. The note on a missing Table 2 is given with the verdict.
fn mismatch_note(mismatch: &Mismatch, maps: &MapFolder) -> Option<String> {
    match mismatch {
        Mismatch::Hash { file, expected, .. } if *file == maps.table1_json.name => {
            Some(format!("table2.json was made from another table1.json ({expected:.12}…): run `pivot-cal invert` again"))
        }
        Mismatch::Generation { file, by, found, expected } => {
            Some(format!("{file} is of generation {found}, {by} of {expected}: run `pivot-cal invert` again"))
        }
        Mismatch::Hash { file, .. } => {
            Some(format!("{file} is not the file that its JSON describes: it was edited, or belongs to another map"))
        }
        Mismatch::Unreadable { file, .. } if file == "table2.json" => None,
        Mismatch::Unreadable { file, .. } => Some(format!("{file} is missing")),
    }
}

/// Note on an incomplete verdict.
fn verdict_note(has_table2: bool, verdict: Option<&MapVerdict>, is_judged: bool) -> Option<String> {
    if !has_table2 {
        return Some("there is no table2.json: run `pivot-cal invert`".to_owned());
    }
    let Some(verdict) = verdict else { return Some("there is no verify.json: run `pivot-cal verify`".to_owned()) };
    if !is_judged {
        return Some("verify.json judged another Table 2: run `pivot-cal verify` again".to_owned());
    }
    let missing = verdict.pivots_left_out();
    (missing > 0).then(|| format!("verify.json leaves out {missing} of the pivots: run `pivot-cal verify` without --scenario"))
}

/// Keeps the maps at the test angle, if there are any, and returns the other wheel angles [°].
fn keep_test_angle(table1: &mut Table1File, table2: Option<&mut Table2File>) -> Vec<f64> {
    let test_angle = table1.vehicle.test_angle();
    if !table1.maps.iter().any(|m| m.angle().is_same(test_angle)) {
        return Vec::new();
    }
    let mut others: Vec<f64> = table1.maps.iter().map(|m| m.wheel_angle_deg).filter(|a| !test_angle.is_same_deg(*a)).collect();
    others.sort_unstable_by(f64::total_cmp);
    others.dedup();
    table1.maps.retain(|m| m.angle().is_same(test_angle));
    if let Some(table2) = table2 {
        table2.maps.retain(|m| m.angle().is_same(test_angle));
    }
    others
}
