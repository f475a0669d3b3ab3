//! The pivot controller in C99 with settings and maps compiled in: the law that was verified, bit for bit.
//!
//! In: the map, and the settings of the controller that its verdict is about. Out: header, source, and the shared library's template.

use crate::control::{AfterFailure, Finish, Nearest, OutsidePolicy, PivotSettings, UnderWay, WaypointLawSettings, WheelPolicy};
use crate::controller::{ControllerFile, ControllerSettings};
use crate::export::file::File;
use crate::export::{Error, ExportSettings, MapSource, Precision, Result, c, provenance};
use crate::map::{Gear, TorqueTable};
use std::fmt::Write as _;

const HEADER: &str = include_str!("template/pivot_controller.h.in");
const SOURCE: &str = include_str!("template/pivot_controller.c.in");
const LIBRARY: &str = include_str!("template/pivot_controller_library.c.in");

/// Numbers on a line.
const PER_LINE: usize = 8;

/// The three files.
///
/// # Errors
/// Single precision or whole counts, which were not verified; settings that the controller refuses for this vehicle; a map without its forward
/// table.
pub(crate) fn files(source: &MapSource, settings: &ExportSettings) -> Result<Vec<File>> {
    if settings.precision != Precision::Double || settings.int16 {
        return Err(Error::DoubleOnly { format: "controller-c" });
    }
    let file = match &source.proof.controller {
        Some(file) => file.clone(),
        None => ControllerFile::bundled()?,
    };
    let controller = file.settings();
    let vehicle = &source.table2.vehicle;
    let pivot = controller.pivot(vehicle.wheelbase_m, vehicle.test_angle().rad());
    let law = controller.law(vehicle.wheelbase_m, source.table2.dead_time_s + source.table2.lag_s);
    pivot.planning.checked().map_err(Error::Controller)?;
    UnderWay::checked(law.reaction_s, law.period_s).map_err(Error::Controller)?;
    let of = |gear| source.torque.iter().find(|(g, _)| *g == gear).map(|(_, table)| table);
    let forward = of(Gear::Forward).ok_or(Error::Controller(crate::control::Error::NoTable { gear: Gear::Forward }))?;
    let reverse = of(Gear::Reverse);
    let tables: String =
        std::iter::once(("forward", forward)).chain(reverse.map(|t| ("reverse", t))).map(|(name, table)| in_c(name, table)).collect();
    let provenance: Vec<_> = provenance::lines(source).iter().map(|line| format!(" * {line}")).collect();
    let whose = if source.proof.controller.is_some() { "of the verdict" } else { "of the program, since there is no verdict" };
    let sha256: String = file.sha256().chars().filter(char::is_ascii_alphanumeric).collect();
    let settings_line = format!(" * Settings {whose}: SHA-256 {sha256}.");
    let policy = if matches!(controller_policy(controller), WheelPolicy::Mirror) { "PIVOT_MIRROR" } else { "PIVOT_HOLD_LEFT" };
    let fill = |template: &str| {
        template
            .replace("@PROVENANCE@", &provenance.join("\n"))
            .replace("@SETTINGS@", &settings_line)
            .replace("@VERIFIED@", if source.proof.is_verified { "1" } else { "0" })
            .replace("@SHA256@", &c::sha256(source))
            .replace("@GENERATION@", &source.table2.generation)
            .replace("@PERIOD_S@", &literal(law.period_s))
            .replace("@CONSTANTS@", &constants(&pivot, &law, controller.outside(), reverse.is_some()))
            .replace("@TABLES@", tables.trim_end())
            .replace("@POLICY@", policy)
            .replace("@RIGHT_ANGLE_RAD@", &literal(pivot.planning.right_angle_rad))
            .replace("@RETURN_ANGLE_RAD@", &literal(pivot.planning.return_angle_rad))
    };
    let bytes: usize = source.torque.iter().map(|(_, t)| 8 * (t.values().len() + t.speed_mps().len() + t.accel_mps2().len())).sum();
    let note = Some(format!("{bytes} bytes of tables"));
    Ok(vec![
        File::new("pivot_controller.h", fill(HEADER)),
        File { note, ..File::new("pivot_controller.c", fill(SOURCE)) },
        File::new("pivot_controller_library.c", fill(LIBRARY)),
    ])
}

/// The policy of the presets: hold-left where both are judged.
fn controller_policy(settings: &ControllerSettings) -> WheelPolicy {
    let policy = settings.planning.wheel_policy;
    if policy.has(WheelPolicy::HoldLeft) { WheelPolicy::HoldLeft } else { WheelPolicy::Mirror }
}

/// Every setting as a constant.
fn constants(pivot: &PivotSettings, law: &WaypointLawSettings, outside: OutsidePolicy, has_reverse: bool) -> String {
    let (planning, lateral, longitudinal) = (&pivot.planning, &pivot.lateral, &pivot.longitudinal);
    let (brakes, decel_mps2, fade_mps) = match longitudinal.after_failure {
        AfterFailure::Coast => (false, 0.0, 1.0),
        AfterFailure::Brake { decel_mps2, fade_mps } => (true, decel_mps2, fade_mps),
    };
    let (rolls_out, creep_mps) = match law.finish {
        Finish::Threshold => (false, 0.0),
        Finish::RollOut { creep_mps } => (true, creep_mps),
    };
    let numbers = [
        ("WHEELBASE_M", law.wheelbase_m),
        ("LEFT_ANGLE_RAD", planning.test_angle_rad.abs()),
        ("START_MPS", planning.profile.start_mps),
        ("CRUISE_MPS", planning.profile.cruise_mps),
        ("ACCEL_MPS2", planning.profile.accel_mps2),
        ("DECEL_MPS2", planning.profile.decel_mps2),
        ("SPACING_M", planning.spacing_m),
        ("LAG_S", law.preview.lag_s),
        ("LEAST_DISTANCE_M", law.preview.min_m),
        ("PROPORTIONAL_PER_S", law.speed_loop.proportional_per_s),
        ("INTEGRAL_PER_S2", law.speed_loop.integral_per_s2),
        ("MIN_ACCEL_MPS2", law.speed_loop.min_accel_mps2),
        ("MAX_ACCEL_MPS2", law.speed_loop.max_accel_mps2),
        ("STANDSTILL_MPS", law.standstill_mps),
        ("END_THRESHOLD_M", law.end_threshold_m),
        ("REACTION_S", law.reaction_s),
        ("POSE_AGE_S", law.pose_age_s),
        ("RISE_MPS3", law.accel_rise_mps3.unwrap_or(0.0).abs()),
        ("GUARD_FROM_MPS2", law.guard.map_or(0.0, |guard| guard.from_mps2)),
        ("CREEP_MPS", creep_mps),
        ("TORQUE_RATE_NM_S", law.torque_rate_nm_s.unwrap_or(0.0).abs()),
        ("TOLERANCE_RAD", lateral.tolerance_rad),
        ("SETTLE_S", lateral.settle_s),
        ("LOST_RAD", lateral.lost_rad),
        ("PLAUSIBLE_RAD", lateral.plausible_rad),
        ("STUCK_RAD", lateral.stuck_rad),
        ("STUCK_S", lateral.stuck_s),
        ("SLOW_S", lateral.slow_s),
        ("STANDSTILL_FILTER_S", longitudinal.standstill_filter_s),
        ("STOOD_STILL_S", longitudinal.stood_still_s),
        ("STOOD_SHORT_S", longitudinal.stood_short_s),
        ("SPEED_LOST_S", longitudinal.speed_lost_s),
        ("GEAR_S", longitudinal.gear_s),
        ("DRIVE_FACTOR", longitudinal.drive_factor),
        ("DRIVE_EXTRA_S", longitudinal.drive_extra_s),
        ("STANDSTILL_WAIT_S", longitudinal.standstill_wait_s),
        ("FAILURE_DECEL_MPS2", decel_mps2),
        ("FAILURE_FADE_MPS", fade_mps),
    ];
    let choices = [
        ("PROJECTS", law.nearest == Nearest::Projection),
        ("CLAMPS", outside == OutsidePolicy::Clamp),
        ("HAS_RISE", law.accel_rise_mps3.is_some()),
        ("HAS_GUARD", law.guard.is_some()),
        ("ROLLS_OUT", rolls_out),
        ("HAS_TORQUE_RATE", law.torque_rate_nm_s.is_some()),
        ("BRAKES", brakes),
    ];
    let mut text = String::new();
    for (name, value) in numbers {
        let _ = writeln!(text, "#define {name} {}", literal(value));
    }
    for (name, is_so) in choices {
        let _ = writeln!(text, "#define {name} {}", i32::from(is_so));
    }
    let _ = write!(text, "#define REVERSE {}", if has_reverse { "&reverse" } else { "((const table *)NULL)" });
    text
}

/// A table with its axes.
fn in_c(name: &str, table: &TorqueTable) -> String {
    let array = |part: &str, values: &[f64]| {
        let lines = values.chunks(PER_LINE).map(|line| format!("    {}", line.iter().map(|v| literal(*v)).collect::<Vec<_>>().join(", ")));
        format!("static const double {name}_{part}[{}] = {{\n{}\n}};\n", values.len(), lines.collect::<Vec<_>>().join(",\n"))
    };
    let (speed, accel) = (table.speed_mps().breaks(), table.accel_mps2().breaks());
    let arrays = [array("speed_mps", speed), array("accel_mps2", accel), array("torque_nm", table.values())].concat();
    let (speeds, accels) = (speed.len(), accel.len());
    format!("{arrays}static const table {name} = {{{name}_speed_mps, {name}_accel_mps2, {name}_torque_nm, {speeds}, {accels}}};\n\n")
}

/// A number that reads back as it is, negative ones in brackets.
fn literal(value: f64) -> String {
    if value.is_sign_negative() { format!("({value:?})") } else { format!("{value:?}") }
}
