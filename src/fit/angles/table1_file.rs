//! One `table1.json` from the fits of all angles.

use crate::campaign::{SampleVerdict, ledger, with_missing};
use crate::check::campaign_checks::content_checks;
use crate::fit::Result;
use crate::fit::angles::family::families;
use crate::fit::angles::fitted_angles::FittedAngles;
use crate::fit::angles::listed_runs::{counts, listed};
use crate::fit::angles::shrink_together::draw_together;
use crate::fit::table1::actuator::actuator;
use crate::fit::table1::angle_fit::AngleFit;
use crate::fit::table1::diagnostics::{diagnostics, plant_noise, speed_readings};
use crate::fit::table1::prediction_checks::prediction_checks;
use crate::fit::table1::runs::{residual_rms_mps2, round};
use crate::fit::table1::soundness::{checks, coverage};
use crate::map::{AccelMap, Check, CheckOutcome, FORMAT_VERSION, LogRef, RunRow, Stage1Report, TABLE1_FORMAT, Table1File, Units, Vehicle};

/// Table 1 with its files.
#[derive(Debug, Clone)]
pub struct Fit {
    /// `table1.json`.
    pub file: Table1File,
    /// Name and text of each CSV beside it.
    pub csvs: Vec<(String, String)>,
    /// The final verdict on every encoder sample, per log in the order of `file.logs`.
    pub verdicts: Vec<Vec<SampleVerdict>>,
    /// Whether no check of the file is an objection.
    pub sound: bool,
}

impl FittedAngles<'_> {
    /// The files.
    ///
    /// # Errors
    /// No fit at the test angle; invalid tables.
    pub(crate) fn table1(&self) -> Result<Fit> {
        let test = self.test()?;
        let verdicts = self.verdicts();
        let mut maps: Vec<AccelMap> = self.angles.iter().flat_map(|fit| fit.maps.iter().cloned()).collect();
        let found = families(&maps)?;
        draw_together(&mut maps, &found)?;
        let csvs = maps.iter().map(|map| Ok((map.csv.file.clone(), map.table()?.to_matrix().to_csv()))).collect::<Result<_>>()?;
        let (logs, surveys): (Vec<_>, Vec<_>) = self.logs().into_iter().unzip();
        let seconds = verdicts.iter().zip(&surveys).flat_map(|(v, s)| v.iter().copied().zip(s.seconds.iter().copied()));
        let all: Vec<RunRow> = self.runs().into_iter().map(|run| run.row).collect();
        let all: Vec<&RunRow> = all.iter().collect();
        let listed = listed(&all);
        let report = Stage1Report {
            ledger: with_missing(ledger(seconds), surveys.iter().map(|survey| survey.missing_s()).sum()),
            runs: listed.iter().map(|k| all[*k].clone()).collect(),
            listed_runs: counts(&all, listed.len()),
            residual_rms_mps2: round(self.residual_rms_mps2(), 1e5),
            coverage: round(coverage(&maps), 1e4),
            iterations: self.angles.iter().map(|fit| fit.estimate.rounds.count as u32).max().unwrap_or(0),
            notes: self.notes(),
            diagnostics: self.diagnostics(test),
        };
        let mut file = Table1File {
            format: TABLE1_FORMAT.to_owned(),
            format_version: FORMAT_VERSION,
            tool_version: env!("CARGO_PKG_VERSION").to_owned(),
            generation: String::new(),
            units: Units::default(),
            vehicle: self.vehicle(),
            torque_limit_driven: self.logs()[0].1.track.vehicle.torque_limit_nm.is_none(),
            logs: logs.into_iter().cloned().collect(),
            settings: serde_json::to_value(self.task.settings).map_err(crate::map::Error::from)?,
            actuator: actuator(&self.delays()?, &test.estimate, &surveys, &self.task.choice, self.task.settings),
            witnesses: speed_readings(&test.estimate),
            noise: plant_noise(&test.estimate),
            maps,
            families: found.into_iter().map(|f| f.reported).collect(),
            checks: self.checks(),
            report,
        };
        let of_content = content_checks(&file);
        file.checks.extend(of_content);
        let file = file.with_generation()?;
        let sound = !file.checks.iter().any(Check::objects);
        Ok(Fit { file, csvs, verdicts, sound })
    }

    /// The checks that need the estimates; the name of one at another wheel angle than the test angle ends in the angle.
    fn checks(&self) -> Vec<Check> {
        let mut all = Vec::new();
        for fit in &self.angles {
            let angle_deg = fit.wheel_angle_deg;
            let mut own = checks(&fit.estimate, &fit.maps, &fit.samples, self.task.settings);
            own.extend(prediction_checks(&fit.estimate, &fit.compared, self.task.settings));
            if self.task.is_test(angle_deg) {
                all.extend(own);
            } else {
                let named =
                    |c: Check| Check { name: format!("{}-{angle_deg}", c.name), meaning: format!("{angle_deg}°: {}", c.meaning), ..c };
                all.extend(own.into_iter().map(named));
            }
        }
        if self.task.asked && !self.left_out.is_empty() {
            let reasons: Vec<String> = self.left_out.iter().map(|(angle, reason)| format!("{angle}° is left out: {reason}")).collect();
            let figure = (self.left_out.len() as f64, 0.0, "wheel angles");
            let check = Check::passed("wheel-angles", figure, reasons.join("; "));
            all.push(check.broken(CheckOutcome::Objection, "drive more runs there, or fit without these angles"));
        }
        all
    }

    /// The vehicle with the test angle, and with the largest commanded torque where no limit is given.
    fn vehicle(&self) -> Vehicle {
        let logs = self.logs();
        let commanded = logs.iter().flat_map(|(_, s)| &s.track.command_nm.value).fold(0.0f64, |m, v| m.max(v.abs()));
        let vehicle = logs[0].1.track.vehicle;
        Vehicle { test_angle_deg: self.task.test_angle_deg, torque_limit_nm: vehicle.torque_limit_nm.or(Some(commanded)), ..vehicle }
    }

    /// One verdict per sample and log: that of the sample's wheel angle, otherwise *wheel not at angle*.
    fn verdicts(&self) -> Vec<Vec<SampleVerdict>> {
        let of_log = |(log, survey): (&LogRef, &crate::campaign::Survey)| {
            let mut merged = vec![SampleVerdict::WheelNotAtAngle; survey.verdicts.len()];
            for fit in &self.angles {
                let Some(k) = fit.estimate.data.logs.iter().position(|l| l.survey.track.source == *log) else { continue };
                for (all, own) in merged.iter_mut().zip(&fit.verdicts[k]) {
                    if *all == SampleVerdict::WheelNotAtAngle {
                        *all = *own;
                    }
                }
            }
            merged
        };
        self.logs().into_iter().map(of_log).collect()
    }

    /// The runs of all angles by log and time.
    pub(crate) fn runs(&self) -> Vec<AngleRun> {
        let logs = self.logs();
        let mut all = Vec::new();
        for (angle, fit) in self.angles.iter().enumerate() {
            let wheel_angle_deg = self.are_several().then_some(fit.wheel_angle_deg);
            for (own, (row, log)) in fit.figures.rows.iter().zip(&fit.figures.logs).enumerate() {
                let source = &fit.estimate.data.logs[*log].survey.track.source;
                let log = logs.iter().position(|(log, _)| *log == source).unwrap_or(usize::MAX);
                all.push(AngleRun { angle, own, log, row: RunRow { wheel_angle_deg, ..row.clone() } });
            }
        }
        all.sort_by(|a, b| a.log.cmp(&b.log).then(a.row.start_s.total_cmp(&b.row.start_s)).then(a.angle.cmp(&b.angle)));
        all
    }

    fn residual_rms_mps2(&self) -> f64 {
        let square = |fit: &AngleFit| residual_rms_mps2(&fit.estimate).powi(2) * fit.samples.len() as f64;
        let squares: f64 = self.angles.iter().map(square).sum();
        let used: usize = self.angles.iter().map(|fit| fit.samples.len()).sum();
        (squares / used.max(1) as f64).sqrt()
    }

    /// Notes for the reader: of the angles, of the logs' signals, of the torque input, then of each fit.
    fn notes(&self) -> Vec<String> {
        let mut notes = self.task.grouped.notes.clone();
        notes.extend(self.left_out.iter().map(|(angle, reason)| format!("{angle}° is left out: {reason}")));
        let of_track = |survey: &crate::campaign::Survey| -> Vec<String> {
            survey.track.notes.iter().map(|n| format!("{}: {n}", survey.track.source.file)).collect()
        };
        let of_logs: Vec<String> = self.logs().into_iter().flat_map(|(_, survey)| of_track(survey)).collect();
        notes.extend(of_logs.iter().cloned());
        notes.extend(self.task.choice.note());
        for fit in &self.angles {
            // most notes of a log's signals are the same at every angle
            let own = fit.estimate.data.logs.iter().flat_map(|l| of_track(l.survey)).filter(|note| !of_logs.contains(note));
            let all = own.chain(fit.notes());
            if self.are_several() {
                notes.extend(all.map(|note| format!("{}°: {note}", fit.wheel_angle_deg)));
            } else {
                notes.extend(all);
            }
        }
        notes
    }

    fn diagnostics(&self, test: &AngleFit) -> serde_json::Value {
        let of = |fit: &AngleFit| diagnostics(&fit.estimate, fit.monotone, fit.figures.pooled);
        let mut all = of(test);
        if self.are_several() {
            let with_angle = |fit: &AngleFit| {
                let mut one = of(fit);
                one["wheel_angle_deg"] = serde_json::json!(fit.wheel_angle_deg);
                one
            };
            all["angles"] = self.angles.iter().map(with_angle).collect();
        }
        all
    }
}

/// A run among those of all angles.
pub(crate) struct AngleRun {
    /// Number of the angle.
    pub(crate) angle: usize,
    /// Number of the row among the angle's own.
    pub(crate) own: usize,
    /// Number of the log.
    log: usize,
    pub(crate) row: RunRow,
}
