//! Rejects an invalid configuration q, and invalid vectors over the DoFs.

use robot_dynamics_number::{InputProblem, InvalidInput, are_finite};

use super::quaternion_at;
use crate::Model;

/// Checks that q has nq finite numbers and that its quaternions have unit length to within 1e-6.
///
/// Limits are not checked: a robot may violate them.
///
/// ```
/// use robot_dynamics::InputProblem;
/// use robot_dynamics::model::check_configuration;
/// # use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::Model;
/// # let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// assert_eq!(check_configuration(&model, &[0.0, 0.0, 0.0, 0.0, 0.0, 0.6, 0.8]), Ok(()));
/// let error = check_configuration(&model, &[0.0, 0.0, 0.0, 0.0, 0.0, 3.0, 4.0]).unwrap_err();
/// assert!(matches!(error.problem, InputProblem::NotAUnitQuaternion { first: 3, norm: 5.0, .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`InvalidInput`] names the number and the joint.
pub fn check_configuration(model: &Model, q: &[f64]) -> Result<(), InvalidInput> {
    if q.len() != model.nq {
        let hint = if model.nq > model.nv {
            "; a quaternion (x y z w) takes four, a floating base seven"
        } else {
            ""
        };
        return Err(wrong_length(model, "q", q.len(), model.nq, hint));
    }
    if !are_finite(q)
        && let Some(index) = q.iter().position(|x| !x.is_finite())
    {
        return Err(not_finite("q", index, joint_of(model, index), q[index]));
    }
    for &first in &model.quaternions {
        let norm = quaternion_at(q, first).norm();
        if (norm - 1.0).abs() > 1e-6 {
            let problem = InputProblem::NotAUnitQuaternion { first, joint: joint_of(model, first), norm };
            return Err(InvalidInput::new("q", problem));
        }
    }
    Ok(())
}

/// Checks that a vector over the DoFs, such as v, a or τ, has nv finite numbers.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, check_vector};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let error = check_vector(&model, "v", &[f64::NAN]).unwrap_err();
/// assert_eq!(error.to_string(), "v[0] (coordinate `hinge`) is NaN; every number must be finite");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`InvalidInput`] names the number and the coordinate.
pub fn check_vector(model: &Model, quantity: &str, x: &[f64]) -> Result<(), InvalidInput> {
    if x.len() != model.nv {
        return Err(wrong_length(model, quantity, x.len(), model.nv, ", one for each degree of freedom"));
    }
    if are_finite(x) {
        return Ok(());
    }
    match x.iter().position(|x| !x.is_finite()) {
        Some(index) => {
            let coordinate = model.coordinate_names().swap_remove(index);
            Err(not_finite(quantity, index, coordinate, x[index]))
        }
        None => Ok(()),
    }
}

fn wrong_length(
    model: &Model,
    quantity: &str,
    found: usize,
    expected: usize,
    hint: &'static str,
) -> InvalidInput {
    let owner = format!("robot `{}`", model.name());
    InvalidInput::new(quantity, InputProblem::WrongLength { found, expected, owner, hint })
}

fn not_finite(quantity: &str, index: usize, coordinate: String, value: f64) -> InvalidInput {
    let (index, coordinate) = (Some(index), Some(coordinate));
    InvalidInput::new(quantity, InputProblem::NotFinite { index, coordinate, value })
}

/// The name of the joint of this entry of q.
fn joint_of(model: &Model, index: usize) -> String {
    let owner = model.joints.iter().find(|joint| joint.q().contains(&index));
    owner.map_or_else(String::new, |joint| joint.name.clone())
}
