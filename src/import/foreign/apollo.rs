//! Apollo's calibration table: protobuf text of `calibration { speed: … acceleration: … command: … }`, alone or inside a control
//! configuration. Command is per cent of throttle when positive, of brake when negative.

use crate::import::foreign::{CommandPoint, CommandPoints, Misread, MisreadKind};

/// Reads every `calibration { … }` message, at any depth; other messages are skipped.
pub(crate) fn points_of_apollo(text: &str) -> (CommandPoints, Vec<Misread>) {
    let (mut points, mut misread) = (CommandPoints { command: "command".to_owned(), ..CommandPoints::default() }, Vec::new());
    let mut bad = |kind, line, what: String| misread.push(Misread { kind, line, column: 0, what });
    let tokens = tokens(text);
    let mut at = 0;
    while at < tokens.len() {
        let opens = tokens[at].1 == "calibration" && tokens[at + 1..].iter().find(|t| t.1 != ":").is_some_and(|t| t.1 == "{");
        if !opens {
            at += 1;
            continue;
        }
        let line = tokens[at].0;
        at += 1 + tokens[at + 1..].iter().position(|t| t.1 == "{").unwrap_or(0) + 1;
        let mut fields = [None; 3];
        let mut closed = false;
        while let Some(&(line, token)) = tokens.get(at) {
            at += 1;
            match token {
                "}" => {
                    closed = true;
                    break;
                }
                "calibration" | "{" => {
                    at -= 1;
                    break;
                }
                "speed" | "acceleration" | "command" => {
                    let slot = ["speed", "acceleration", "command"].iter().position(|n| *n == token).unwrap_or(0);
                    let value = tokens.get(at).filter(|t| t.1 == ":").and_then(|_| tokens.get(at + 1));
                    match value.map(|t| t.1.parse::<f64>()) {
                        Some(Ok(number)) if number.is_finite() => fields[slot] = Some(number),
                        _ => bad(MisreadKind::NotANumber, line, format!("{token} is {:?}, not a finite number", value.map_or("", |t| t.1))),
                    }
                    at += usize::from(value.is_some()) * 2;
                }
                _ => {}
            }
        }
        match fields {
            [Some(speed), Some(accel), Some(command)] if closed => points.points.push(CommandPoint { line, speed, accel, command }),
            _ if closed => bad(MisreadKind::Malformed, line, "an entry needs speed, acceleration and command".to_owned()),
            _ => bad(MisreadKind::Malformed, line, "the entry is not closed by }".to_owned()),
        }
    }
    if points.points.is_empty() {
        bad(MisreadKind::TooSmall, 1, "no calibration entry that can be read".to_owned());
    }
    (points, misread)
}

/// Words, numbers and the signs `{`, `}`, `:` with their lines; comments from `#` to the end of the line are skipped.
fn tokens(text: &str) -> Vec<(u64, &str)> {
    let mut tokens = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let line = line.split('#').next().unwrap_or_default();
        let mut rest = line;
        while let Some(start) = rest.find(|c: char| !(c.is_whitespace() || c == ',' || c == ';')) {
            rest = &rest[start..];
            let signs = |c: char| matches!(c, '{' | '}' | ':');
            let end = if rest.starts_with(signs) {
                1
            } else {
                rest.find(|c: char| c.is_whitespace() || c == ',' || c == ';' || signs(c)).unwrap_or(rest.len())
            };
            tokens.push((k as u64 + 1, &rest[..end]));
            rest = &rest[end..];
        }
    }
    tokens
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn entries_are_found_inside_other_messages_and_on_one_line() {
        let text = "lon {\n calibration_table { # default\n  calibration { speed: 0 acceleration: -1.5e0 command:-35 }\n calibration: {\nspeed: 1\nacceleration: 0.5\ncommand: 20\n}\n}}";
        let (points, misread) = points_of_apollo(text);
        assert!(misread.is_empty(), "{misread:?}");
        assert_eq!(
            points.points.iter().map(|p| (p.line, p.speed, p.accel, p.command)).collect::<Vec<_>>(),
            [(3, 0.0, -1.5, -35.0), (4, 1.0, 0.5, 20.0)]
        );
    }

    #[test]
    fn a_broken_entry_is_reported_and_the_others_are_read() {
        let text = "calibration { speed: x acceleration: 1 command: 2 }\ncalibration { speed: 1 acceleration: 1 }\ncalibration { speed: 1 acceleration: 2 command: 3 }\ncalibration { speed: 2";
        let (points, misread) = points_of_apollo(text);
        assert_eq!(points.points.len(), 1);
        let kinds: Vec<_> = misread.iter().map(|m| (m.kind, m.line)).collect();
        assert_eq!(
            kinds,
            [(MisreadKind::NotANumber, 1), (MisreadKind::Malformed, 1), (MisreadKind::Malformed, 2), (MisreadKind::Malformed, 4)]
        );
    }
}
