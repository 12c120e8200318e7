//! The word that an unknown one may have meant.

/// Least likeness of two words of which one may be meant by the other, 0 to 1.
const MIN_LIKENESS: f64 = 0.6;

/// The word that is most like another one, if any is like it.
pub(crate) fn nearest<'w>(found: &str, words: impl Iterator<Item = &'w str>) -> Option<&'w str> {
    let likeness = words.map(|word| (strsim::normalized_damerau_levenshtein(found, word), word));
    let most = likeness.max_by(|a, b| a.0.total_cmp(&b.0))?;
    (most.0 >= MIN_LIKENESS).then_some(most.1)
}

/// A message of the parser about an unknown key, with the key that is nearest to it in place of all that there are,
/// where one is near; any other message as it is.
pub(super) fn with_nearest(message: &str) -> String {
    let Some((before, list)) = message.split_once("unknown field `") else {
        return message.to_owned();
    };
    // "latice`, expected one of `lattice`, `voxels`"
    let mut words = list.split('`').step_by(2);
    let Some(found) = words.next() else { return message.to_owned() };
    match nearest(found, words) {
        Some(word) => format!("{before}unknown field `{found}`, did you mean `{word}`?"),
        None => message.to_owned(),
    }
}
