//! Results of tasks.

use core::fmt;

use nalgebra::{DMatrix, DVector};

/// The index of a task in the order in which tasks were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct KinematicTaskId(pub(super) usize);

impl KinematicTaskId {
    /// The index of the task.
    pub fn index(self) -> usize {
        self.0
    }
}

/// The error of a task, without its weights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TaskResidual {
    /// The length of the linear rows \[m\]; for constraints the largest |φ|.
    pub position: f64,
    /// The length of the angular rows, or the angle between an axis and its direction \[rad\]; for a posture
    /// the largest difference of a coordinate.
    pub angle: f64,
}

/// The rows of a task at a configuration; rows of weight zero are left out.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearizedTask {
    /// √w e.
    pub residual: DVector<f64>,
    /// √w J, with nv columns.
    pub jacobian: DMatrix<f64>,
}

/// A limit of the motion.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum KinematicLimit {
    /// The position of a degree of freedom.
    Position {
        /// Its index in v.
        dof: usize,
    },
    /// The velocity of a degree of freedom.
    Velocity {
        /// Its index in v.
        dof: usize,
    },
    /// The acceleration of a degree of freedom.
    Acceleration {
        /// Its index in v.
        dof: usize,
    },
    /// The distance of two links.
    Distance {
        /// The names of the links.
        links: [String; 2],
    },
}

impl fmt::Display for KinematicLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Position { dof } => write!(f, "the position limit of degree of freedom {dof}"),
            Self::Velocity { dof } => write!(f, "the velocity limit of degree of freedom {dof}"),
            Self::Acceleration { dof } => write!(f, "the acceleration limit of degree of freedom {dof}"),
            Self::Distance { links: [a, b] } => write!(f, "the distance of the links `{a}` and `{b}`"),
        }
    }
}

/// The result of one differential step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct KinematicStep {
    /// v, nv numbers \[rad/s, m/s\].
    pub velocity: Vec<f64>,
    /// q ⊕ v Δt, nq numbers.
    pub q: Vec<f64>,
    /// The errors at the start of the step, in the order of the tasks.
    pub errors: Vec<TaskResidual>,
    /// The least distance between links that was found, within the range of the avoidance \[m\].
    pub distance: Option<f64>,
    /// The steps of the quadratic programs: rows added to the working sets, or removed.
    pub steps: usize,
}

/// A configuration, and its distance from the targets.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct TaskSolution {
    /// q, nq numbers, within the position limits.
    pub q: Vec<f64>,
    /// The errors, in the order of the tasks.
    pub errors: Vec<TaskResidual>,
    /// The number of steps from all starts.
    pub iterations: usize,
    /// The number of random starts.
    pub restarts: usize,
}
