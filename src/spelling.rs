//! Edit distance of two words, to suggest the nearest known word for a misspelt one.

/// Levenshtein distance: number of characters to insert, delete or replace in one text to get the other, ignoring case.
pub(crate) fn edits(a: &str, b: &str) -> usize {
    strsim::levenshtein(&a.to_lowercase(), &b.to_lowercase())
}

/// The candidate with the smallest distance from `found`, if at most half of its letters differ.
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
