//! A pair of axes, each linear or logarithmic.

use crate::canvas::{Canvas, GREY, Hold, INK, LIGHT};
use crate::records::Trouble;

/// From numbers to pixels along one axis.
#[derive(Clone, Copy)]
pub(crate) struct Axis {
    pub(crate) numbers: [f64; 2],
    pub(crate) pixels: [f64; 2],
    pub(crate) is_logarithmic: bool,
}

impl Axis {
    pub(crate) fn at(&self, x: f64) -> f64 {
        let map = |x: f64| if self.is_logarithmic { x.ln() } else { x };
        let [low, high] = self.numbers.map(map);
        let [from, to] = self.pixels;
        from + (to - from) * (map(x) - low) / (high - low)
    }
}

/// 1, 2 and 5 of every decade between the ends.
pub(crate) fn decades([low, high]: [f64; 2]) -> Vec<f64> {
    let mut ticks = Vec::new();
    let mut decade = 10_f64.powf(low.log10().floor());
    while decade <= high {
        ticks.extend([1.0, 2.0, 5.0].map(|k| k * decade).into_iter().filter(|&x| low <= x && x <= high));
        decade *= 10.0;
    }
    ticks
}

/// A number without trailing zeros, with spaces between thousands.
pub(crate) fn shown(x: f64) -> String {
    if x < 1000.0 {
        let text = format!("{x:.3}");
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    let digits = format!("{x:.0}");
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push('\u{a0}');
        }
        text.push(digit);
    }
    text
}

/// Axes with their ticks and titles.
pub(crate) struct Panel<'a> {
    pub(crate) title: &'a str,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
    pub(crate) x_title: &'a str,
    pub(crate) y_title: &'a str,
    pub(crate) x_ticks: Vec<(f64, String)>,
    pub(crate) y_ticks: Vec<(f64, String)>,
}

/// Ticks labelled with their values.
pub(crate) fn labelled(ticks: &[f64]) -> Vec<(f64, String)> {
    ticks.iter().map(|&x| (x, shown(x))).collect()
}

impl Panel<'_> {
    pub(crate) fn at(&self, x: f64, y: f64) -> (f64, f64) {
        (self.x.at(x), self.y.at(y))
    }

    pub(crate) fn draw(&self, canvas: &Canvas<'_>) -> Result<(), Trouble> {
        let ([left, right], [bottom, top]) = (self.x.pixels, self.y.pixels);
        for (x, label) in &self.x_ticks {
            let x = self.x.at(*x);
            canvas.line(&[(x, bottom), (x, top)], LIGHT, 1)?;
            canvas.text(label, (x, bottom + 16.0), Hold::Center, 15, INK)?;
        }
        for (y, label) in &self.y_ticks {
            let y = self.y.at(*y);
            canvas.line(&[(left, y), (right, y)], LIGHT, 1)?;
            canvas.text(label, (left - 9.0, y), Hold::Right, 15, INK)?;
        }
        canvas.line(&[(left, top), (left, bottom), (right, bottom)], GREY, 1)?;
        canvas.text(self.title, (left, top - 24.0), Hold::Left, 19, INK)?;
        canvas.text(self.x_title, (f64::midpoint(left, right), bottom + 42.0), Hold::Center, 16, INK)?;
        if !self.y_title.is_empty() {
            canvas.upright(self.y_title, (left - 72.0, f64::midpoint(top, bottom)), 16)?;
        }
        Ok(())
    }
}

/// Heights of labels, moved apart so that none overlap; in the given order.
pub(crate) fn apart(heights: &[f64], least: f64) -> Vec<f64> {
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|&i, &j| heights[i].total_cmp(&heights[j]));
    let mut placed = heights.to_vec();
    // Overlapping pairs move away from their middle until none is left.
    for _ in 0..200 {
        for pair in order.windows(2) {
            let gap = placed[pair[1]] - placed[pair[0]];
            if gap < least {
                let push = (least - gap) / 2.0;
                placed[pair[0]] -= push;
                placed[pair[1]] += push;
            }
        }
    }
    placed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_axis_maps_its_ends_to_its_ends() {
        let axis = Axis { numbers: [4.0, 256.0], pixels: [100.0, 500.0], is_logarithmic: true };
        assert!((axis.at(4.0) - 100.0).abs() < 1e-9 && (axis.at(256.0) - 500.0).abs() < 1e-9);
        assert!((axis.at(32.0) - 300.0).abs() < 1e-9);
    }

    #[test]
    fn ticks_and_labels_are_readable() {
        assert_eq!(decades([40.0, 1100.0]), [50.0, 100.0, 200.0, 500.0, 1000.0]);
        assert_eq!([0.5, 20.0, 12000.0].map(shown), ["0.5", "20", "12\u{a0}000"]);
    }

    #[test]
    fn labels_are_moved_apart_in_their_order() {
        let placed = apart(&[10.0, 12.0, 100.0], 16.0);
        assert!(
            (placed[1] - placed[0] - 16.0).abs() < 1e-6 && (placed[2] - 100.0).abs() < 1e-9,
            "{placed:?}"
        );
    }
}
