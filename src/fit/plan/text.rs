//! The plan as a campaign file that `record` reads.

use super::drive::{HOLD_S, PAUSE_S, STALL_S};
use super::{Plan, PlanEntry};
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

impl PlanEntry {
    /// What is driven: `from rest`, or the spin-up.
    pub fn start(&self) -> String {
        match self.spin_up_nm {
            Some(spin_up_nm) => format!("from {:.2} m/s reached with {spin_up_nm:.1} N·m", self.start_speed_mps),
            None => "from rest".to_owned(),
        }
    }

    fn write(&self, text: &mut String) -> std::fmt::Result {
        writeln!(text, "\n# {} at {:.1} N·m: {}", self.start(), self.torque_nm, self.reason)?;
        writeln!(
            text,
            "# the first run: {:.1} s, {:.4} N·m off the standard error ({:.2} %)",
            self.seconds, self.gain_nm, self.gain_percent
        )?;
        writeln!(text, "[[runs]]\ngear = \"{}\"\ntorque_nm = {:?}", self.gear, self.torque_nm)?;
        writeln!(text, "repeats = {}", self.repeats)?;
        if let Some(spin_up_nm) = self.spin_up_nm {
            writeln!(text, "start_speed_mps = {:?}\nspin_up_nm = {spin_up_nm:?}", self.start_speed_mps)?;
        }
        writeln!(text, "hold_s = {HOLD_S:?}\nspeed_limit_mps = {:?}", self.speed_limit_mps)?;
        writeln!(text, "stall_s = {STALL_S:?}\npause_s = {PAUSE_S:?}")
    }
}
