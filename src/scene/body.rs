//! `[body]`: the outline of the vehicle, around the wheelbase of the vehicle that drives.

use crate::guidance::BodyShape;
use crate::scene::Result;
use crate::scene::ranges::{check, ranged};
use serde::{Deserialize, Serialize};

/// The outline. A length that is left out is that of the usual outline for the vehicle's wheelbase.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub(crate) struct BodyKeys {
    /// Width [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    width_m: Option<f64>,
    /// Length before the front wheel's centre [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    front_overhang_m: Option<f64>,
    /// Length behind the rear axle [m].
    #[serde(skip_serializing_if = "Option::is_none")]
    rear_overhang_m: Option<f64>,
}

impl BodyKeys {
    /// Checks every length.
    pub(crate) fn checked(&self, text: &str) -> Result<()> {
        let all = [
            ("width_m", self.width_m, 0.1),
            ("front_overhang_m", self.front_overhang_m, 0.0),
            ("rear_overhang_m", self.rear_overhang_m, 0.0),
        ];
        let given: Vec<_> = all.into_iter().filter_map(|(key, value, low)| Some(ranged(key, value?, low, 5.0))).collect();
        check(text, ("body", 0), &given)
    }

    /// The outline for a wheelbase [m].
    pub(crate) fn shape(&self, wheelbase_m: f64) -> BodyShape {
        let usual = BodyShape::usual(wheelbase_m);
        BodyShape {
            wheelbase_m,
            width_m: self.width_m.unwrap_or(usual.width_m),
            front_overhang_m: self.front_overhang_m.unwrap_or(usual.front_overhang_m),
            rear_overhang_m: self.rear_overhang_m.unwrap_or(usual.rear_overhang_m),
        }
    }
}
