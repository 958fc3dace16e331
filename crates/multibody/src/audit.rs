//! The laws as checks of one robot: each route to a number against another, with what rounding may make of it.
//!
//! | check | law |
//! | --- | --- |
//! | `mass_matrix`, `mass_columns` | M ≻ 0 and its condition; M eⱼ by inverse dynamics |
//! | `lagrange_…` | M, C v and g of the recursions against the Lagrange recipe |
//! | `gravity` | g = ∂V/∂q |
//! | `skew` | Ṁ − 2C skew-symmetric |
//! | `forward_inverse`, `forward_dynamics` | the two dynamics undo each other; accelerations by two routes |
//! | `power` | d/dt (K + V) = τ·v |
//! | `drift_…` | the energy of a free motion keeps to each integrator's order |
//! | `inertia_triangle` | moments that a body can have |

mod check;
mod drift;
mod forward;
mod gravity;
mod inertia;
mod inverse;
mod lagrange;
mod load;
mod mass_matrix;
mod power;
mod probe;
mod skew;

pub use check::{Check, Verdict};

use self::probe::Probe;
use crate::{LoadReport, Model};

/// Checks a robot's dynamics against independent derivations, at random states within its limits, the same for equal
/// seeds; every check shows its worst state.
///
/// Two routes to the same number may differ by rounding: 1e-12 of the largest term where terms are added up, and of a solved equation
/// M a = f what 64 ε of each row's terms makes of a by M⁻¹ **(Skeel 1979)**. Where the numbers of a robot leave no
/// accuracy, κ(M) itself falls short, and where M is singular accelerations are not checked. Some ten milliseconds for
/// an arm and 20 states.
///
/// ```
/// use multibody::audit::{Verdict, audit};
/// use multibody::{Model, RandomRobotOptions, random_robot};
/// let model = Model::new(random_robot(2, &RandomRobotOptions::default()))?;
/// let checks = audit(&model, 5, 1);
/// assert!(checks.iter().any(|check| check.name == "skew"));
/// assert!(checks.iter().all(|check| check.verdict == Verdict::Ok));
/// # Ok::<(), multibody::ModelError>(())
/// ```
pub fn audit(model: &Model, states: u32, seed: u64) -> Vec<Check> {
    audit_against(model, model, states, seed)
}

/// [`audit`] with the second route to each number taken on another robot of the same coordinates: how large a
/// difference between the two each check sees. The checks of M's condition, of moments and of drift are of `model` alone.
///
/// ```
/// use multibody::audit::{Verdict, audit_against};
/// use multibody::{Model, RandomRobotOptions, random_robot};
/// let robot = random_robot(2, &RandomRobotOptions::default());
/// let mut lighter = robot.clone();
/// lighter.gravity[2] *= 1.0 - 1e-6;
/// let checks = audit_against(&Model::new(robot)?, &Model::new(lighter)?, 5, 1);
/// let gravity = checks.iter().find(|check| check.name == "gravity");
/// assert!(gravity.is_some_and(|check| check.verdict == Verdict::Short));
/// # Ok::<(), multibody::ModelError>(())
/// ```
///
/// # Panics
/// If the robots have different numbers of coordinates.
#[track_caller]
pub fn audit_against(model: &Model, other: &Model, states: u32, seed: u64) -> Vec<Check> {
    let coordinates = |model: &Model| (model.nq, model.nv);
    assert_eq!(coordinates(model), coordinates(other), "two robots with different coordinates");
    let mut checks = Vec::new();
    checks.extend(inertia::triangle(model));
    if model.nv() == 0 {
        return checks;
    }
    let probe = Probe { oracle: other, ..Probe::new(model, states, seed) };
    checks.extend(mass_matrix::checks(&probe));
    checks.extend(lagrange::checks(&probe));
    checks.push(gravity::slope_of_potential(&probe));
    checks.push(skew::defect(&probe));
    if probe.has_accelerations() {
        checks.push(inverse::undoes_forward(&probe));
        checks.push(forward::two_routes(&probe));
        checks.push(power::balance(&probe));
        checks.extend(drift::checks(&probe));
    }
    checks
}

/// Whether all physics of a robot file is in the model.
///
/// ```
/// use multibody::LoadReport;
/// use multibody::audit::{Verdict, ignored_physics};
/// assert_eq!(ignored_physics(&LoadReport::default()).verdict, Verdict::Ok);
/// ```
pub fn ignored_physics(report: &LoadReport) -> Check {
    load::ignored_physics(report)
}
