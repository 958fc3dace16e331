//! Motion in time: steps and runs with their energy account, and functions that check their input.
//!
//! A step of length h leads from (q₀, v₀) to (q₁, v₁) of M(q) v̇ + C(q, v) v + g(q) + b(q, v) = τ.
//! `integrate` has the explicit and the variational rows, `implicit` the step for stiff and discontinuous
//! forces, `mujoco_euler` MuJoCo's step, `simulate::adaptive` steps controlled by a tolerance.
//! `linearize_step` and `pullback` differentiate a step.
//!
//! Cost: one to four evaluations of forward dynamics, O(n), for an explicit step. Explicit steps diverge if h
//! exceeds about 2.8 times the shortest time constant. Source: HLW; each file names its own.

pub mod contact_step;
pub mod implicit;
pub mod integrate;
pub mod linearize_step;
pub(crate) mod mujoco_euler;
pub mod pullback;
pub mod simulate;
mod state;
pub mod step_actuation;

pub use state::RobotState;
