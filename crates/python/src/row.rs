//! The arguments and results of an algorithm: a row of the table that Python's methods are made from.

use pyo3::PyResult;
use pyo3::exceptions::PyValueError;
use robot_dynamics::algorithms::{PARAMETERS_PER_LINK, ReferenceFrame};
use robot_dynamics::derivatives::parameter_count;
use robot_dynamics::model::{FrameId, Model};
use robot_dynamics::quantity::Quantity;

use crate::pullback::Pullback;
use crate::results::{MOST_OPERANDS, Results};
use crate::scratch::Scratch;

/// A row.
#[derive(Debug)]
pub(crate) struct Row {
    /// The method's name, which is the library's.
    pub(crate) name: &'static str,
    /// Its operands, in the order of the arguments.
    pub(crate) operands: &'static [Operand],
    /// The shapes of its results. The names of several results are the fields of a named tuple in
    /// `robot_dynamics.results`.
    pub(crate) results: &'static [Shape],
    pub(crate) work: Work,
}

/// An argument of numbers.
#[derive(Debug)]
pub(crate) struct Operand {
    pub(crate) name: &'static str,
    pub(crate) width: Width,
}

/// How many numbers of one state an operand has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Width {
    Nq,
    Nv,
    /// A number for each of a configuration's.
    Coordinates,
    /// Six for each frame of the call.
    Wrenches,
    /// No axis of its own.
    One,
    /// Linear, then angular.
    Six,
    /// A direction in q, v and a third argument.
    Direction,
}

impl Width {
    pub(crate) fn len(self, model: &Model, frames: usize) -> usize {
        match self {
            Self::Nq | Self::Coordinates => model.nq(),
            Self::Nv => model.nv(),
            Self::Wrenches => 6 * frames,
            Self::One => 1,
            Self::Six => 6,
            Self::Direction => 3 * model.nv(),
        }
    }

    /// The axes of one state.
    pub(crate) fn dims(self, model: &Model, frames: usize) -> Dims {
        match self {
            Self::Nq | Self::Nv | Self::Coordinates | Self::Six | Self::Direction => {
                Dims::new(&[self.len(model, frames)])
            }
            Self::Wrenches => Dims::new(&[frames, 6]),
            Self::One => Dims::new(&[]),
        }
    }

    /// For messages.
    pub(crate) fn meaning(self, model: &Model) -> String {
        match self {
            Self::Nq => format!("a configuration has nq = {} numbers along the last axis", model.nq()),
            Self::Nv => format!("it has nv = {} numbers along the last axis", model.nv()),
            Self::Coordinates => format!("it has nq = {} numbers along the last axis", model.nq()),
            Self::Wrenches => "a row of six for each frame, force then moment".into(),
            Self::One => "one number a state".into(),
            Self::Six => "six numbers along the last axis, linear then angular".into(),
            Self::Direction => {
                let count = 3 * model.nv();
                format!("it has 3·nv = {count} numbers along the last axis: δq, δv and the third change")
            }
        }
    }
}

/// The shape of one state's result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    Scalar,
    Point,
    /// Linear, then angular.
    Six,
    Configuration,
    Vector,
    Square,
    Cube,
    /// nv×nv for each of six components.
    SixSquares,
    /// A direction in q, v and a third argument.
    Direction,
    /// A matrix over q, v and a third argument.
    Hessian,
    /// A matrix over q and v.
    StateHessian,
    Rows(usize),
    /// One number for each inertial parameter.
    Parameters,
    /// One for each parameter of the dynamics, those of joints and gravity with them.
    AllParameters,
    /// nv rows of them.
    Regressor,
    /// A homogeneous matrix.
    Pose,
    /// One for each frame.
    Poses,
    /// Six for each joint.
    Reactions,
}

impl Shape {
    pub(crate) fn dims(self, model: &Model, frames: usize) -> Dims {
        let (nq, nv) = (model.nq(), model.nv());
        let parameters = || PARAMETERS_PER_LINK * model.moving_links().count();
        match self {
            Self::Scalar => Dims::new(&[]),
            Self::Point => Dims::new(&[3]),
            Self::Six => Dims::new(&[6]),
            Self::Configuration => Dims::new(&[nq]),
            Self::Vector => Dims::new(&[nv]),
            Self::Square => Dims::new(&[nv, nv]),
            Self::Cube => Dims::new(&[nv, nv, nv]),
            Self::SixSquares => Dims::new(&[6, nv, nv]),
            Self::Direction => Dims::new(&[3 * nv]),
            Self::Hessian => Dims::new(&[3 * nv, 3 * nv]),
            Self::StateHessian => Dims::new(&[2 * nv, 2 * nv]),
            Self::Rows(rows) => Dims::new(&[rows, nv]),
            Self::Parameters => Dims::new(&[parameters()]),
            Self::AllParameters => Dims::new(&[parameter_count(model)]),
            Self::Regressor => Dims::new(&[nv, parameters()]),
            Self::Pose => Dims::new(&[4, 4]),
            Self::Poses => Dims::new(&[frames, 4, 4]),
            Self::Reactions => Dims::new(&[model.joints().len(), 6]),
        }
    }
}

/// A few lengths of axes, without allocation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Dims {
    count: usize,
    lengths: [usize; 3],
}

impl Dims {
    pub(crate) fn new(dims: &[usize]) -> Self {
        let mut lengths = [1; 3];
        lengths[..dims.len()].copy_from_slice(dims);
        Self { count: dims.len(), lengths }
    }

    pub(crate) fn as_slice(&self) -> &[usize] {
        &self.lengths[..self.count]
    }

    /// How many numbers.
    pub(crate) fn len(&self) -> usize {
        self.lengths.iter().product()
    }
}

/// How it is computed.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Work {
    /// A row of the library's table, with lanes where it has them.
    Quantity(Quantity),
    /// One state after the other.
    Each(Each),
    /// Poses as homogeneous matrices.
    Poses,
    /// A vector-Jacobian product.
    Pullback(Pullback),
    /// One state after the other, of one frame in a reference frame.
    OfFrame(OfFrame, ReferenceFrame),
}

/// An algorithm on one state. Its arguments are the operands in the row's order, the frames of the call, and
/// the results.
pub(crate) type Each = fn(&Model, &mut Scratch, &[&[f64]; MOST_OPERANDS], &[FrameId], Results<'_>);

/// An algorithm on one state of a frame in a reference frame.
pub(crate) type OfFrame =
    fn(&Model, &mut Scratch, &[&[f64]; MOST_OPERANDS], FrameId, ReferenceFrame, Results<'_>);

/// The work in each reference frame, in the order of [`ReferenceFrame::ALL`].
pub(crate) const fn of_frame(work: OfFrame) -> [Work; 3] {
    let [local, world, aligned] = ReferenceFrame::ALL;
    [Work::OfFrame(work, local), Work::OfFrame(work, world), Work::OfFrame(work, aligned)]
}

/// The reference frame with this name, which the argument `argument` states.
pub(crate) fn reference_frame_of(argument: &str, name: &str) -> PyResult<ReferenceFrame> {
    ReferenceFrame::ALL.into_iter().find(|reference_frame| reference_frame.name() == name).ok_or_else(|| {
        let [local, world, aligned] = ReferenceFrame::ALL.map(ReferenceFrame::name);
        PyValueError::new_err(format!("{argument} must be '{local}', '{world}' or '{aligned}', got {name:?}"))
    })
}

impl Row {
    /// Whether the result is undefined where M is singular.
    pub(crate) fn inverts_mass(&self) -> bool {
        matches!(self.work, Work::Quantity(quantity) if quantity.inverts_mass())
            || self.name.starts_with("forward_dynamics")
    }
}
