//! Central differences of sixth order.
//!
//! With dᵢ = (f(i s) − f(−i s))/(2 i s),
//!
//! ```text
//! f′ = 3/2 d₁ − 3/5 d₂ + 1/10 d₃ + O(s⁶).
//! ```
//!
//! Next to a kink, such as a bound of a force, the formulas of fourth and sixth order disagree. Then d₁ of a
//! small increment is the result.

/// The increment s \[rad, m, rad/s, m/s, or a control's unit\]. Truncation is s⁶/140 times the seventh
/// derivative: 1e-11 of the first derivative for lengths of 3 cm. Rounding is 2e-13 of the forces.
const MOVE: f64 = 1e-3;

/// The increment next to a kink.
pub(super) const NEAR_KINK: f64 = 1e-5;

/// The formulas of fourth and sixth order differ by less than this fraction of the largest entry if the
/// forces are smooth: 6e-9 of it for lengths of 5 cm.
const AGREE: f64 = 1e-6;

/// The memory of the differences.
#[derive(Clone, Debug, Default)]
pub(super) struct DifferenceMemory {
    pub(super) way: Vec<f64>,
    pub(super) q: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) u: Vec<f64>,
    pub(super) column: Column,
}

/// A column of derivatives, and forces beside the state.
#[derive(Clone, Debug, Default)]
pub(super) struct Column {
    pub(super) derivative: Vec<f64>,
    pub(super) fourth_order: Vec<f64>,
    pub(super) after: Vec<f64>,
    pub(super) before: Vec<f64>,
}

impl Column {
    /// Computes the derivative at 0 of a function of one number. Returns whether the function is smooth
    /// nearby; otherwise the derivative is that of `NEAR_KINK`.
    pub(super) fn differentiate(&mut self, mut at: impl FnMut(f64, &mut [f64])) -> bool {
        let Self { derivative, fourth_order, after, before } = self;
        derivative.fill(0.0);
        fourth_order.fill(0.0);
        for (times, sixth, fourth) in [(1.0, 1.5, 4.0 / 3.0), (2.0, -0.6, -1.0 / 3.0), (3.0, 0.1, 0.0)] {
            at(times * MOVE, after);
            at(-times * MOVE, before);
            for (i, (after, before)) in after.iter().zip(&*before).enumerate() {
                let slope = (after - before) / (2.0 * times * MOVE);
                derivative[i] += sixth * slope;
                fourth_order[i] += fourth * slope;
            }
        }
        let size = derivative.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let apart =
            derivative.iter().zip(&*fourth_order).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
        if apart <= AGREE * size {
            return true;
        }
        at(NEAR_KINK, after);
        at(-NEAR_KINK, before);
        for (derivative, (after, before)) in derivative.iter_mut().zip(after.iter().zip(&*before)) {
            *derivative = (after - before) / (2.0 * NEAR_KINK);
        }
        false
    }
}
