//! The round trip A(v, T(v, a)) − a: what the grid of Table 2 costs.

use crate::invert::inverse::Inverse;
use crate::map::{CellStatus, GridPoint, RoundTripErrors, TorqueTable};

/// Dense points per interval of each axis.
const PER_INTERVAL: usize = 5;

/// Over the nodes and between them, wherever `measured` says that the torque was tested at the speed.
pub(crate) fn round_trip(
    inverse: &Inverse,
    table: &TorqueTable,
    status: &[Vec<CellStatus>],
    measured: impl Fn(f64, f64) -> bool,
) -> RoundTripErrors {
    let (speeds, accels) = (table.speed_mps().breaks(), table.accel_mps2().breaks());
    let mut nodes = MissTally::default();
    for (i, v) in speeds.iter().enumerate() {
        for (j, a) in accels.iter().enumerate() {
            if matches!(status[i][j], CellStatus::Measured | CellStatus::Interpolated) {
                nodes.add(inverse.accel_mps2(*v, table.at(i, j)) - a, *v, *a);
            }
        }
    }
    let mut between = MissTally::default();
    let inner = |breaks: &[f64]| -> Vec<f64> {
        breaks
            .windows(2)
            .flat_map(|w| (0..PER_INTERVAL).map(move |k| w[0] + (k as f64 + 0.5) / PER_INTERVAL as f64 * (w[1] - w[0])))
            .collect()
    };
    let inner_accels = inner(accels);
    for v in inner(speeds) {
        for a in &inner_accels {
            if measured(v, inverse.torque_nm(v, *a))
                && let Some(torque) = table.torque_from_accel(v, *a)
            {
                between.add(inverse.accel_mps2(v, torque) - a, v, *a);
            }
        }
    }
    RoundTripErrors {
        node_rms_mps2: nodes.rms(),
        node_max_mps2: round(nodes.largest),
        node_max_at: nodes.at,
        between_rms_mps2: between.rms(),
        between_max_mps2: round(between.largest),
        between_max_at: between.at,
    }
}

#[derive(Default)]
struct MissTally {
    square: f64,
    count: usize,
    largest: f64,
    at: GridPoint,
}

impl MissTally {
    fn add(&mut self, miss: f64, speed_mps: f64, accel_mps2: f64) {
        self.square += miss * miss;
        self.count += 1;
        if miss.abs() > self.largest {
            self.largest = miss.abs();
            self.at = GridPoint { speed_mps: round(speed_mps), accel_mps2: round(accel_mps2) };
        }
    }

    fn rms(&self) -> f64 {
        round((self.square / self.count.max(1) as f64).sqrt())
    }
}

fn round(value: f64) -> f64 {
    (value * 1e6).round() / 1e6
}
