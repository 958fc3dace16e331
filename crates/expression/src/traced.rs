//! A number that writes down what is done with it.
//!
//! An algorithm that is generic over its number, run over this one, leaves a [`Graph`] instead of a value: the same operations, with
//! constants folded and zeros gone. Run over it with constants alone it leaves values: those that the expression must give.

use core::cell::{Cell, RefCell};
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use number::Scalar;
use number::sine::{Quadrants, SHORT_PARTS, of_reduced_f32, sin_cos_f32_in_short_parts, sin_cos_f64};

use crate::graph::{Graph, Operand};
use crate::triple::{TracedSymmetric, TracedTriple};
use crate::{Arithmetic, Precision, Sine};

thread_local! {
    static GRAPH: RefCell<Graph> = RefCell::new(Graph::new(Precision::Double));
    static ARITHMETIC: Cell<Arithmetic> = Cell::new(Arithmetic::default());
    /// The whole number of quarter turns, of the sine that is being traced itself.
    static SHIFTED: Cell<Option<Operand>> = const { Cell::new(None) };
}

/// A number of a trace: a constant, or something that the expression computes.
///
/// It has no order and cannot be compared, so that no branch can depend on what is not known before the expression is
/// computed: the compiler refuses one.
#[derive(Clone, Copy, Debug)]
pub struct Traced(
    /// Which constant, or the value of which operation.
    pub Operand,
);

/// What is computed from arguments of these lengths, as a graph, and the results in it.
///
/// ```
/// use expression::{Arithmetic, trace};
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

/// What is computed further from values of a graph, which it is added to.
///
/// ```
/// use expression::{Arithmetic, Traced, continue_trace, trace};
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

/// What is computed from known arguments: each operation done as the expression does it.
///
/// ```
/// use expression::{Arithmetic, Precision, evaluate};
/// let third = |arithmetic| evaluate(arithmetic, &[vec![1.0, 3.0]], |x| vec![vec![x[0][0] / x[0][1]]])[0][0];
/// assert_eq!(third(Arithmetic::default()), 1.0 / 3.0);
/// assert_eq!(third(Arithmetic::new(Precision::Single)), f64::from(1.0_f32 / 3.0));
/// ```
///
/// # Panics
/// Where a result depends on what is not known.
pub fn evaluate(
    arithmetic: Arithmetic,
    arguments: &[Vec<f64>],
    compute: impl FnOnce(&[Vec<Traced>]) -> Vec<Vec<Traced>>,
) -> Vec<Vec<f64>> {
    ARITHMETIC.set(arithmetic);
    let known = |x: &f64| Traced(Operand::constant(arithmetic.precision.round(*x)));
    let arguments: Vec<Vec<Traced>> = arguments.iter().map(|x| x.iter().map(known).collect()).collect();
    let value = |x: Traced| x.0.known().expect("what is computed from constants is constant");
    compute(&arguments).into_iter().map(|result| result.into_iter().map(value).collect()).collect()
}

/// The library's own sine as a graph: of one input x, the rounded quotient 2x/π shifted so that its lowest bits are a whole
/// number n, and sine and cosine of x − n π/2.
///
/// ```
/// use expression::{Arithmetic, trace_sine};
/// let (graph, results) = trace_sine(Arithmetic::default());
/// assert!(results[0].len() == 3 && graph.nodes[0].is_input());
/// ```
#[allow(clippy::missing_panics_doc)] // what is not known is always turned
pub fn trace_sine(arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    trace(arithmetic, &[1], |arguments| {
        SHIFTED.set(None);
        let (sine, cosine) = own_sine(arguments[0][0]);
        let shifted = SHIFTED.take().expect("the sine of what is not known is turned");
        vec![vec![Traced(shifted), sine, cosine]]
    })
}

/// As [`trace_sine`], of two inputs, x and n: for languages whose compilers may reassociate, so that adding a large number does not
/// round.
///
/// ```
/// use expression::{Arithmetic, Precision, trace_sine_of_quarters};
/// let (graph, results) = trace_sine_of_quarters(Arithmetic::new(Precision::Single));
/// assert!(results[0].len() == 3 && graph.nodes[1].is_input());
/// ```
pub fn trace_sine_of_quarters(arithmetic: Arithmetic) -> (Graph, Vec<Vec<Operand>>) {
    trace(arithmetic, &[1, 1], |arguments| {
        let (x, n) = (arguments[0][0], arguments[1][0]);
        let r = SHORT_PARTS.iter().fold(x, |r, &part| (-n).mul_add(Traced::from_f64(part), r));
        let (sine, cosine) = of_reduced_f32(n, r);
        SHIFTED.set(None);
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
    /// Of constants the value; else a graph has the reduced angle's alone, and who writes a program turns these.
    fn turn(shifted: Self, sine: Self, cosine: Self) -> (Self, Self) {
        let (Some(x), Some(s), Some(c)) = (shifted.0.known(), sine.0.known(), cosine.0.known()) else {
            SHIFTED.set(Some(shifted.0));
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
        (folded(s), folded(c))
    }
}

/// On the graph of this thread.
fn written(operation: impl FnOnce(&mut Graph) -> Operand) -> Traced {
    Traced(GRAPH.with_borrow_mut(operation))
}

/// The value of an operation on constants.
fn folded(x: f64) -> Traced {
    Traced(Operand::constant(ARITHMETIC.get().precision.round(x)))
}

impl Add for Traced {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        match (self.0.known(), other.0.known()) {
            (Some(x), Some(y)) => folded(x + y),
            _ => written(|graph| graph.sum(self.0, other.0)),
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
            (Some(x), Some(y)) => folded(x * y),
            _ => written(|graph| graph.product(self.0, other.0)),
        }
    }
}

impl Div for Traced {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        match (self.0.known(), other.0.known()) {
            (Some(x), Some(y)) => folded(x / y),
            _ => written(|graph| graph.quotient(self.0, other.0)),
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
        folded(x)
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
                (folded(sine), folded(cosine))
            }
            #[allow(clippy::cast_possible_truncation)]
            (Some(x), _) => {
                let (sine, cosine) = (x as f32).sin_cos();
                (folded(sine.into()), folded(cosine.into()))
            }
        }
    }

    #[inline(never)]
    fn sqrt(self) -> Self {
        written(|graph| graph.root(self.0))
    }

    #[inline(never)]
    fn signum0(self) -> Self {
        written(|graph| graph.sign(self.0))
    }

    #[inline(never)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        if ARITHMETIC.get().fused { written(|graph| graph.fused(self.0, a.0, b.0)) } else { self * a + b }
    }
}
