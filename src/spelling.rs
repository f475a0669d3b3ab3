//! How far two words are apart, to name the nearest known one beside a misspelt one.

/// Characters to insert, delete or replace in one text to get the other (Levenshtein distance), without regard to case.
pub(crate) fn edits(a: &str, b: &str) -> usize {
    strsim::levenshtein(&a.to_lowercase(), &b.to_lowercase())
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
