//! The result of whole-body control.

use core::fmt;

/// The index of a contact in the order in which contacts were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ContactId(pub(super) usize);

/// The index of a task in the order in which tasks were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TaskId(pub(super) usize);

impl ContactId {
    /// The index of the contact.
    pub fn index(self) -> usize {
        self.0
    }
}

impl TaskId {
    /// The index of the task.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A limit of the motion or of the forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Limit {
    /// The torque of a degree of freedom.
    Torque {
        /// Its index in v.
        dof: usize,
    },
    /// The acceleration of a degree of freedom, from its limits of position, velocity and acceleration.
    Acceleration {
        /// Its index in v.
        dof: usize,
    },
    /// The normal force at a point of a contact.
    NormalForce {
        /// The contact.
        contact: ContactId,
        /// The index of the point.
        point: usize,
    },
    /// A side of the friction pyramid at a point of a contact.
    Friction {
        /// The contact.
        contact: ContactId,
        /// The index of the point.
        point: usize,
        /// The index of the side.
        side: usize,
    },
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Torque { dof } => write!(f, "the torque limit of degree of freedom {dof}"),
            Self::Acceleration { dof } => write!(f, "the acceleration limit of degree of freedom {dof}"),
            Self::NormalForce { contact, point } => {
                write!(f, "the normal force at point {point} of contact {}", contact.0)
            }
            Self::Friction { contact, point, .. } => {
                write!(f, "the friction at point {point} of contact {}", contact.0)
            }
        }
    }
}

/// A limit that determines the solution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ActiveLimit {
    /// The limit.
    pub limit: Limit,
    /// Whether it is the upper bound.
    pub is_upper: bool,
    /// λ ≥ 0: the decrease of the objective ½ Σ w r² of the last level for each unit by which the bound is
    /// relaxed.
    pub multiplier: f64,
}

/// The force of the environment on the robot at a point of a contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPointForce {
    /// The contact.
    pub contact: ContactId,
    /// The index of the point in the contact.
    pub point: usize,
    /// The position of the point in the world \[m\].
    pub position: [f64; 3],
    /// The force along the world's axes \[N\].
    pub force: [f64; 3],
}

/// Torques, accelerations and contact forces of one state.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WholeBodySolution {
    /// τ, nv entries; zero for degrees of freedom without a motor \[N·m, N\].
    pub torque: Vec<f64>,
    /// q̈, nv entries \[rad/s², m/s²\].
    pub acceleration: Vec<f64>,
    /// The forces at the points of the active contacts.
    pub forces: Vec<ContactPointForce>,
    /// The limits that determine the last level's solution.
    pub active_limits: Vec<ActiveLimit>,
    /// |A x − b| of each task, in the order of the tasks; zero for tasks with the weight zero.
    pub task_errors: Vec<f64>,
    /// The steps of the quadratic programs: rows added to the working sets, or removed.
    pub steps: usize,
}
