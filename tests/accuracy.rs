//! A short run of the Monte Carlo study (`examples/study.rs`): five minutes of each vehicle, two seeds. Every ratio is taken within a trial,
//! so that an easy or a hard campaign touches both sides, and each gate is at least 1.3 times looser than what was measured.

#![allow(clippy::unwrap_used, clippy::print_stdout)] // a test says what it measured

#[path = "common/study/trial.rs"]
mod trial;

use trial::{Kind, Outcome};

/// Gates of one vehicle.
struct Gates {
    /// Most of the floor √(CRB² + table²).
    over_floor: f64,
    /// Least of bins over ours, and of the better differentiation over ours.
    bins: f64,
    differentiation: f64,
    /// Widest interval, relative to the bound's.
    width: f64,
}

fn judge(kind: Kind, gates: &Gates) {
    let outcomes: Vec<Outcome> = (1..=2)
        .map(|seed| {
            let outcome = trial::run(kind, 5.0, seed).unwrap();
            println!("{kind:?}, seed {seed}: {outcome}");
            outcome
        })
        .collect();
    // geometric means of the paired ratios
    let mean = |of: &dyn Fn(&Outcome) -> f64| (outcomes.iter().map(|o| of(o).ln()).sum::<f64>() / outcomes.len() as f64).exp();
    let over_floor = mean(&|o| o.pivot_cal_nm / o.floor_nm());
    let bins = mean(&|o| o.bins_nm / o.pivot_cal_nm);
    let differentiation = mean(&|o| o.local_quadratic_nm.min(o.savitzky_golay_nm) / o.pivot_cal_nm);
    let width = mean(&|o| o.width_ratio);
    println!("{over_floor:.2} × the floor; bins {bins:.1} ×, differentiation {differentiation:.1} ×; intervals {width:.2} ×");
    assert!(over_floor < gates.over_floor);
    assert!(bins > gates.bins && differentiation > gates.differentiation);
    assert!(width < gates.width);
    // nominal is 0.95; one campaign's errors go together, so that a few per cent less happen by chance
    assert!(mean(&|o| o.coverage) > 0.88);
}

#[test]
fn where_physics_holds_five_minutes_come_near_the_bound() {
    // measured: 0.73, 35.7, 7.8, 0.99
    judge(Kind::Physics, &Gates { over_floor: 1.2, bins: 25.0, differentiation: 4.5, width: 1.35 });
}

#[test]
fn where_physics_is_wrong_the_surface_follows() {
    // measured: 2.44, 9.0, 3.7, 2.61
    judge(Kind::Wrong, &Gates { over_floor: 3.4, bins: 6.5, differentiation: 2.5, width: 3.4 });
}
