//! The page of a comparison, for people: no scripts, no network.

use std::fmt::Write;

use super::pictures::FACTOR;
use super::report::{Comparison, SpeciesComparison, State, percent};
use crate::page::{STYLE, escaped, link};

/// Pictures of a species on the page: their names and size.
pub(super) struct Shown {
    pub names: [String; 3],
    pub size: [u32; 2],
}

/// The page; `shown` has an entry for each species.
pub(super) fn html(found: &Comparison, shown: &[Option<Shown>]) -> String {
    let title = format!("{} -&gt; {}", escaped(&found.old), escaped(&found.new));
    let verdict = match (found.fail_above, found.passes) {
        (None, _) => "",
        (Some(_), true) => "Passed: ",
        (Some(_), false) => "<b class=\"bad\">Failed:</b> ",
    };
    let mut page = format!(
        "<!doctype html>\n<html lang=\"en\">\n<meta charset=\"utf-8\">\n<title>{title}</title>\n<style>\n{STYLE}</style>\n\
         <h1>{title}</h1>\n<p>{verdict}{}.</p>\n",
        escaped(&found.summary())
    );
    changed(&mut page, found, shown);
    for (state, heading) in
        [(State::Removed, "Removed"), (State::Added, "Added"), (State::Unchanged, "Unchanged")]
    {
        let named = found.species.iter().filter(|one| one.state == state);
        let names: Vec<String> = named.map(|one| format!("<li>{}\n", escaped(&one.name))).collect();
        if !names.is_empty() {
            let _ = write!(page, "<h2>{heading}</h2>\n<ul>\n{}</ul>\n", names.concat());
        }
    }
    page
}

fn changed(page: &mut String, found: &Comparison, shown: &[Option<Shown>]) {
    if found.count.changed == 0 {
        return;
    }
    let _ = write!(
        page,
        "<h2>Changed</h2>\n<p>Differences are shares of the mean light before. The third picture is the difference of \
         the pixels, times {FACTOR}.</p>\n<table>\n\
         <tr><th>species<th>rms<th>99th percentile<th>mean<th>before<th>after<th>difference x {FACTOR}<th>more\n"
    );
    for (one, shown) in found.species.iter().zip(shown) {
        if one.state == State::Changed {
            row(page, one, shown.as_ref());
        }
    }
    page.push_str("</table>\n");
}

fn row(page: &mut String, one: &SpeciesComparison, shown: Option<&Shown>) {
    let class = if one.failure.is_some() { " class=\"bad\"" } else { "" };
    let figures = one.light.as_ref().map_or_else(
        || "<td>-<td>-<td>-".to_owned(),
        |light| format!("<td>{}<td>{}<td>{}", percent(light.rms), percent(light.p99), percent(light.mean)),
    );
    let _ = write!(page, "<tr><td{class}>{}{figures}", escaped(&one.name));
    match shown {
        Some(Shown { names, size: [width, height] }) => {
            for (name, what) in names.iter().zip(["before", "after", "difference"]) {
                let (name, label) = (link(name), escaped(&one.name));
                let _ = write!(
                    page,
                    "<td><img src=\"{name}\" width=\"{width}\" height=\"{height}\" alt=\"{label}, {what}\">"
                );
            }
        }
        None => page.push_str("<td>-<td>-<td>-"),
    }
    let _ = writeln!(page, "<td class=\"text\">{}", escaped(&one.told()));
}
