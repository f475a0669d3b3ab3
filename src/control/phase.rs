//! The state machine of a pivot, with all its transitions.
//!
//! ```text
//!  Idle, Succeeded, Failed ──Requested──► WaitingForAngle ──AngleReached──► SettingGear ──GearSet──► Driving
//!  Driving ──EndReached──► WaitingForStandstill ──StoodStill──► RestoringAngle ──AngleRestored──► Succeeded
//!  WaitingForAngle … RestoringAngle ──Broken(reason)──► Failed(reason)
//! ```

use crate::messages::{Failure, Phase};

/// Event of the state machine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Planning requests a pivot.
    Requested,
    /// The wheel is at its angle.
    AngleReached,
    /// The drive reports the gear.
    GearSet,
    /// The end of the path is reached.
    EndReached,
    /// The front wheel rests.
    StoodStill,
    /// The wheel is at its return angle.
    AngleRestored,
    /// Something failed.
    Broken(Failure),
}

impl Phase {
    /// The phase after `event`; an event without a transition in this phase does not change it.
    #[must_use]
    pub fn after(self, event: Event) -> Self {
        match (self, event) {
            (Self::Idle | Self::Succeeded | Self::Failed(_), Event::Requested) => Self::WaitingForAngle,
            (Self::WaitingForAngle, Event::AngleReached) => Self::SettingGear,
            (Self::SettingGear, Event::GearSet) => Self::Driving,
            (Self::Driving, Event::EndReached) => Self::WaitingForStandstill,
            (Self::WaitingForStandstill, Event::StoodStill) => Self::RestoringAngle,
            (Self::RestoringAngle, Event::AngleRestored) => Self::Succeeded,
            (phase, Event::Broken(failure)) if phase.is_active() => Self::Failed(failure),
            (phase, _) => phase,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FAILED: Phase = Phase::Failed(Failure::ObstacleStop);
    const PHASES: [Phase; 8] = [
        Phase::Idle,
        Phase::WaitingForAngle,
        Phase::SettingGear,
        Phase::Driving,
        Phase::WaitingForStandstill,
        Phase::RestoringAngle,
        Phase::Succeeded,
        FAILED,
    ];

    /// Every phase that `event` changes, with the next phase.
    fn changes(event: Event) -> Vec<(Phase, Phase)> {
        PHASES.iter().map(|&p| (p, p.after(event))).filter(|(p, q)| p != q).collect()
    }

    #[test]
    fn a_request_starts_a_pivot_only_if_none_is_in_progress() {
        let next = Phase::WaitingForAngle;
        assert_eq!(changes(Event::Requested), [(Phase::Idle, next), (Phase::Succeeded, next), (FAILED, next)]);
    }

    #[test]
    fn after_the_wheel_is_at_its_angle_the_gear_is_set() {
        assert_eq!(changes(Event::AngleReached), [(Phase::WaitingForAngle, Phase::SettingGear)]);
    }

    #[test]
    fn after_the_gear_is_set_the_vehicle_drives() {
        assert_eq!(changes(Event::GearSet), [(Phase::SettingGear, Phase::Driving)]);
    }

    #[test]
    fn the_end_of_the_path_ends_the_driving() {
        assert_eq!(changes(Event::EndReached), [(Phase::Driving, Phase::WaitingForStandstill)]);
    }

    #[test]
    fn a_resting_wheel_is_returned() {
        assert_eq!(changes(Event::StoodStill), [(Phase::WaitingForStandstill, Phase::RestoringAngle)]);
    }

    #[test]
    fn the_wheel_back_at_its_return_angle_is_success() {
        assert_eq!(changes(Event::AngleRestored), [(Phase::RestoringAngle, Phase::Succeeded)]);
    }

    #[test]
    fn a_failure_ends_every_phase_in_progress_and_no_other() {
        let broken = Event::Broken(Failure::TimeOut);
        let after = Phase::Failed(Failure::TimeOut);
        let active: Vec<_> = PHASES.iter().filter(|p| p.is_active()).map(|&p| (p, after)).collect();
        assert_eq!(changes(broken), active);
        assert_eq!(active.len(), 5);
    }
}
