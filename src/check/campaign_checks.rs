//! What `table1.json` holds about its campaign → checks: how much was driven, and how well the campaign's signals agree.
//!
//! The fit stores the checks in the file. A verdict and the page make them again, so that a file of an older version, or one from which they
//! were removed, is judged as well.

use crate::check::change_checks::change_checks;
use crate::check::loss_check::loss_check;
use crate::map::{
    AccelMap, CellStatus, Check, CheckOutcome, DelayStatus, Gear, LogActuator, RunRow, SampleVerdict, SpeedSource, Table1File, Vehicle,
};

/// Departure of the encoder's scale from the yaw rate's above which it is a warning, and an objection: tyres wear by 1 to 2 %; a wheelbase
/// or a radius that is measured with a tape is wrong by less than 5 %.
const ENCODER_SCALE: [f64; 2] = [0.02, 0.05];
/// Share of the moving samples left out as push or slip, for a warning and for an objection: if more than two in five samples are left
/// out, the model chooses the rest that is meant to judge it.
const CONDEMNED: [f64; 2] = [0.20, 0.40];
/// Breakaway torque over the largest torque beyond which little is left to accelerate with.
const FRICTION: f64 = 0.60;
/// The share below which there is no friction at all, which no drive has: torques of one gear have another sign or offset.
const NO_FRICTION: f64 = 0.005;
/// Largest clock offset that sampling phases explain [s].
const CLOCK_OFFSET_S: f64 = 0.02;
/// Largest standard error of a well-determined dead time [s].
const DEAD_TIME_STD_ERR_S: f64 = 0.01;
/// Fewest driving torques of a gear: two and coasting do not show whether acceleration is linear in torque.
const FEWEST_DRIVING_TORQUES: usize = 3;
/// Least used motion of a gear [s].
const LEAST_MOTION_S: f64 = 20.0;
/// Torques nearer than this share of the largest count as one.
const SAME_TORQUE: f64 = 0.04;
/// Effective number of torques from which a torque that was varied without levels counts as many.
const VARIED_TORQUES: f64 = 6.0;
/// Share of the cells that must be measured or interpolated, where the file does not give it.
const LEAST_COVERAGE: f64 = 0.3;
/// Ratios that a wrong unit makes, and the mistake.
const UNIT_RATIOS: [(f64, &str); 3] = [
    (60.0 / std::f64::consts::TAU, "revolutions per minute taken for rad/s (9.549)"),
    (180.0 / std::f64::consts::PI, "degrees taken for radians (57.3)"),
    (std::f64::consts::TAU, "revolutions per second taken for rad/s (6.283)"),
];

/// Every check on a Table 1: the stored ones, and those that the file's own content gives. Of two with one name the worse is kept.
pub(crate) fn all_checks(file: &Table1File) -> Vec<Check> {
    let mut all = file.checks.clone();
    let at_test_angle: Vec<&AccelMap> = file.maps.iter().filter(|m| m.angle().is_same(file.vehicle.test_angle())).collect();
    let least = file.settings["least_coverage"].as_f64().unwrap_or(LEAST_COVERAGE);
    for check in std::iter::once(coverage_check(&at_test_angle, least)).chain(content_checks(file)) {
        match all.iter_mut().find(|known| known.name == check.name) {
            Some(known) if known.outcome < check.outcome => *known = check,
            Some(_) => {}
            None => all.push(check),
        }
    }
    all
}

/// Whether enough cells of the maps are measured or interpolated; `least` is a share, 0 to 1.
pub(crate) fn coverage_check(maps: &[&AccelMap], least: f64) -> Check {
    let cells = || maps.iter().flat_map(|m| m.status.iter().flatten());
    let known = cells().filter(|s| **s != CellStatus::Extrapolated).count() as f64 / cells().count().max(1) as f64;
    let shares = format!("{:.0} % of the cells are measured or interpolated, {:.0} % are needed", 100.0 * known, 100.0 * least);
    let check = |meaning| Check::passed("coverage", (100.0 * known, 100.0 * least, "%"), meaning);
    if known >= least {
        return check(shares);
    }
    let advice = "drive the missing torques, from rest and from speed";
    check(format!("coverage is too thin: {shares}")).broken(CheckOutcome::Objection, advice)
}

/// The checks that follow from the file's content, beside coverage.
pub(crate) fn content_checks(file: &Table1File) -> Vec<Check> {
    let mut all: Vec<Check> = encoder_scale(file).into_iter().collect();
    all.extend(loss_check(&file.logs));
    all.extend(clock_offset(file));
    all.extend(dead_time(file));
    all.extend(condemned(file));
    all.extend(file.maps.iter().filter(|m| m.angle().is_same(file.vehicle.test_angle())).map(|map| friction(file, map)));
    all.push(undelivered(file));
    all.extend(given_drive(file));
    all.extend(change_checks(file));
    all
}

/// Encoder against yaw rate × wheelbase. `None` without a second source of speed.
fn encoder_scale(file: &Table1File) -> Option<Check> {
    let encoder = file.witnesses.iter().find(|w| w.name == SpeedSource::Encoder && w.scale_std_err.is_some())?;
    Some(scale_check(&file.vehicle, encoder.scale))
}

/// The check of an encoder's scale, its speed over that of the yaw rate.
pub(crate) fn scale_check(vehicle: &Vehicle, scale: f64) -> Check {
    let departure = (scale - 1.0).abs();
    let (outcome, limit) = CheckOutcome::graded(departure, ENCODER_SCALE);
    let meaning = format!(
        "the encoder's speed is {scale:.3} times that of the yaw rate with this wheelbase: a difference of {:.1} %, {:.0} % is allowed",
        100.0 * departure,
        100.0 * limit
    );
    let check = Check::passed("encoder-scale", (100.0 * departure, 100.0 * limit, "%"), meaning);
    check.judged(outcome, scale_advice(vehicle, scale))
}

/// Advice on a wrong scale: the most likely cause first.
fn scale_advice(vehicle: &Vehicle, scale: f64) -> String {
    let ratio = scale.max(1.0 / scale.max(1e-9));
    let near = |value: f64| (ratio / value - 1.0).abs() < ENCODER_SCALE[1];
    if let Some((_, mistake)) = UNIT_RATIOS.iter().find(|(value, _)| near(*value)) {
        return format!("correct the unit: {mistake}");
    }
    let dimensions = format!(
        "wheelbase ({:.3} m would agree instead of {:.3} m) and wheel radius ({:.4} m would agree instead of {:.4} m)",
        vehicle.wheelbase_m * scale,
        vehicle.wheelbase_m,
        vehicle.wheel_radius_m / scale,
        vehicle.wheel_radius_m
    );
    let gear = if ratio > 1.5 { format!(", and a gear ratio of {ratio:.2} between encoder and wheel") } else { String::new() };
    format!("measure {dimensions}{gear}, and look at the units (rpm for rad/s is 9.549, degrees for radians 57.3)")
}

/// The largest clock offset. `None` where nothing separates one from the dead time.
fn clock_offset(file: &Table1File) -> Option<Check> {
    let known = |status| matches!(status, DelayStatus::Estimated | DelayStatus::NoneFound | DelayStatus::WeaklyDetermined);
    let logs = file.actuator.per_log.iter().filter(|log| known(log.clock_offset.status));
    // an offset that counts is preferred to a larger one within its own error
    let size = |log: &LogActuator| (log.clock_offset.status == DelayStatus::Estimated, log.clock_offset.value_s.abs());
    let log = logs.max_by(|a, b| size(a).0.cmp(&size(b).0).then(size(a).1.total_cmp(&size(b).1)))?;
    let offset_ms = 1e3 * log.clock_offset.value_s;
    let limit_ms = 1e3 * CLOCK_OFFSET_S;
    let meaning =
        format!("{}: the speed's clock is {offset_ms:.1} ms ahead of the torque command's, {limit_ms:.0} ms is allowed", log.file);
    let check = Check::passed("clock-offset", (offset_ms.abs(), limit_ms, "ms"), meaning);
    // a smaller one, or one within its own error, is not reported as estimated
    Some(if log.clock_offset.status == DelayStatus::Estimated {
        check.broken(CheckOutcome::Warning, "record torque and speed with the stamps of one clock")
    } else {
        check
    })
}

/// Whether the campaign determined the dead time. `None` where it was given.
fn dead_time(file: &Table1File) -> Option<Check> {
    let dead_time = &file.actuator.dead_time;
    let (error_ms, limit_ms) = (1e3 * dead_time.std_err_s?, 1e3 * DEAD_TIME_STD_ERR_S);
    let meaning = format!("the standard error of the dead time is {error_ms:.1} ms, {limit_ms:.0} ms is allowed");
    let check = Check::passed("dead-time", (error_ms, limit_ms, "ms"), meaning);
    Some(if dead_time.status == DelayStatus::WeaklyDetermined {
        check.broken(CheckOutcome::Warning, "drive more steps of torque, or give the dead time")
    } else {
        check
    })
}

/// Moving samples that were left out as pushed or slipping. `None` without moving samples.
fn condemned(file: &Table1File) -> Option<Check> {
    let samples = |of: &[SampleVerdict]| file.report.ledger.iter().filter(|r| of.contains(&r.verdict)).map(|r| r.samples).sum::<u64>();
    let bad = samples(&[SampleVerdict::Push, SampleVerdict::Slip]);
    let moving = bad + samples(&[SampleVerdict::Used]);
    if moving == 0 {
        return None;
    }
    let share = bad as f64 / moving as f64;
    let (outcome, limit) = CheckOutcome::graded(share, CONDEMNED);
    let meaning = format!("{:.0} % of the moving samples are left out as push or slip, {:.0} % is allowed", 100.0 * share, 100.0 * limit);
    let check = Check::passed("push-and-slip", (100.0 * share, 100.0 * limit, "%"), meaning);
    let advice = "check the signs, units and clocks of the signals, and the floor; drive again without pushing the vehicle";
    Some(check.judged(outcome, advice))
}

/// Breakaway torque against what the drive can give.
fn friction(file: &Table1File, map: &AccelMap) -> Check {
    let largest_nm = file.most_torque_nm(0.0).max(1e-9);
    let share = map.breakaway.torque_nm / largest_nm;
    let meaning = format!(
        "{} gear: the breakaway torque is {:.1} N·m, {:.0} % of the largest torque of {largest_nm:.1} N·m, {:.0} % is allowed",
        map.gear,
        map.breakaway.torque_nm,
        100.0 * share,
        100.0 * FRICTION
    );
    let check = Check::passed(format!("friction-{}", map.gear), (100.0 * share, 100.0 * FRICTION, "%"), meaning);
    if share < NO_FRICTION {
        let meaning =
            format!("{} gear: no torque is needed to start from rest, as of no drive; {:.1} % is the least", map.gear, 100.0 * NO_FRICTION);
        let check = Check { meaning, limit: 100.0 * NO_FRICTION, ..check };
        return check.broken(CheckOutcome::Objection, "look at sign and offset of the torque in this gear, and at the floor");
    }
    if share > FRICTION {
        check.broken(CheckOutcome::Warning, "look for a dragging brake, a soft floor, or a torque in another unit")
    } else {
        check
    }
}

/// Whether the data contradict a drive that was given. `None` unless they do.
fn given_drive(file: &Table1File) -> Option<Check> {
    let better = file.actuator.drive.as_ref()?.better_than_given.as_ref()?;
    let meaning =
        format!("the data contradict the given drive: a {} predicts the readings better by {:.0} (−2·ln L)", better.drive, -better.worse);
    let check = Check::passed("given-drive", (-better.worse, 30.0, "−2·ln L"), meaning);
    Some(check.broken(CheckOutcome::Objection, "leave out --lag-ms, or give the value that the data show"))
}

/// Torque that the drive did not deliver.
fn undelivered(file: &Table1File) -> Check {
    let drive = file.actuator.drive.as_ref();
    let seconds = drive.and_then(|d| d.undelivered_s).unwrap_or(0.0);
    let figure = (seconds, 0.0, "s");
    if let Some(exceeded_s) = drive.and_then(|d| d.exceeded_s) {
        let meaning = format!("for {exceeded_s:.1} s, the torque feedback shows more than the torque in the log's command, 0 s is allowed");
        let advice = "the log does not hold the command that the drive had: look for a saturated or limited message, and for a second source of the command";
        return Check::passed("torque-delivered", (exceeded_s, 0.0, "s"), meaning).broken(CheckOutcome::Objection, advice);
    }
    if let Some(share) = drive.and_then(|d| d.undelivered_share) {
        let meaning = format!(
            "for {seconds:.1} s, the torque feedback is {share:.2} times the commanded torque, at small and large torques alike: another scale, and not a limit"
        );
        let advice =
            "find out which of the two is the torque at the wheel, at torques of either sign, and correct scale or conversion of the other";
        return Check::passed("torque-delivered", figure, meaning).broken(CheckOutcome::Objection, advice);
    }
    if seconds > 0.0 {
        let advice = "the drive limits torque, power or speed: plan within it, and give torque_limit_nm";
        let meaning = format!("the drive did not deliver the commanded torque during {seconds:.1} s, 0 s is allowed");
        return Check::passed("torque-delivered", figure, meaning).broken(CheckOutcome::Warning, advice);
    }
    Check::passed("torque-delivered", figure, "no torque is known to be undelivered".to_owned())
}

/// Why the campaign is too short to judge a gear's map at the test angle; `None` if it is not.
pub(crate) fn too_little(file: &Table1File, gear: Gear) -> Option<String> {
    let at_test_angle = |run: &&RunRow| run.wheel_angle_deg.is_none_or(|angle| file.vehicle.test_angle().is_same_deg(angle));
    let runs: Vec<&RunRow> = file.report.runs.iter().filter(|r| r.gear == gear && r.used_s > 0.0).filter(at_test_angle).collect();
    let seconds: f64 = runs.iter().map(|r| r.used_s).sum();
    let torques = driving_torques(&runs);
    let varied = file.checks.iter().any(|c| c.name == torques_name(gear) && c.figure >= VARIED_TORQUES);
    if torques < FEWEST_DRIVING_TORQUES && !varied {
        return Some(format!(
            "{gear} gear: {torques} driving torque{} used, {FEWEST_DRIVING_TORQUES} are needed; drive more torque steps",
            if torques == 1 { " was" } else { "s were" }
        ));
    }
    (seconds < LEAST_MOTION_S)
        .then(|| format!("{gear} gear: {seconds:.1} s of motion were used, {LEAST_MOTION_S:.0} s are needed; drive longer or more runs"))
}

/// Name of the check on the torques of a gear.
pub(crate) fn torques_name(gear: Gear) -> String {
    format!("torques-{gear}")
}

/// Number of different driving torques.
fn driving_torques(runs: &[&RunRow]) -> usize {
    let mut torques: Vec<f64> = runs.iter().map(|r| r.torque_nm).filter(|t| *t > 0.0).collect();
    torques.sort_unstable_by(f64::total_cmp);
    let same_nm = SAME_TORQUE * torques.last().copied().unwrap_or(0.0);
    let mut last_nm = f64::NEG_INFINITY;
    let mut count = 0;
    for torque_nm in torques {
        if torque_nm - last_nm > same_nm {
            count += 1;
            last_nm = torque_nm;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// The bundled map, without the checks that its fit stored.
    fn demo() -> Table1File {
        Table1File { checks: Vec::new(), ..Table1File::from_json(include_str!("../../maps/table1.json")).unwrap() }
    }

    fn check(file: &Table1File, name: &str) -> Check {
        all_checks(file).into_iter().find(|c| c.name == name).unwrap()
    }

    #[test]
    fn the_demo_campaign_passes_every_check_and_has_enough_of_both_gears() {
        let file = demo();
        let bad: Vec<Check> = all_checks(&file).into_iter().filter(|c| c.outcome != CheckOutcome::Passed).collect();
        assert_eq!(bad, []);
        assert_eq!(Gear::ALL.map(|gear| too_little(&file, gear)), [None, None]);
    }

    #[test]
    fn an_encoder_scale_warns_from_2_and_objects_from_5_percent_and_names_what_would_explain_it() {
        let with = |scale: f64| {
            let mut file = demo();
            file.witnesses[0].scale = scale;
            check(&file, "encoder-scale")
        };
        let outcomes = [1.019, 0.979, 1.049, 0.94].map(|scale| with(scale).outcome);
        assert_eq!(outcomes, [CheckOutcome::Passed, CheckOutcome::Warning, CheckOutcome::Warning, CheckOutcome::Objection]);
        // the wheelbase was given as 1.15 m and is 0.90 m
        let mut file = demo();
        (file.vehicle.wheelbase_m, file.witnesses[0].scale) = (1.15, 0.7826);
        let text = check(&file, "encoder-scale").text();
        assert!(
            text.contains("a difference of 21.7 %, 5 % is allowed") && text.contains("0.900 m would agree instead of 1.150 m"),
            "{text}"
        );
        assert!(with(9.55).advice.contains("revolutions per minute") && with(1.0 / 57.3).advice.contains("degrees"));
        assert!(with(4.0).advice.contains("gear ratio of 4.00"));
        let mut alone = demo();
        alone.witnesses[0].scale_std_err = None;
        assert!(all_checks(&alone).iter().all(|c| c.name != "encoder-scale"), "without a yaw rate nothing is compared");
    }

    #[test]
    fn delays_pushes_friction_and_undelivered_torque_are_judged_by_their_figures() {
        let mut file = demo();
        file.actuator.per_log[0].clock_offset =
            crate::map::DelayEstimate { value_s: -0.05, std_err_s: Some(0.001), status: DelayStatus::Estimated };
        file.actuator.dead_time.status = DelayStatus::WeaklyDetermined;
        file.actuator.dead_time.std_err_s = Some(0.012);
        file.maps[0].breakaway.torque_nm = 0.61 * 44.0;
        let names: Vec<String> = all_checks(&file).into_iter().filter(|c| c.outcome == CheckOutcome::Warning).map(|c| c.name).collect();
        assert_eq!(names, ["clock-offset", "dead-time", "friction-forward"]);
        assert!(check(&file, "clock-offset").meaning.contains("demo.mcap: the speed's clock is -50.0 ms"));
        file.maps[1].breakaway.torque_nm = 0.0;
        assert!(check(&file, "friction-reverse").objects(), "no drive is without friction");
        for (pushed, outcome) in [(0.19, CheckOutcome::Passed), (0.21, CheckOutcome::Warning), (0.41, CheckOutcome::Objection)] {
            let mut file = demo();
            let used = file.report.ledger[0].samples as f64;
            let samples = (used * pushed / (1.0 - pushed)).round() as u64;
            file.report.ledger.push(crate::map::LedgerRow { verdict: SampleVerdict::Push, samples, seconds: 1.0 });
            assert_eq!(check(&file, "push-and-slip").outcome, outcome, "{pushed}");
        }
    }

    #[test]
    fn thin_coverage_of_a_file_without_stored_checks_is_an_objection() {
        let mut file = demo();
        for map in &mut file.maps {
            map.status.iter_mut().flatten().for_each(|s| *s = CellStatus::Extrapolated);
        }
        let coverage = check(&file, "coverage");
        assert!(coverage.objects() && coverage.text().contains("0 % of the cells") && coverage.text().contains("30 % are needed"));
    }

    #[test]
    fn a_stored_objection_stays_whatever_the_content_says() {
        let mut file = demo();
        let stored = Check { outcome: CheckOutcome::Objection, ..check(&file, "coverage") };
        file.checks.push(stored.clone());
        assert_eq!(check(&file, "coverage"), stored);
    }

    #[test]
    fn two_driving_torques_or_less_than_20_s_are_too_little_for_a_gear() {
        let mut file = demo();
        file.report.runs.retain(|r| r.gear == Gear::Reverse || r.torque_nm <= 0.0 || [20.0, 20.5, 36.0].contains(&r.torque_nm));
        let reason = too_little(&file, Gear::Forward).unwrap();
        assert!(reason.contains("forward gear: 2 driving torques were used, 3 are needed"), "{reason}");
        assert_eq!(too_little(&file, Gear::Reverse), None);
        let mut file = demo();
        file.report.runs.iter_mut().for_each(|r| r.used_s *= 0.3);
        let reason = too_little(&file, Gear::Reverse).unwrap();
        assert!(reason.contains("19.2 s of motion were used, 20 s are needed"), "{reason}");
    }
}
