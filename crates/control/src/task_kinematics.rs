//! Inverse kinematics with several tasks: velocities from one quadratic program a step, and configurations.
//!
//! A task has an error e(q) with ė = J v, which should become zero. Tasks control the pose of a frame in the
//! world or relative to another frame, the centre of mass, or a posture. Others control an axis that points
//! at a point, couplings of joints and closed loops. [`TaskKinematics::step`] computes Δq = v Δt as the
//! minimizer of
//!
//! > ½ Σ w |J Δq + α e|² + ½ (λ + Σ μ w |e|²) |Δq|²
//!
//! within limits of position, velocity, acceleration and of distances between links.
//! [`TaskKinematics::solve`] iterates such steps from several starts until e = 0.
//!
//! Tasks at the same level are weighted against each other. A level with a larger number does not change J Δq
//! of the levels before it.
//!
//! ```
//! use robot_dynamics::control::task_kinematics::{KinematicObjective, KinematicTask, TaskKinematics};
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
//! let model = robot_dynamics::load(file)?.model;
//! let mut kinematics = TaskKinematics::new(&model);
//! let hand = model.frame_named("panda_link8")?;
//! let mut q = vec![0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8];
//! let mut target = model.frame_pose(&q, hand)?;
//! target.translation[1] += 0.2;
//! kinematics.add_task(KinematicTask::new(KinematicObjective::pose(hand, target)).with_gain(0.2))?;
//! let posture = KinematicObjective::Posture { target: q.clone() };
//! kinematics.add_task(KinematicTask::new(posture).with_weight(1e-4))?;
//! let mut v = vec![0.0; 7];
//! for _ in 0..200 {
//!     let step = kinematics.step(&q, &v, 0.01)?;
//!     (q, v) = (step.q.clone(), step.velocity.clone());
//! }
//! assert!((model.frame_pose(&q, hand)?.translation[1] - target.translation[1]).abs() < 1e-3);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Sources: Escande, Mansard, Wieber, *Hierarchical quadratic programming*, Int. J. Robotics Research 33
//! (2014); Sugihara, *Solvability-unconcerned inverse kinematics by the Levenberg–Marquardt method*, IEEE
//! Trans. Robotics 27 (2011); Faverjon, Tournassoud, *A local based approach for path planning of
//! manipulators with a high number of degrees of freedom*, ICRA 1987, for the distances.

mod avoidance;
mod batch;
mod controller;
mod error;
mod levels;
mod limits;
mod objective;
mod rows;
mod solution;
mod solve;

pub use avoidance::CollisionAvoidance;
pub use controller::TaskKinematics;
pub use error::TaskKinematicsError;
pub use limits::KinematicLimits;
pub use objective::{KinematicObjective, KinematicTask};
pub use solution::{
    KinematicLimit, KinematicStep, KinematicTaskId, LinearizedTask, TaskResidual, TaskSolution,
};
