//! Linear constraints on (u, x) = (s̈, ṡ²) at one grid point.

/// Half-planes α u + β x ≤ γ.
#[derive(Clone, Debug, Default)]
pub(super) struct HalfPlanes {
    rows: Vec<[f64; 3]>,
}

/// The slack for the rounding of α u + β x, as a fraction of its terms.
const ROUNDING: f64 = 1e-15;

impl HalfPlanes {
    /// Adds α u + β x ≤ γ; an infinite γ adds nothing.
    pub(super) fn add(&mut self, alpha: f64, beta: f64, gamma: f64) {
        if gamma < f64::INFINITY {
            self.rows.push([alpha, beta, gamma]);
        }
    }

    /// Adds low ≤ α u + β x ≤ high.
    pub(super) fn add_between(&mut self, alpha: f64, beta: f64, low: f64, high: f64) {
        self.add(alpha, beta, high);
        self.add(-alpha, -beta, -low);
    }

    /// The interval of x ≥ 0 for which some u satisfies every row; `None` if it is empty.
    ///
    /// The method of Fourier and Motzkin eliminates u: each pair of an upper and a lower bound on u gives a
    /// linear inequality in x.
    pub(super) fn speeds(&self) -> Option<(f64, f64)> {
        let (mut low, mut high) = (0.0, f64::INFINITY);
        let mut bound = |beta: f64, gamma: f64, size: f64| {
            // β x ≤ γ; a β within the rounding of its terms is zero.
            if beta.abs() <= ROUNDING * size {
                if gamma < 0.0 {
                    high = f64::NEG_INFINITY;
                }
            } else if beta > 0.0 {
                high = high.min(gamma / beta);
            } else {
                low = f64::max(low, gamma / beta);
            }
        };
        for &[a1, b1, c1] in &self.rows {
            if a1 == 0.0 {
                bound(b1, c1 + ROUNDING * c1.abs(), 0.0);
            }
            for &[a2, b2, c2] in self.rows.iter().filter(|row| row[0] < 0.0 && a1 > 0.0) {
                // (c2 − b2 x)/a2 ≤ (c1 − b1 x)/a1
                let (b, c) = (b1 / a1 - b2 / a2, c1 / a1 - c2 / a2);
                bound(
                    b,
                    c + ROUNDING * ((c1 / a1).abs() + (c2 / a2).abs()),
                    (b1 / a1).abs() + (b2 / a2).abs(),
                );
            }
        }
        (low <= high).then_some((low, high))
    }

    /// The interval of u at this x.
    pub(super) fn accelerations(&self, x: f64) -> (f64, f64) {
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for &[alpha, beta, gamma] in &self.rows {
            let bound = (gamma - beta * x) / alpha;
            if alpha > 0.0 {
                high = high.min(bound);
            } else if alpha < 0.0 {
                low = f64::max(low, bound);
            }
        }
        (low, high)
    }
}
