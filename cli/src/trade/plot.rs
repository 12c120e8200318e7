//! Plots of the distance from the finest light against what it costs, as SVG.
//!
//! The SVG is written here and not by a plotting library, because every mark carries a `<title>`, which browsers show
//! as a tooltip, and the libraries at hand (plotters, charming) draw anonymous shapes or need scripts.

use std::fmt::Write;

use flb_eval::trade::{Row, front};

/// What a plot shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Against {
    /// The error on the mesh against seconds; the others, the distance from the finest light.
    Mesh,
    Seconds,
    Bytes,
    Memory,
}

impl Against {
    pub(super) const ALL: [Against; 4] = [Against::Mesh, Against::Seconds, Against::Bytes, Against::Memory];

    /// Part of the file's name.
    pub(super) fn name(self) -> &'static str {
        match self {
            Against::Mesh => "mesh",
            Against::Seconds => "seconds",
            Against::Bytes => "bytes",
            Against::Memory => "memory",
        }
    }

    /// Along the axis.
    pub(super) fn title(self) -> &'static str {
        match self {
            Against::Mesh | Against::Seconds => "seconds of a bake",
            Against::Bytes => "file, MB",
            Against::Memory => "peak memory, MB",
        }
    }

    /// Along y, in %; `None` where it is not known.
    fn off(self, row: &Row) -> Option<f64> {
        match self {
            Against::Mesh => row.mesh.as_ref().map(|mesh| mesh.rms_percent),
            _ => Some(row.finest_percent),
        }
    }

    /// What that is.
    fn off_title(self) -> &'static str {
        match self {
            Against::Mesh => "rms error on the mesh",
            _ => "distance from the finest light",
        }
    }

    fn of(self, row: &Row) -> f64 {
        match self {
            Against::Mesh | Against::Seconds => row.seconds,
            Against::Bytes => row.bytes as f64 / 1e6,
            Against::Memory => row.peak_bytes as f64 / 1e6,
        }
    }
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 470.0;
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [64.0, 40.0, 150.0, 48.0];
/// Height of the strip below the axis for rows without any distance, which a logarithm has no place for.
const ZERO_STRIP: f64 = 26.0;
/// Half the size of a mark.
const MARK: f64 = 5.0;

/// How the front is drawn.
const FRONT_STROKE: &str = "fill=\"none\" stroke=\"#222222\" stroke-dasharray=\"4 3\"";

/// Colours that the colour-blind tell apart (Okabe and Ito, 2008; the last of Tol's), by what makes the light.
const COLORS: [(&str, &str); 10] = [
    ("paper", "#e69f00"),
    ("lattice18", "#d55e00"),
    ("sh1", "#56b4e9"),
    ("sh2", "#7f7f7f"),
    ("sh3", "#f0e442"),
    ("sh1s", "#0072b2"),
    ("sh2s", "#009e73"),
    ("sh3s", "#cc79a7"),
    ("ico12", "#000000"),
    ("ico42", "#882255"),
];

fn color(row: &Row) -> (&'static str, &'static str) {
    let name = row.suns.as_deref().unwrap_or(row.model);
    COLORS.into_iter().find(|(of, _)| *of == name).unwrap_or(("other", "#999999"))
}

/// A logarithmic axis from data to pixels.
struct Axis {
    low: f64,
    high: f64,
    pixels: [f64; 2],
}

impl Axis {
    /// With some room around the values, which are above 0.
    fn around(values: impl Iterator<Item = f64>, pixels: [f64; 2]) -> Axis {
        let logs = values.filter(|value| *value > 0.0).map(libm::log10);
        let [low, high] =
            logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b]: [f64; 2], v: f64| [a.min(v), b.max(v)]);
        if low > high {
            return Axis { low: -1.0, high: 1.0, pixels };
        }
        let room = (0.05 * (high - low)).max(0.04);
        Axis { low: low - room, high: high + room, pixels }
    }

    fn place(&self, value: f64) -> f64 {
        let share = (libm::log10(value) - self.low) / (self.high - self.low);
        self.pixels[0] + share * (self.pixels[1] - self.pixels[0])
    }

    /// 1, 2 and 5 of every decade; where there are many, 1 only, and within a part of one, all of its steps.
    fn ticks(&self) -> Vec<f64> {
        let decades = libm::floor(self.low) as i32..=libm::ceil(self.high) as i32;
        let steps: &[f64] = match self.high - self.low {
            wide if wide > 3.0 => &[1.0],
            narrow if narrow < 0.7 => &[1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
            _ => &[1.0, 2.0, 5.0],
        };
        let all = decades.flat_map(|d| steps.iter().map(move |step| step * libm::exp10(f64::from(d))));
        all.filter(|tick| (self.low..=self.high).contains(&libm::log10(*tick))).collect()
    }
}

/// A tick's number, short.
fn number(value: f64) -> String {
    let digits = (-libm::floor(libm::log10(value) + 1e-9)).max(0.0) as usize;
    format!("{value:.digits$}")
}

/// Text as XML has it.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// One plot, complete in itself.
pub(super) fn plot(rows: &[Row], against: Against, subject: &str) -> String {
    let [left, top, right, bottom] = MARGIN;
    let floor = HEIGHT - bottom;
    let known: Vec<(&Row, f64)> = rows.iter().filter_map(|row| Some((row, against.off(row)?))).collect();
    let x = Axis::around(known.iter().map(|(row, _)| against.of(row)), [left, WIDTH - right]);
    let y = Axis::around(known.iter().map(|(_, off)| *off), [floor - ZERO_STRIP, top]);
    let place = |(row, off): &(&Row, f64)| {
        let height = if *off > 0.0 { y.place(*off) } else { floor - ZERO_STRIP / 2.0 };
        [x.place(against.of(row)), height]
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
         font-family=\"sans-serif\" font-size=\"12\">\n<rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#ffffff\"/>\n"
    );
    let title = format!("{subject}: {} against {}", against.off_title(), against.title());
    text(&mut svg, [left, 22.0], "start", &title);
    grid(&mut svg, &x, &y, against);
    front_line(&mut svg, &known, against, &place);
    // Rows of the front last, so that they lie on top.
    for on_front in [false, true] {
        for one @ (row, _) in known.iter().filter(|(row, _)| row.pareto == on_front) {
            mark(&mut svg, place(one), row.lattice, color(row).1, on_front, &tooltip(row));
        }
    }
    legend(&mut svg, rows);
    svg + "</svg>\n"
}

fn text(svg: &mut String, [x, y]: [f64; 2], anchor: &str, words: &str) {
    let words = escape(words);
    let _ = writeln!(
        svg,
        "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"#222222\">{words}</text>"
    );
}

fn line(svg: &mut String, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], color: &str) {
    let _ = writeln!(
        svg,
        "<line x1=\"{x1:.1}\" y1=\"{y1:.1}\" x2=\"{x2:.1}\" y2=\"{y2:.1}\" stroke=\"{color}\"/>"
    );
}

/// Ticks, their numbers and the axes' names.
fn grid(svg: &mut String, x: &Axis, y: &Axis, against: Against) {
    let ([left, right], [floor, top]) = (x.pixels, [HEIGHT - MARGIN[3], MARGIN[1]]);
    for tick in x.ticks() {
        let at = x.place(tick);
        line(svg, [at, top], [at, floor], "#e5e5e5");
        text(svg, [at, floor + 16.0], "middle", &number(tick));
    }
    for tick in y.ticks() {
        let at = y.place(tick);
        line(svg, [left, at], [right, at], "#e5e5e5");
        text(svg, [left - 6.0, at + 4.0], "end", &number(tick));
    }
    line(svg, [left, y.pixels[0]], [right, y.pixels[0]], "#bbbbbb");
    text(svg, [left - 6.0, floor - ZERO_STRIP / 2.0 + 4.0], "end", "0");
    line(svg, [left, floor], [right, floor], "#555555");
    line(svg, [left, floor], [left, top], "#555555");
    text(svg, [(left + right) / 2.0, HEIGHT - 12.0], "middle", against.title());
    let middle = (floor + top) / 2.0;
    let _ = writeln!(
        svg,
        "<text transform=\"translate(16 {middle:.1}) rotate(-90)\" text-anchor=\"middle\" fill=\"#222222\">{}, %</text>",
        against.off_title()
    );
}

/// The front of this plot alone, as stairs: what of all rows has no other that is cheaper and nearer.
fn front_line(
    svg: &mut String,
    rows: &[(&Row, f64)],
    against: Against,
    place: &dyn Fn(&(&Row, f64)) -> [f64; 2],
) {
    let points: Vec<[f64; 2]> = rows.iter().map(|(row, off)| [against.of(row), *off]).collect();
    let mut stairs: Vec<[f64; 2]> =
        rows.iter().zip(front(&points)).filter(|(_, on)| *on).map(|(row, _)| place(row)).collect();
    stairs.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut path = String::new();
    for (at, [x, y]) in stairs.iter().enumerate() {
        let _ = match at {
            0 => write!(path, "M{x:.1} {y:.1}"),
            _ => write!(path, "H{x:.1}V{y:.1}"),
        };
    }
    let _ = writeln!(svg, "<path d=\"{path}\" {FRONT_STROKE}/>");
}

/// What a browser shows over a mark.
fn tooltip(row: &Row) -> String {
    let truth = row
        .monte_carlo
        .map_or(String::new(), |found| format!(", {:.2} % from Monte Carlo", found.rms_percent));
    let mesh = row
        .mesh
        .as_ref()
        .map_or(String::new(), |mesh| format!("{:.1} % off on the mesh, ", mesh.rms_percent));
    format!(
        "{}: {}{}\n{mesh}{:.2} % from the finest{truth}\n{:.2} s, {} of memory, {} of file, {} fields{}",
        row.row,
        row.choice,
        if row.presets.is_empty() { String::new() } else { format!(" (preset {})", row.presets.join(", ")) },
        row.finest_percent,
        row.seconds,
        crate::print::bytes(row.peak_bytes),
        crate::print::bytes(row.bytes),
        row.fields,
        if row.pareto { "\non the Pareto front of all four" } else { "" }
    )
}

/// A shape by lattice; those on the front of all four columns are filled, with a dark edge.
fn mark(svg: &mut String, [x, y]: [f64; 2], lattice: u32, color: &str, on_front: bool, tooltip: &str) {
    let (fill, edge, wide) = if on_front { (color, "#000000", 1.4) } else { ("#ffffff", color, 1.4) };
    let style = format!("fill=\"{fill}\" stroke=\"{edge}\" stroke-width=\"{wide}\"");
    let title = escape(tooltip);
    let (r, s) = (MARK, MARK * 0.9);
    let shape = match lattice {
        32 => format!("circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{r}\""),
        64 => format!(
            "rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\"",
            x - s,
            y - s,
            2.0 * s,
            2.0 * s
        ),
        128 => polygon(x, y, &[[0.0, -1.2 * r], [1.1 * r, 0.8 * r], [-1.1 * r, 0.8 * r]]),
        256 => polygon(x, y, &[[0.0, -1.3 * r], [1.3 * r, 0.0], [0.0, 1.3 * r], [-1.3 * r, 0.0]]),
        _ => polygon(x, y, &[[0.0, 1.2 * r], [1.1 * r, -0.8 * r], [-1.1 * r, -0.8 * r]]),
    };
    let name = shape.split(' ').next().unwrap_or_default();
    let _ = writeln!(svg, "<{shape} {style}><title>{title}</title></{name}>");
}

fn polygon(x: f64, y: f64, corners: &[[f64; 2]]) -> String {
    let points: Vec<String> = corners.iter().map(|[dx, dy]| format!("{:.1},{:.1}", x + dx, y + dy)).collect();
    format!("polygon points=\"{}\"", points.join(" "))
}

/// Colours, shapes and the front's marks, of what there is.
fn legend(svg: &mut String, rows: &[Row]) {
    let x = WIDTH - MARGIN[2] + 18.0;
    let mut y = MARGIN[1] + 8.0;
    let mut entry = |svg: &mut String, lattice, color, on_front, words: &str| {
        mark(svg, [x, y], lattice, color, on_front, words);
        text(svg, [x + 12.0, y + 4.0], "start", words);
        y += 20.0;
    };
    for (name, of) in COLORS.iter().filter(|(name, _)| rows.iter().any(|row| color(row).0 == *name)) {
        entry(svg, 32, of, false, name);
    }
    let mut lattices: Vec<u32> = rows.iter().map(|row| row.lattice).collect();
    lattices.sort_unstable();
    lattices.dedup();
    for lattice in lattices {
        entry(svg, lattice, "#666666", false, &format!("lattice {lattice}"));
    }
    entry(svg, 32, "#666666", true, "Pareto front of");
    text(svg, [x + 12.0, y + 0.0], "start", "all four columns");
    let _ = writeln!(svg, "<path d=\"M{:.1} {:.1}h14\" {FRONT_STROKE}/>", x - 7.0, y + 20.0);
    text(svg, [x + 12.0, y + 24.0], "start", "front of this plot");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_logarithmic_axis_puts_decades_evenly() {
        let axis = Axis { low: 0.0, high: 2.0, pixels: [100.0, 300.0] };
        assert_eq!([1.0, 10.0, 100.0].map(|value| axis.place(value)), [100.0, 200.0, 300.0]);
        assert_eq!(axis.ticks(), [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0]);
        assert_eq!([0.05, 0.5, 1.0, 20.0].map(number), ["0.05", "0.5", "1", "20"]);
        // 32 to 38 %, as errors on a mesh are.
        let narrow = Axis::around([32.0, 38.0].into_iter(), [0.0, 100.0]);
        assert_eq!(narrow.ticks(), [30.0, 35.0, 40.0]);
    }

    #[test]
    fn names_cannot_break_the_markup() {
        let svg = plot(&[], Against::Bytes, "<b>&\"oak\"");
        assert!(svg.contains("&lt;b&gt;&amp;&quot;oak&quot;") && !svg.contains("<b>"), "{svg}");
    }
}
