//! The proposal as a campaign that `record` drives.

use crate::map::{PlanEntry, Proposal, WheelAngle};
use crate::plan::drive::{PAUSE_S, STALL_S};
use crate::record::{Campaign, RunGroup, Torques, WheelAngles};

impl Proposal {
    /// The campaign: one group per entry, the most useful first. The wheel angle is the vehicle's test angle if none is given.
    pub(crate) fn to_campaign(&self, wheel_angle: Option<WheelAngle>) -> Campaign {
        let angles = wheel_angle.map(|angle| WheelAngles::One(angle.deg()));
        let runs = self.entries.iter().map(|entry| RunGroup { wheel_angle_deg: angles.clone(), ..group(entry) });
        Campaign { name: "plan".to_owned(), runs: runs.collect(), ..Campaign::default() }
    }

    /// The campaign file (TOML), with the expected gain and the reason of each run as comments.
    ///
    /// # Errors
    /// None in practice; serialisation is fallible by its signature.
    pub fn to_toml(&self, wheel_angle: Option<WheelAngle>) -> Result<String, toml::ser::Error> {
        let header = format!(
            "# The next campaign: {} runs, about {:.0} s. The runs that help most per second come first.\n\
             # Expected standard error of the torque, root mean square over the cells: {:.3} N·m now, {:.3} N·m after.\n\
             # Torques are in the gear's frame.\n",
            self.runs, self.seconds, self.std_err_nm, self.std_err_after_nm
        );
        let comments = self.entries.iter().map(comment).collect::<Vec<_>>();
        Ok(header + &self.to_campaign(wheel_angle).to_toml(&comments)?)
    }
}

fn group(entry: &PlanEntry) -> RunGroup {
    let run = &entry.run;
    let level = RunGroup {
        gear: run.gear,
        repeats: entry.repeats,
        hold_s: run.hold_s,
        speed_limit_mps: run.speed_limit_mps,
        stall_s: STALL_S,
        pause_s: PAUSE_S,
        ..RunGroup::new(Torques::One(run.torque_nm))
    };
    match run.spin_up_nm {
        Some(spin_up_nm) => RunGroup { start_speed_mps: run.start_speed_mps, spin_up_nm, end_speed_mps: run.end_speed_mps, ..level },
        None => level,
    }
}

fn comment(entry: &PlanEntry) -> String {
    format!(
        "# {:.1} N·m {}: {}\n# the first run: {:.1} s, lowers the standard error by {:.4} N·m ({:.2} %)\n",
        entry.run.torque_nm,
        entry.run.start(),
        entry.reason,
        entry.seconds,
        entry.gain_nm,
        entry.gain_percent
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::{Gear, PlannedRun};

    fn proposal() -> Proposal {
        let from_rest = PlannedRun {
            gear: Gear::Forward,
            torque_nm: 20.0,
            start_speed_mps: 0.0,
            spin_up_nm: None,
            speed_limit_mps: 0.95,
            end_speed_mps: 0.03,
            hold_s: 2.5,
        };
        let braking = PlannedRun {
            gear: Gear::Reverse,
            torque_nm: -8.5,
            start_speed_mps: 0.7,
            spin_up_nm: Some(40.0),
            end_speed_mps: 0.1,
            ..from_rest
        };
        let entry = |run, repeats| PlanEntry {
            run,
            repeats,
            seconds: 3.25,
            gain_nm: 0.01,
            gain_percent: 1.5,
            gain_nm_per_s: 0.004,
            reason: "few runs there".to_owned(),
        };
        let entries = vec![entry(from_rest, 2), entry(braking, 1)];
        Proposal { budget_s: 30.0, seconds: 9.75, runs: 3, std_err_nm: 0.25, std_err_after_nm: 0.125, entries }
    }

    #[test]
    fn the_campaign_file_shows_what_matters_and_reads_back() {
        let text = proposal().to_toml(None).unwrap();
        insta::assert_snapshot!(text, @r#"
        # The next campaign: 3 runs, about 10 s. The runs that help most per second come first.
        # Expected standard error of the torque, root mean square over the cells: 0.250 N·m now, 0.125 N·m after.
        # Torques are in the gear's frame.
        name = "plan"

        # 20.0 N·m from rest: few runs there
        # the first run: 3.2 s, lowers the standard error by 0.0100 N·m (1.50 %)
        [[runs]]
        gear = "forward"
        torque_nm = 20.0
        repeats = 2
        hold_s = 2.5
        speed_limit_mps = 0.95
        stall_s = 1.0
        pause_s = 0.0

        # -8.5 N·m from 0.70 m/s reached with 40.0 N·m: few runs there
        # the first run: 3.2 s, lowers the standard error by 0.0100 N·m (1.50 %)
        [[runs]]
        gear = "reverse"
        torque_nm = -8.5
        repeats = 1
        start_speed_mps = 0.7
        spin_up_nm = 40.0
        end_speed_mps = 0.1
        hold_s = 2.5
        speed_limit_mps = 0.95
        stall_s = 1.0
        pause_s = 0.0
        "#);
        assert_eq!(Campaign::from_toml(&text).unwrap(), proposal().to_campaign(None));
    }

    #[test]
    fn another_wheel_angle_is_in_every_group() {
        let text = proposal().to_toml(Some(WheelAngle::from_deg(-22.5))).unwrap();
        assert_eq!(text.matches("wheel_angle_deg = -22.5").count(), 2);
        let runs = Campaign::from_toml(&text).unwrap().plan(1).unwrap();
        assert!(runs.len() == 3 && runs.iter().all(|run| run.wheel_angle_deg == Some(-22.5)));
    }
}
