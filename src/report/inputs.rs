//! What a folder of maps holds, and whether its files belong together.

use crate::manoeuvre::ManoeuvreTraces;
use crate::map::{FitTraces, PlanFile, SAME_ANGLE_DEG, Table1File, Table2File, sha256_hex};
use crate::report::{Error, Result};
use crate::verify::{ClosedLoop, MapVerdict, Scenario};
use std::path::Path;

/// The files that a report is made from. Only `table1.json` is needed.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// `table1.json`.
    pub table1: Table1File,
    /// `table2.json`.
    pub table2: Option<Table2File>,
    /// `verify.json`.
    pub verdict: Option<MapVerdict>,
    /// `fit_traces.json`, of the same fit.
    pub fit_traces: Option<FitTraces>,
    /// `verify_traces.json`, of the same Table 2.
    pub closed_loop: Option<ClosedLoop>,
    /// `manoeuvre_traces.json`, of the same Table 2.
    pub manoeuvres: Option<ManoeuvreTraces>,
    /// `plan.json`, of the same Table 1.
    pub plan: Option<PlanFile>,
    /// Name and SHA-256 of every file that was read, and of the tables' CSVs.
    pub files: Vec<(String, String)>,
    /// What is missing or does not belong together; empty when all is well.
    pub notes: Vec<String>,
    /// Whether the verdict is about these tables.
    pub verdict_is_current: bool,
    /// Wheel angles [°] of which the files hold maps, too, and which are not shown: the page is about the test angle.
    pub other_angles_deg: Vec<f64>,
}

/// Whether a map may be deployed, as far as the files tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Judgement {
    /// The verdict of these very tables is a pass.
    Pass,
    /// It is a fail.
    Fail,
    /// There is none, it is about other tables, or it leaves out pivots.
    NotJudged,
}

impl Inputs {
    /// Reads the folder. What is absent, or belongs to other tables, is left out and told in `notes`.
    ///
    /// # Errors
    /// No `table1.json`, or a file that is there and cannot be read.
    pub fn read(folder: &Path) -> Result<Self> {
        let path = folder.join("table1.json");
        let text1 = std::fs::read_to_string(&path).map_err(|source| Error::NoTable1 { path: path.clone(), source })?;
        let table1 = Table1File::from_json(&text1).map_err(|source| Error::Map { path, source })?;
        let mut files = vec![("table1.json".to_owned(), sha256_hex(text1.as_bytes()))];
        let mut notes = Vec::new();
        let mut text = |name: &str| -> Result<Option<String>> {
            let path = folder.join(name);
            match std::fs::read_to_string(&path) {
                Ok(text) => {
                    files.push((name.to_owned(), sha256_hex(text.as_bytes())));
                    Ok(Some(text))
                }
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
                Err(source) => Err(Error::Read { path, source }),
            }
        };
        let of_map = |name: &str| {
            let path = folder.join(name);
            move |source| Error::Map { path, source }
        };
        let of_verdict = |name: &str| {
            let path = folder.join(name);
            move |source| Error::Verdict { path, source }
        };
        let table2 = text("table2.json")?.map(|t| Table2File::from_json(&t)).transpose().map_err(of_map("table2.json"))?;
        let verdict = text("verify.json")?.map(|t| MapVerdict::from_json(&t)).transpose().map_err(of_verdict("verify.json"))?;
        let fit_traces = text("fit_traces.json")?.map(|t| FitTraces::from_json(&t)).transpose().map_err(of_map("fit_traces.json"))?;
        let closed_loop =
            text("verify_traces.json")?.map(|t| ClosedLoop::from_json(&t)).transpose().map_err(of_verdict("verify_traces.json"))?;
        let manoeuvres = text("manoeuvre_traces.json")?;
        let manoeuvres = manoeuvres.map(|t| ManoeuvreTraces::from_json(&t)).transpose().map_err(of_verdict("manoeuvre_traces.json"))?;
        let plan = text("plan.json")?.map(|t| PlanFile::from_json(&t)).transpose().map_err(of_map("plan.json"))?;

        let sha1 = files[0].1.clone();
        if let Some(table2) = table2.as_ref().filter(|t| t.table1.sha256 != sha1) {
            notes.push(format!(
                "table2.json was made from another table1.json ({:.12}…): run `pivot-cal invert` again",
                table2.table1.sha256
            ));
        }
        let csvs = table1.maps.iter().map(|m| &m.csv).chain(table2.iter().flat_map(|t| t.maps.iter().map(|m| &m.csv)));
        for csv in csvs {
            match std::fs::read(folder.join(&csv.file)) {
                Ok(bytes) => {
                    let found = sha256_hex(&bytes);
                    if found != csv.sha256 {
                        notes.push(format!(
                            "{} is not the file that its JSON describes: it was edited, or belongs to another map",
                            csv.file
                        ));
                    }
                    files.push((csv.file.clone(), found));
                }
                Err(_) => notes.push(format!("{} is missing", csv.file)),
            }
        }
        let fits_together = notes.is_empty();
        let hashes = |table2: &Table2File| table2.maps.iter().map(|m| m.csv.sha256.clone()).collect::<Vec<String>>();
        let same = |judged: &[String]| table2.as_ref().is_some_and(|t| judged.iter().all(|s| hashes(t).contains(s)));
        let verdict_is_current = fits_together && verdict.as_ref().is_some_and(|v| same(&v.table2_csv_sha256));
        match (&table2, &verdict) {
            (None, _) => notes.push("there is no table2.json: run `pivot-cal invert`".to_owned()),
            (_, None) => notes.push("there is no verify.json: run `pivot-cal verify`".to_owned()),
            (_, Some(v)) if !same(&v.table2_csv_sha256) => {
                notes.push("verify.json judged another Table 2: run `pivot-cal verify` again".to_owned());
            }
            (_, Some(v)) => {
                let missing = pivots_left_out(v);
                if missing > 0 {
                    notes.push(format!("verify.json leaves out {missing} of the pivots: run `pivot-cal verify` without --scenario"));
                }
            }
        }
        let fit_traces = fit_traces.filter(|t| {
            let same = t.table1.sha256 == sha1;
            if !same {
                notes.push("fit_traces.json belongs to another table1.json and is left out: run `pivot-cal fit` again".to_owned());
            }
            same
        });
        let closed_loop = closed_loop.filter(|t| {
            let same = same(&t.table2_csv_sha256);
            if !same {
                notes.push("verify_traces.json belongs to another Table 2 and is left out: run `pivot-cal verify` again".to_owned());
            }
            same
        });
        let manoeuvres = manoeuvres.filter(|t| {
            let same = same(&t.table2_csv_sha256);
            if !same {
                notes.push(
                    "manoeuvre_traces.json belongs to another Table 2 and is left out: run `pivot-cal verify --scenario manoeuvres` again"
                        .to_owned(),
                );
            }
            same
        });
        let plan = plan.filter(|p| {
            let same = p.table1_sha256 == sha1;
            if !same {
                notes.push("plan.json was made from another table1.json and is left out: run `pivot-cal plan` again".to_owned());
            }
            same
        });
        let (mut table1, mut table2) = (table1, table2);
        let test_angle_deg = table1.vehicle.test_angle_deg;
        let shown = |angle_deg: f64| (angle_deg - test_angle_deg).abs() < SAME_ANGLE_DEG;
        let mut other_angles_deg = Vec::new();
        if table1.maps.iter().any(|m| shown(m.wheel_angle_deg)) {
            other_angles_deg = table1.maps.iter().map(|m| m.wheel_angle_deg).filter(|a| !shown(*a)).collect();
            other_angles_deg.sort_unstable_by(f64::total_cmp);
            other_angles_deg.dedup();
            table1.maps.retain(|m| shown(m.wheel_angle_deg));
            if let Some(table2) = &mut table2 {
                table2.maps.retain(|m| shown(m.wheel_angle_deg));
            }
        }
        Ok(Self { table1, table2, verdict, fit_traces, closed_loop, manoeuvres, plan, files, notes, verdict_is_current, other_angles_deg })
    }

    /// Whether the map may be deployed.
    pub fn judgement(&self) -> Judgement {
        match &self.verdict {
            Some(verdict) if self.verdict_is_current && !verdict.passes() => Judgement::Fail,
            Some(verdict) if self.verdict_is_current && pivots_left_out(verdict) == 0 => Judgement::Pass,
            _ => Judgement::NotJudged,
        }
    }
}

/// How many of the pivots a verdict says nothing of: one of chosen scenarios alone judges no map.
fn pivots_left_out(verdict: &MapVerdict) -> usize {
    Scenario::all().iter().filter(|pivot| verdict.scenarios.iter().all(|judged| judged.name != pivot.name)).count()
}
