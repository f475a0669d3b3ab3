//! Advice that only the command line can give: the flag that helps, beside what the library says is wrong.

use crate::calibrate::Error;
use crate::{export, fit, invert, log, report, verify};

/// The error with the command or the flag that helps.
pub(crate) fn with_advice(error: Error) -> anyhow::Error {
    match error {
        Error::WheelAngle { angle_deg, reason } => anyhow::anyhow!("--angle {angle_deg}: {reason}"),
        Error::EditedCsv { .. } => anyhow::anyhow!("{error}, or continue with --force"),
        Error::NoTable1 { source } => with_advice(*source).context("Table 1 is made by `pivot-cal fit LOG…`; --maps names its folder"),
        Error::About { what, source } => with_advice(*source).context(what),
        other => other.into(),
    }
}

/// The flag or the command that helps against an error of the library, as the end of its line. `None` if the message says all there is.
pub(crate) fn flag_for(error: &anyhow::Error) -> Option<String> {
    error.chain().find_map(|cause| match cause.downcast_ref::<Error>() {
        Some(Error::Log(cause)) => of_log(cause),
        Some(Error::Fit(cause)) => of_fit(cause),
        Some(Error::Invert(cause)) => of_invert(cause),
        Some(Error::Verify(cause)) => of_verify(cause),
        Some(_) => None,
        None => None
            .or_else(|| of_log(cause.downcast_ref()?))
            .or_else(|| of_fit(cause.downcast_ref()?))
            .or_else(|| of_invert(cause.downcast_ref()?))
            .or_else(|| of_verify(cause.downcast_ref()?))
            .or_else(|| of_maps(cause)),
    })
}

fn of_log(error: &log::Error) -> Option<String> {
    match error {
        log::Error::MissingSignal { .. } => Some("--signals names a signal map".to_owned()),
        // the signal map says that the unit is %
        log::Error::MissingVehicle { missing: "torque_full_scale_nm" } => None,
        log::Error::MissingVehicle { missing } => Some(gives(missing)),
        _ => None,
    }
}

fn of_fit(error: &fit::Error) -> Option<String> {
    match error {
        fit::Error::DifferentVehicles { field, .. } => Some(gives(field)),
        fit::Error::NoTestAngle { .. } => Some(gives("test_angle_deg")),
        _ => None,
    }
}

fn of_invert(error: &invert::Error) -> Option<String> {
    match error {
        invert::Error::NotSolved { .. } => Some("--node-exact chooses them".to_owned()),
        invert::Error::BadPlace { .. } => Some("--place gives their number".to_owned()),
        _ => None,
    }
}

fn of_verify(error: &verify::Error) -> Option<String> {
    match error {
        verify::Error::Hash { .. } => Some("`pivot-cal invert` does that, and --force continues without it".to_owned()),
        verify::Error::NoScenario { .. } => Some("`pivot-cal verify --list` shows all".to_owned()),
        _ => None,
    }
}

/// Of a folder without the map that is to be shown or exported.
fn of_maps(error: &(dyn std::error::Error + 'static)) -> Option<String> {
    if let Some(report::Error::NoTable1 { .. }) = error.downcast_ref() {
        return Some("Table 1 is made by `pivot-cal fit LOG…`, and --maps names its folder".to_owned());
    }
    matches!(error.downcast_ref(), Some(export::Error::Read { .. }))
        .then(|| "a map is made by `pivot-cal fit` and `pivot-cal invert`, and --maps names its folder".to_owned())
}

/// The flag of a vehicle's dimension.
fn gives(field: &str) -> String {
    format!("--{} gives it", field.replace('_', "-"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_of_the_library_ends_with_the_flag_that_helps() {
        let missing = || log::Error::MissingVehicle { missing: "wheelbase_m" };
        let about = Error::About { what: "a.mcap".to_owned(), source: Box::new(missing().into()) };
        for error in [missing().into(), with_advice(about), anyhow::Error::from(missing()).context("a.mcap")] {
            assert_eq!(flag_for(&error).as_deref(), Some("--wheelbase-m gives it"), "{error:#}");
        }
        let hash = verify::Error::Hash { path: "table2.csv".into(), by: "table2.json".into(), found: "0".into(), expected: "1".into() };
        assert!(flag_for(&hash.into()).is_some_and(|flag| flag.contains("--force")));
        assert_eq!(flag_for(&anyhow::anyhow!("another")), None);
    }

    #[test]
    fn each_error_names_its_flag_and_keeps_its_subject() {
        let text = |error: Error| format!("{:#}", with_advice(error));
        let about = |source: Error| Error::About { what: "maps/table1.json".to_owned(), source: Box::new(source) };
        let angle = Error::WheelAngle { angle_deg: 45.0, reason: "no run was driven there".to_owned() };
        assert_eq!(text(about(angle)), "maps/table1.json: --angle 45: no run was driven there");
        let edited = text(about(Error::EditedCsv { path: "table1.csv".into() }));
        assert!(
            edited.starts_with("maps/table1.json: table1.csv is not the file") && edited.ends_with("continue with --force"),
            "{edited}"
        );
        let missing = Error::NoTable1 { source: Box::new(about(std::io::Error::other("gone").into())) };
        assert!(text(missing).contains("--maps names its folder: maps/table1.json: gone"));
    }
}
