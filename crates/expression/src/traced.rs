//! A number that records the operations on it.
//!
//! An algorithm that is generic over its number and runs over [`Traced`] produces a [`Graph`] instead of a
//! value. The graph has the same operations, with constants folded and zeros removed. With constant arguments
//! it produces the values that the expression must give.

use core::cell::{Cell, RefCell};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use robot_dynamics_number::Scalar;
use robot_dynamics_number::sine::{
    Quadrants, SHORT_PARTS, of_reduced_f32, sin_cos_f32_in_short_parts, sin_cos_f64,
};

use crate::graph::{Graph, Operand};
use crate::triple::{TracedSymmetric, TracedTriple};
use crate::{Arithmetic, Precision, Sine};

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::new(Graph::new(Precision::Double));
    static ARITHMETIC: Cell<Arithmetic> = Cell::new(Arithmetic::default());
    /// The shifted number of quarter turns, while the sine itself is traced.
    static SINE_QUADRANT: Cell<Option<Operand>> = const { Cell::new(None) };
}

/// A number of a trace: a constant, or a value of the expression.
///
/// It cannot be compared, so the compiler rejects a branch that depends on a value of the expression.
#[derive(Clone, Copy, Debug)]
pub struct Traced(
    /// The constant, or the operation whose value it is.
    pub Operand,
);

/// Traces a computation on arguments of these lengths and returns its graph and results.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, trace};
/// let (graph, results) = trace(Arithmetic::default(), &[1], |x| vec![vec![x[0][0] + x[0][0], x[0][0] + x[0][0]]]);
/// assert_eq!(graph.nodes.len(), 2); // the input and one sum
/// assert_eq!(results[0][0], results[0][1]);
/// ```
pub fn trace(
    arithmetic: Arithmetic,
    lengths: &[usize],
    compute: impl FnOnce(&[Vec<Traced>]) -> Vec<Vec<Traced>>,
) -> (Graph, Vec<Vec<Operand>>) {
    ARITHMETIC.set(arithmetic);
    GRAPH.set(Graph::new(arithmetic.precision));
    let argument = |(argument, &length): (usize, &usize)| -> Vec<Traced> {
        let input = |index| Traced(GRAPH.with_borrow_mut(|graph| graph.input(argument, index)));
        (0..length).map(input).collect()
    };
    let arguments: Vec<_> = lengths.iter().enumerate().map(argument).collect();
    let results = compute(&arguments);
    let results = results.into_iter().map(|result| result.into_iter().map(|x| x.0).collect()).collect();
    (GRAPH.replace(Graph::new(arithmetic.precision)), results)
}

/// Continues a trace: records a computation on values of a graph, and adds its operations to that graph.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, Traced, continue_trace, trace};
/// let arithmetic = Arithmetic::default();
/// let (mut graph, results) = trace(arithmetic, &[1], |x| vec![vec![x[0][0] * x[0][0]]]);
/// let square = Traced(results[0][0]);
/// continue_trace(arithmetic, &mut graph, || square * square);
/// assert_eq!(graph.nodes.len(), 3);
/// ```
pub fn continue_trace<R>(arithmetic: Arithmetic, graph: &mut Graph, compute: impl FnOnce() -> R) -> R {
    ARITHMETIC.set(arithmetic);
    let empty = Graph::new(arithmetic.precision);
    let elsewhere = GRAPH.replace(core::mem::replace(graph, empty));
    let result = compute();
    *graph = GRAPH.replace(elsewhere);
    result
}

/// Evaluates a computation on constant arguments, each operation rounded as in the expression.
///
/// ```
/// use robot_dynamics_expression::{Arithmetic, Precision, evaluate};
/// let third = |arithmetic| evaluate(arithmetic, &[vec![1.0, 3.0]], |x| vec![vec![x[0][0] / x[0][1]]])[0][0];
/// assert_eq!(third(Arithmetic::default()), 1.0 / 3.0);
/// assert_eq!(third(Arithmetic::new(Precision::Single)), f64::from(1.0_f32 / 3.0));
/// ```
///
/// # Panics
/// If a result is not constant.
pub fn evaluate(
    arithmetic: Arithmetic,
    arguments: &[Vec<f64>],
    compute: impl FnOnce(&[Vec<Traced>]) -> Vec<Vec<Traced>>,
) -> Vec<Vec<f64>> {
    ARITHMETIC.set(arithmetic);
    let known = |x: &f64| Traced(Operand::constant(arithmetic.precision.round(*x)));
    let arguments: Vec<Vec<Traced>> = arguments.iter().map(|x| x.iter().map(known).collect()).collect();
    let value = |x: Traced| x.0.known().expect("a result of constant arguments is constant");
    compute(&arguments).into_iter().map(|result| result.into_iter().map(value).collect()).collect()
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

fn own_sine(x: Traced) -> (Traced, Traced) {
    match ARITHMETIC.get().precision {
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
        let (s, c) = match ARITHMETIC.get().precision {
            Precision::Double => f64::turn(x, s, c),
            Precision::Single => {
                let (s, c) = f32::turn(x as f32, s as f32, c as f32);
                (s.into(), c.into())
            }
        };
        (fold_constant(s), fold_constant(c))
    }
}

/// Records an operation in the graph of this thread.
fn record(operation: impl FnOnce(&mut Graph) -> Operand) -> Traced {
    Traced(GRAPH.with_borrow_mut(operation))
}

/// The value of an operation on constants, rounded.
fn fold_constant(x: f64) -> Traced {
    Traced(Operand::constant(ARITHMETIC.get().precision.round(x)))
}

impl Add for Traced {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        match (self.0.known(), other.0.known()) {
            (Some(x), Some(y)) => fold_constant(x + y),
            _ => record(|graph| graph.sum(self.0, other.0)),
        }
    }
}

impl Sub for Traced {
    type Output = Self;
    #[inline(never)]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Traced {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        match (self.0.known(), other.0.known()) {
            (Some(x), Some(y)) => fold_constant(x * y),
            _ => record(|graph| graph.product(self.0, other.0)),
        }
    }
}

impl Div for Traced {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        match (self.0.known(), other.0.known()) {
            (Some(x), Some(y)) => fold_constant(x / y),
            _ => record(|graph| graph.quotient(self.0, other.0)),
        }
    }
}

impl Neg for Traced {
    type Output = Self;
    #[inline(never)]
    fn neg(self) -> Self {
        Self(self.0.negated())
    }
}

impl AddAssign for Traced {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for Traced {
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl MulAssign for Traced {
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl Scalar for Traced {
    type Triple = TracedTriple;
    type Symmetric = TracedSymmetric;

    #[inline(never)]
    fn from_f64(x: f64) -> Self {
        fold_constant(x)
    }

    #[inline(never)]
    fn sin_cos(self) -> (Self, Self) {
        match (self.0.known(), ARITHMETIC.get()) {
            (None, _) => {
                let (sine, cosine) = GRAPH.with_borrow_mut(|graph| graph.sine_cosine(self.0));
                (Self(sine), Self(cosine))
            }
            (Some(_), Arithmetic { sine: Sine::Own, .. }) => own_sine(self),
            (Some(x), Arithmetic { precision: Precision::Double, .. }) => {
                let (sine, cosine) = x.sin_cos();
                (fold_constant(sine), fold_constant(cosine))
            }
            #[allow(clippy::cast_possible_truncation)]
            (Some(x), _) => {
                let (sine, cosine) = (x as f32).sin_cos();
                (fold_constant(sine.into()), fold_constant(cosine.into()))
            }
        }
    }

    #[inline(never)]
    fn sqrt(self) -> Self {
        record(|graph| graph.root(self.0))
    }

    #[inline(never)]
    fn signum0(self) -> Self {
        record(|graph| graph.sign(self.0))
    }

    #[inline(never)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        if ARITHMETIC.get().fused { record(|graph| graph.fused(self.0, a.0, b.0)) } else { self * a + b }
    }
}
