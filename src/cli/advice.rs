//! Advice that only the command line can give: the flag that helps, beside what the library says is wrong.

use crate::calibrate::Error;

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

#[cfg(test)]
mod tests {
    use super::*;

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
