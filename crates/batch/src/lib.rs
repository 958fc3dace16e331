//! Algorithms on many states of one robot at once, with SIMD lanes and threads.
//!
//! Tables are row-major, one state after the other: q is \[batch\]\[nq\], v, a and tau are \[batch\]\[nv\], a
//! matrix is \[batch\]\[rows\]\[columns\]. A block of states fills the lanes of one vector register, and
//! threads process chunks of blocks. The arithmetic of each lane does not depend on its position in a block
//! or chunk. Results are therefore the same bits for any number of threads and for any division of a batch.
//! They differ from those of the single-state functions by rounding.
//!
//! A state with an input or a result that is not finite does not affect other states. [`BadStates`] reports
//! it, its results are NaN, and those of all other states are valid.
//!
//! ```
//! use robot_dynamics::batch;
//! use robot_dynamics::batch::BatchWorkspace;
//! use robot_dynamics::description::{RandomRobotOptions, random_robot};
//! use robot_dynamics::model::Model;
//! let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
//! let mut workspace = BatchWorkspace::<f64>::new(&model);
//! let q = robot_dynamics::model::neutral(&model).repeat(100);
//! let v = vec![0.1; 100 * model.nv()];
//! let mut tau = v.clone();
//! batch::bias(&model, &mut workspace, &q, &v, &mut tau)?;
//! assert_eq!(tau[..model.nv()], tau[99 * model.nv()..]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Tables, blocks and threads,
mod bad_states;
mod block;
mod kernel_call;
mod tables;
mod threads;
mod workspace;

// the division of a batch, and machine code,
mod distribution;
mod machine_code;

// the algorithms, compiled once for each float,
mod computation;
mod float;

// and the public functions.
mod constrained;
mod construction;
mod derivatives;
mod equation;
mod kinematics;
mod linearize;
mod pullback;
mod quantity;
mod related_mass;
mod rollout;
mod simulations;

pub use bad_states::BadStates;
pub use constrained::{
    ConstrainedDerivativesMut, ConstrainedInputs, ConstrainedPullbackMut,
    constrained_forward_dynamics_derivatives, constrained_forward_dynamics_pullback,
};
pub use derivatives::{forward_dynamics_derivatives, inverse_dynamics_derivatives};
pub use equation::{bias, forward_dynamics, gravity, inverse_dynamics, inverse_mass_matrix, mass_matrix};
pub use float::BatchFloat;
pub use kinematics::{NUMBERS_PER_POSE, frame_jacobian, frame_poses};
pub use linearize::{LinearizeInputs, linearize_step, linearize_stepper};
pub use pullback::{forward_dynamics_pullback, inverse_dynamics_pullback};
pub use quantity::BatchQuantity;
pub use related_mass::mass_matrix_related;
pub use robot_dynamics_core::mass_matrix_related_entries;
pub use robot_dynamics_core::{
    ForwardDynamicsDerivativesMut, ForwardPullbackMut, InverseDynamicsDerivativesMut, InversePullbackMut,
};
pub use robot_dynamics_simulation::{LinearizedSteps, MotionCotangents, TrajectoryCotangents};
pub use rollout::{
    PolicyInput, Rollout, RolloutError, RolloutObserver, RolloutProgress, RolloutPullbackInputs,
    RolloutStates, StepperRollout, Torques, UNOBSERVED, rollout, rollout_by_stepper, rollout_pullback,
    rollout_pullback_by_stepper,
};
pub use simulations::{PositionControl, SimulationBatch};
pub use threads::{ThreadError, Threads};
pub use workspace::{BatchOptions, BatchWorkspace};
