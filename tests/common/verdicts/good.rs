//! Good campaigns in five forms: the usual one, long, short, two logs, forward only.

use crate::verdicts::Fallible;
use crate::verdicts::campaign::{driven, from_rest, from_speed, usual};
use crate::verdicts::case::Case;

const FORMS: [&str; 5] = ["usual", "long", "short", "two logs", "forward only"];
const FIRST_SEED: u64 = 1001;

/// Seed of the k-th campaign.
pub(crate) fn seed(k: u64) -> u64 {
    FIRST_SEED + k
}

/// The k-th campaign of a vehicle, and its form.
///
/// # Errors
/// What the simulator refuses.
pub(crate) fn driven_form(vehicle: &str, k: u64) -> Fallible<(&'static str, Case)> {
    let mut case = Case::not_driven(vehicle, seed(k))?;
    let size = case.size;
    let form = FORMS[(k % FORMS.len() as u64) as usize];
    let forward = |repeats: u32| {
        from_rest(size, &[12.0, 16.0, 20.0, 24.0, 30.0, 36.0, 42.0], &format!("hold_s = 3.0\nrepeats = {repeats}\nshuffle = true"))
            + &from_speed(size, &[-20.0, -12.0, -6.0, 0.0, 6.0], "hold_s = 3.0")
    };
    let short = from_rest(size, &[12.0, 18.0, 26.0, 38.0], "hold_s = 3.0\nrepeats = 3")
        + &from_speed(size, &[-12.0, 0.0], "hold_s = 3.0")
        + &from_rest(size, &[14.0, 22.0, 36.0], "gear = \"reverse\"\nhold_s = 3.0\nrepeats = 3");
    let campaigns = match form {
        "long" => vec![usual(size) + &forward(2) + &usual(size)],
        "short" => vec![short],
        "two logs" => vec![usual(size), forward(2)],
        "forward only" => vec![forward(3)],
        _ => vec![usual(size)],
    };
    for (n, campaign) in campaigns.iter().enumerate() {
        case.logs.push(driven(&case.truth, campaign, seed(k) + 10_000 * n as u64)?);
    }
    Ok((form, case))
}
