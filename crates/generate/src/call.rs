//! The library's algorithms over any number: the tracing one, and floats to compare with.

use dynamics::{Integrator, Method};
use multibody::{FrameId, FramePose, InstructionSet, Model, StepForces, StepStagesWorkspace, Workspace};
use number::Scalar;

use crate::function::Size;
use crate::{Function, GenerateError};

/// Computes a function's results, each row-major, from its arguments.
///
/// # Errors
/// [`GenerateError::NoSuchFrame`].
#[allow(clippy::type_complexity)] // numbers in, numbers out
pub(crate) fn call<S: Scalar>(
    function: &Function,
    model: &Model,
) -> Result<impl Fn(&[Vec<S>]) -> Vec<Vec<S>>, GenerateError> {
    let frame = function.frame().map(|name| model.frame_named(name)).transpose()?;
    Ok(move |arguments: &[Vec<S>]| {
        let size = |size: Size| size.of(model);
        let zeros =
            |(_, rows, columns, _): &(_, Size, Size, _)| vec![S::zero(); size(*rows) * size(*columns)];
        let mut results: Vec<Vec<S>> = function.results().iter().map(zeros).collect();
        let mut arguments: Vec<&[S]> = arguments.iter().map(Vec::as_slice).collect();
        arguments.resize(4, &[]);
        let memory = &mut Memory::new(function, model, InstructionSet::Portable);
        compute(function, model, frame, memory, &arguments, &mut results);
        results
    })
}

/// Scratch of the library's calls.
pub(crate) struct Memory<S: Scalar> {
    tree: Workspace<S>,
    step: Option<StepStagesWorkspace<S>>,
}

impl<S: Scalar> Memory<S> {
    pub(crate) fn new(function: &Function, model: &Model, limit: InstructionSet) -> Self {
        let step = function.integrator().map(|_| StepStagesWorkspace::limited(model, limit));
        Self { tree: Workspace::limited(model, limit), step }
    }
}

/// The function's results, four arguments given, those that it has not empty.
pub(crate) fn compute<S: Scalar>(
    function: &Function,
    model: &Model,
    frame: Option<FrameId>,
    memory: &mut Memory<S>,
    arguments: &[&[S]],
    results: &mut [Vec<S>],
) {
    let Memory { tree: w, step } = memory;
    let (x, y, z, l) = (arguments[0], arguments[1], arguments[2], arguments[3]);
    let (first, others) = results.split_at_mut(1);
    let one = &mut first[0][..];
    match function {
        Function::InverseDynamics => multibody::inverse_dynamics(model, w, x, y, z, one),
        Function::ForwardDynamics => multibody::forward_dynamics(model, w, x, y, z, one),
        Function::MassMatrix => multibody::mass_matrix(model, w, x, one),
        Function::MassMatrixRelated => {
            let (nv, mut mass) = (model.nv(), vec![S::zero(); model.nv() * model.nv()]);
            multibody::mass_matrix(model, w, x, &mut mass);
            let entries = multibody::mass_matrix_related_entries(model);
            entries.iter().zip(one).for_each(|(&(i, j), entry)| *entry = mass[i * nv + j]);
        }
        Function::MassMatrixFactor => multibody::mass_matrix_factor(model, w, x, one),
        Function::InverseMassMatrix => multibody::inverse_mass_matrix(model, w, x, one),
        Function::Bias => multibody::bias(model, w, x, y, one),
        Function::Gravity => multibody::gravity(model, w, x, one),
        Function::VelocityProduct => multibody::velocity_product(model, w, x, y, one),
        Function::CoriolisMatrix => multibody::coriolis_matrix(model, w, x, y, one),
        Function::Dissipation => multibody::dissipation(model, x, one),
        Function::KineticEnergy => one[0] = multibody::kinetic_energy(model, w, x, y),
        Function::PotentialEnergy => one[0] = multibody::potential_energy(model, w, x),
        Function::Momentum => multibody::momentum(model, w, x, y, one),
        Function::CenterOfMass => one.copy_from_slice(&multibody::center_of_mass(model, w, x)),
        Function::InverseDynamicsDerivatives => {
            let [two, three] = others else { unreachable!("three results") };
            multibody::inverse_dynamics_derivatives(model, w, x, y, z, one, two);
            multibody::mass_matrix(model, w, x, three);
        }
        Function::ForwardDynamicsDerivatives => {
            let [two, three] = others else { unreachable!("three results") };
            multibody::forward_dynamics_derivatives(model, w, x, y, z, one, two, three);
        }
        Function::InverseDynamicsPullback => {
            let [two, three] = others else { unreachable!("three results") };
            multibody::inverse_dynamics_pullback(model, w, x, y, z, l, one, two, three);
        }
        Function::ForwardDynamicsPullback => {
            let [two, three, four] = others else { unreachable!("four results") };
            multibody::forward_dynamics_pullback(model, w, x, y, z, l, one, two, three, four);
        }
        Function::JointTorqueRegressor => multibody::joint_torque_regressor(model, w, x, y, z, one),
        Function::SemiImplicitEulerStep | Function::Rk4Step => {
            let w = step.as_mut().expect("a step has its own");
            let Some(Method::Explicit(stages)) = function.integrator().map(Integrator::method) else {
                unreachable!("the rows that steps are generated of have explicit stages")
            };
            let forces = StepForces::new(z, true);
            multibody::step_stages(model, stages, w, &forces, l[0], (x, y), (one, &mut others[0]));
        }
        Function::FramePose(_) => {
            let FramePose { rotation, translation } = multibody::frame_pose(model, w, x, found(frame));
            one.copy_from_slice(rotation.as_flattened());
            others[0].copy_from_slice(&translation);
        }
        Function::FrameJacobianWorldAligned(_) => {
            multibody::frame_jacobian_world_aligned(model, w, x, found(frame), one);
        }
        Function::FrameJacobianInFrame(_) => {
            multibody::frame_jacobian_in_frame(model, w, x, found(frame), one);
        }
        Function::Derivatives(_) | Function::Pullback(_) => unreachable!("made of another's trace"),
    }
}

fn found(frame: Option<FrameId>) -> FrameId {
    frame.expect("a function of a frame has one")
}
