//! Random configurations, which are the same on every machine.

use std::f64::consts::{PI, TAU};

use robot_dynamics_description::{CoordinateKind, Limits, Quaternion};
use robot_dynamics_number::SplitMix64;

use super::neutral;
use crate::Model;

/// A random configuration: coordinates uniform within their limits, rotations uniform over SO(3).
///
/// If one limit is absent, the range extends π (or 1 m for a slide) beyond the other limit. If both are
/// absent, it extends that far on both sides of 0. Positions of a floating joint are in \[−1, 1) m. Equal
/// seeds give equal configurations.
///
/// Rotations follow Shoemake, *Uniform random rotations*, Graphics Gems III (1992).
///
/// ```
/// use robot_dynamics::description::{Limits, pendulum};
/// use robot_dynamics::model::{Model, random_within_limits};
/// let mut robot = pendulum(2.0, 0.5);
/// robot.joints[0].limits = Limits::new(0.2, 0.3);
/// let (model, mut random) = (Model::new(robot)?, robot_dynamics::number::SplitMix64::new(7));
/// let draws: Vec<f64> = (0..1000).map(|_| random_within_limits(&model, &mut random)[0]).collect();
/// assert!(draws.iter().all(|q| (0.2..0.3).contains(q)));
/// let mean = draws.iter().sum::<f64>() / 1000.0; // uniform: 0.25, σ = 0.1/√12/√1000 ≈ 1e-3
/// assert!((mean - 0.25).abs() < 4e-3);
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
pub fn random_within_limits(model: &Model, random: &mut SplitMix64) -> Vec<f64> {
    let mut q = neutral(model);
    for joint in model.joints.iter().filter(|joint| joint.nq > 0) {
        let part = &mut q[joint.q()];
        let positions = joint.kind.plain_positions();
        let (plain, quaternion) = part.split_at_mut(positions.len());
        for (x, position) in plain.iter_mut().zip(positions) {
            let reach = if position.kind == CoordinateKind::Length { 1.0 } else { PI };
            // Limits of a joint with a quaternion do not apply to entries of q.
            let limits = if quaternion.is_empty() { joint.limits } else { Limits::default() };
            let (low, high) = range(&limits, reach);
            *x = random.uniform(low, high);
        }
        if !quaternion.is_empty() {
            quaternion.copy_from_slice(&random_rotation(random).to_xyzw());
        }
    }
    q
}

/// The range of the limits; `reach` replaces an absent one.
fn range(limits: &Limits, reach: f64) -> (f64, f64) {
    match (limits.lower.is_finite(), limits.upper.is_finite()) {
        // A file may have them in the wrong order.
        (true, true) => {
            let (low, high) = (limits.lower.min(limits.upper), limits.lower.max(limits.upper));
            // Some files write the largest numbers for no limit, which leaves no finite range.
            if (high - low).is_finite() { (low, high) } else { (-reach, reach) }
        }
        (true, false) => (limits.lower, limits.lower + reach),
        (false, true) => (limits.upper - reach, limits.upper),
        (false, false) => (-reach, reach),
    }
}

/// Two uniform angles and a uniform squared radius give a uniform point of the unit sphere of R⁴.
fn random_rotation(random: &mut SplitMix64) -> Quaternion {
    let squared = random.uniform(0.0, 1.0);
    let (sine_a, cosine_a) = random.uniform(0.0, TAU).sin_cos();
    let (sine_b, cosine_b) = random.uniform(0.0, TAU).sin_cos();
    let (a, b) = ((1.0 - squared).sqrt(), squared.sqrt());
    Quaternion::from_xyzw([a * sine_a, a * cosine_a, b * sine_b, b * cosine_b]).normalized()
}
