//! The algorithms on many states of one robot at once: lanes inside, threads across.
//!
//! Tables are row-major, one state after the other: q is \[batch\]\[nq\], v, a and tau \[batch\]\[nv\], a matrix
//! \[batch\]\[rows\]\[columns\]. States are taken in blocks of one vector register's
//! lanes, blocks in chunks by the threads. Each lane's arithmetic is the same wherever in a
//! block or a chunk its state stands, so results are the same bits for any number of threads and however a
//! batch is split. They differ from the single-state functions' by rounding.
//!
//! A state with a number that is not finite, or whose result is not, spoils no other state: it is reported
//! in [`BadStates`], its results are NaN, and those of all other states are valid.
//!
//! ```
//! use multibody::batch::{self, BatchWorkspace};
//! use multibody::{Model, RandomRobotOptions, random_robot};
//! let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
//! let mut workspace = BatchWorkspace::<f64>::new(&model);
//! let q = multibody::neutral(&model).repeat(100);
//! let v = vec![0.1; 100 * model.nv()];
//! let mut tau = v.clone();
//! batch::bias(&model, &mut workspace, &q, &v, &mut tau)?;
//! assert_eq!(tau[..model.nv()], tau[99 * model.nv()..]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bad_states;
mod block;
mod compiled_once;
mod compute;
mod derivatives;
mod equation;
mod kinematics;
mod native;
mod pullback;
mod recursions;
mod related_mass;
mod rollout;
mod share;
mod simulations;
mod within;
mod workspace;

pub use crate::algorithms::mass_matrix::mass_matrix_related_entries;
pub use bad_states::BadStates;
pub use derivatives::{forward_dynamics_derivatives, inverse_dynamics_derivatives};
pub use equation::{bias, forward_dynamics, gravity, inverse_dynamics, inverse_mass_matrix, mass_matrix};
pub use kinematics::{
    NUMBERS_PER_POSE, frame_jacobian_in_frame, frame_jacobian_in_world, frame_jacobian_world_aligned,
    frame_poses,
};
pub use pullback::{forward_dynamics_pullback, inverse_dynamics_pullback};
pub use related_mass::mass_matrix_related;
pub use rollout::{
    PolicyInput, Rollout, RolloutError, RolloutProgress, StepperRollout, Torques, rollout,
    rollout_by_stepper, rollout_pullback,
};
pub use simulations::SimulationBatch;
pub use workspace::{BatchFloat, BatchOptions, BatchWorkspace, ThreadError, Threads};
