//! Changes of a vehicle file's text.

/// A vehicle file with lines replaced, or added below a heading.
pub(crate) fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    let mut text = text.to_owned();
    for (heading, lines) in changes {
        for line in lines.lines() {
            let key = line.split(" = ").next().unwrap_or(line);
            let at = text.find(heading).map_or(0, |k| k + heading.len() + 1);
            let end = text[at..].find("\n[").map_or(text.len(), |k| at + k);
            let kept: Vec<&str> = text[at..end].lines().filter(|l| !l.starts_with(&format!("{key} "))).collect();
            text = format!("{}{line}\n{}\n{}", &text[..at], kept.join("\n"), &text[end..]);
        }
    }
    text
}
