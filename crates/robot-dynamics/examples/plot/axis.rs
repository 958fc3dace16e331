//! The range of an axis, and the round numbers on it.

/// How values are spaced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Axis {
    /// Evenly.
    Linear,
    /// By their powers of ten; values below 10⁻¹⁷ are at the bottom.
    Logarithmic,
}

/// From the lowest value to the highest.
pub(super) struct Span {
    axis: Axis,
    low: f64,
    high: f64,
}

/// The range of a vertical axis, over that of its values.
pub(super) const ROOM: f64 = 1.12;

/// The value that stands for zero on a logarithmic axis.
const FLOOR: f64 = 1e-17;

impl Span {
    /// The range of the values, without a margin.
    pub(super) fn exactly(values: impl Iterator<Item = f64>) -> Self {
        let (low, high) = extremes(values);
        Self { axis: Axis::Linear, low, high }
    }

    /// The range of the values with a margin; whole decades on a logarithmic axis.
    pub(super) fn around(values: impl Iterator<Item = f64>, axis: Axis) -> Self {
        let (low, high) = match axis {
            Axis::Linear => {
                let (low, high) = extremes(values);
                let room = 0.5 * (ROOM - 1.0) * (high - low);
                (low - room, high + room)
            }
            Axis::Logarithmic => {
                let (low, high) = extremes(values.map(|value| value.max(FLOOR).log10()));
                (low.floor(), high.ceil())
            }
        };
        Self { axis, low, high }
    }

    /// Where a value lies, 0 to 1.
    pub(super) fn share(&self, value: f64) -> f64 {
        let value = if self.axis == Axis::Linear { value } else { value.max(FLOOR).log10() };
        (value - self.low) / (self.high - self.low)
    }

    /// Up to some `most` round values, 1, 2 or 5 times a power of ten apart, with their labels.
    pub(super) fn ticks(&self, most: u32) -> Vec<(f64, String)> {
        let rough = (self.high - self.low) / f64::from(most);
        let power = 10f64.powf(rough.log10().floor());
        let wide = [1.0, 2.0, 5.0, 10.0].map(|k| k * power).into_iter().find(|&step| step >= rough);
        let mut step = wide.unwrap_or(10.0 * power);
        if self.axis == Axis::Logarithmic {
            step = step.max(1.0).round();
        }
        // As many decimals as bring the step to 1.
        let shifted = std::iter::successors(Some(step), |shifted| Some(10.0 * shifted));
        let decimals = shifted.take(18).take_while(|&shifted| shifted < 0.999).count();
        let (first, last) = ((self.low / step - 1e-9).ceil(), self.high / step + 1e-9);
        let tick = |k: f64| {
            let value = k * step;
            match self.axis {
                Axis::Linear => (value, format!("{value:.decimals$}").replace('-', "−")),
                Axis::Logarithmic => (10f64.powf(value), format!("10{}", superscript(value))),
            }
        };
        (0..2 * most).map(|k| first + f64::from(k)).take_while(|&k| k <= last).map(tick).collect()
    }
}

/// The lowest and the highest; never the same.
fn extremes(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low < high {
        (low, high)
    } else if low == high {
        (low - 0.5, high + 0.5)
    } else {
        (0.0, 1.0)
    }
}

/// A whole number, raised.
fn superscript(number: f64) -> String {
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        other => other.to_digit(10).and_then(|digit| char::from_u32(0x2070 + digit)).unwrap_or(other),
    };
    format!("{number:.0}").chars().map(raised).collect()
}
