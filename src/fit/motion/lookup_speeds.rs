//! Speeds along a segment at which the surface is looked up.
//!
//! On the way to a reading the surface is looked up from where the readings so far have put the speed to where they and the surface let it be
//! expected, never to where the reading itself puts it then: what a reading predicts may depend on earlier ones only (Ljung, *System
//! Identification*). A look-up that leans towards the reading holds a part of the very innovation that it is to explain, in proportion to
//! how steeply the surface changes with speed. That is little at each reading and the same at all of them: in an hour of a campaign whose
//! surface bends it tilted the surface by twice the standard error.

/// Speeds along a segment, one of each per reading [m/s].
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Speeds {
    /// As expected when the reading comes.
    pub(crate) before: Vec<f64>,
    /// As told by the reading as well.
    pub(crate) after: Vec<f64>,
}

impl Speeds {
    /// Goes half the way only from `last`.
    pub(crate) fn go_half_way_from(&mut self, last: &Self) {
        for (now, last) in [(&mut self.before, &last.before), (&mut self.after, &last.after)] {
            now.iter_mut().zip(last).for_each(|(now, last)| *now = 0.5 * (*now + last));
        }
    }
}

impl From<Vec<f64>> for Speeds {
    /// Speeds that are known whatever is read.
    fn from(known: Vec<f64>) -> Self {
        Self { before: known.clone(), after: known }
    }
}
