//! Random states, for tests and examples.

use robot_dynamics_description::{CoordinateKind, random_quaternion};
use robot_dynamics_number::SplitMix64;

use crate::Model;

/// A state of a model, with an acceleration and a force.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomState {
    /// Positions, nq: angles in \[−π, π), lengths in \[−1, 1) m, unit quaternions.
    pub q: Vec<f64>,
    /// Velocities, nv, in \[−2, 2).
    pub v: Vec<f64>,
    /// Accelerations, nv, in \[−5, 5).
    pub a: Vec<f64>,
    /// Generalized forces, nv, in \[−10, 10).
    pub tau: Vec<f64>,
}

/// A random state. It ignores limits, because the laws of motion hold beyond them.
///
/// ```
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, check_configuration, random_state};
/// use robot_dynamics::number::SplitMix64;
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let state = random_state(&model, &mut SplitMix64::new(1));
/// check_configuration(&model, &state.q)?;
/// assert_eq!(state, random_state(&model, &mut SplitMix64::new(1))); // the same seed gives the same state
/// let tau = model.inverse_dynamics(&state.q, &state.v, &state.a)?;
/// let back = model.forward_dynamics(&state.q, &state.v, tau.as_slice())?;
/// assert!(back.iter().zip(&state.a).all(|(back, a)| (back - a).abs() < 1e-9)); // κ(M) times rounding
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn random_state(model: &Model, random: &mut SplitMix64) -> RandomState {
    let mut q = vec![0.0; model.nq()];
    for joint in model.joints() {
        let q = &mut q[joint.q()];
        if joint.nq == 0 {
            continue;
        }
        let positions = joint.kind.plain_positions();
        let (plain, quaternion) = q.split_at_mut(positions.len());
        for (x, position) in plain.iter_mut().zip(positions) {
            let reach = if position.kind == CoordinateKind::Length { 1.0 } else { std::f64::consts::PI };
            *x = random.uniform(-reach, reach);
        }
        if !quaternion.is_empty() {
            quaternion.copy_from_slice(&random_quaternion(random));
        }
    }
    let mut vector = |bound: f64| (0..model.nv()).map(|_| random.uniform(-bound, bound)).collect();
    RandomState { q, v: vector(2.0), a: vector(5.0), tau: vector(10.0) }
}
