//! The number of starts of a grid that end parked.

use crate::guidance::parking::stage::ParkingStage;
use crate::guidance::parking::start::ParkingStart;
use crate::guidance::parking::{ParkingScene, plan};

/// Counts over a grid of starts: the usable ones, and those of them that end parked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Success {
    /// Starts that do not touch anything.
    pub tried: usize,
    /// Starts from which a path was found that passes every check.
    pub parked: usize,
    /// Of these, the ones that went straight in.
    pub direct: usize,
    /// Of these, the ones that had to shuffle.
    pub shuffled: usize,
}

impl Success {
    /// Share of the usable starts [0 to 1]; 0 if there are none.
    pub(crate) fn share(&self) -> f64 {
        if self.tried == 0 { 0.0 } else { self.parked as f64 / self.tried as f64 }
    }
}

/// Plans from every start and counts. Starts that already touch something are skipped.
pub(crate) fn success(scene: &ParkingScene, starts: &[ParkingStart]) -> Success {
    let mut count = Success::default();
    for start in starts {
        let body = scene.body.at(start.x_m, start.y_m, start.heading_rad);
        if scene.obstacles().iter().any(|o| o.separation_m(&body) <= 0.0) {
            continue;
        }
        count.tried += 1;
        if let Ok(plan) = plan(scene, *start) {
            count.parked += 1;
            count.direct += usize::from(plan.stages.iter().all(|s| s.stage == ParkingStage::Enter));
            count.shuffled += usize::from(plan.stages.iter().any(|s| s.stage == ParkingStage::Shuffle));
        }
    }
    count
}
