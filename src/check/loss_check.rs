//! What the logs have lost → a check: a map of half a campaign is not the map of the campaign.

use crate::map::{Check, CheckOutcome, LogLoss, LogRef};

/// Lost share of a log above which it is a warning, and an objection [%]. A recorder that is switched off loses its last second, a bad
/// sector a chunk; a log that lacks a tenth is not the campaign that was driven.
const LOST_PERCENT: [f64; 2] = [0.0, 10.0];

/// The log that has lost most. `None` when nothing is lost.
pub(crate) fn loss_check(logs: &[LogRef]) -> Option<Check> {
    let lost = |log: &'_ LogRef| log.loss.as_ref().map(|loss| 100.0 * loss.share(log.bytes));
    let damaged = logs.iter().filter(|log| log.loss.is_some()).count();
    let (percent, log) = logs.iter().filter_map(|log| Some((lost(log)?, log))).max_by(|a, b| a.0.total_cmp(&b.0))?;
    let what = log.loss.as_ref().map(LogLoss::to_string).unwrap_or_default();
    let (outcome, limit) = CheckOutcome::graded(percent, LOST_PERCENT);
    // damage that hits no message is damage
    let outcome = outcome.max(CheckOutcome::Warning);
    let meaning = format!("{damaged} of {} logs are damaged; {} has lost {percent:.1} %: {what}", logs.len(), log.file);
    let advice = "record them again, or recover them with `mcap recover`; `inspect --runs` lists the places";
    Some(Check::passed("log-damage", (percent, limit, "%"), meaning).broken(outcome, advice))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn log(file: &str, lost: Option<u64>) -> LogRef {
        let loss =
            lost.map(|lost| LogLoss { messages: Some(lost), unreadable_messages: 0, places: 1, bytes: 7, messages_read: 1000 - lost });
        LogRef { sha256: String::new(), file: file.to_owned(), bytes: 1 << 20, loss }
    }

    #[test]
    fn any_damage_is_a_warning_and_a_lost_tenth_an_objection() {
        assert_eq!(loss_check(&[log("a", None)]), None);
        let outcome = |lost| loss_check(&[log("a", None), log("b", Some(lost))]).map(|check| check.outcome);
        assert_eq!(outcome(0), Some(CheckOutcome::Warning));
        assert_eq!(outcome(100), Some(CheckOutcome::Warning));
        assert_eq!(outcome(101), Some(CheckOutcome::Objection));
    }

    #[test]
    fn the_worst_log_is_named() {
        let text = loss_check(&[log("a", Some(1)), log("b", Some(20))]).map(|check| check.text()).unwrap_or_default();
        assert!(text.starts_with("2 of 2 logs are damaged; b has lost 2.0 %: 20 messages lost in 1 damaged places (7 bytes)"), "{text}");
    }
}
