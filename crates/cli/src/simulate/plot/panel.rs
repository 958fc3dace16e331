//! One panel: lines over time with a legend.

use plotters::chart::{ChartBuilder, ChartContext};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{AsRangedCoord, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::{
    Cartesian2d, DrawingArea, DrawingAreaErrorKind, DrawingBackend, IntoLogRange, LineSeries, PathElement,
    Text,
};
use plotters::style::{Color, RGBColor, ShapeStyle};
use robot_dynamics::text::one_line;

use crate::table::short;

/// Lines over time.
pub(super) struct Panel {
    pub name: String,
    pub axis: Axis,
    pub lines: Vec<Line>,
    pub times: Vec<f64>,
    /// Whether values far above the others may be clipped.
    pub diverged: bool,
}

/// One value for each time.
pub(super) struct Line {
    pub name: String,
    pub values: Vec<f64>,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Axis {
    Linear,
    Logarithmic,
}

/// Whether the edges of a line form one path. A bitmap draws each edge alone, since the joints of a path
/// stick out at sharp turns. In SVG the viewer draws joints correctly, and one path is shorter.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Corners {
    Joined,
    Open,
}

type DrawingResult<B> = Result<(), DrawingAreaErrorKind<<B as DrawingBackend>::ErrorType>>;

/// Ten colours that most people can distinguish, also in print. Further lines repeat them with dashes.
const COLOURS: [RGBColor; 10] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(60, 60, 60),
    RGBColor(150, 80, 30),
    RGBColor(120, 60, 190),
    RGBColor(130, 150, 20),
];

/// Dash and gap in pixels for each group of ten lines; the first group is solid.
const DASHES: [(u32, u32); 5] = [(0, 0), (10, 4), (3, 3), (18, 6), (6, 10)];

const LEGEND_WIDTH: u32 = 260;
const LEGEND_ROW: u32 = 17;

/// Smallest relative error on a logarithmic axis; below it are rounding and zero.
const FLOOR: f64 = 1e-17;

impl Panel {
    /// The usual height, or more if the legend needs it.
    pub(super) fn height(&self, usual: u32) -> u32 {
        let rows = u32::try_from(self.lines.len()).unwrap_or(u32::MAX / LEGEND_ROW / 2);
        usual.max(rows * LEGEND_ROW + 60)
    }

    pub(super) fn draw<B: DrawingBackend>(
        &self,
        area: &DrawingArea<B, Shift>,
        corners: Corners,
    ) -> DrawingResult<B> {
        let (width, _) = area.dim_in_pixel();
        let (chart, legend) = area.split_horizontally(width - LEGEND_WIDTH);
        self.draw_legend(&legend)?;
        let mut builder = ChartBuilder::on(&chart);
        builder.caption(&self.name, ("sans-serif", 16));
        builder.margin(8).x_label_area_size(40).y_label_area_size(80);
        let end = self.times.last().copied().filter(|&end| end > 0.0).unwrap_or(1.0);
        let (low, high) = self.range();
        match self.axis {
            Axis::Linear => {
                let mut chart = builder.build_cartesian_2d(0.0..end, low..high)?;
                self.draw_lines(&mut chart, (low, high), corners, &|y| short_or_zero(*y, high - low))
            }
            Axis::Logarithmic => {
                let mut chart = builder.build_cartesian_2d(0.0..end, (low..high).log_scale())?;
                self.draw_lines(&mut chart, (low, high), corners, &|y| format!("{y:.0e}"))
            }
        }
    }

    fn draw_lines<B: DrawingBackend, Y>(
        &self,
        chart: &mut ChartContext<'_, B, Cartesian2d<RangedCoordf64, Y>>,
        (low, high): (f64, f64),
        corners: Corners,
        label: &dyn Fn(&f64) -> String,
    ) -> DrawingResult<B>
    where
        Y: Ranged<ValueType = f64> + ValueFormatter<f64> + AsRangedCoord,
    {
        chart
            .configure_mesh()
            .max_light_lines(1)
            .light_line_style(RGBColor(240, 240, 240))
            .bold_line_style(RGBColor(215, 215, 215))
            .x_desc("t [s]")
            .y_labels(8)
            .y_label_formatter(label)
            .x_label_formatter(&|x| short_or_zero(*x, 1.0))
            .label_style(("sans-serif", 13))
            .axis_desc_style(("sans-serif", 14))
            .draw()?;
        let (pixels, _) = chart.plotting_area().dim_in_pixel();
        let second = f64::from(pixels) / self.times.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
        for (index, line) in self.lines.iter().enumerate() {
            let (style, (dash, gap)) = style(index);
            let points = self.times.iter().zip(&line.values).map(|(&t, &y)| match self.axis {
                // Zero has no logarithm and is drawn at the bottom.
                Axis::Logarithmic => (t, y.max(low)),
                Axis::Linear => (t, y),
            });
            let points: Vec<(f64, f64)> = points.collect();
            // Points outside the frame are not drawn. A stretch of one point is outside or has no
            // neighbour.
            let stretches = points.chunk_by(|a, b| [a, b].iter().all(|p| (low..=high).contains(&p.1)));
            for stretch in stretches.filter(|stretch| stretch.len() > 1) {
                for piece in dashed(stretch, f64::from(dash) / second, f64::from(gap) / second) {
                    match corners {
                        Corners::Joined => drop(chart.draw_series(LineSeries::new(piece, style))?),
                        Corners::Open => {
                            let edges = piece.windows(2).map(|edge| PathElement::new(edge.to_vec(), style));
                            chart.draw_series(edges)?;
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// The style and name of each line, one below the other.
    fn draw_legend<B: DrawingBackend>(&self, area: &DrawingArea<B, Shift>) -> DrawingResult<B> {
        for (index, line) in self.lines.iter().enumerate() {
            let y = 45 + i32::try_from(index).unwrap_or(0) * LEGEND_ROW.cast_signed();
            let (style, (dash, gap)) = style(index);
            // Strokes of `dash` pixels with gaps, as in the chart.
            let (start, end) = (4_i32, 40_i32);
            let (dash, gap) =
                if dash == 0 { (end - start, 1) } else { (dash.cast_signed(), gap.cast_signed()) };
            let mut x = start;
            while x < end {
                area.draw(&PathElement::new([(x, y), ((x + dash).min(end), y)], style))?;
                x += dash + gap;
            }
            area.draw(&Text::new(fitted(&one_line(&line.name)), (48, y - 7), ("sans-serif", 13)))?;
        }
        Ok(())
    }

    /// The range of the axis: all values, except for diverged motions, whose last values would hide the rest.
    fn range(&self) -> (f64, f64) {
        let values = || self.lines.iter().flat_map(|line| &line.values).copied().filter(|y| y.is_finite());
        if self.axis == Axis::Logarithmic {
            let least = values().filter(|&y| y > FLOOR).fold(f64::INFINITY, f64::min).clamp(FLOOR, 1e-12);
            let most = values().fold(least * 10.0, f64::max).min(1e12);
            // Whole decades.
            return (10f64.powf(least.log10().floor()), 10f64.powf(most.log10().ceil()));
        }
        // The largest absolute value at each time; nine tenths of them are below `usual`.
        let most_at = |i: usize| {
            self.lines
                .iter()
                .filter_map(|line| line.values.get(i))
                .fold(0.0, |most: f64, y| most.max(y.abs()))
        };
        let mut sizes: Vec<f64> = (0..self.times.len()).map(most_at).collect();
        sizes.sort_by(f64::total_cmp);
        let usual = sizes.get(sizes.len() * 9 / 10).copied().unwrap_or(0.0);
        let bound = if self.diverged { 3.0 * usual.max(1e-3) } else { f64::INFINITY };
        let (low, high) = values()
            .filter(|y| y.abs() <= bound)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| (low.min(y), high.max(y)));
        if low > high {
            return (-1.0, 1.0);
        }
        // A constant line is drawn in the middle.
        let is_flat = high - low <= 1e-9 * high.abs().max(1e-3);
        let margin = if is_flat { (0.05 * high.abs()).max(1.0) } else { 0.05 * (high - low) };
        (low - margin, high + margin)
    }
}

/// The style of line number `index`.
fn style(index: usize) -> (ShapeStyle, (u32, u32)) {
    let colour = COLOURS[index % COLOURS.len()];
    (colour.stroke_width(2), DASHES[index / COLOURS.len() % DASHES.len()])
}

/// The drawn pieces of a line: the whole line without a dash, else pieces of `dash` seconds with gaps.
fn dashed(points: &[(f64, f64)], dash: f64, gap: f64) -> Vec<Vec<(f64, f64)>> {
    if dash == 0.0 {
        return vec![points.to_vec()];
    }
    let period = dash + gap;
    let mut pieces = Vec::new();
    let mut piece = Vec::new();
    for edge in points.windows(2) {
        let ((t0, y0), (t1, y1)) = (edge[0], edge[1]);
        let at = |t: f64| (t, y0 + (y1 - y0) * (t - t0) / (t1 - t0));
        let mut t = t0;
        while t < t1 {
            let start = (t / period).floor() * period;
            let is_drawn = t - start < dash;
            // Rounding can put a boundary at t.
            let next = (start + if is_drawn { dash } else { period }).max(t + 1e-6 * period).min(t1);
            if is_drawn {
                if piece.is_empty() {
                    piece.push(at(t));
                }
                piece.push(at(next));
            } else if !piece.is_empty() {
                pieces.push(std::mem::take(&mut piece));
            }
            t = next;
        }
    }
    pieces.push(piece);
    pieces
}

/// The label of a tick. Values that are zero up to rounding become 0.
fn short_or_zero(x: f64, span: f64) -> String {
    if x.abs() < 1e-9 * span { "0".into() } else { short(x) }
}

/// A name that fits beside the chart; a longer one is shortened in the middle.
fn fitted(name: &str) -> String {
    const MOST: usize = 27;
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= MOST {
        return name.into();
    }
    let (head, tail) = (&letters[..MOST / 2], &letters[letters.len() - MOST / 2..]);
    format!("{}…{}", head.iter().collect::<String>(), tail.iter().collect::<String>())
}
