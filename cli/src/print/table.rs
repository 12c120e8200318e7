//! Numbers and tables as people read them.

use flb_format::mesh::{ClassError, MeshError, SourceError};

use super::one_line;

/// How far light is off on a mesh, in the mean of the bands: "leaves 1.03 of the truth under the sky (24 % rms), ...".
pub(crate) fn mesh_error(error: &MeshError) -> String {
    let mean = |values: [f64; 3]| values.iter().sum::<f64>() / 3.0;
    let of_source = |source: &Option<SourceError>, under: &str| {
        source.as_ref().map(|SourceError { ratio, rms }| {
            format!("{:.2} under {under} ({:.0} % rms)", mean(*ratio), 100.0 * mean(*rms))
        })
    };
    let of_class = |class: &Option<ClassError>, name: &str| {
        let class = class.as_ref()?;
        let sources = [of_source(&class.sky, "the sky"), of_source(&class.suns, "suns")];
        let sources: Vec<String> = sources.into_iter().flatten().collect();
        (!sources.is_empty()).then(|| format!("{name} {}", sources.join(", ")))
    };
    let classes = [of_class(&error.leaf, "leaves"), of_class(&error.wood, "wood")];
    match classes.into_iter().flatten().collect::<Vec<_>>().join("; ") {
        text if text.is_empty() => "nothing that is lit".to_owned(),
        text => format!("light over truth: {text}"),
    }
}

/// Rows as columns: the first column left-aligned, the others right-aligned, two spaces between. A cell is one line.
pub(crate) fn table(rows: &[Vec<String>]) -> String {
    let rows: Vec<Vec<String>> =
        rows.iter().map(|row| row.iter().map(|cell| one_line(cell).into_owned()).collect()).collect();
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in &rows {
        let mut line = String::new();
        for (column, (cell, &width)) in row.iter().zip(&widths).enumerate() {
            let pad = " ".repeat(width - cell.chars().count());
            match column {
                0 => line += &format!("{cell}{pad}"),
                _ => line += &format!("  {pad}{cell}"),
            }
        }
        text += line.trim_end();
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = vec![vec!["a".into(), "10".into()], vec!["long".into(), "5".into()]];
        assert_eq!(table(&rows), "a     10\nlong   5\n");
    }

    #[test]
    fn a_cell_with_a_line_break_makes_no_row() {
        assert_eq!(table(&[vec!["a\nb  9".into(), "10".into()]]), "a\\nb  9  10\n");
    }
}
