//! The controller of a pivot: planning, lateral and longitudinal and their messages, one step per control period.

use crate::drive_law::DriveLaw;
use crate::lateral::{Lateral, LateralSettings};
use crate::longitudinal::{Longitudinal, LongitudinalSettings};
use crate::messages::{AngleStatus, Inputs, LateralTask, Outputs, Phase, PivotRequest, Pose};
use crate::planning::PlanningSettings;
use crate::{Error, Result};

/// Settings of the three modules; the drive law has separate settings.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct PivotSettings {
    /// Planning.
    pub planning: PlanningSettings,
    /// Lateral.
    pub lateral: LateralSettings,
    /// Longitudinal.
    pub longitudinal: LongitudinalSettings,
}

impl PivotSettings {
    /// The defaults for a wheelbase [m] and the wheel angle of the map [rad].
    pub fn new(wheelbase_m: f64, test_angle_rad: f64) -> Self {
        Self {
            planning: PlanningSettings::new(wheelbase_m, test_angle_rad),
            lateral: LateralSettings::default(),
            longitudinal: LongitudinalSettings::default(),
        }
    }
}

/// The controller, with any drive law.
///
/// [`step`](Self::step) allocates nothing, reads no clock, does no input or output, and cannot panic.
#[derive(Debug, Clone)]
pub struct PivotController<L> {
    planning: PlanningSettings,
    lateral: Lateral,
    longitudinal: Longitudinal<L>,
    task: LateralTask,
    angle: AngleStatus,
}

impl<L: DriveLaw> PivotController<L> {
    /// A controller at rest.
    ///
    /// # Errors
    /// Settings that cannot be used.
    pub fn new(settings: &PivotSettings, law: L) -> Result<Self> {
        Ok(Self {
            planning: settings.planning.checked()?,
            lateral: Lateral::new(settings.lateral),
            longitudinal: Longitudinal::new(settings.longitudinal, law),
            task: LateralTask::Rest,
            angle: AngleStatus::InProgress,
        })
    }

    /// Requests a turn of `turn_rad` (left positive, at most ±360°) from `pose`.
    ///
    /// # Errors
    /// A pivot is in progress, or the turn cannot be planned.
    pub fn request(&mut self, turn_rad: f64, pose: Pose) -> Result<()> {
        if self.longitudinal.phase().is_active() {
            return Err(Error::Busy);
        }
        self.longitudinal.request(self.planning.plan(turn_rad, pose)?);
        // the wheel may still be at this angle from the previous pivot; the lateral module must confirm it again
        self.angle = AngleStatus::InProgress;
        Ok(())
    }

    /// Phase of the pivot.
    pub fn phase(&self) -> Phase {
        self.longitudinal.phase()
    }

    /// The request in force, or the last one; `None` before the first.
    pub fn current(&self) -> Option<&PivotRequest> {
        self.longitudinal.current()
    }

    /// One control period: readings → commands. Messages between the modules take one period.
    pub fn step(&mut self, inputs: &Inputs) -> Outputs {
        let done = self.longitudinal.step(inputs, self.angle);
        self.task = done.task;
        let (wheel_angle_rad, angle) = self.lateral.step(self.task, inputs.wheel_angle_rad);
        // lateral restarts with each task, so this status never belongs to the previous task
        self.angle = angle;
        Outputs {
            torque_nm: done.torque_nm,
            wheel_angle_rad,
            gear: done.gear,
            phase: done.phase,
            direction: self.longitudinal.current().map(|request| request.direction),
            angle,
            task: self.task,
            restore: matches!(self.task, LateralTask::Restore(_)),
            drive: done.drive,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use crate::angle::RAD_PER_DEG;
    use crate::{Gear, *};
    use proptest::prelude::*;

    const WHEELBASE_M: f64 = 0.92;
    const INERTIA_NM_PER_MPS2: f64 = 25.0;
    const FRICTION_NM: f64 = 10.0;

    /// The exact inverse of [`Toy`].
    #[derive(Debug, Clone, Copy)]
    struct ToyMap;

    impl TorqueFromAccel for ToyMap {
        fn torque(&self, _gear: Gear, _speed_mps: f64, accel_mps2: f64) -> Option<Lookup> {
            Some(Lookup { torque_nm: FRICTION_NM + INERTIA_NM_PER_MPS2 * accel_mps2, outside: false })
        }
    }

    /// A vehicle with inertia, Coulomb friction, a 50 ms lag, and steering of 90°/s; its fields set faults.
    struct Toy {
        inputs: Inputs,
        speed_mps: f64,
        torque_nm: f64,
        steering_rad_s: f64,
        gear_works: bool,
        speed_works: bool,
        drives: bool,
    }

    impl Toy {
        fn new() -> Self {
            let inputs = Inputs { speed_mps: Some(0.0), wheel_angle_rad: 0.0, pose: Pose::default(), gear: None, estop: false };
            Self {
                inputs,
                speed_mps: 0.0,
                torque_nm: 0.0,
                steering_rad_s: 90.0 * RAD_PER_DEG,
                gear_works: true,
                speed_works: true,
                drives: true,
            }
        }

        fn step(&mut self, command: &Outputs) {
            const STEP_S: f64 = 0.001;
            for _ in 0..20 {
                let asked = if self.drives { command.torque_nm } else { 0.0 };
                self.torque_nm += (asked - self.torque_nm) * STEP_S / 0.05;
                let friction = FRICTION_NM * STEP_S / INERTIA_NM_PER_MPS2;
                let free = self.speed_mps + self.torque_nm * STEP_S / INERTIA_NM_PER_MPS2;
                self.speed_mps = if free.abs() <= friction { 0.0 } else { free - friction * free.signum() };
                let turn = self.steering_rad_s * STEP_S;
                self.inputs.wheel_angle_rad += (command.wheel_angle_rad - self.inputs.wheel_angle_rad).clamp(-turn, turn);
                let (sin, cos) = self.inputs.wheel_angle_rad.sin_cos();
                let heading = self.inputs.pose.heading_rad;
                self.inputs.pose.x_m += self.speed_mps * cos * heading.cos() * STEP_S;
                self.inputs.pose.y_m += self.speed_mps * cos * heading.sin() * STEP_S;
                self.inputs.pose.heading_rad += self.speed_mps * sin / WHEELBASE_M * STEP_S;
            }
            self.inputs.speed_mps = self.speed_works.then_some(self.speed_mps);
            self.inputs.gear = if self.gear_works { command.gear } else { None };
        }
    }

    fn settings(policy: WheelPolicy) -> PivotSettings {
        let mut settings = PivotSettings::new(WHEELBASE_M, 90.0 * RAD_PER_DEG);
        settings.planning.policy = policy;
        settings
    }

    fn controller(policy: WheelPolicy) -> PivotController<WaypointLaw<ToyMap>> {
        let law = WaypointLaw::new(WaypointLawSettings::new(WHEELBASE_M), ToyMap);
        PivotController::new(&settings(policy), law).unwrap()
    }

    /// Runs until the pivot has ended (at most 60 s), with `meddle` before each period; the phases in order.
    fn run<L: DriveLaw>(
        controller: &mut PivotController<L>,
        toy: &mut Toy,
        turn_deg: f64,
        mut meddle: impl FnMut(&mut Toy, Phase),
    ) -> Vec<Phase> {
        controller.request(turn_deg * RAD_PER_DEG, toy.inputs.pose).unwrap();
        let mut phases = vec![controller.phase()];
        for _ in 0..3000 {
            meddle(toy, controller.phase());
            let command = controller.step(&toy.inputs);
            if phases.last() != Some(&command.phase) {
                phases.push(command.phase);
            }
            toy.step(&command);
            if !command.phase.is_active() {
                break;
            }
        }
        phases
    }

    const SUCCESS: [Phase; 6] =
        [Phase::WaitingForAngle, Phase::SettingGear, Phase::Driving, Phase::WaitingForStandstill, Phase::RestoringAngle, Phase::Succeeded];

    #[test]
    fn turns_of_every_size_both_ways_and_with_both_policies_succeed() {
        for policy in [WheelPolicy::HoldLeft, WheelPolicy::Mirror] {
            for turn_deg in [30.0, -30.0, 90.0, -90.0, 180.0, -180.0, 360.0, -360.0] {
                let (mut controller, mut toy) = (controller(policy), Toy::new());
                assert_eq!(run(&mut controller, &mut toy, turn_deg, |_, _| {}), SUCCESS, "{policy:?} {turn_deg}°");
                let error_deg = toy.inputs.pose.heading_rad / RAD_PER_DEG - turn_deg;
                // the end threshold is 0.02 m of arc, 1.25°; coasting covers part of it
                assert!(error_deg.abs() < 1.25, "{policy:?} {turn_deg}°: {error_deg}°");
            }
        }
    }

    #[test]
    fn the_wheel_turns_right_at_its_second_preset_and_returns_to_its_third() {
        let mut settings = settings(WheelPolicy::Mirror);
        (settings.planning.right_angle_rad, settings.planning.return_angle_rad) = (-70.0 * RAD_PER_DEG, 25.0 * RAD_PER_DEG);
        let law = WaypointLaw::new(WaypointLawSettings::new(WHEELBASE_M), ToyMap);
        let (mut controller, mut toy) = (PivotController::new(&settings, law).unwrap(), Toy::new());
        let mut held_deg = Vec::new();
        let mut heading_deg = 0.0;
        for (turn_deg, wheel_deg) in [(90.0, 90.0), (-90.0, -70.0), (180.0, 90.0)] {
            held_deg.clear();
            let phases = run(&mut controller, &mut toy, turn_deg, |toy, phase| {
                if phase == Phase::Driving {
                    held_deg.push(toy.inputs.wheel_angle_rad / RAD_PER_DEG);
                }
            });
            assert_eq!(phases, SUCCESS);
            assert!(held_deg.iter().all(|deg| (deg - wheel_deg).abs() < 1.6), "{turn_deg}°: {held_deg:?}");
            assert!((toy.inputs.wheel_angle_rad / RAD_PER_DEG - 25.0).abs() < 1.6, "{turn_deg}°: {}", toy.inputs.wheel_angle_rad);
            heading_deg += turn_deg;
            assert!((toy.inputs.pose.heading_rad / RAD_PER_DEG - heading_deg).abs() < 1.25 * 3.0);
        }
    }

    #[test]
    fn pivots_can_be_chained_and_a_second_request_during_one_is_refused() {
        let (mut controller, mut toy) = (controller(WheelPolicy::HoldLeft), Toy::new());
        for turn_deg in [90.0, -90.0, 180.0] {
            assert_eq!(run(&mut controller, &mut toy, turn_deg, |_, _| {}), SUCCESS);
        }
        controller.request(1.0, Pose::default()).unwrap();
        assert_eq!(controller.request(1.0, Pose::default()), Err(Error::Busy));
    }

    #[test]
    fn an_obstacle_stop_in_any_phase_fails_the_pivot_and_a_new_request_restarts_it() {
        for stop_in in &SUCCESS[..5] {
            let (mut controller, mut toy) = (controller(WheelPolicy::HoldLeft), Toy::new());
            let phases = run(&mut controller, &mut toy, 90.0, |toy, phase| toy.inputs.estop = phase == *stop_in);
            assert_eq!(phases.last(), Some(&Phase::Failed(Failure::ObstacleStop)), "{stop_in:?}");
            for _ in 0..200 {
                let command = controller.step(&toy.inputs);
                toy.step(&command);
            }
            assert_eq!(toy.speed_mps, 0.0);
            toy.inputs.estop = false;
            assert_eq!(run(&mut controller, &mut toy, 90.0, |_, _| {}), SUCCESS);
        }
    }

    #[test]
    fn each_fault_has_its_reason() {
        type Meddle = fn(&mut Toy, Phase);
        let lost = Failure::Steering(SteeringFault::Lost);
        let cases: [(Failure, Meddle); 9] = [
            (Failure::GearNotSet, |toy, _| toy.gear_works = false),
            (Failure::SpeedLost, |toy, phase| toy.speed_works = phase != Phase::Driving),
            (Failure::StoodStill, |toy, _| toy.drives = false),
            (Failure::TimeOut, |toy, phase| {
                if phase == Phase::Driving {
                    toy.speed_mps = 0.03; // dragged along
                    toy.torque_nm = 0.0;
                }
            }),
            (lost, |toy, phase| {
                if phase == Phase::Driving {
                    toy.steering_rad_s = 0.0;
                    toy.inputs.wheel_angle_rad -= 0.01;
                }
            }),
            (Failure::Steering(SteeringFault::Stuck), |toy, _| {
                if toy.inputs.wheel_angle_rad > 0.5 {
                    toy.steering_rad_s = 0.0;
                }
            }),
            (Failure::Steering(SteeringFault::Stuck), |toy, phase| {
                if phase == Phase::RestoringAngle {
                    toy.steering_rad_s = 0.0;
                }
            }),
            (Failure::Steering(SteeringFault::TooSlow), |toy, _| toy.steering_rad_s = 2.0 * RAD_PER_DEG),
            (Failure::Steering(SteeringFault::Implausible), |toy, phase| {
                if phase == Phase::RestoringAngle {
                    toy.inputs.wheel_angle_rad = 2.5;
                }
            }),
        ];
        for (failure, meddle) in cases {
            let (mut controller, mut toy) = (controller(WheelPolicy::HoldLeft), Toy::new());
            let phases = run(&mut controller, &mut toy, 90.0, meddle);
            assert_eq!(phases.last(), Some(&Phase::Failed(failure)));
        }
    }

    #[test]
    fn the_conventional_law_turns_too() {
        let speed_loop = SpeedLoopSettings::default();
        let law = HeadingLaw::new(HeadingLawSettings {
            period_s: 0.02,
            heading_proportional: 2.0,
            heading_integral: 0.0,
            heading_derivative: 0.2,
            max_speed_mps: 0.6,
            speed_loop: SpeedLoopSettings { proportional_per_s: 4.0, integral_per_s2: 4.0, ..speed_loop },
            standstill_mps: 0.02,
            end_threshold_rad: 1.25 * RAD_PER_DEG,
            torque: ConstantGain { gain_nm_per_mps2: 25.0, limit_nm: 44.0 },
        });
        let mut controller = PivotController::new(&settings(WheelPolicy::HoldLeft), law).unwrap();
        for turn_deg in [90.0, -90.0] {
            let mut toy = Toy::new();
            assert_eq!(run(&mut controller, &mut toy, turn_deg, |_, _| {}), SUCCESS);
            assert!((toy.inputs.pose.heading_rad / RAD_PER_DEG - turn_deg).abs() < 5.0);
        }
    }

    proptest! {
        #[test]
        fn no_input_panics_and_after_a_failure_no_torque_drives(
            turn_deg in prop::sample::select(vec![-90.0, 30.0, 90.0]),
            readings in prop::collection::vec(
                (prop::option::of(any::<f64>()), any::<f64>(), (any::<f64>(), any::<f64>(), any::<f64>()), 0..40u32), 1..60)
        ) {
            let (mut controller, mut toy) = (controller(WheelPolicy::HoldLeft), Toy::new());
            controller.request(turn_deg * RAD_PER_DEG, Pose::default()).unwrap();
            let gear = if turn_deg > 0.0 { Gear::Forward } else { Gear::Reverse };
            for (speed, angle, (x_m, y_m, heading_rad), sane) in readings {
                for _ in 0..sane {
                    let command = controller.step(&toy.inputs);
                    toy.step(&command);
                }
                let wild = Inputs {
                    speed_mps: speed, wheel_angle_rad: angle, pose: Pose { x_m, y_m, heading_rad }, gear: None, estop: sane == 0,
                };
                let command = controller.step(&wild);
                prop_assert!(command.torque_nm.is_finite() && command.wheel_angle_rad.is_finite());
                if matches!(command.phase, Phase::Failed(_)) {
                    prop_assert!(gear.sign() * command.torque_nm <= 0.0);
                    for _ in 0..50 {
                        let after = controller.step(&toy.inputs);
                        prop_assert!(gear.sign() * after.torque_nm <= 0.0 && matches!(after.phase, Phase::Failed(_)));
                        toy.step(&after);
                    }
                }
            }
        }
    }
}
