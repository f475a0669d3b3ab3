//! The fits at all wheel angles of a campaign; one angle is a list of one.
//!
//! Drive and encoder are the same at every angle, and so are dead times, lag and encoder calibration (`shared_delays`). With those held,
//! every angle is fitted by itself. Angles never share samples: each has its own friction and inertia. The common part of the finished maps
//! is then estimated, and moves them toward each other as far as their standard errors allow (`family`, `shrink_together`).

use crate::campaign::{AngleGroup, Grouped, Survey};
use crate::fit::angles::shared_delays::{Pooled, Shared};
use crate::fit::drive::torque_input::TorqueChoice;
use crate::fit::rounds::drive_choice::with_better_input;
use crate::fit::table1::actuator::Delays;
use crate::fit::table1::angle_fit::AngleFit;
use crate::fit::{Error, FitSettings, Result};
use crate::map::{LogRef, SAME_ANGLE_DEG};
use std::collections::BTreeMap;

/// The task of a fit.
pub(crate) struct Task<'a> {
    pub(crate) grouped: &'a Grouped,
    /// Whether the user requested the angles: one that is skipped, or whose table is not sound, makes the fit not sound. Otherwise
    /// angles were only found in the logs, and one without a sound table is skipped: a drive across the yard spoils no campaign.
    pub(crate) asked: bool,
    /// The angle of the plain file names [°].
    pub(crate) test_angle_deg: f64,
    pub(crate) choice: TorqueChoice,
    pub(crate) settings: &'a FitSettings,
}

/// The fits of all angles.
pub(crate) struct FittedAngles<'a> {
    pub(crate) task: &'a Task<'a>,
    /// By rising wheel angle.
    pub(crate) angles: Vec<AngleFit<'a>>,
    /// Delays that the angles share; absent with one angle, whose delays are its own.
    shared: Option<Pooled>,
    /// Angles that are skipped, by rising angle, with the reason.
    pub(crate) left_out: Vec<(f64, String)>,
}

impl<'a> Task<'a> {
    /// Chooses the torque input for all logs together.
    pub(crate) fn new(grouped: &'a Grouped, asked: bool, test_angle_deg: f64, settings: &'a FitSettings) -> Self {
        let choice = TorqueChoice::new(grouped.groups.iter().flat_map(|g| &g.surveys), settings);
        let test = grouped.groups.iter().find(|g| (g.wheel_angle_deg - test_angle_deg).abs() < SAME_ANGLE_DEG);
        let choice = match test {
            Some(group) => with_better_input(&group.surveys, choice, settings),
            None => choice,
        };
        Self { grouped, asked, test_angle_deg, choice, settings }
    }

    /// Whether a wheel angle is the test angle.
    pub(crate) fn is_test(&self, wheel_angle_deg: f64) -> bool {
        (wheel_angle_deg - self.test_angle_deg).abs() < SAME_ANGLE_DEG
    }

    /// Fits every angle. One that cannot be fitted is skipped; at the test angle it is an error.
    ///
    /// # Errors
    /// As of a fit at one angle; no group at the test angle; logs of different vehicles.
    pub(crate) fn fitted(&'a self) -> Result<FittedAngles<'a>> {
        let Grouped { groups, empty, .. } = self.grouped;
        check_vehicles(groups)?;
        if !groups.iter().any(|g| self.is_test(g.wheel_angle_deg)) {
            return Err(self.no_test_angle(groups.iter().map(|g| g.wheel_angle_deg)));
        }
        let several = groups.len() > 1 || !empty.is_empty();
        let shared = several.then(|| Shared::new(groups, &self.choice, self.settings));
        let (known, pooled, mut failed) = shared.map_or((None, None, Vec::new()), |s| (Some(s.known), Some(s.pooled), s.failed));
        let held = FitSettings { known: known.or_else(|| self.settings.known.clone()), ..self.settings.clone() };
        let mut angles = Vec::new();
        let mut unsound = Vec::new();
        for group in groups {
            let angle_deg = group.wheel_angle_deg;
            if failed.iter().any(|(failed_deg, _)| failed_deg.total_cmp(&angle_deg).is_eq()) {
                continue;
            }
            match AngleFit::new(group, &self.choice, &held, self.test_angle_deg) {
                Ok(fit) if self.asked || fit.objections.is_empty() || self.is_test(angle_deg) => angles.push(fit),
                Ok(fit) => unsound.push((angle_deg, fit.objections.join("; "))),
                Err(error) => failed.push((angle_deg, error)),
            }
        }
        if let Some(at) = failed.iter().position(|(angle, _)| self.is_test(*angle)) {
            return Err(failed.swap_remove(at).1);
        }
        let failed = failed.iter().map(|(angle, error)| (*angle, error.to_string()));
        let mut left_out: Vec<(f64, String)> = failed.chain(unsound).chain(empty.iter().cloned()).collect();
        left_out.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(FittedAngles { task: self, angles, shared: pooled, left_out })
    }

    fn no_test_angle(&self, angles_deg: impl Iterator<Item = f64>) -> Error {
        let all: Vec<String> = angles_deg.map(|a| format!("{a}°")).collect();
        let found = if all.is_empty() { "none".to_owned() } else { all.join(", ") };
        Error::NoTestAngle { test_angle_deg: self.test_angle_deg, found }
    }
}

impl FittedAngles<'_> {
    /// Whether there is more than one wheel angle, skipped ones included.
    pub(crate) fn are_several(&self) -> bool {
        self.shared.is_some()
    }

    /// The fit at the test angle.
    ///
    /// # Errors
    /// There is none.
    pub(crate) fn test(&self) -> Result<&AngleFit<'_>> {
        let found = self.angles.iter().find(|fit| self.task.is_test(fit.wheel_angle_deg));
        found.ok_or_else(|| self.task.no_test_angle(self.angles.iter().map(|fit| fit.wheel_angle_deg)))
    }

    /// Every log once, in the order of the files, with a survey of it.
    pub(crate) fn logs(&self) -> Vec<(&LogRef, &Survey)> {
        let surveys = self.task.grouped.groups.iter().flat_map(|g| &g.surveys);
        let by_log: BTreeMap<&LogRef, &Survey> = surveys.map(|s| (&s.track.source, s)).collect();
        by_log.into_iter().collect()
    }

    /// The delays of the logs, shared by the angles.
    ///
    /// # Errors
    /// No fit at the test angle.
    pub(crate) fn delays(&self) -> Result<Delays> {
        let test = &self.test()?.estimate;
        let logs: Vec<LogRef> = self.logs().into_iter().map(|(log, _)| log.clone()).collect();
        Ok(self.shared.as_ref().map_or_else(|| test.into(), |shared| shared.delays(&logs, test)))
    }
}

/// The logs are of one vehicle: its geometry is the same in all of them, and the wheel angle of a group in all of the group.
fn check_vehicles(groups: &[AngleGroup]) -> Result<()> {
    let first = groups.iter().find_map(|g| g.surveys.first()).ok_or(Error::NoLogs)?;
    for group in groups {
        for other in &group.surveys {
            let same_group = group.surveys.first().unwrap_or(first);
            let (a, b) = (&first.track.vehicle, &other.track.vehicle);
            for (field, x, y, of) in [
                ("wheelbase_m", a.wheelbase_m, b.wheelbase_m, first),
                ("wheel_radius_m", a.wheel_radius_m, b.wheel_radius_m, first),
                ("test_angle_deg", same_group.track.wheel_angle_deg, other.track.wheel_angle_deg, same_group),
            ] {
                if (x - y).abs() > 1e-6 * x.abs().max(y.abs()) {
                    return Err(Error::DifferentVehicles {
                        field,
                        first: of.track.source.file.clone(),
                        first_value: x,
                        second: other.track.source.file.clone(),
                        second_value: y,
                    });
                }
            }
        }
    }
    Ok(())
}
