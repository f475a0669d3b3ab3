//! Speeds along a segment at which the surface is looked up.
//!
//! On the way to a reading, the surface is looked up from the filtered speed at the reading before to the expected speed at this one, never
//! to the filtered one there: the prediction of a reading may depend on earlier readings only (Ljung, *System Identification*). A look-up
//! that leans towards the reading holds a part of the innovation that it must explain, in proportion to the slope of the surface along
//! speed. The effect is small and the same at every reading: in an hour of a campaign whose surface bends it tilted the surface by twice
//! the standard error.

/// Speeds along a segment, one of each per reading [m/s].
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Speeds {
    /// Expected before the reading.
    pub(crate) before: Vec<f64>,
    /// Filtered, with the reading.
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
    /// Speeds that are known whatever the readings are.
    fn from(known: Vec<f64>) -> Self {
        Self { before: known.clone(), after: known }
    }
}
