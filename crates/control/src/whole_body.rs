//! Whole-body control: torques, accelerations and contact forces from one quadratic program.
//!
//! The variables are x = (q̈, f), with three force components at each contact point; τ = M q̈ + h − Jᵀf.
//!
//! > minimize ½ Σ w |A x − b|² over the tasks
//!
//! The constraints are τ = 0 without a motor, J q̈ + J̇ v = −kd J v for held contacts, friction pyramids, |τ| ≤
//! τ_max, and bounds on q̈ from the limits of the joints.
//!
//! Tasks at the same level are weighted against each other. A level with a larger number does not change the
//! task values of the levels before it. Where tasks leave a motion or a force free, the solution nearest to
//! the particular solution of the equations is chosen.
//!
//! The equations are eliminated by an orthogonal basis, and a dual active-set method solves each level. It
//! starts from the limits that were active in the last call.
//!
//! ```
//! use robot_dynamics::control::whole_body::{ContactGeometry, HeldContact, Objective, PdGains};
//! use robot_dynamics::control::whole_body::WholeBodyControl;
//! use robot_dynamics::control::Reference;
//! use robot_dynamics::description::Base;
//! use robot_dynamics::model::{Model, neutral};
//! # let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.urdf");
//! let mut quadruped = robot_dynamics::load_description(file, &robot_dynamics::LoadOptions::default())?.description;
//! quadruped.base = Base::Floating;
//! let model = Model::new(quadruped)?;
//! let mut control = WholeBodyControl::new(&model);
//! for foot in ["front_left_foot", "front_right_foot", "hind_left_foot", "hind_right_foot"] {
//!     let frame = model.frame_named(foot)?;
//!     control.add_contact(HeldContact::new(frame, ContactGeometry::Ball(0.02)).with_friction(0.7, 4)?)?;
//! }
//! let (mut q, rest) = (neutral(&model), vec![0.0; model.nv()]);
//! for leg in 0..4 {
//!     q[7 + 3 * leg..10 + 3 * leg].copy_from_slice(&[0.0, 0.7, -1.4]);
//! }
//! let reference = Reference { q: q.clone(), v: rest.clone(), a: rest.clone() };
//! control.add_task(Objective::Posture { reference, gains: PdGains::critical(100.0) }, 1.0)?;
//! let solution = control.solve(&q, &rest)?;
//! let carried: f64 = solution.forces.iter().map(|point| point.force[2]).sum();
//! assert!((carried - model.mass() * 9.81).abs() < 1e-6); // the feet carry the weight
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Sources: Escande, Mansard, Wieber, *Hierarchical quadratic programming*, Int. J. Robotics Research 33
//! (2014); Herzog, Rotella, Mason, Grimminger, Schaal, Righetti, *Momentum control with hierarchical inverse
//! dynamics on a torque-controlled humanoid*, Autonomous Robots 40 (2016).

mod contact;
mod controller;
mod error;
mod levels;
mod limits;
mod matrix;
mod objective;
mod problem;
mod program;
mod solution;
mod state;
mod task;

pub use contact::{ContactGeometry, HeldContact};
pub use controller::WholeBodyControl;
pub use error::WholeBodyError;
pub use limits::WholeBodyLimits;
pub use objective::{ALL_AXES, Objective, PdGains};
pub use program::WholeBodyProgram;
pub use solution::{ActiveLimit, ContactId, ContactPointForce, Limit, TaskId, WholeBodySolution};
