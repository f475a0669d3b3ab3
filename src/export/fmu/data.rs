//! The numbers of the plant as a C header: surfaces, drive, noise, sensors.

use crate::export::Result;
use crate::export::fmu::variable;
use crate::sim::{Error, IdentifiedSettings, MotionSettings, WorldSettings};
use std::fmt::Write as _;

/// A plant whose numbers are written.
pub(crate) struct PlantData<'a> {
    world: &'a WorldSettings,
    motion: &'a IdentifiedSettings,
}

/// Numbers on a line.
const PER_LINE: usize = 8;

impl<'a> PlantData<'a> {
    /// The plant of a world.
    ///
    /// # Errors
    /// A world whose motion is not that of a Table 1.
    pub(crate) fn new(world: &'a WorldSettings) -> Result<Self> {
        match &world.motion {
            MotionSettings::Identified(motion) => Ok(Self { world, motion }),
            MotionSettings::Physical(_) => Err(Error::NoForwardMap { wheel_angle_deg: world.vehicle.test_angle_deg }.into()),
        }
    }

    /// The header's text after its first comment.
    pub(crate) fn in_c(&self) -> String {
        let (drive, sensors) = (&self.world.drive, &self.world.sensors);
        let surfaces: Vec<_> = std::iter::once(&self.motion.forward).chain(&self.motion.reverse).collect();
        let cells = surfaces.iter().map(|s| s.table.values().len()).max().unwrap_or(1);
        let slew = drive.slew_limit_nm_s.unwrap_or(f64::INFINITY);
        let (speed, yaw, pose) = (&sensors.encoder, &sensors.gyro, &sensors.pose);
        let numbers: [(&str, f64, &str); 26] = [
            ("STEP_S", self.world.step_s, "its own step [s]"),
            ("WHEELBASE_M", self.world.vehicle.wheelbase_m, "[m]"),
            ("DEAD_TIME_S", drive.dead_time_s, "[s]"),
            ("LAG_S", drive.lag_s, "time constant of the drive [s]"),
            ("TORQUE_LIMIT_NM", drive.torque_limit_nm, "[N.m]"),
            ("SLEW_NM_S", slew, "largest rate of the torque [N.m/s]"),
            ("FALL_NM_S", drive.slew_fall_limit_nm_s.unwrap_or(slew), "the same while its magnitude falls [N.m/s]"),
            ("FREQUENCY_HZ", drive.frequency_hz.unwrap_or(0.0), "of a drive of second order [Hz]; 0: of first order"),
            ("DAMPING", drive.damping.unwrap_or(0.7), "of a drive of second order"),
            ("ESTOP_BRAKE_NM", drive.estop_brake_nm, "brake of the emergency stop [N.m]"),
            ("POWER_LIMIT", self.motion.power_limit_nm_mps, "largest torque times speed [N.m.m/s]"),
            ("DISTURBANCE_MPS2", self.motion.disturbance_mps2, "standard deviation of the disturbance [m/s2]"),
            ("DISTURBANCE_TIME_S", self.motion.disturbance_time_s, "its time constant [s]"),
            ("RUN_OFFSET_MPS2", self.motion.run_offset_mps2, "standard deviation of the offset of a run [m/s2]"),
            ("SPEED_NOISE_MPS", speed.noise_mps, "standard deviation of a speed reading [m/s]"),
            ("SPEED_STEP_MPS", speed.step_mps, "step of the speed readings [m/s]; 0 for none"),
            ("SPEED_SCALE", speed.scale, "speed reading over true speed"),
            ("SPEED_PERIOD_S", 1.0 / speed.timing.rate_hz, "time between speed readings [s]"),
            ("SPEED_LATENCY_S", speed.timing.latency_s, "time from reading to arrival [s]"),
            ("YAW_RATE_NOISE_RAD_S", yaw.noise_rad_s, "[rad/s]"),
            ("YAW_RATE_PERIOD_S", 1.0 / yaw.timing.rate_hz, "[s]"),
            ("YAW_RATE_LATENCY_S", yaw.timing.latency_s, "[s]"),
            ("HEADING_NOISE_RAD", pose.noise_deg.to_radians(), "[rad]"),
            ("HEADING_PERIOD_S", 1.0 / pose.timing.rate_hz, "[s]"),
            ("HEADING_LATENCY_S", pose.timing.latency_s, "[s]"),
            ("BREAKAWAY_NM", self.motion.forward.breakaway_nm, "forward [N.m]"),
        ];
        let mut text = "#ifndef PIVOT_PLANT_DATA_H\n#define PIVOT_PLANT_DATA_H\n\n#include <math.h>\n\n".to_owned();
        for (name, value, about) in numbers {
            let _ = writeln!(text, "#define PIVOT_PLANT_{name} {} /* {about} */", literal(value));
        }
        let _ = writeln!(text, "#define PIVOT_PLANT_HAS_REVERSE {}", i32::from(self.motion.reverse.is_some()));
        let _ = writeln!(text, "/* Most cells of a surface. */\n#define PIVOT_PLANT_CELLS {cells}\n");
        text.push_str(&variable::tables());
        text.push_str(
            "\n/* Acceleration [m/s2] over torque [N.m] (rows) and speed [m/s] (columns) in the gear's frame. */\ntypedef struct {\n    int \
             speeds, torques;\n    const double *speed_mps, *torque_nm, *accel_mps2;\n    double breakaway_nm;\n} pivot_plant_axes;\n\n",
        );
        let names = ["forward", "reverse"];
        for (name, surface) in names.iter().zip(&surfaces) {
            let table = &surface.table;
            for (part, values) in [("speed", table.speed_mps().breaks()), ("torque", table.torque_nm().breaks()), ("accel", table.values())]
            {
                let lines: Vec<String> = values
                    .chunks(PER_LINE)
                    .map(|line| format!("    {}", line.iter().map(|v| literal(*v)).collect::<Vec<_>>().join(", ")))
                    .collect();
                let _ = writeln!(text, "static const double {name}_{part}[{}] = {{\n{}\n}};\n", values.len(), lines.join(",\n"));
            }
        }
        let rows: Vec<String> = names
            .iter()
            .zip(&surfaces)
            .map(|(name, surface)| {
                let (speeds, torques) = (surface.table.speed_mps().len(), surface.table.torque_nm().len());
                format!("    {{{speeds}, {torques}, {name}_speed, {name}_torque, {name}_accel, {}}}", literal(surface.breakaway_nm))
            })
            .collect();
        let _ = writeln!(text, "static const pivot_plant_axes pivot_plant_axes_of[{}] = {{\n{}\n}};", rows.len(), rows.join(",\n"));
        text.push_str("\n#endif\n");
        text
    }
}

/// A number that reads back as it is.
fn literal(value: f64) -> String {
    if value.is_finite() { format!("{value:?}") } else { "HUGE_VAL".to_owned() }
}
