//! The settings of the pivot controller's modules and of its law, for a vehicle.

use crate::control::{
    AfterFailure, Finish, LateralSettings, LongitudinalSettings, OutsidePolicy, PivotSettings, PlanningSettings, Preview, Profile,
    SpeedLoopSettings, StoppingGuard, WaypointLawSettings,
};
use crate::controller::ControllerSettings;
use crate::controller::module_sections::{SpotTurnKeys, TrackingKeys};
use crate::controller::sections::LoopKeys;
use crate::controller::words::Ending;
use crate::units::RAD_PER_DEG;

impl ControllerSettings {
    /// The settings of planning, lateral and longitudinal for a wheelbase [m] and the wheel angle of the map [rad].
    pub(crate) fn pivot(&self, wheelbase_m: f64, test_angle_rad: f64) -> PivotSettings {
        let (planning, monitoring, steering) = (&self.planning, &self.monitoring, &self.steering);
        let default = PlanningSettings::new(wheelbase_m, test_angle_rad);
        PivotSettings {
            planning: PlanningSettings {
                right_angle_rad: planning.right_angle_deg.value().map_or(default.right_angle_rad, |deg| deg * RAD_PER_DEG),
                return_angle_rad: planning.return_angle_deg * RAD_PER_DEG,
                profile: Profile {
                    start_mps: planning.start_speed_mps,
                    cruise_mps: planning.cruise_speed_mps,
                    accel_mps2: planning.accel_mps2,
                    decel_mps2: planning.decel_mps2,
                },
                spacing_m: planning.waypoint_spacing_m,
                ..default
            },
            lateral: LateralSettings {
                period_s: self.period_s,
                tolerance_rad: steering.tolerance_deg * RAD_PER_DEG,
                settle_s: steering.settle_s,
                lost_rad: steering.lost_deg * RAD_PER_DEG,
                plausible_rad: steering.plausible_deg * RAD_PER_DEG,
                stuck_rad: steering.stuck_deg * RAD_PER_DEG,
                stuck_s: steering.stuck_s,
                slow_s: steering.slow_s,
            },
            longitudinal: LongitudinalSettings {
                period_s: self.period_s,
                standstill_mps: self.finish.standstill_speed_mps,
                standstill_filter_s: self.additions.standstill_filter_s,
                stood_still_s: monitoring.rest_s,
                stood_short_s: monitoring.stood_short_s,
                speed_lost_s: monitoring.speed_lost_s,
                gear_s: monitoring.gear_s,
                drive_factor: monitoring.drive_factor,
                drive_extra_s: monitoring.drive_extra_s,
                standstill_wait_s: monitoring.standstill_wait_s,
                after_failure: monitoring
                    .failure_decel_mps2
                    .value()
                    .map_or(AfterFailure::Coast, |decel_mps2| AfterFailure::Brake { decel_mps2, fade_mps: monitoring.failure_fade_mps }),
            },
        }
    }

    /// The settings of the law for a wheelbase [m] and the time from a command to its effect that the map holds [s].
    pub(crate) fn law(&self, wheelbase_m: f64, reaction_s: f64) -> WaypointLawSettings {
        let (additions, finish) = (&self.additions, &self.finish);
        WaypointLawSettings {
            period_s: self.period_s,
            wheelbase_m,
            nearest: self.preview.nearest.into(),
            preview: Preview { lag_s: self.preview.lag_s, min_m: self.preview.least_distance_m },
            speed_loop: self.speed_loop.gains(),
            standstill_mps: finish.standstill_speed_mps,
            end_threshold_m: finish.end_threshold_m,
            reaction_s: additions.reaction_s.value().unwrap_or(reaction_s),
            pose_age_s: additions.pose_age_s,
            accel_rise_mps3: additions.accel_rise_mps3.value(),
            guard: additions.guard_from_mps2.value().map(|from_mps2| StoppingGuard { from_mps2 }),
            finish: match finish.finish {
                Ending::Threshold => Finish::Threshold,
                Ending::RollOut => Finish::RollOut { creep_mps: finish.creep_speed_mps },
            },
            torque_rate_nm_s: additions.torque_rate_nm_s.value(),
        }
    }

    /// Policy outside the table's axes.
    pub(crate) fn outside(&self) -> OutsidePolicy {
        self.finish.outside_axes.into()
    }
}

impl LoopKeys {
    /// Gains and limits of the pivot's speed loop.
    fn gains(&self) -> SpeedLoopSettings {
        gains([self.proportional_per_s, self.integral_per_s2], [self.lowest_accel_mps2, self.highest_accel_mps2])
    }
}

impl TrackingKeys {
    /// Gains and limits of the speed loop along a path.
    pub(crate) fn gains(&self) -> SpeedLoopSettings {
        gains([self.proportional_per_s, self.integral_per_s2], [self.lowest_accel_mps2, self.highest_accel_mps2])
    }
}

impl SpotTurnKeys {
    /// Gains and limits of the speed loop of a turn on the spot.
    pub(crate) fn gains(&self) -> SpeedLoopSettings {
        gains([self.proportional_per_s, self.integral_per_s2], [self.lowest_accel_mps2, self.highest_accel_mps2])
    }
}

fn gains([proportional_per_s, integral_per_s2]: [f64; 2], [min_accel_mps2, max_accel_mps2]: [f64; 2]) -> SpeedLoopSettings {
    SpeedLoopSettings { proportional_per_s, integral_per_s2, min_accel_mps2, max_accel_mps2 }
}
