//! Lines over an axis as SVG, for the examples: panels one below the other, names beside them.

mod axis;

use std::error::Error;
use std::fmt::Write as _;
use std::fs;
use std::path::PathBuf;

use axis::Span;

pub(crate) use axis::Axis;

/// A picture.
pub(crate) struct Figure {
    pub(crate) title: String,
    /// The label of the horizontal axes.
    pub(crate) across: String,
    pub(crate) panels: Vec<Panel>,
}

/// One diagram of it.
pub(crate) struct Panel {
    pub(crate) name: String,
    pub(crate) axis: Axis,
    pub(crate) lines: Vec<Line>,
    /// Values drawn as dashed lines across.
    pub(crate) limits: Vec<f64>,
}

/// A named line, interrupted where a number is not finite.
pub(crate) struct Line {
    pub(crate) name: String,
    pub(crate) points: Vec<(f64, f64)>,
}

/// Eight colours that most people can tell apart, also on paper.
const COLOURS: [&str; 8] =
    ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#3c3c3c", "#7839be"];

/// Pixels: the whole width, a diagram's frame, and the margins above and below it.
const WIDTH: f64 = 960.0;
const LEFT: f64 = 78.0;
const RIGHT: f64 = 790.0;
const HEIGHT: f64 = 220.0;
const ABOVE: f64 = 34.0;
const BELOW: f64 = 34.0;
const TITLE: f64 = 40.0;
/// A line drawn with more points would show no more.
const MOST_POINTS: usize = 500;

impl Line {
    pub(crate) fn new(name: impl Into<String>, points: Vec<(f64, f64)>) -> Self {
        Self { name: name.into(), points }
    }
}

impl Figure {
    /// Writes the picture to the file that the first argument names, else to `target/NAME.svg`, and says so.
    pub(crate) fn save(&self, name: &str) -> Result<(), Box<dyn Error>> {
        let path = std::env::args().nth(1).map_or(PathBuf::from(format!("target/{name}.svg")), PathBuf::from);
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        fs::write(&path, self.svg()).map_err(|error| format!("{}: {error}", path.display()))?;
        println!("plot                      {}", path.display());
        Ok(())
    }

    /// The pixels of a unit across over those of a unit up, in a panel whose values span `across` and `up`.
    pub(crate) fn aspect(across: f64, up: f64) -> f64 {
        (RIGHT - LEFT) / across / (HEIGHT / (up * axis::ROOM))
    }

    /// The picture as text.
    pub(crate) fn svg(&self) -> String {
        let each = ABOVE + HEIGHT + BELOW;
        let height = TITLE + each * self.panels.len() as f64 + 6.0;
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" width=\"{WIDTH}\" \
             height=\"{height}\" font-family=\"sans-serif\" font-size=\"13\" fill=\"#222\">\n\
             <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n"
        );
        text(&mut svg, (16.0, 27.0), "font-size=\"18\"", &self.title);
        for (i, panel) in self.panels.iter().enumerate() {
            panel.draw(&mut svg, TITLE + each * i as f64 + ABOVE, &self.across);
        }
        svg + "</svg>\n"
    }
}

impl Panel {
    /// Draws the panel, its frame's top at `top`.
    fn draw(&self, svg: &mut String, top: f64, across_name: &str) {
        let drawn: Vec<Vec<(f64, f64)>> =
            self.lines.iter().map(|line| thinned(&line.points, self.axis)).collect();
        let across = Span::exactly(self.lines.iter().flat_map(|line| &line.points).map(|point| point.0));
        let up = Span::around(
            drawn.iter().flatten().map(|point| point.1).chain(self.limits.iter().copied()),
            self.axis,
        );
        let bottom = top + HEIGHT;
        let x = |value: f64| LEFT + (RIGHT - LEFT) * across.share(value);
        let y = |value: f64| bottom - HEIGHT * up.share(value);
        text(svg, (LEFT, top - 9.0), "font-size=\"15\"", &self.name);
        for (value, label) in across.ticks(8) {
            rule(svg, (x(value), top), (x(value), bottom), "#e4e4e4", "");
            text(svg, (x(value), bottom + 16.0), "text-anchor=\"middle\"", &label);
        }
        for (value, label) in up.ticks(6) {
            rule(svg, (LEFT, y(value)), (RIGHT, y(value)), "#e4e4e4", "");
            text(svg, (LEFT - 7.0, y(value) + 4.5), "text-anchor=\"end\"", &label);
        }
        for &limit in &self.limits {
            rule(svg, (LEFT, y(limit)), (RIGHT, y(limit)), "#888", " stroke-dasharray=\"7 4\"");
        }
        let (width, colour) = (RIGHT - LEFT, "#999");
        let _ = writeln!(
            svg,
            "<rect x=\"{LEFT}\" y=\"{top}\" width=\"{width}\" height=\"{HEIGHT}\" fill=\"none\" stroke=\"{colour}\"/>"
        );
        text(svg, (RIGHT + 22.0, bottom + 16.0), "", across_name);
        for (i, (line, points)) in self.lines.iter().zip(&drawn).enumerate() {
            let colour = COLOURS[i % COLOURS.len()];
            let mut path = String::new();
            let mut pen = 'M';
            for point in points {
                if point.0.is_finite() && point.1.is_finite() {
                    let _ = write!(path, "{pen}{:.1},{:.1}", x(point.0), y(point.1));
                    pen = ' ';
                } else {
                    pen = 'M';
                }
            }
            let _ = writeln!(
                svg,
                "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.8\" \
                 stroke-linejoin=\"round\"/>"
            );
            let at = top + 9.0 + 19.0 * i as f64;
            let _ = writeln!(
                svg,
                "<path d=\"M{:.1},{at:.1} h22\" stroke=\"{colour}\" stroke-width=\"3\"/>",
                RIGHT + 12.0
            );
            text(svg, (RIGHT + 40.0, at + 4.5), "", &line.name);
        }
    }
}

/// About [`MOST_POINTS`] points: the lowest and the highest of each stretch, in their order. On a logarithmic
/// axis only the highest is kept, because an error passes through zero within a stretch.
fn thinned(points: &[(f64, f64)], axis: Axis) -> Vec<(f64, f64)> {
    let stretch = 2 * points.len() / MOST_POINTS;
    if stretch < 3 {
        return points.to_vec();
    }
    let ends = |point: Option<&(f64, f64)>| point.filter(|_| axis == Axis::Linear).copied();
    let mut kept = Vec::from_iter(ends(points.first()));
    for part in points.chunks(stretch) {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (Some(low), Some(high)) = (part.iter().min_by(by), part.iter().max_by(by)) else { continue };
        if axis == Axis::Logarithmic {
            kept.push(*high);
            continue;
        }
        kept.extend(if low.0 <= high.0 { [*low, *high] } else { [*high, *low] });
    }
    kept.extend(ends(points.last()));
    kept
}

fn text(svg: &mut String, (x, y): (f64, f64), style: &str, words: &str) {
    let words = words.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" {style}>{words}</text>");
}

fn rule(svg: &mut String, (x0, y0): (f64, f64), (x1, y1): (f64, f64), colour: &str, style: &str) {
    let _ = writeln!(svg, "<path d=\"M{x0:.1},{y0:.1} L{x1:.1},{y1:.1}\" stroke=\"{colour}\"{style}/>");
}
