//! An error of toml about a part of a text, shown as toml shows it for the whole text: toml itself can show it for no
//! text but the one that it has read.

use std::ops::Range;

/// Line and column, the line, a mark below it, and the message. Columns count characters, from 1; behind the text's end
/// they count on from its last character.
pub(super) fn shown(text: &str, span: Range<usize>, message: &str) -> String {
    let last = text.len().saturating_sub(1);
    let within = text.floor_char_boundary(span.start.min(last));
    let start = text[..within].rfind('\n').map_or(0, |end| end + 1);
    let line = 1 + text[..start].bytes().filter(|byte| *byte == b'\n').count();
    let content = text[start..].split('\n').next().unwrap_or_default();
    let column = text[start..within].chars().count() + span.start.saturating_sub(last);
    let marks = (span.end - span.start).min(content.len().saturating_sub(column)).max(1);
    let gutter = " ".repeat(line.to_string().len() + 1);
    format!(
        "TOML parse error at line {line}, column {}\n{gutter}|\n{line} | {content}\n{gutter}| {}{}\n{message}\n",
        column + 1,
        " ".repeat(column),
        "^".repeat(marks)
    )
}
