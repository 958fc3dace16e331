//! The checks of the input of pullbacks.

use robot_dynamics_core::{Model, SingularMass, Workspace, check_rank};
use robot_dynamics_description::check_length;
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{InputProblem, InvalidInput, Scalar, Specialization, TypeFamily};

use super::cotangents::{MotionCotangents, TrajectoryCotangents};
use crate::motion::RobotState;

/// A slice of numbers of any type.
struct SliceInputs<'a>(core::marker::PhantomData<&'a ()>);

impl<'a> TypeFamily for SliceInputs<'a> {
    type Over<S: Scalar> = &'a [S];
}

/// A workspace and a configuration.
struct PositionInputs<'a>(core::marker::PhantomData<&'a ()>);

impl<'a> TypeFamily for PositionInputs<'a> {
    type Over<S: Scalar> = (&'a mut Workspace<S>, &'a [S]);
}

fn first_not_finite<T: Copy + Into<f64>>(numbers: &[T]) -> Option<(usize, f64)> {
    let mut numbers = numbers.iter().map(|&x| x.into()).enumerate();
    numbers.find(|(_, x)| !x.is_finite())
}

/// The first float that is not finite; numbers of other types are not checked.
fn bad_float<S: Scalar>(numbers: &[S]) -> Option<(usize, f64)> {
    match S::specialize::<SliceInputs<'_>>(numbers) {
        Specialization::F64(numbers) => first_not_finite(numbers),
        Specialization::F32(numbers) => first_not_finite(numbers),
        Specialization::Other(_) => None,
    }
}

/// Checks that the floats of an argument are finite.
pub(super) fn check_given<S: Scalar>(quantity: &'static str, numbers: &[S]) -> Result<(), InvalidInput> {
    bad_float(numbers).map_or(Ok(()), |(index, value)| {
        let problem = InputProblem::NotFinite { index: Some(index), coordinate: None, value };
        Err(InvalidInput::new(quantity, problem))
    })
}

/// Checks that computed floats are finite.
pub(super) fn check_floats<S: Scalar>(quantity: &'static str, numbers: &[S]) -> Result<(), IntegratorError> {
    bad_float(numbers).map_or(Ok(()), |(index, _)| Err(IntegratorError::NotFinite { quantity, index }))
}

/// Checks that M is regular, for `f64`; for other types a singular M gives numbers that are not finite.
pub(super) fn check_mass<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
) -> Result<(), SingularMass> {
    match S::specialize::<PositionInputs<'_>>((workspace, q)) {
        Specialization::F64((workspace, q)) => check_rank(model, workspace, q),
        Specialization::F32(_) | Specialization::Other(_) => Ok(()),
    }
}

/// Checks the lengths of a rollout's arguments, q and v apart.
///
/// # Panics
/// If a slice has the wrong length.
#[track_caller]
pub(super) fn check_rollout_lengths<S>(
    nv: usize,
    (steps, samples): (usize, usize),
    tau: &[S],
    trajectory: &TrajectoryCotangents<'_, S>,
    cotangents: &MotionCotangents<'_, S>,
) {
    let is_held = tau.is_empty() || tau.len() == nv;
    check_length("tau", tau.len(), if is_held { tau.len() } else { steps * nv });
    check_length("the cotangent of the trajectory's q", trajectory.by_position.len(), samples * nv);
    check_length("the cotangent of the trajectory's v", trajectory.by_velocity.len(), samples * nv);
    check_length("the cotangent of q", cotangents.by_position.len(), nv);
    check_length("the cotangent of v", cotangents.by_velocity.len(), nv);
    check_length("the cotangent of tau", cotangents.by_force.len(), tau.len());
}

/// Checks that the floats of a rollout's arguments are finite.
pub(super) fn check_rollout_floats<S: Scalar>(
    RobotState { q, v }: RobotState<'_, S>,
    tau: &[S],
    trajectory: &TrajectoryCotangents<'_, S>,
    cotangents: &MotionCotangents<'_, S>,
) -> Result<(), InvalidInput> {
    for (quantity, numbers) in [
        ("q", q),
        ("v", v),
        ("tau", tau),
        ("the cotangent of the trajectory's q", trajectory.by_position),
        ("the cotangent of the trajectory's v", trajectory.by_velocity),
        ("the cotangent of q", &*cotangents.by_position),
        ("the cotangent of v", &*cotangents.by_velocity),
    ] {
        check_given(quantity, numbers)?;
    }
    Ok(())
}
