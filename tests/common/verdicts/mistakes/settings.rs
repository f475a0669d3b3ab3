//! Command lines: wrong values that a user gives.

use super::{Mistake, kind};
use crate::verdicts::log::{COMMAND, FEEDBACK};
use pivot_cal::fit::CampaignTime;

pub(super) fn all() -> Vec<Mistake> {
    [
        kind("dead time given wrong", [("0 ms", 0.0), ("300 ms", 0.3)], |case, dead_time_s| {
            case.fit.dead_time_s = Some(dead_time_s);
            Ok(())
        }),
        kind("dead time given wrong, no feedback", [("0 ms", 0.0), ("300 ms", 0.3)], |case, dead_time_s| {
            case.fit.dead_time_s = Some(dead_time_s);
            case.logs[0].keep(FEEDBACK, |_| false);
            Ok(())
        }),
        kind("lag given wrong", [("0 ms", 0.0), ("400 ms", 0.4)], |case, lag_s| {
            case.fit.lag_s = Some(lag_s);
            Ok(())
        }),
        kind("lag given wrong, no feedback", [("0 ms", 0.0), ("400 ms", 0.4)], |case, lag_s| {
            case.fit.lag_s = Some(lag_s);
            case.logs[0].keep(FEEDBACK, |_| false);
            Ok(())
        }),
        kind("speed breaks beyond what was driven", [("to 1.6 m/s", 1.6), ("to 3 m/s", 3.0)], |case, fastest_mps| {
            case.fit.speed_breaks_mps = Some((0..=10).map(|k| f64::from(k) * 0.1 * fastest_mps).collect());
            Ok(())
        }),
        kind("torque breaks beyond what was driven", [("to 60 N·m", 60.0), ("to 100 N·m", 100.0)], |case, most_nm| {
            let most_nm = most_nm * case.size;
            case.fit.torque_breaks_nm = Some((-3..=8).map(|k| f64::from(k) * 0.125 * most_nm).collect());
            Ok(())
        }),
        kind("no draws", [("0", 0.0)], |case, _| {
            case.draws = 0;
            Ok(())
        }),
        kind("transient left out", [("0.3 s", 0.3), ("1.5 s", 1.5)], |case, transient_s| {
            case.fit.transient_s = transient_s;
            Ok(())
        }),
        kind("at the end of a campaign", [("stationary", 0.0), ("gain falls by 20 %", 0.2)], |case, share| {
            case.fit.at = CampaignTime::End;
            let end_s = case.logs[0].length_s();
            case.logs[0].values(COMMAND, |t_s, value| value / (1.0 - share * t_s / end_s));
            case.delivered = Box::new(move |_, torque_nm, _| torque_nm * (1.0 - share));
            Ok(())
        }),
        kind("Table 1 of another vehicle, by force", [("sweeper", 0.0), ("drag", 1.0)], |case, drag| {
            let of_sweeper = case.truth.vehicle.wheelbase_m > 1.0;
            case.forced_table1_of = Some(if drag > 0.0 {
                "drag"
            } else if of_sweeper {
                "scrubber"
            } else {
                "sweeper"
            });
            Ok(())
        }),
    ]
    .concat()
}
