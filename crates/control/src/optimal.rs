//! Optimal control: the controls u₀ … u_{N−1} that minimize a cost along x_{k+1} = f_k(x_k, u_k).
//!
//! > minimize Σₖ ℓ_k(x_k, u_k) + ℓ_N(x_N)  with  x₀ given,  x_{k+1} = f_k(x_k, u_k),  u̲_k ≤ u_k ≤ ū_k,
//! > l_k ≤ c_k(x_k, u_k) ≤ h_k
//!
//! A state x = (q, v) lies on the robot's configuration manifold; its differences have 2nv numbers.
//! [`DiscreteDynamics`] gives f, [`Cost`] sums terms ½ Σ w r² of [`Residual`]s, [`Problem`] joins them.
//! [`Fddp`] solves problems without the constraints c, [`AugmentedLagrangian`] those with them; [`Mpc`]
//! solves one at each period of a controller. [`Sampling`] needs no derivatives.
//!
//! Source: Mastalli, Budhiraja, Merkt, Saurel, Hammoud, Naveau, Carpentier, Righetti, Vijayakumar, Mansard,
//! *Crocoddyl: an efficient and versatile framework for multi-contact optimal control*, ICRA 2020.

mod augmented_lagrangian;
mod box_qp;
mod constraint;
mod control_bounds;
mod cost;
pub(crate) mod dense;
mod dynamics;
mod error;
mod mpc;
mod problem;
mod residual;
mod sampling;
mod solver;
mod state_space;

pub use augmented_lagrangian::{
    AugmentedLagrangian, AugmentedLagrangianOptions, ConstrainedReport, OuterRecord,
};
pub use control_bounds::ControlBounds;
pub use cost::{Activation, Cost, CostExpansion, CostTerm, LeastSquares, Weights};
pub use dynamics::{
    ActuationMatrix, ContactForces, DiscreteDynamics, HeldContactStep, ImpactStep, LinearDynamics,
    LinearizedDynamics, SimulationStep, SmoothStep,
};
pub use error::{Evaluation, OptimalControlError};
pub use mpc::{Mpc, MpcOptions, MpcTimes};
pub use problem::Problem;
pub use residual::{
    CenterOfMassResidual, ContactForceResidual, ControlResidual, DifferentiatedResidual,
    FramePlacementResidual, FrameRotationResidual, FrameTranslationResidual, FrameVelocityResidual, Residual,
    ResidualFunction, ResidualInputs, ResidualJacobian, StateResidual,
};
pub use sampling::{Sampling, SamplingLaw, SamplingOptions, SamplingRecord, SamplingReport};
pub use solver::{Fddp, FddpOptions, FddpReport, IterationRecord, Termination};
pub use state_space::StateSpace;
pub(crate) use state_space::each_quaternion_block;
