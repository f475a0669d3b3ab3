//! What can drive the pivots of a verdict: the bundled controller with any drive law, or a process of the user's.

use crate::control::{DriveLaw, Inputs, Outputs, Phase, PivotController, PivotRequest, PivotSettings, Pose};
use crate::verify::Result;

/// From the settings of a run to its controller.
pub(crate) trait PivotLaw {
    /// The controller.
    type Controller: PivotControl;

    /// A controller at rest.
    ///
    /// # Errors
    /// Settings that it refuses; a process that cannot be started.
    fn controller(self, settings: &PivotSettings) -> Result<Self::Controller>;
}

/// A controller of pivots, one step per control period.
pub(crate) trait PivotControl {
    /// Requests a turn [rad], left positive, from a pose.
    ///
    /// # Errors
    /// A turn that cannot be planned.
    fn request(&mut self, turn_rad: f64, pose: Pose) -> Result<()>;

    /// The phase after the last step or request.
    fn phase(&self) -> Phase;

    /// The request in force, or the last one; `None` before the first.
    fn current(&self) -> Option<&PivotRequest>;

    /// The commands for the period that begins at `t_s` [s].
    fn step(&mut self, t_s: f64, inputs: &Inputs) -> Outputs;

    /// Why it no longer controls, with the time and what it said; `None` while it does.
    fn fault(&self) -> Option<&str> {
        None
    }
}

impl<L: DriveLaw> PivotLaw for L {
    type Controller = PivotController<L>;

    fn controller(self, settings: &PivotSettings) -> Result<PivotController<L>> {
        Ok(PivotController::new(settings, self)?)
    }
}

impl<L: DriveLaw> PivotControl for PivotController<L> {
    fn request(&mut self, turn_rad: f64, pose: Pose) -> Result<()> {
        Ok(Self::request(self, turn_rad, pose)?)
    }

    fn phase(&self) -> Phase {
        Self::phase(self)
    }

    fn current(&self) -> Option<&PivotRequest> {
        Self::current(self)
    }

    fn step(&mut self, _: f64, inputs: &Inputs) -> Outputs {
        Self::step(self, inputs)
    }
}
