//! A number that records the operations on it.
//!
//! An algorithm that is generic over its number and runs over [`Traced`] produces a [`Graph`] instead of a
//! value. The graph has the same operations, with constants folded and zeros removed. With constant arguments
//! it produces the values that the expression must give.

use core::cell::{Cell, RefCell};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::graph::{Graph, Operand};
use crate::{Arithmetic, Precision};

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::new(Graph::new(Precision::Double));
    static ARITHMETIC: Cell<Arithmetic> = Cell::new(Arithmetic::default());
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

/// The arithmetic of this thread's trace.
pub(crate) fn arithmetic() -> Arithmetic {
    ARITHMETIC.get()
}

/// Applies an operation to the graph of this thread.
pub(crate) fn with_graph<R>(operation: impl FnOnce(&mut Graph) -> R) -> R {
    GRAPH.with_borrow_mut(operation)
}

/// Records an operation in the graph of this thread.
pub(crate) fn record(operation: impl FnOnce(&mut Graph) -> Operand) -> Traced {
    Traced(with_graph(operation))
}

/// The value of an operation on constants, rounded.
pub(crate) fn fold_constant(x: f64) -> Traced {
    Traced(Operand::constant(arithmetic().precision.round(x)))
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
