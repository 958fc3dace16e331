//! The checks of the input of pullbacks.

use robot_dynamics_core::{Model, SingularMass, Workspace, check_rank};
use robot_dynamics_integrators::IntegratorError;
use robot_dynamics_number::{InputProblem, InvalidInput, Scalar, Specialization, TypeFamily};

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
