//! The plan as a campaign file that `record` reads.

use crate::plan::drive::{PAUSE_S, PlannedRun, STALL_S};
use crate::plan::{Plan, PlanEntry};
use std::fmt::Write;

impl Plan {
    /// The campaign file (TOML): one group per entry, the most useful first, each with its expected gain and its reason as comments.
    pub fn to_toml(&self) -> String {
        let mut text = format!(
            "# The campaign still to drive: {} runs, about {:.0} s. The most useful runs per second come first.\n\
             # Expected standard error of the torque, root mean square over the cells: {:.3} N·m now, {:.3} N·m after.\n\
             # Torques are in the gear's frame.\n\
             name = \"plan\"\n",
            self.runs, self.seconds, self.std_err_nm, self.std_err_after_nm
        );
        for entry in &self.entries {
            // writing to a string does not fail
            let _ = entry.write(&mut text);
        }
        text
    }
}

impl PlannedRun {
    /// What is driven: `from rest`, or the spin-up.
    pub fn start(&self) -> String {
        match self.spin_up_nm {
            Some(spin_up_nm) => format!("from {:.2} m/s reached with {spin_up_nm:.1} N·m", self.start_speed_mps),
            None => "from rest".to_owned(),
        }
    }
}

impl PlanEntry {
    fn write(&self, text: &mut String) -> std::fmt::Result {
        let run = &self.run;
        writeln!(text, "\n# {:.1} N·m {}: {}", run.torque_nm, run.start(), self.reason)?;
        writeln!(
            text,
            "# the first run: {:.1} s, {:.4} N·m off the standard error ({:.2} %)",
            self.seconds, self.gain_nm, self.gain_percent
        )?;
        writeln!(text, "[[runs]]\ngear = \"{}\"\ntorque_nm = {:?}", run.gear, run.torque_nm)?;
        writeln!(text, "repeats = {}", self.repeats)?;
        if let Some(spin_up_nm) = run.spin_up_nm {
            writeln!(
                text,
                "start_speed_mps = {:?}\nspin_up_nm = {spin_up_nm:?}\nend_speed_mps = {:?}",
                run.start_speed_mps, run.end_speed_mps
            )?;
        }
        writeln!(text, "hold_s = {:?}\nspeed_limit_mps = {:?}", run.hold_s, run.speed_limit_mps)?;
        writeln!(text, "stall_s = {STALL_S:?}\npause_s = {PAUSE_S:?}")
    }
}
