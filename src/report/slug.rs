//! A name from a file as a part of a file name.

/// Longest name that stays as it is.
const LONGEST: usize = 60;

/// `name` as a part of a file name: letters, digits and hyphens of ASCII. A name that has to change ends with `number`, so that it differs
/// from that of another picture.
pub(crate) fn slug(name: &str, number: usize) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || matches!(c, '-' | '_');
    if !name.is_empty() && name.len() <= LONGEST && name.chars().all(plain) {
        return name.to_owned();
    }
    let words = name.split(|c: char| !c.is_ascii_alphanumeric()).filter(|word| !word.is_empty());
    let kept: String = words.flat_map(|word| [word, "-"]).flat_map(str::chars).take(LONGEST).collect();
    format!("{}-{number}", kept.trim_end_matches('-')).trim_start_matches('-').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_name_stays_and_another_one_cannot_leave_its_folder() {
        assert_eq!(slug("parking-slanted", 1), "parking-slanted");
        assert_eq!(slug("../../etc/passwd", 2), "etc-passwd-2");
        assert_eq!(slug("C:\\new\0line\n", 3), "C-new-line-3");
        assert_eq!(slug("…", 4), "4");
        assert_eq!(slug("", 5), "5");
        let long = slug(&"x".repeat(500), 6);
        assert!(long.len() <= LONGEST + 2 && long.ends_with("x-6"), "{long}");
    }
}
