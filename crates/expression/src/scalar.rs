//! The operations of a [`Scalar`], recorded.

use robot_dynamics_number::Scalar;

use crate::sine::own_sine;
use crate::traced::{Traced, arithmetic, fold_constant, record, with_graph};
use crate::triple::{TracedSymmetric, TracedTriple};
use crate::{Arithmetic, Precision, Sine};

impl Scalar for Traced {
    type Triple = TracedTriple;
    type Symmetric = TracedSymmetric;

    #[inline(never)]
    fn from_f64(x: f64) -> Self {
        fold_constant(x)
    }

    #[inline(never)]
    fn sin_cos(self) -> (Self, Self) {
        match (self.0.known(), arithmetic()) {
            (None, _) => {
                let (sine, cosine) = with_graph(|graph| graph.sine_cosine(self.0));
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
        if arithmetic().fused { record(|graph| graph.fused(self.0, a.0, b.0)) } else { self * a + b }
    }
}
