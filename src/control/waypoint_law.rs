//! The law of the map: waypoints that carry speeds → preview → desired acceleration → look-up → torque.

use crate::drive_law::{DriveInputs, DriveLaw};
use crate::messages::{DriveStep, PivotRequest, Pose};
use crate::numeric::sin_cos;
use crate::speed_loop::{SpeedLoop, SpeedLoopSettings};
use crate::stopping::{Arrival, Left, StoppingGuard, UnderWay};
use crate::torque_map::TorqueFromAccel;
use crate::waypoints::{Nearest, Place};
use crate::{Gear, Preview};

/// Settings of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct WaypointLawSettings {
    /// Control period [s]. Default 0.02.
    pub period_s: f64,
    /// Distance from the rear axle to the front wheel's centre [m].
    pub wheelbase_m: f64,
    /// How the wheel is placed on the path. Default projection.
    pub nearest: Nearest,
    /// How far the law looks ahead.
    pub preview: Preview,
    /// Gains and limits of the speed loop.
    pub speed_loop: SpeedLoopSettings,
    /// Below this speed [m/s] the wheel counts as standing: a desired acceleration of zero or less then gives no torque. Default 0.02, above
    /// the quantum of a usual encoder.
    pub standstill_mps: f64,
    /// The end is reached when less than this is left of the arc [m]. Default 0.02.
    pub end_threshold_m: f64,
    /// Time from a command to its effect [s], dead time and lag together, for what looks at the end. Default 0.1; a map tells its own.
    pub reaction_s: f64,
    /// Age of the pose when it is read [s]: what the wheel has covered since is no longer left. Default 0.015: half a period of a
    /// localisation at 50 Hz, and 5 ms for its way.
    pub pose_age_s: f64,
    /// Fastest rise of a driving acceleration [m/s³]; `None` leaves it free. Default 2.5: the plan's 0.4 m/s² within 0.16 s, about
    /// what dead time and lag of a drive take anyway. A desired
    /// acceleration may always fall, and rise up to zero, at once.
    pub accel_rise_mps3: Option<f64>,
    /// Brakes for the end when the speed loop would come there too fast; `None` leaves that to the speed loop.
    pub guard: Option<StoppingGuard>,
    /// What happens on the last piece. Default: rolling out, with 0.06 m/s: half of the median error of the bare threshold,
    /// and nothing worse than its 99th percentile, over the Monte Carlo of the bundled vehicle.
    pub finish: Finish,
    /// Fastest change of the torque [N·m/s]; `None`, the default, leaves it free.
    pub torque_rate_nm_s: Option<f64>,
}

impl WaypointLawSettings {
    /// The defaults for a wheelbase [m].
    pub fn new(wheelbase_m: f64) -> Self {
        Self {
            period_s: 0.02,
            wheelbase_m,
            nearest: Nearest::default(),
            preview: Preview::default(),
            speed_loop: SpeedLoopSettings::default(),
            standstill_mps: 0.02,
            end_threshold_m: 0.02,
            reaction_s: 0.1,
            pose_age_s: 0.015,
            accel_rise_mps3: Some(2.5),
            guard: Some(StoppingGuard::default()),
            finish: Finish::RollOut { creep_mps: 0.06 },
            torque_rate_nm_s: None,
        }
    }
}

/// How the law finishes.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Finish {
    /// The torque goes as soon as less than the end threshold is left: where the wheel then comes to rest depends on its friction.
    Threshold,
    /// With less than the end threshold left, the torque goes when the wheel would roll out to the end by itself, as the map tells; until
    /// then the wheel is not asked to go slower than it can without standing short of the end.
    RollOut {
        /// Slowest speed that is asked for [m/s].
        creep_mps: f64,
    },
}

/// Share of the end threshold that the wheel may roll past the end without being braked: 5 mm of 0.02 m, the noise of a usual localisation.
const OVERRUN: f64 = 0.25;

/// The law with its map and memory.
#[derive(Debug, Clone)]
pub struct WaypointLaw<M> {
    settings: WaypointLawSettings,
    map: M,
    place: Place,
    speed_loop: SpeedLoop,
    under_way: UnderWay,
    left: Left,
    accel_mps2: f64,
    torque_nm: f64,
    saturated: bool,
}

impl<M: TorqueFromAccel> WaypointLaw<M> {
    /// A law that asks `map`.
    pub fn new(settings: WaypointLawSettings, map: M) -> Self {
        Self {
            settings,
            map,
            place: Place::default(),
            speed_loop: SpeedLoop::default(),
            under_way: UnderWay::new(settings.reaction_s, settings.period_s),
            left: Left::default(),
            accel_mps2: 0.0,
            torque_nm: 0.0,
            saturated: false,
        }
    }

    /// The speed loop's acceleration [m/s²] with the rise of its driving part limited, and under the guard's ceiling.
    fn bounded(&self, accel_mps2: f64, arrival: Arrival) -> f64 {
        let settings = &self.settings;
        let risen = settings.accel_rise_mps3.map_or(f64::INFINITY, |rise| self.accel_mps2.max(0.0) + rise.abs() * settings.period_s);
        let ceiling = settings.guard.map_or(f64::INFINITY, |guard| guard.ceiling_mps2(arrival));
        accel_mps2.min(risen).min(ceiling).max(settings.speed_loop.min_accel_mps2)
    }

    /// How far the wheel rolls by itself from `speed_mps` [m], with the acceleration for which the map gives no torque. Infinity when it would
    /// not come to rest.
    fn rolling_m(&self, gear: Gear, speed_mps: f64) -> f64 {
        let (mut low, mut high) = (self.settings.speed_loop.min_accel_mps2, 0.0);
        let drives = |accel| self.map.torque(gear, speed_mps, accel).is_some_and(|found| found.torque_nm > 0.0);
        if !drives(high) {
            return f64::INFINITY;
        }
        // bisection to 1e-3 of the range
        for _ in 0..10 {
            let middle = 0.5 * (low + high);
            if drives(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        speed_mps * speed_mps / (-2.0 * high.min(-1e-3))
    }

    /// Whether the torque goes now. With a threshold: less than it is left. With rolling out: the wheel would roll to the end by itself, and
    /// not so far past it that braking on were better.
    fn ends(&self, gear: Gear, left_m: f64, arrival: Arrival) -> bool {
        let settings = &self.settings;
        if left_m >= settings.end_threshold_m {
            return false;
        }
        match settings.finish {
            Finish::Threshold => true,
            Finish::RollOut { .. } => {
                let past_m = self.rolling_m(gear, arrival.speed_mps) - arrival.left_m;
                let guarded = settings.guard.is_some_and(|guard| guard.ceiling_mps2(arrival).is_finite());
                let brakes_on = guarded && past_m > OVERRUN * settings.end_threshold_m;
                past_m >= 0.0 && !brakes_on
            }
        }
    }
}

impl<M: TorqueFromAccel> DriveLaw for WaypointLaw<M> {
    fn start(&mut self, request: &PivotRequest, _pose: Pose) {
        self.place = Place::default();
        self.speed_loop = SpeedLoop::default();
        self.under_way = UnderWay::new(self.settings.reaction_s, self.settings.period_s);
        self.left = Left::new(request.path.length_m());
        (self.accel_mps2, self.torque_nm, self.saturated) = (0.0, 0.0, false);
    }

    fn step(&mut self, request: &PivotRequest, inputs: &DriveInputs) -> Option<DriveStep> {
        let settings = &self.settings;
        let (path, speed_mps) = (&request.path, inputs.speed_mps);
        let (sin, cos) = sin_cos(inputs.pose.heading_rad);
        let (x_m, y_m) = (inputs.pose.x_m + settings.wheelbase_m * cos, inputs.pose.y_m + settings.wheelbase_m * sin);
        self.place = path.locate(settings.nearest, x_m, y_m, self.place);
        let seen_m = path.length_m() - path.foot_m(x_m, y_m, self.place) - speed_mps * settings.pose_age_s;
        let left_m = self.left.step(speed_mps, seen_m, settings.period_s);
        let arrival = Arrival::after(settings.reaction_s, speed_mps, self.under_way.mean_mps2(), left_m);
        let ahead_m = settings.preview.distance_m(speed_mps, self.accel_mps2);
        let planned_mps = path.speed_at(self.place.arc_m + ahead_m, self.place.index);
        // e = v_p − v, but at least 2·(creep − v'): braking from well above the creep speed is as ever, at the creep speed it ends
        let target_speed_mps = match settings.finish {
            Finish::Threshold => planned_mps,
            Finish::RollOut { creep_mps } => planned_mps.max(speed_mps + 2.0 * (creep_mps - arrival.speed_mps)),
        };
        let error_mps = target_speed_mps - speed_mps;
        let (looped_mps2, limited) = self.speed_loop.step(&settings.speed_loop, error_mps, self.saturated, settings.period_s);
        let accel_mps2 = self.bounded(looped_mps2, arrival);
        // a wheel that the sensor sees rolling back a little is looked up as standing
        let looked_up_mps = if speed_mps < 0.0 { 0.0 } else { speed_mps };
        let found = self.map.torque(request.gear, looked_up_mps, accel_mps2)?;
        // standing, and nothing wanted: the table's row at v = 0 holds the torque of a wheel that just moves, which would be held for nothing
        let wanted_nm = if speed_mps < settings.standstill_mps && accel_mps2 <= 0.0 { 0.0 } else { found.torque_nm };
        let torque_nm = match settings.torque_rate_nm_s {
            Some(rate) => {
                let step = rate.abs() * settings.period_s;
                wanted_nm.max(self.torque_nm - step).min(self.torque_nm + step)
            }
            None => wanted_nm,
        };
        self.saturated = torque_nm != wanted_nm || found.outside || accel_mps2 != looped_mps2;
        (self.accel_mps2, self.torque_nm) = (accel_mps2, torque_nm);
        self.under_way.push(accel_mps2);
        let end_reached = self.ends(request.gear, left_m, arrival);
        Some(DriveStep {
            torque_nm,
            target_speed_mps,
            speed_mps: looked_up_mps,
            accel_mps2,
            arc_m: self.place.arc_m,
            limited: limited || accel_mps2 != looped_mps2,
            outside_table: found.outside,
            end_reached,
        })
    }

    fn braking_torque_nm(&self, gear: Gear, speed_mps: f64, decel_mps2: f64) -> f64 {
        self.map.torque(gear, speed_mps, -decel_mps2).map_or(0.0, |found| found.torque_nm)
    }
}
