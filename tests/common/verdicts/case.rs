//! A case: a vehicle, what was driven, and how the calibration is called; a mistake changes one of them.

use crate::verdicts::Fallible;
use crate::verdicts::campaign::{driven, size, usual};
use crate::verdicts::log::Log;
use crate::verdicts::vehicles::{text, vehicle};
use pivot_cal::fit::FitSettings;
use pivot_cal::internals::VehicleFile;
use pivot_cal::log::VehicleOverrides;

/// Torque that the plant gets in a steady state: of speed [m/s] and commanded torque [N·m], in the gear's frame, and the gear's sign.
pub(crate) type Delivered = Box<dyn Fn(f64, f64, f64) -> f64 + Send + Sync>;

/// Input of a calibration, with the truth about its vehicle.
pub(crate) struct Case {
    /// The vehicle that the map is for.
    pub(crate) truth: VehicleFile,
    /// The text of its file.
    pub(crate) text: String,
    /// Torque relative to the scrubber's.
    pub(crate) size: f64,
    /// Seed of the first log.
    pub(crate) seed: u64,
    /// The logs.
    pub(crate) logs: Vec<Log>,
    /// The drive's steady characteristic.
    pub(crate) delivered: Delivered,
    /// The text of the signal map; without one the signals are detected.
    pub(crate) signals: Option<String>,
    /// Vehicle data from the command line.
    pub(crate) given: VehicleOverrides,
    /// Settings of the estimator.
    pub(crate) fit: FitSettings,
    /// Perturbed vehicles per scenario.
    pub(crate) draws: usize,
    /// Table 1 of this vehicle is put beside Table 2, and taken by force.
    pub(crate) forced_table1_of: Option<&'static str>,
}

impl Case {
    /// A good case: one usual log, and a call without options.
    ///
    /// # Errors
    /// A vehicle or a campaign that the simulator refuses.
    pub(crate) fn good(name: &str, seed: u64) -> Fallible<Self> {
        let mut case = Self::not_driven(name, seed)?;
        case.logs = vec![driven(&case.truth, &usual(case.size), seed)?];
        Ok(case)
    }

    /// A case without a log.
    ///
    /// # Errors
    /// As [`Case::good`].
    pub(crate) fn not_driven(name: &str, seed: u64) -> Fallible<Self> {
        let text = text(name);
        let truth = vehicle(&text)?;
        Ok(Self {
            size: size(&truth),
            truth,
            text,
            seed,
            logs: Vec::new(),
            delivered: Box::new(|_, torque_nm, _| torque_nm),
            signals: None,
            given: VehicleOverrides::default(),
            fit: FitSettings::default(),
            // the median of four perturbed vehicles is mostly chance; a verdict drives 200
            draws: 24,
            forced_table1_of: None,
        })
    }

    /// Another log of the case's vehicle.
    ///
    /// # Errors
    /// A campaign that the simulator refuses.
    pub(crate) fn another(&self, campaign: &str) -> Fallible<Log> {
        driven(&self.truth, campaign, self.seed + 100)
    }

    /// Another log, of a vehicle with another file.
    ///
    /// # Errors
    /// A vehicle or a campaign that the simulator refuses.
    pub(crate) fn another_of(&self, text: &str, campaign: &str) -> Fallible<Log> {
        driven(&vehicle(text)?, campaign, self.seed + 100)
    }

    /// The case with another vehicle file, driven as usual.
    ///
    /// # Errors
    /// A vehicle or a campaign that the simulator refuses.
    pub(crate) fn drive_as(&mut self, text: &str) -> Fallible<()> {
        self.truth = vehicle(text)?;
        text.clone_into(&mut self.text);
        self.drive(&usual(self.size))
    }

    /// The case with another campaign.
    ///
    /// # Errors
    /// A campaign that the simulator refuses.
    pub(crate) fn drive(&mut self, campaign: &str) -> Fallible<()> {
        self.logs = vec![driven(&self.truth, campaign, self.seed)?];
        Ok(())
    }

    /// A signal map with the usual paths, `changes` made to its text.
    pub(crate) fn map_signals(&mut self, changes: &[(&str, &str)]) {
        let vehicle = self.truth.vehicle;
        let mut map = include_str!("../../../data/signals/reference.toml")
            .replace("wheelbase_m = 0.92", &format!("wheelbase_m = {}", vehicle.wheelbase_m))
            .replace("wheel_radius_m = 0.120", &format!("wheel_radius_m = {}", vehicle.wheel_radius_m))
            .replace("torque_limit_nm = 44.0", &format!("torque_limit_nm = {}", vehicle.torque_limit_nm.unwrap_or(44.0)));
        for (from, to) in changes {
            map = map.replace(from, to);
        }
        self.signals = Some(map);
    }
}
