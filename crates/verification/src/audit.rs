//! An audit of one robot: checks of the laws of mechanics by independent computations, within the rounding of
//! each.
//!
//! | check | law |
//! | --- | --- |
//! | `mass_matrix`, `mass_columns` | M ≻ 0 and its condition; M eⱼ by inverse dynamics |
//! | `lagrange_…` | M, C v and g of the recursions against the Lagrange recipe |
//! | `gravity` | g = ∂V/∂q |
//! | `skew` | Ṁ − 2C skew-symmetric |
//! | `forward_inverse`, `forward_dynamics` | forward and inverse dynamics are inverse functions; accelerations by two methods |
//! | `power` | d/dt (K + V) = τ·v |
//! | `drift_…` | the drift of the energy of a free motion has each integrator's order |
//! | `inertia_triangle` | moments of inertia are those of a rigid body |

mod check;
mod drift;
mod forward_dynamics;
mod gravity;
mod inertia;
mod inverse_dynamics;
mod lagrange;
mod load;
mod mass_matrix;
mod power;
mod probe;
mod skew_symmetry;

pub use check::{Check, Verdict};

use robot_dynamics_core::Model;
use robot_dynamics_description::LoadReport;

use self::probe::Probe;

/// The default number of random states of an audit in the command and in Python.
pub const DEFAULT_STATES: u32 = 20;

/// The default seed of the random states of an audit in the command and in Python.
pub const DEFAULT_SEED: u64 = 1;

/// Checks a robot's dynamics against independent derivations at random states within its limits. Equal seeds
/// give equal states, and every check reports its worst state.
///
/// Two computations of the same number may differ by rounding. For sums this is 1e-12 of the largest term.
/// For the solution of M a = f it is the effect on a of 64 ε of each row's terms through M⁻¹ **(Skeel
/// 1979)**. If a robot is too ill-conditioned for any accuracy, the check of κ(M) itself fails. If M is
/// singular, accelerations are not checked. An arm with 20 states takes about ten milliseconds.
///
/// ```
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::verification::audit::{Verdict, audit};
/// let model = Model::new(random_robot(2, &RandomRobotOptions::default()))?;
/// let checks = audit(&model, 5, 1);
/// assert!(checks.iter().any(|check| check.name == "skew"));
/// assert!(checks.iter().all(|check| check.verdict == Verdict::Ok));
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
pub fn audit(model: &Model, states: u32, seed: u64) -> Vec<Check> {
    audit_against(model, model, states, seed)
}

/// [`audit`] with the second computation of each number on another robot with the same coordinates. It shows
/// how large a difference between the robots each check detects. The checks of M's condition, of moments of
/// inertia and of drift apply to `model` alone.
///
/// ```
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// use robot_dynamics::verification::audit::{Verdict, audit_against};
/// let robot = random_robot(2, &RandomRobotOptions::default());
/// let mut lighter = robot.clone();
/// lighter.gravity[2] *= 1.0 - 1e-6;
/// let checks = audit_against(&Model::new(robot)?, &Model::new(lighter)?, 5, 1);
/// let gravity = checks.iter().find(|check| check.name == "gravity");
/// assert!(gravity.is_some_and(|check| check.verdict == Verdict::Short));
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Panics
/// Panics if the robots have different numbers of coordinates.
#[track_caller]
pub fn audit_against(model: &Model, other: &Model, states: u32, seed: u64) -> Vec<Check> {
    let coordinates = |model: &Model| (model.nq, model.nv);
    assert_eq!(coordinates(model), coordinates(other), "two robots with different coordinates");
    let mut checks = Vec::new();
    checks.extend(inertia::triangle(model));
    if model.nv() == 0 {
        return checks;
    }
    let probe = Probe { reference: other, ..Probe::new(model, states, seed) };
    checks.extend(mass_matrix::checks(&probe));
    checks.extend(lagrange::checks(&probe));
    checks.push(gravity::gradient_of_potential(&probe));
    checks.push(skew_symmetry::defect(&probe));
    if probe.has_accelerations() {
        checks.push(inverse_dynamics::undoes_forward(&probe));
        checks.push(forward_dynamics::two_routes(&probe));
        checks.push(power::balance(&probe));
        checks.extend(drift::checks(&probe));
    }
    checks
}

/// Checks that the model includes all physics of a robot file.
///
/// ```
/// use robot_dynamics::description::LoadReport;
/// use robot_dynamics::verification::audit::{Verdict, ignored_physics};
/// assert_eq!(ignored_physics(&LoadReport::default()).verdict, Verdict::Ok);
/// ```
pub fn ignored_physics(report: &LoadReport) -> Check {
    load::ignored_physics(report)
}
