//! Inputs and results of a quantity.

use crate::{FrameId, Model};

/// An input of a [`Quantity`](crate::Quantity) besides q.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Input {
    /// v, nv entries.
    Velocity,
    /// a, nv entries.
    Acceleration,
    /// τ, nv entries.
    Force,
    /// A frame, the first of [`Inputs::frames`].
    Frame,
}

/// The inputs of a [`Quantity`](crate::Quantity); those that it does not read may be empty.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs<'a, T = f64> {
    /// The configuration, nq numbers; for a batch \[batch\]\[nq\].
    pub q: &'a [T],
    /// The velocity, nv numbers; for a batch \[batch\]\[nv\], as for the next two.
    pub v: &'a [T],
    /// The acceleration.
    pub a: &'a [T],
    /// The generalized force.
    pub tau: &'a [T],
    /// Frames: the first one for a Jacobian, all for poses.
    pub frames: &'a [FrameId],
}

/// The shape of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ResultShape {
    /// One number.
    Scalar,
    /// Three numbers.
    Point,
    /// nv numbers.
    Vector,
    /// nv×nv numbers, row by row.
    Square,
    /// This many rows of nv numbers.
    Rows(usize),
    /// Twelve numbers for each frame: the rotation by rows, then the translation.
    Poses,
}

impl ResultShape {
    /// The lengths of the axes, slowest first; empty for a scalar.
    pub fn dimensions(self, model: &Model, frames: usize) -> Vec<usize> {
        match self {
            Self::Scalar => vec![],
            Self::Point => vec![3],
            Self::Vector => vec![model.nv()],
            Self::Square => vec![model.nv(), model.nv()],
            Self::Rows(rows) => vec![rows, model.nv()],
            Self::Poses => vec![frames, 12],
        }
    }

    /// The number of entries.
    pub fn len(self, model: &Model, frames: usize) -> usize {
        let nv = model.nv();
        match self {
            Self::Scalar => 1,
            Self::Point => 3,
            Self::Vector => nv,
            Self::Square => nv * nv,
            Self::Rows(rows) => rows * nv,
            Self::Poses => 12 * frames,
        }
    }
}

/// A result of a [`Quantity`](crate::Quantity).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct QuantityResult {
    /// Its name among several, for example `by_velocity`; empty if there is only one.
    pub name: &'static str,
    /// Its shape.
    pub shape: ResultShape,
}
