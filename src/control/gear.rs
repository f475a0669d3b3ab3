//! The gear that a map or a sample belongs to.

use core::fmt;

/// Direction of travel that the drive is set to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "snake_case"))]
pub enum Gear {
    /// Positive wheel speed; at +90° the vehicle turns left.
    Forward,
    /// Negative wheel speed; at +90° the vehicle turns right.
    Reverse,
}

impl Gear {
    /// Both gears, forward first.
    pub const ALL: [Self; 2] = [Self::Forward, Self::Reverse];

    /// +1 or −1: what turns a quantity of the gear's frame into one of the vehicle's frame, and back.
    pub fn sign(self) -> f64 {
        match self {
            Self::Forward => 1.0,
            Self::Reverse => -1.0,
        }
    }

    /// What stands between the table's name and `.csv`: nothing, or `.reverse`.
    pub fn file_infix(self) -> &'static str {
        match self {
            Self::Forward => "",
            Self::Reverse => ".reverse",
        }
    }
}

impl fmt::Display for Gear {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Forward => "forward",
            Self::Reverse => "reverse",
        })
    }
}
