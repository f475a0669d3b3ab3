//! How far two words are apart, to name the nearest known one beside a misspelt one.

/// Edits (insert, delete, replace a character) that turn one text into the other, without regard to case.
///
/// Source: V. I. Levenshtein, "Binary codes capable of correcting deletions, insertions and reversals", 1966.
pub(crate) fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, from) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, to) in b.iter().enumerate() {
            let replace = diagonal + usize::from(from != *to);
            diagonal = row[j + 1];
            row[j + 1] = replace.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// The candidate fewest edits away from `found`, if at most half of its letters differ.
pub(crate) fn nearest<'a>(found: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    candidates
        .map(|candidate| (edits(found, candidate), candidate))
        .filter(|&(distance, candidate)| 2 * distance <= candidate.len().max(found.len()))
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_word_is_the_one_with_the_fewest_edits() {
        assert_eq!(edits("kitten", "Sitting"), 3);
        assert_eq!(nearest("wheelbse_m", ["wheelbase_m", "wheel_radius_m"].into_iter()), Some("wheelbase_m"));
        assert_eq!(nearest("mass", ["wheelbase_m", "wheel_radius_m"].into_iter()), None);
    }
}
