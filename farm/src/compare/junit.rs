//! The verdict as JUnit XML, which build servers read: a test case for each species.

use std::fmt::Write;

use super::report::Comparison;
use crate::page::escaped;

/// The file.
pub(super) fn xml(found: &Comparison) -> String {
    let (tests, failures) = (found.species.len(), found.count.failed);
    let name = text(&format!("{} -> {}", found.old, found.new));
    let head = format!("tests=\"{tests}\" failures=\"{failures}\" errors=\"0\"");
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites {head}>\n<testsuite name=\"flb library diff: {name}\" {head}>\n"
    );
    let mut species: Vec<_> = found.species.iter().collect();
    species.sort_by(|one, other| one.name.cmp(&other.name));
    for one in species {
        let (name, told) = (text(&one.name), text(&one.told()));
        let _ = write!(out, "<testcase classname=\"species\" name=\"{name}\">");
        if let Some(failure) = &one.failure {
            let _ = write!(out, "<failure message=\"{}\">{told}</failure>", text(failure));
        } else {
            let _ = write!(out, "<system-out>{told}</system-out>");
        }
        out.push_str("</testcase>\n");
    }
    out + "</testsuite>\n</testsuites>\n"
}

/// Text that XML 1.0 takes: what it has no letters for is replaced.
fn text(text: &str) -> String {
    let is_known = |c: char| matches!(c, ' '..='\u{fffd}' | '\u{10000}'..);
    escaped(&text.chars().map(|c| if is_known(c) { c } else { '\u{fffd}' }).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_any_letters_is_xml() {
        assert_eq!(text("a<b> & \"c\""), "a&lt;b&gt; &amp; &quot;c&quot;");
        assert_eq!(text("a\0b\n\u{ffff}\u{1f33f}"), "a\u{fffd}b\u{fffd}\u{fffd}\u{1f33f}");
    }
}
