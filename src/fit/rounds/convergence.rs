//! The length of a round's steps, and the distance left.

/// Movement of the surface below which it has converged [m/s², root mean square].
pub(crate) const STILL_MPS2: f64 = 2e-4;
/// Step of a delay below which it has converged, as a share of its standard error.
const STILL_DELAY: f64 = 0.1;
/// Least share of a step of a delay that is made.
const LEAST_DAMPED: f64 = 0.2;

/// A step of a delay [s].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct DelayStep {
    /// As the equations asked for it.
    pub(crate) asked_s: f64,
    /// As it was made.
    pub(crate) made_s: f64,
}

impl DelayStep {
    /// The step that is made when the equations give `asked_s`, after the last step.
    ///
    /// The equations hold the look-up speeds fixed, but these follow the delays, and more so for a smaller disturbance. In the limit
    /// each step overshoots by as much as the equations gave. The secant of the last two steps then gives the length, never more than
    /// asked.
    pub(crate) fn damped(asked_s: f64, last: Option<&Self>) -> Self {
        let secant = last.map(|last| last.made_s / (last.asked_s - asked_s));
        let share = secant.filter(|share| share.is_finite() && *share > 0.0).map_or(1.0, |share| share.clamp(LEAST_DAMPED, 1.0));
        Self { asked_s, made_s: asked_s * share }
    }
}

/// Distance left of a linearly convergent iteration: the sum of all later steps if each shrinks by the factor of the last two.
fn to_come(before: f64, last: f64) -> f64 {
    let factor = last / before.max(1e-300);
    if factor < 1.0 { last * factor / (1.0 - factor) } else { f64::INFINITY }
}

/// Movements of a round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Moved {
    /// The surface [m/s², root mean square].
    pub(crate) surface_mps2: f64,
    /// The delays: the largest step over its standard error.
    pub(crate) delays: f64,
}

/// Whether the rounds have converged: the last movement is small, or the distance left is.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Convergence {
    last: Option<Moved>,
}

impl Convergence {
    /// Whether they have converged after a round with this movement.
    pub(crate) fn reached(&mut self, moved: Moved) -> bool {
        let small = |now: f64, before: Option<f64>, still: f64| now < still || before.is_some_and(|before| to_come(before, now) < still);
        let surface = small(moved.surface_mps2, self.last.map(|l| l.surface_mps2), STILL_MPS2);
        let delays = small(moved.delays, self.last.map(|l| l.delays), STILL_DELAY);
        self.last = Some(moved);
        surface && delays
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance from the solution after some rounds that each request (1 + `overshoot`) times the distance.
    fn left(overshoot: f64, rounds: usize) -> f64 {
        let (mut x, mut last) = (1.0, None);
        for _ in 0..rounds {
            let step = DelayStep::damped(-(1.0 + overshoot) * x, last.as_ref());
            x += step.made_s;
            last = Some(step);
        }
        x
    }

    #[test]
    fn steps_that_overshoot_find_the_answer_and_others_are_made_as_asked() {
        // undamped, the second would never end and the third would diverge
        for overshoot in [0.3, 1.0, 1.6] {
            assert!(left(overshoot, 4).abs() < 1e-9, "{overshoot}: {}", left(overshoot, 4));
        }
        assert!((left(-0.5, 4) - 0.5f64.powi(4)).abs() < 1e-12);
    }

    #[test]
    fn what_is_to_come_is_the_sum_of_shrinking_steps() {
        assert!((to_come(0.4, 0.2) - 0.2).abs() < 1e-12);
        assert!(to_come(0.2, 0.2).is_infinite());
    }
}
