//! Logarithmic barriers of intervals.

/// An interval with finite or infinite ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interval {
    lower: f64,
    upper: f64,
}

impl Interval {
    pub(super) fn new([lower, upper]: [f64; 2]) -> Self {
        Self { lower, upper }
    }

    pub(super) fn symmetric(limit: f64) -> Self {
        Self { lower: -limit, upper: limit }
    }

    /// The length to which distances refer: half of the interval, or 1.
    fn scale(self) -> f64 {
        let half = 0.5 * (self.upper - self.lower);
        if half.is_finite() && half > 0.0 { half } else { 1.0 }
    }

    /// The interval that is smaller by a part of its half at each end.
    pub(super) fn shrunk(self, margin: f64) -> Self {
        let by = margin * self.scale();
        Self { lower: self.lower + by, upper: self.upper - by }
    }

    /// Its middle, or the point nearest to 0.
    pub(super) fn middle(self) -> f64 {
        let middle = 0.5 * (self.lower + self.upper);
        if middle.is_finite() { middle } else { 0.0_f64.clamp(self.lower + 1.0, self.upper - 1.0) }
    }

    /// The distance from the middle over half of the interval: 1 at the limit. 0 without limits.
    pub(super) fn usage(self, x: f64) -> f64 {
        let middle = self.middle();
        let part = |end: f64| if end.is_finite() { (x - middle) / (end - middle) } else { 0.0 };
        let usage = part(self.upper).max(part(self.lower));
        // A point interval allows only its point.
        if usage.is_nan() { f64::from(x != middle) * 2.0 } else { usage }
    }

    /// −ln of the relative distances to the finite ends, and its derivative; infinite outside.
    pub(super) fn barrier(self, x: f64) -> (f64, f64) {
        let (mut value, mut slope, scale) = (0.0, 0.0, self.scale());
        for (distance, sign) in [(self.upper - x, 1.0), (x - self.lower, -1.0)] {
            if distance.is_infinite() {
                continue;
            }
            if distance <= 0.0 || distance.is_nan() {
                return (f64::INFINITY, 0.0);
            }
            value -= (distance / scale).ln();
            slope += sign / distance;
        }
        (value, slope)
    }
}
