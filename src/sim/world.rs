//! The world loop with a fixed step: command → drive → traction → motion → body → sensors.

use crate::sim::drive::Drive;
use crate::sim::error::Result;
use crate::sim::load::Load;
use crate::sim::motion::Motion;
use crate::sim::pose::{Body, SpeedStep, WheelAngleTerms};
use crate::sim::sensors::{Scene, Sensors};
use crate::sim::settings::WorldSettings;
use crate::sim::steering::Steering;
use crate::sim::traction::Traction;
use crate::sim::{Fault, Gear};

/// Standard gravity [m/s²]. Source: ISO 80000-3.
const GRAVITY_MPS2: f64 = 9.806_65;

/// Command of a controller, vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct WorldCommand {
    /// Torque [N·m]; positive drives the wheel forward. It has no effect in neutral.
    pub torque_nm: f64,
    /// Wheel angle target [rad], left positive.
    pub wheel_angle_rad: f64,
    /// Gear; `None` is neutral.
    pub gear: Option<Gear>,
}

/// The true state, without sensor errors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct TrueState {
    /// Time since the start [s].
    pub t_s: f64,
    /// Front-wheel speed over the floor [m/s], vehicle frame.
    pub speed_mps: f64,
    /// Its derivative [m/s²].
    pub accel_mps2: f64,
    /// Wheel angle [rad], left positive.
    pub wheel_angle_rad: f64,
    /// x of the rear axle's middle [m].
    pub x_m: f64,
    /// y of the rear axle's middle [m].
    pub y_m: f64,
    /// Heading [rad], counter-clockwise, not wrapped.
    pub heading_rad: f64,
    /// Effective torque [N·m], after dead time and lag, vehicle frame.
    pub torque_nm: f64,
}

/// Input of a controller: the latest readings that have arrived.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measurement {
    /// Front-wheel speed from the encoder [m/s]; `None` if the sensor is lost.
    pub speed_mps: Option<f64>,
    /// Wheel angle [rad].
    pub wheel_angle_rad: f64,
    /// Yaw rate [rad/s].
    pub yaw_rate_rad_s: f64,
    /// x of the rear axle's middle [m].
    pub x_m: f64,
    /// y of the rear axle's middle [m].
    pub y_m: f64,
    /// Heading [rad].
    pub heading_rad: f64,
    /// Gear engaged.
    pub gear: Option<Gear>,
    /// Whether the emergency stop is active: no drive torque, brake applied.
    pub estop: bool,
}

/// One simulated vehicle on its floor. The same settings, seed and commands give the same bits.
#[derive(Debug, Clone)]
pub struct World {
    step_s: f64,
    steps: u64,
    t_s: f64,
    drive: Drive,
    /// Effective torque at the start of the last step [N·m].
    torque_before_nm: f64,
    traction: Traction,
    motion: Motion,
    steering: Steering,
    angle: WheelAngleTerms,
    /// Whether `angle` and the motion's terms still hold the last steering movement instead of one fixed angle.
    angle_moved: bool,
    body: Body,
    sensors: Sensors,
    rolled_m: f64,
    gear: Option<Gear>,
    estop: bool,
    brake_nm: f64,
    torque_limit_nm: f64,
    wheel_radius_m: f64,
    wheelbase_m: f64,
    push_nm: f64,
    slope: Option<Slope>,
    wheel_angle_offset_rad: f64,
    speed_lost: bool,
}

#[derive(Debug, Clone, Copy)]
struct Slope {
    /// Torque that holds the vehicle with the wheel pointing straight uphill [N·m].
    torque_nm: f64,
    uphill_rad: f64,
}

impl World {
    /// A vehicle at rest at the origin, heading along x, wheel straight ahead, in neutral.
    ///
    /// # Errors
    /// A setting is out of its range.
    pub fn new(settings: &WorldSettings, seed: u64) -> Result<Self> {
        settings.check()?;
        let (step_s, vehicle) = (settings.step_s, &settings.vehicle);
        let mut motion = Motion::new(&settings.motion, vehicle, step_s, seed)?;
        let angle = WheelAngleTerms::fixed(0.0);
        motion.set_angle(&angle);
        let mut world = Self {
            step_s,
            steps: 0,
            t_s: 0.0,
            drive: Drive::new(&settings.drive, step_s)?,
            torque_before_nm: 0.0,
            traction: Traction::new(motion.wheel_mass_kg(), vehicle.wheel_radius_m, step_s),
            motion,
            steering: Steering::new(&settings.steering, step_s)?,
            angle,
            angle_moved: false,
            body: Body::new(vehicle.wheelbase_m),
            sensors: Sensors::new(&settings.sensors, vehicle, seed)?,
            rolled_m: 0.0,
            gear: None,
            estop: false,
            brake_nm: settings.drive.estop_brake_nm,
            torque_limit_nm: settings.drive.torque_limit_nm,
            wheel_radius_m: vehicle.wheel_radius_m,
            wheelbase_m: vehicle.wheelbase_m,
            push_nm: 0.0,
            slope: None,
            wheel_angle_offset_rad: 0.0,
            speed_lost: false,
        };
        world.look();
        Ok(world)
    }

    /// Advances one step under `command`. A NaN torque counts as zero; a NaN angle holds the wheel angle.
    #[inline]
    pub fn step(&mut self, command: &WorldCommand) {
        self.gear = command.gear;
        let commanded_nm = if self.estop || command.gear.is_none() { 0.0 } else { command.torque_nm };
        self.torque_before_nm = self.drive.effective_nm();
        let nothing_pushes = commanded_nm == 0.0 && self.drive.is_untouched() && self.push_nm == 0.0 && self.slope.is_none();
        let (speed, turning) = if nothing_pushes && self.motion.speed_mps() == 0.0 && self.traction.slip_mps() == 0.0 {
            (SpeedStep::default(), self.steer(command.wheel_angle_rad))
        } else {
            let torque = self.traction.step(self.drive.step(commanded_nm));
            let turning = self.steer(command.wheel_angle_rad);
            let brake_nm = if self.estop { self.brake_nm } else { 0.0 };
            let load = Load { torque, external_nm: self.external_nm(), brake_nm, gear: command.gear };
            (self.motion.step(&load), turning)
        };
        if let Some(angles_rad) = turning {
            // the plant ignores the angle while the steering turns: sines are computed only if the vehicle rolls, which is rare then
            if speed.is_rest() {
                self.body.rest();
            } else {
                self.angle = self.angle.after(angles_rad);
                self.body.step(self.step_s, speed, &self.angle);
            }
        } else {
            self.body.step(self.step_s, speed, &self.angle);
        }
        self.rolled_m += speed.distance_m(self.step_s) + self.step_s * self.traction.slip_mps();
        self.steps += 1;
        self.t_s = self.steps as f64 * self.step_s;
        self.look();
    }

    /// The true state.
    #[inline]
    pub fn state(&self) -> TrueState {
        TrueState {
            t_s: self.t_s,
            speed_mps: self.motion.speed_mps(),
            accel_mps2: self.motion.accel_mps2(),
            wheel_angle_rad: self.steering.angle_rad(),
            x_m: self.body.x_m(),
            y_m: self.body.y_m(),
            heading_rad: self.body.heading_rad(),
            torque_nm: self.drive.effective_nm(),
        }
    }

    /// The latest readings that have arrived.
    pub fn measure(&self) -> Measurement {
        let now_s = self.t_s;
        let [x_m, y_m, heading_rad] = self.sensors.pose().latest(now_s);
        Measurement {
            speed_mps: if self.speed_lost { None } else { Some(self.sensors.encoder().latest(now_s)) },
            wheel_angle_rad: self.sensors.steering_angle().latest(now_s),
            yaw_rate_rad_s: self.sensors.gyro().latest(now_s),
            x_m,
            y_m,
            heading_rad,
            gear: self.gear,
            estop: self.estop,
        }
    }

    /// The sensors with the times of their readings, for a log.
    pub fn sensors(&self) -> &Sensors {
        &self.sensors
    }

    /// Leaves out the sensors that no controller reads: the torque feedback, and the gyro unless `yaw_rate` is read from [`Measurement`]. Every
    /// sensor has a random stream of its own, so that the readings of the others stay the same.
    pub(crate) fn leave_out_unread_sensors(&mut self, yaw_rate: bool) {
        self.sensors.silence_torque_feedback();
        if !yaw_rate {
            self.sensors.silence_gyro();
        }
    }

    /// Speed of the wheel's rim over the floor [m/s]: 0 unless it slips.
    #[inline]
    pub fn slip_mps(&self) -> f64 {
        self.traction.slip_mps()
    }

    /// The torque command after the drive's input [N·m]: rounded, limited, zero in neutral and during an emergency stop.
    pub fn accepted_torque_nm(&self, command: &WorldCommand) -> f64 {
        if self.estop || command.gear.is_none() { 0.0 } else { self.drive.limited(command.torque_nm) }
    }

    /// Applies or releases the emergency stop.
    pub fn set_estop(&mut self, estop: bool) {
        self.estop = estop;
    }

    /// Sets the initial wheel angle [rad] directly.
    pub fn place_wheel(&mut self, angle_rad: f64) {
        self.steering.place(angle_rad);
        self.set_fixed_angle();
        self.look();
    }

    /// Sets the initial front-wheel speed [m/s] directly.
    pub fn place_speed(&mut self, speed_mps: f64) {
        self.motion.set_speed(speed_mps);
    }

    /// Draws the values that differ between runs: friction of the physical plant, offset of the identified one. The first draw is made at
    /// creation.
    pub fn begin_run(&mut self) {
        self.motion.begin_run();
    }

    /// Injects or clears a fault.
    pub fn inject(&mut self, fault: Fault) {
        match fault {
            Fault::Cleared => {
                self.steering.set_stuck(false);
                self.steering.set_rate_factor(1.0);
                self.wheel_angle_offset_rad = 0.0;
                self.speed_lost = false;
                self.slope = None;
                self.traction.set_grip_nm(f64::INFINITY);
                self.push_nm = 0.0;
                self.drive.set_torque_limit_nm(self.torque_limit_nm);
            }
            Fault::SteeringStuck => self.steering.set_stuck(true),
            Fault::SteeringSlow { rate_factor } => self.steering.set_rate_factor(rate_factor),
            Fault::SteeringOffset { offset_rad } => self.wheel_angle_offset_rad = offset_rad,
            Fault::SpeedSensorLost => self.speed_lost = true,
            Fault::Slope { grade_rad, uphill_heading_rad } => {
                let torque_nm = self.motion.slope_mass_kg() * GRAVITY_MPS2 * grade_rad.sin() * self.wheel_radius_m;
                self.slope = Some(Slope { torque_nm, uphill_rad: uphill_heading_rad });
            }
            Fault::WetFloor { grip_nm } => self.traction.set_grip_nm(grip_nm),
            Fault::Push { force_n } => self.push_nm = force_n * self.wheel_radius_m,
            Fault::TorqueLimit { limit_nm } => self.drive.set_torque_limit_nm(limit_nm),
        }
    }

    /// Turns the wheel. Returns the angles of the step [rad] if it moved and only the body needs them.
    #[inline]
    fn steer(&mut self, target_rad: f64) -> Option<[f64; 3]> {
        match self.steering.step(target_rad) {
            Some(step) => {
                let angles_rad = [step.start_rad, step.mid_rad, step.end_rad];
                self.angle_moved = true;
                if self.slope.is_none() && self.motion.knows_one_angle() {
                    return Some(angles_rad);
                }
                self.angle = self.angle.after(angles_rad);
                self.motion.set_angle(&self.angle);
            }
            None if self.angle_moved => self.set_fixed_angle(),
            None => {}
        }
        None
    }

    fn set_fixed_angle(&mut self) {
        self.angle = WheelAngleTerms::fixed(self.steering.angle_rad());
        self.motion.set_angle(&self.angle);
        self.angle_moved = false;
    }

    #[inline]
    fn external_nm(&self) -> f64 {
        let slope_nm = self
            .slope
            .map_or(0.0, |slope| -slope.torque_nm * self.body.cos_of_wheel_from(slope.uphill_rad, self.angle.sin[0], self.angle.cos[0]));
        self.push_nm + slope_nm
    }

    #[inline]
    fn look(&mut self) {
        if self.t_s < self.sensors.next_event_s() {
            self.sensors.forget_taken();
        } else {
            self.look_closely();
        }
    }

    fn look_closely(&mut self) {
        self.sensors.poll(&Scene {
            t_s: self.t_s,
            rim_speed_mps: self.motion.speed_mps() + self.traction.slip_mps(),
            accel_mps2: self.motion.accel_mps2(),
            rolled_m: self.rolled_m,
            wheel_angle_rad: self.steering.angle_rad(),
            wheel_angle_offset_rad: self.wheel_angle_offset_rad,
            torque_nm: self.drive.effective_nm(),
            delivered_nm: self.motion.delivered_nm(self.drive.effective_nm()),
            torque_slope_nm_s: (self.drive.effective_nm() - self.torque_before_nm) / self.step_s,
            yaw_rate_rad_s: self.body.yaw_rate_rad_s(),
            yaw_accel_rad_s2: self.motion.accel_mps2() * self.angle.sin[2] / self.wheelbase_m,
            pose: [self.body.x_m(), self.body.y_m(), self.body.heading_rad()],
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::map::Vehicle;
    use crate::sim::PhysicalSettings;
    use std::f64::consts::FRAC_PI_2;

    fn settings() -> WorldSettings {
        let vehicle =
            Vehicle { wheelbase_m: 0.9, wheel_radius_m: 0.12, test_angle_deg: 90.0, torque_limit_nm: None, torque_full_scale_nm: None };
        WorldSettings::physical(vehicle, PhysicalSettings { friction_spread: 0.02, disturbance_nm: 0.2, ..PhysicalSettings::default() })
    }

    fn drive(torque_nm: f64) -> WorldCommand {
        WorldCommand { torque_nm, wheel_angle_rad: FRAC_PI_2, gear: Some(Gear::Forward) }
    }

    fn run(seed: u64) -> (TrueState, Measurement) {
        let mut world = World::new(&settings(), seed).unwrap();
        for k in 0..6000 {
            world.step(&drive(if k < 2500 { 0.0 } else { 25.0 }));
        }
        (world.state(), world.measure())
    }

    #[test]
    fn the_same_seed_gives_the_same_bits_and_another_seed_gives_other_noise() {
        assert_eq!(run(4), run(4));
        assert_ne!(run(4).1.yaw_rate_rad_s, run(5).1.yaw_rate_rad_s);
    }

    #[test]
    fn a_pivot_leaves_the_reference_point_in_place_and_turns_by_arc_over_wheelbase() {
        let mut world = World::new(&settings(), 1).unwrap();
        world.place_wheel(FRAC_PI_2);
        let mut arc_m = 0.0;
        for _ in 0..4000 {
            let before = world.state().speed_mps;
            world.step(&drive(25.0));
            arc_m += 5e-4 * (before + world.state().speed_mps);
        }
        let state = world.state();
        assert!(state.heading_rad > 1.0 && (state.heading_rad - arc_m / 0.9).abs() < 1e-5, "{state:?}");
        assert_eq!((state.x_m, state.y_m), (0.0, 0.0));
    }

    #[test]
    fn a_slope_below_breakaway_holds_and_a_steep_one_rolls_away_downhill() {
        for (grade_rad, rolls) in [(0.05, false), (0.3, true)] {
            let mut world = World::new(&settings(), 1).unwrap();
            world.inject(Fault::Slope { grade_rad, uphill_heading_rad: 0.0 });
            for _ in 0..500 {
                world.step(&WorldCommand::default());
            }
            assert_eq!(world.state().speed_mps < 0.0, rolls, "grade {grade_rad} rad");
        }
    }

    #[test]
    fn an_emergency_stop_removes_the_torque_and_brakes() {
        let mut world = World::new(&settings(), 1).unwrap();
        world.place_wheel(FRAC_PI_2);
        for _ in 0..1500 {
            world.step(&drive(30.0));
        }
        assert!(world.state().speed_mps > 0.5);
        world.set_estop(true);
        assert_eq!(world.accepted_torque_nm(&drive(30.0)), 0.0);
        for _ in 0..1500 {
            world.step(&drive(30.0));
        }
        assert_eq!(world.state().speed_mps, 0.0);
        assert!(world.measure().estop);
    }

    #[test]
    fn on_a_wet_floor_the_encoder_reads_more_than_the_vehicle_speed() {
        let mut world = World::new(&settings(), 1).unwrap();
        world.place_wheel(FRAC_PI_2);
        world.inject(Fault::WetFloor { grip_nm: 15.0 });
        for _ in 0..600 {
            world.step(&drive(40.0));
        }
        let (state, seen) = (world.state(), world.measure());
        assert!(world.slip_mps() > 1.0 && seen.speed_mps.unwrap() > state.speed_mps + 0.8, "{state:?} {seen:?}");
        world.inject(Fault::Cleared);
        world.step(&drive(40.0));
        assert_eq!(world.slip_mps(), 0.0);
    }

    #[test]
    fn faults_change_the_readings() {
        let mut world = World::new(&settings(), 1).unwrap();
        world.inject(Fault::SteeringStuck);
        world.inject(Fault::SpeedSensorLost);
        world.inject(Fault::SteeringOffset { offset_rad: 3.0 });
        for _ in 0..200 {
            world.step(&drive(0.0));
        }
        let seen = world.measure();
        assert_eq!(world.state().wheel_angle_rad, 0.0);
        assert!(seen.speed_mps.is_none() && (seen.wheel_angle_rad - 3.0).abs() < 0.02, "{seen:?}");
    }

    #[test]
    fn commands_that_are_not_numbers_do_no_harm() {
        let mut world = World::new(&settings(), 1).unwrap();
        for _ in 0..1000 {
            world.step(&WorldCommand { torque_nm: f64::NAN, wheel_angle_rad: f64::NAN, gear: Some(Gear::Forward) });
        }
        assert_eq!((world.state().speed_mps, world.state().wheel_angle_rad), (0.0, 0.0));
    }
}
