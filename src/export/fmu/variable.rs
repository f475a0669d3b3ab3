//! The variables of the unit: one list for `modelDescription.xml` and for the C sources.

use crate::map::WheelAngle;
use std::fmt::Write as _;

/// What a variable is to its user.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Role {
    /// Set at any time.
    Input,
    /// Read.
    Output,
    /// Set before the initialisation.
    Parameter,
}

/// Type with start value and, of parameters, the allowed range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum VariableKind {
    /// A real number.
    Real {
        /// Value at the start.
        start: f64,
        /// Lowest and highest allowed value.
        range: Option<[f64; 2]>,
        /// Unit.
        unit: &'static str,
    },
    /// A whole number.
    Whole {
        /// Value at the start.
        start: i32,
        /// Lowest and highest allowed value.
        range: [i32; 2],
    },
    /// Yes or no, no at the start.
    Boolean,
}

/// One variable; its value reference is its place in the list, from 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variable {
    /// Name.
    pub(crate) name: &'static str,
    /// Meaning.
    pub(crate) about: &'static str,
    /// Role.
    pub(crate) role: Role,
    /// Type.
    pub(crate) kind: VariableKind,
}

const fn input(name: &'static str, unit: &'static str, about: &'static str) -> Variable {
    Variable { name, about, role: Role::Input, kind: VariableKind::Real { start: 0.0, range: None, unit } }
}

const fn output(name: &'static str, unit: &'static str, about: &'static str) -> Variable {
    Variable { name, about, role: Role::Output, kind: VariableKind::Real { start: 0.0, range: None, unit } }
}

const fn factor(name: &'static str, least: f64, about: &'static str) -> Variable {
    Variable { name, about, role: Role::Parameter, kind: VariableKind::Real { start: 1.0, range: Some([least, 100.0]), unit: "1" } }
}

const fn parameter(name: &'static str, unit: &'static str, range: [f64; 2], about: &'static str) -> Variable {
    Variable { name, about, role: Role::Parameter, kind: VariableKind::Real { start: 0.0, range: Some(range), unit } }
}

/// The list. The start of `wheel_angle_rad` is the wheel angle of the map.
pub(crate) const VARIABLES: [Variable; 25] = [
    input("torque_nm", "N.m", "torque command; positive drives the wheel forward, no effect in neutral"),
    Variable {
        name: "gear",
        about: "1 forward, -1 reverse, 0 neutral",
        role: Role::Input,
        kind: VariableKind::Whole { start: 1, range: [-1, 1] },
    },
    Variable { name: "emergency_stop", about: "no drive torque, brake applied", role: Role::Input, kind: VariableKind::Boolean },
    input(
        "wheel_angle_rad",
        "rad",
        "angle of the front wheel for pose and yaw rate, left positive; the surface is that of one wheel angle",
    ),
    input("external_torque_nm", "N.m", "torque from outside on the wheel: a push, a slope"),
    output("speed_mps", "m/s", "front-wheel speed"),
    output("accel_mps2", "m/s2", "its derivative"),
    output("effective_torque_nm", "N.m", "torque on the wheel after dead time and drive"),
    output("distance_m", "m", "distance rolled by the wheel"),
    output("x_m", "m", "place of the rear axle's middle"),
    output("y_m", "m", "place of the rear axle's middle"),
    output("heading_rad", "rad", "heading, counter-clockwise"),
    output("speed_reading_mps", "m/s", "latest reading of the speed sensor that has arrived"),
    output("yaw_rate_reading_rad_s", "rad/s", "latest reading of the yaw rate sensor that has arrived"),
    output("heading_reading_rad", "rad", "latest reading of the heading that has arrived"),
    factor("inertia_factor", 0.01, "on all inertia: a full tank, a load"),
    factor("friction_factor", 0.01, "on all friction, the breakaway torque included"),
    factor("dead_time_factor", 0.01, "on the drive's dead time"),
    factor("lag_factor", 0.01, "on the drive's time constant"),
    factor("torque_limit_factor", 0.01, "on the drive's torque limit: a low battery"),
    Variable {
        name: "noise_factor",
        about: "on disturbance, run-to-run offset and sensor noise; 0 for none",
        role: Role::Parameter,
        kind: VariableKind::Real { start: 0.0, range: Some([0.0, 100.0]), unit: "1" },
    },
    Variable {
        name: "seed",
        about: "of everything random",
        role: Role::Parameter,
        kind: VariableKind::Whole { start: 1, range: [0, 2_147_483_647] },
    },
    parameter("initial_speed_mps", "m/s", [-20.0, 20.0], "front-wheel speed at the start"),
    parameter("torque_step_nm", "N.m", [0.0, 1000.0], "step of the torque command's encoding; 0 for none"),
    parameter("torque_dead_band_nm", "N.m", [0.0, 10000.0], "smaller commands give no torque"),
];

/// Units with their exponents of kg, m, s and rad.
pub(crate) const UNITS: [(&str, [i32; 4]); 7] = [
    ("1", [0, 0, 0, 0]),
    ("m", [0, 1, 0, 0]),
    ("rad", [0, 0, 0, 1]),
    ("m/s", [0, 1, -1, 0]),
    ("m/s2", [0, 1, -2, 0]),
    ("rad/s", [0, 0, -1, 1]),
    ("N.m", [1, 2, -2, 0]),
];

/// Name of a variable's value reference in C.
fn constant(variable: &Variable) -> String {
    format!("PLANT_{}", variable.name.to_ascii_uppercase())
}

/// The value references as constants of an enumeration.
pub(crate) fn references() -> String {
    let line = |(k, v): (usize, &Variable)| format!("    {} = {}, /* {} */", constant(v), k + 1, v.about);
    let mut lines: Vec<String> = VARIABLES.iter().enumerate().map(line).collect();
    lines.push(format!("    PIVOT_PLANT_VARIABLES = {}", VARIABLES.len() + 1));
    lines.join("\n")
}

/// Type and role of each value reference as characters, for the data header.
pub(crate) fn tables() -> String {
    let of = |character: &dyn Fn(&Variable) -> char| -> String { VARIABLES.iter().map(character).collect() };
    let kinds = of(&|v| match v.kind {
        VariableKind::Real { .. } => 'r',
        VariableKind::Whole { .. } => 'n',
        VariableKind::Boolean => 'b',
    });
    let roles = of(&|v| match v.role {
        Role::Input => 'i',
        Role::Output => 'o',
        Role::Parameter => 'p',
    });
    format!("static const char pivot_plant_kind[] = \"-{kinds}\";\nstatic const char pivot_plant_role[] = \"-{roles}\";\n")
}

/// Start value of a real variable.
pub(crate) fn start_of(variable: &Variable, start: f64, angle: WheelAngle) -> f64 {
    if variable.name == "wheel_angle_rad" { angle.rad() } else { start }
}

/// Statements that set the start values, and those that check the parameters.
pub(crate) fn in_c(angle: WheelAngle) -> [String; 2] {
    let (mut starts, mut checks) = (String::new(), String::new());
    for variable in &VARIABLES {
        let name = constant(variable);
        let (array, start) = match variable.kind {
            VariableKind::Real { start, .. } => ("real", format!("{:?}", start_of(variable, start, angle))),
            VariableKind::Whole { start, .. } => ("integer", start.to_string()),
            VariableKind::Boolean => ("integer", "0".to_owned()),
        };
        let _ = writeln!(starts, "    plant->{array}[{name}] = {start};");
        if variable.role != Role::Parameter {
            continue;
        }
        let (low, high) = match variable.kind {
            VariableKind::Real { range: Some([low, high]), .. } => (format!("{low:?}"), format!("{high:?}")),
            VariableKind::Whole { range: [low, high], .. } => (low.to_string(), high.to_string()),
            VariableKind::Real { range: None, .. } | VariableKind::Boolean => continue,
        };
        let _ = writeln!(
            checks,
            "    if (!(plant->{array}[{name}] >= {low} && plant->{array}[{name}] <= {high})) {{\n        *why = \"{} is out of its range; allowed: {low} to \
             {high}\";\n        return 1;\n    }}",
            variable.name
        );
    }
    [starts, checks].map(|text| text.trim_end().to_owned())
}
