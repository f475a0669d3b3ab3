//! `[lateral]`: a route of straights and bends with the mounting errors that the lateral compensation has to cancel.

use crate::control::Accumulation;
use crate::guidance::route::clothoid_path::ClothoidPiece;
use crate::guidance::route::tracking::LawName;
use crate::map::{Gear, toml_line};
use crate::scene::ranges::{check, ranged};
use crate::scene::{Error, Result};
use serde::{Deserialize, Serialize};

/// `[[lateral.piece]]`: curvature changes linearly along it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PieceKeys {
    /// Length [m].
    length_m: f64,
    /// Curvature at its start [1/m], left positive; 0 is straight.
    #[serde(default)]
    from_per_m: f64,
    /// Curvature at its end [1/m]; that of its start if it is left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    to_per_m: Option<f64>,
}

/// `[lateral]`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct RouteKeys {
    piece: Vec<PieceKeys>,
    /// Direction of travel.
    #[serde(default)]
    direction: RouteDirection,
    /// Tracking law; that of the calibration.
    #[serde(default = "law")]
    law: LawName,
    /// Navigation's heading minus the vehicle's [°].
    #[serde(default = "yaw")]
    yaw_deg: f64,
    /// True wheel angle minus reported wheel angle [°]; if it is left out, 0.8 against the yaw error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    steering_zero_deg: Option<f64>,
    /// Distance on which the compensation is estimated, from the start [m]; it is judged on the rest.
    #[serde(default = "learning")]
    learning_m: f64,
    /// Distance over which the error is averaged [m].
    #[serde(default = "averaging")]
    averaging_m: f64,
}

/// Direction of travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum RouteDirection {
    /// Forward.
    #[default]
    Forward,
    /// In reverse.
    Reverse,
}

fn law() -> LawName {
    LawName::Lqr
}
fn yaw() -> f64 {
    1.0
}
fn learning() -> f64 {
    50.0
}
fn averaging() -> f64 {
    5.0
}

/// End of every route that is not judged, for the stop [m].
pub(crate) const STOP_M: f64 = 1.0;
/// Least length that is judged [m].
const LEAST_JUDGED_M: f64 = 5.0;
/// Largest step of the curvature between pieces [1/m]: about a degree of the wheel.
const STEP_PER_M: f64 = 0.02;

impl RouteKeys {
    /// Checks every number, and that the pieces are a route.
    pub(crate) fn checked(&self, text: &str) -> Result<()> {
        let zero_deg = self.steering_zero_deg.unwrap_or(0.0);
        let numbers = [
            ranged("yaw_deg", self.yaw_deg, -5.0, 5.0),
            ranged("steering_zero_deg", zero_deg, -5.0, 5.0),
            ranged("learning_m", self.learning_m, 1.0, 1000.0),
            ranged("averaging_m", self.averaging_m, 0.5, 100.0),
        ];
        check(text, ("lateral", 0), &numbers)?;
        let mut before_per_m = 0.0;
        for (nth, piece) in self.piece.iter().enumerate() {
            let to_per_m = piece.to_per_m.unwrap_or(piece.from_per_m);
            let numbers = [
                ranged("length_m", piece.length_m, 0.05, 1000.0),
                ranged("from_per_m", piece.from_per_m, -2.0, 2.0),
                ranged("to_per_m", to_per_m, -2.0, 2.0),
            ];
            check(text, ("lateral.piece", nth), &numbers)?;
            if (piece.from_per_m - before_per_m).abs() > STEP_PER_M {
                let (line, key) = (toml_line(text, ("lateral.piece", nth), "from_per_m"), format!("lateral.piece {}", nth + 1));
                let problem = format!(
                    "the curvature jumps from {before_per_m} to {} 1/m where it begins; allowed: a step of {STEP_PER_M} 1/m: put a piece \
                     before it whose curvature goes from one to the other",
                    piece.from_per_m
                );
                return Err(Error::Shape { line, key, problem });
            }
            before_per_m = to_per_m;
        }
        let (length_m, least_m) = (self.length_m(), self.learning_m + LEAST_JUDGED_M + STOP_M);
        if length_m < least_m {
            return Err(Error::Shape {
                line: toml_line(text, ("lateral", 0), "learning_m").or_else(|| toml_line(text, ("lateral.piece", 0), "length_m")),
                key: "lateral.piece".to_owned(),
                problem: format!(
                    "the pieces are {length_m} m long together; allowed: at least {least_m} m, learning_m ({} m), {LEAST_JUDGED_M} m that are \
                     judged and {STOP_M} m for the stop: add pieces or shorten learning_m",
                    self.learning_m
                ),
            });
        }
        Ok(())
    }

    /// The piece with the largest curvature, from 1, and that curvature [1/m].
    pub(crate) fn tightest(&self) -> (usize, f64) {
        let curvatures = self.piece.iter().map(|p| p.from_per_m.abs().max(p.to_per_m.unwrap_or(0.0).abs()));
        curvatures.enumerate().fold((1, 0.0), |most, (k, per_m)| if per_m > most.1 { (k + 1, per_m) } else { most })
    }

    /// Length of the route [m].
    fn length_m(&self) -> f64 {
        self.piece.iter().map(|piece| piece.length_m).sum()
    }

    /// The pieces.
    pub(crate) fn pieces(&self) -> Vec<ClothoidPiece> {
        let turned = |piece: ClothoidPiece| if self.direction == RouteDirection::Reverse { piece.reversed() } else { piece };
        let piece = |p: &PieceKeys| turned(ClothoidPiece::bend(p.length_m, p.from_per_m, p.to_per_m.unwrap_or(p.from_per_m)));
        self.piece.iter().map(piece).collect()
    }

    /// Direction of travel.
    pub(crate) fn gear(&self) -> Gear {
        match self.direction {
            RouteDirection::Forward => Gear::Forward,
            RouteDirection::Reverse => Gear::Reverse,
        }
    }

    /// Tracking law.
    pub(crate) fn law(&self) -> LawName {
        self.law
    }

    /// The mounting errors: yaw and steering zero [°].
    pub(crate) fn mounting_deg(&self) -> [f64; 2] {
        [self.yaw_deg, self.steering_zero_deg.unwrap_or(-self.gear().sign() * 0.8)]
    }

    /// The distances on which the compensation is estimated, and on which it is judged [m].
    pub(crate) fn stretches_m(&self) -> [f64; 2] {
        [self.learning_m, self.length_m() - self.learning_m - STOP_M]
    }

    /// Averaging of the run-time law.
    pub(crate) fn accumulation(&self) -> Accumulation {
        Accumulation::Distance(self.averaging_m)
    }
}
