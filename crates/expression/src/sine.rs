//! The library's own sine as an expression.

use core::cell::Cell;

use robot_dynamics_number::Scalar;
use robot_dynamics_number::sine::{
    Quadrants, SHORT_PARTS, of_reduced_f32, sin_cos_f32_in_short_parts, sin_cos_f64,
};

use crate::graph::{Graph, Operand};
use crate::traced::{Traced, arithmetic, fold_constant, trace};
use crate::{Arithmetic, Precision};

thread_local! {
    /// The shifted number of quarter turns, while the sine itself is traced.
    static SINE_QUADRANT: Cell<Option<Operand>> = const { Cell::new(None) };
}

/// The library's own sine as a graph of one input x. The first result is the quotient 2x/π, rounded to an
/// integer n and shifted so that the lowest bits are n. The others are the sine and cosine of x − n π/2.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, trace_sine};
/// let (graph, results) = trace_sine(Arithmetic::default());
/// assert!(results[0].len() == 3 && graph.nodes[0].is_input());
/// ```
#[allow(clippy::missing_panics_doc)] // the input is not a constant
pub fn trace_sine(arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    trace(arithmetic, &[1], |arguments| {
        SINE_QUADRANT.set(None);
        let (sine, cosine) = own_sine(arguments[0][0]);
        let shifted = SINE_QUADRANT.take().expect("the sine of an input calls `turn`");
        vec![vec![Traced(shifted), sine, cosine]]
    })
}

/// As [`trace_sine`], with two inputs, x and n. This is for languages whose compilers may reassociate, where
/// adding a large number does not round.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, Precision, trace_sine_of_quarters};
/// let (graph, results) = trace_sine_of_quarters(Arithmetic::new(Precision::Single));
/// assert!(results[0].len() == 3 && graph.nodes[1].is_input());
/// ```
pub fn trace_sine_of_quarters(arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    trace(arithmetic, &[1, 1], |arguments| {
        let (x, n) = (arguments[0][0], arguments[1][0]);
        let r = SHORT_PARTS.iter().fold(x, |r, &part| (-n).mul_add(Traced::from_f64(part), r));
        let (sine, cosine) = of_reduced_f32(n, r);
        SINE_QUADRANT.set(None);
        vec![vec![n, sine, cosine]]
    })
}

pub(crate) fn own_sine(x: Traced) -> (Traced, Traced) {
    match arithmetic().precision {
        Precision::Double => sin_cos_f64(x),
        Precision::Single => sin_cos_f32_in_short_parts(x),
    }
}

impl Quadrants for Traced {
    /// Returns the value for constants. Otherwise the graph contains the sine and cosine of the reduced
    /// angle, and the generated program rotates them.
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let (Some(x), Some(s), Some(c)) = (shifted.0.known(), sine.0.known(), cosine.0.known()) else {
            SINE_QUADRANT.set(Some(shifted.0));
            return (sine, cosine);
        };
        #[allow(clippy::cast_possible_truncation)] // they are singles
        let (s, c) = match arithmetic().precision {
            Precision::Double => f64::turn(x, s, c),
            Precision::Single => {
                let (s, c) = f32::turn(x as f32, s as f32, c as f32);
                (s.into(), c.into())
            }
        };
        (fold_constant(s), fold_constant(c))
    }
}
