//! What changed during the campaign → checks. A change that the fit found is taken out of the map, as a straight line over the campaign or
//! over each log. A large one is rarely a straight line: a load that was put on, a brake that began to drag.

use crate::map::{CampaignChange, Check, CheckOutcome, Table1File};

/// Fall of friction over the campaign for a warning and for an objection: gears and tyres that warm up lose up to a quarter.
const FALLING_FRICTION: [f64; 2] = [0.15, 0.30];
/// The same of a rise: nothing that warms up explains it, a brake that begins to drag does.
const RISING_FRICTION: [f64; 2] = [0.08, 0.15];
/// Change of the acceleration by the same torque for a warning and for an objection: a battery that empties, a motor that warms up. More is
/// another load or another vehicle.
const TORQUE: [f64; 2] = [0.03, 0.06];
/// A change counts from this many standard errors on.
const SIGNIFICANT: f64 = 3.0;

/// One check on friction and one on torque.
pub(crate) fn change_checks(file: &Table1File) -> Vec<Check> {
    let friction = |c: &CampaignChange| (c.friction_share, c.friction_share_std_err);
    let torque = |c: &CampaignChange| (c.torque_share, c.torque_share_std_err);
    vec![
        check(file, "friction-change", "friction changed", friction, [FALLING_FRICTION, RISING_FRICTION]),
        check(file, "torque-change", "the acceleration by the same torque changed", torque, [TORQUE; 2]),
    ]
}

fn check(file: &Table1File, name: &str, what: &str, of: impl Fn(&CampaignChange) -> (f64, f64), [fall, rise]: [[f64; 2]; 2]) -> Check {
    let clear = |c: &&CampaignChange| of(c).0.abs() > SIGNIFICANT * of(c).1;
    let largest = file.actuator.changes.iter().filter(clear).max_by(|a, b| of(a).0.abs().total_cmp(&of(b).0.abs()));
    // the file holds the change from the middle to the end
    let (change, std_err) = largest.map_or((0.0, 0.0), |c| (2.0 * of(c).0, 2.0 * of(c).1));
    let (outcome, limit) = CheckOutcome::graded(change.abs(), if change < 0.0 { fall } else { rise });
    let over = if largest.is_some_and(|c| c.of_each_log) { "each log" } else { "the campaign" };
    let meaning = match largest {
        Some(_) => format!("{what} by {:+.1} ± {:.1} % over {over}, {:.0} % is allowed", 100.0 * change, 100.0 * std_err, 100.0 * limit),
        None => format!("no change is clear: {what} by less than {:.0} %", 100.0 * limit),
    };
    let advice = "look for another load, a dragging brake, heat or an empty battery, and drive again, or fit the logs apart";
    Check::passed(name, (100.0 * change.abs(), 100.0 * limit, "%"), meaning).judged(outcome, advice)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_clear_change_warns_or_objects_by_its_size() {
        let outcomes = |friction_share: f64, torque_share: f64, std_err: f64| {
            let mut file = Table1File::from_json(include_str!("../../maps/table1.json")).unwrap();
            file.actuator.changes = vec![CampaignChange {
                of_each_log: false,
                friction_share,
                friction_share_std_err: std_err,
                torque_share,
                torque_share_std_err: std_err,
            }];
            change_checks(&file).into_iter().map(|c| c.outcome).collect::<Vec<_>>()
        };
        // half of the change over the campaign
        assert_eq!(outcomes(-0.07, 0.01, 0.002), [CheckOutcome::Passed, CheckOutcome::Passed]);
        assert_eq!(outcomes(-0.10, 0.02, 0.002), [CheckOutcome::Warning, CheckOutcome::Warning]);
        assert_eq!(outcomes(-0.20, -0.08, 0.002), [CheckOutcome::Objection, CheckOutcome::Objection]);
        assert_eq!(outcomes(0.05, 0.0, 0.002), [CheckOutcome::Warning, CheckOutcome::Passed]);
        assert_eq!(outcomes(0.09, 0.0, 0.002), [CheckOutcome::Objection, CheckOutcome::Passed]);
        assert_eq!(outcomes(0.20, -0.08, 0.07), [CheckOutcome::Passed, CheckOutcome::Passed]);
    }
}
