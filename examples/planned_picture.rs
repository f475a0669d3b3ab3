//! Draws parking or the U-turn of the bundled vehicle from above, planned and driven: `cargo run --example planned_picture -- parking > docs/parking.svg`,
//! and `u-turn` for docs/u_turn.svg.

#![allow(clippy::print_stdout)] // the picture is what this program is for

use pivot_cal::internals::{Manoeuvre, ManoeuvreKind, ManoeuvreSettings, known_maps, picture, replay_manoeuvre};
use pivot_cal::verify::{Maps, Metric};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_else(|| "parking".to_owned());
    let settings = ManoeuvreSettings::new()?;
    let (table1, table2) = known_maps(&settings.vehicle)?;
    let maps = Maps::new(table1, table2)?;
    let manoeuvre = Manoeuvre::all().into_iter().find(|m| m.name == name).ok_or("no such manoeuvre")?;
    let ManoeuvreKind::Planned(task) = &manoeuvre.kind else { return Err("not a planned manoeuvre".into()) };
    let mut driven = Vec::new();
    let values = replay_manoeuvre(&maps, &settings, &manoeuvre, |moment| driven.push((moment.state.x_m, moment.state.y_m)))?;
    let figure = |metric| values.get(metric).unwrap_or(f64::NAN);
    let title = format!(
        "{name}: planned (blue forward, orange reverse), driven (dashed); ends {:.0} mm and {:.2}° off, clearance {:.2} m",
        1e3 * figure(Metric::FinalPositionM),
        figure(Metric::HeadingErrorDeg),
        figure(Metric::ClearanceM)
    );
    let view = if name == "u-turn" { [-3.4, 1.0, -1.4, 6.7] } else { [-3.2, 4.2, -2.1, 4.4] };
    println!("{}", picture(&task.plan(settings.vehicle.vehicle.wheelbase_m)?, &driven, view, 760.0, &title));
    Ok(())
}
