//! The pullback of a rollout, of one state.

use dynamics::{Integrator, Method, Scalar};

use super::course::{Course, memory_size, pull_back};
use super::error::{PullbackError, check_floats, check_mass};
use super::stages::add;
use super::step::OneState;
use crate::derivatives::check_parameters;
use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::motion::integrate::check_step;
use crate::motion::integrate::explicit::most_stages;
use crate::{Model, Workspace, parameter_count};

/// How states move.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Rollout {
    /// A row with explicit stages.
    pub integrator: Integrator,
    /// One step \[s\].
    pub step: f64,
    /// How many steps.
    pub steps: usize,
    /// Whether the joints' damping and friction act.
    pub dissipation: bool,
    /// Every how many-th step goes into the trajectory; 0 for none.
    pub stride: usize,
}

impl Rollout {
    /// So many steps of that length \[s\], damping and friction acting, without a trajectory.
    ///
    /// ```
    /// use dynamics::Integrator;
    /// use multibody::Rollout;
    /// let second = Rollout::new(Integrator::RungeKutta4, 1e-3, 1000).with_stride(10);
    /// assert_eq!(second.samples(), 100);
    /// ```
    pub const fn new(integrator: Integrator, step: f64, steps: usize) -> Self {
        Self { integrator, step, steps, dissipation: true, stride: 0 }
    }

    /// Whether the joints' damping and friction act.
    pub const fn with_dissipation(self, dissipation: bool) -> Self {
        Self { dissipation, ..self }
    }

    /// With every `stride`-th step in the trajectory; 0 for none.
    pub const fn with_stride(self, stride: usize) -> Self {
        Self { stride, ..self }
    }

    /// States of one trajectory: those after every `stride`-th step.
    pub fn samples(&self) -> usize {
        self.steps.checked_div(self.stride).unwrap_or(0)
    }

    /// Steps between checkpoints: as asked for, or √steps, which needs the least memory.
    pub(crate) fn spacing(&self, asked: usize) -> usize {
        let least = self.steps.isqrt();
        let least = if least * least < self.steps { least + 1 } else { least };
        if asked == 0 { least.max(1) } else { asked.min(self.steps.max(1)) }
    }
}

/// Scratch for [`rollout_pullback`] of one kind of rollout on one model.
#[derive(Clone, Debug)]
pub struct RolloutPullbackWorkspace<S: Scalar = f64> {
    dynamics: Workspace<S>,
    steps: usize,
    spacing: usize,
    memory: Vec<S>,
    by_position: Vec<S>,
    by_velocity: Vec<S>,
    cotangent: Vec<S>,
    parameters: Vec<S>,
}

impl<S: Scalar> RolloutPullbackWorkspace<S> {
    /// Memory for this model and so many steps, with a checkpoint at every `spacing`-th: ⌈steps/spacing⌉ states, and `spacing`
    /// more with the accelerations of their stages. 0 stands for √steps, about the least; each step is then taken twice
    /// before its pullback. With `spacing` = steps everything is kept, and each is taken once.
    ///
    /// ```
    /// use multibody::{Model, Rollout, RolloutPullbackWorkspace, pendulum};
    /// # let integrator = dynamics::Integrator::RungeKutta4;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// let rollout = Rollout::new(integrator, 1e-3, 1_000_000).with_dissipation(false);
    /// assert_eq!(RolloutPullbackWorkspace::<f64>::new(&model, &rollout, 0).spacing(), 1000);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(model: &Model, rollout: &Rollout, spacing: usize) -> Self {
        let spacing = rollout.spacing(spacing);
        Self {
            dynamics: Workspace::new(model),
            steps: rollout.steps,
            spacing,
            memory: vec![S::zero(); memory_size(model, rollout, most_stages(), spacing)],
            by_position: vec![S::zero(); model.nv],
            by_velocity: vec![S::zero(); model.nv],
            cotangent: vec![S::zero(); 2 * model.nv],
            parameters: vec![S::zero(); parameter_count(model)],
        }
    }

    /// Steps between checkpoints.
    pub fn spacing(&self) -> usize {
        self.spacing
    }
}

/// One state's course: its forces and cotangents as tables.
struct Tables<'a, S> {
    /// Over all steps, or \[steps\]\[nv\]; none for none.
    tau: &'a [S],
    trajectory: (&'a [S], &'a [S]),
    by_force: &'a mut [S],
}

impl<S: Scalar> Course<S> for Tables<'_, S> {
    fn torque(&mut self, step: usize, tau: &mut [S]) {
        let n = tau.len();
        match self.tau.len() {
            0 => tau.fill(S::zero()),
            held if held == n => tau.copy_from_slice(self.tau),
            _ => tau.copy_from_slice(&self.tau[step * n..(step + 1) * n]),
        }
    }

    fn add_cotangents(&mut self, sample: usize, by_position: &mut [S], by_velocity: &mut [S]) {
        let rows = sample * by_position.len()..(sample + 1) * by_position.len();
        add(by_position, &self.trajectory.0[rows.clone()]);
        add(by_velocity, &self.trajectory.1[rows]);
    }

    fn take(&mut self, step: usize, by_force: &[S]) {
        let n = by_force.len();
        match self.by_force.len() {
            0 => {}
            held if held == n => add(self.by_force, by_force),
            _ => self.by_force[step * n..(step + 1) * n].copy_from_slice(by_force),
        }
    }

    fn go_on(&mut self, _: usize) -> bool {
        true
    }
}

/// The gradient of a loss through time: from its cotangents by the states of a rollout to those by the state at the
/// start, the forces and the parameters. No Jacobian is formed; the states that the way back needs are computed again from
/// the workspace's checkpoints. No allocation.
///
/// (`q`, `v`) is the state at the start. `tau` has nv numbers held over all steps, or \[steps\]\[nv\], or none. The loss's
/// gradients come in two places: `by_position` and `by_velocity` hold those by the state at the end, `trajectory` those by the
/// states after every `stride`-th step, \[samples\]\[nv\] each (empty without a stride); a state named in both counts twice.
/// `by_position` and `by_velocity` receive the cotangents of the state at the start, and `by_force`, of `tau`'s shape, those of the
/// forces. Cotangents of configurations have nv numbers, along the displacements of [`integrate`](crate::integrate()) there:
/// see [`cotangent_from_coordinates`](crate::cotangent_from_coordinates). `parameters` is empty or laid out as
/// [`ParameterCotangents`](crate::ParameterCotangents) says and **added** to.
/// On an error `by_position`, `by_velocity` and `parameters` are as they were.
///
/// ```
/// use dynamics::Integrator;
/// use multibody::{Model, Rollout, RolloutPullbackWorkspace, pendulum, rollout_pullback};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let integrator = Integrator::SemiImplicitEuler;
/// let rollout = Rollout::new(integrator, 0.01, 50).with_dissipation(false);
/// // The speed at the end, by the torques: each adds about h/(m l²) near the lowest point, where it hangs.
/// let w = &mut RolloutPullbackWorkspace::<f64>::new(&model, &rollout, 0);
/// let (tau, down) = (vec![0.0; 50], [std::f64::consts::FRAC_PI_2]);
/// let (mut by_q, mut by_v, mut by_tau) = ([0.0], [1.0], vec![0.0; 50]);
/// rollout_pullback(
///     &model, &rollout, w, &tau, &down, &[0.0], (&[], &[]), &mut by_q, &mut by_v, &mut by_tau, &mut [],
/// )?;
/// assert!((by_tau[49] - 0.01 / (2.0 * 0.25)).abs() < 1e-14 && by_tau[0] < by_tau[49]); // what came early swings back
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`PullbackError::Step`] where a float given or computed is not finite, or the step not positive;
/// [`PullbackError::SingularMass`] where M(q) is singular, with the joints' names (found beforehand in `f64`);
/// [`PullbackError::Implicit`] for the variational rows.
///
/// # Panics
/// If a slice has the wrong length, or the workspace is for another number of steps.
#[allow(clippy::too_many_arguments)] // a rollout's, with cotangents and results
#[track_caller]
pub fn rollout_pullback<S: Scalar>(
    model: &Model,
    rollout: &Rollout,
    workspace: &mut RolloutPullbackWorkspace<S>,
    tau: &[S],
    q: &[S],
    v: &[S],
    trajectory: (&[S], &[S]),
    by_position: &mut [S],
    by_velocity: &mut [S],
    by_force: &mut [S],
    parameters: &mut [S],
) -> Result<(), PullbackError> {
    check_step(rollout.step)?;
    let (w, nv) = (workspace, model.nv);
    w.dynamics.admit(model, q);
    check_length("the workspace's steps", w.steps, rollout.steps);
    check_length("v", v.len(), nv);
    let is_held = tau.is_empty() || tau.len() == nv;
    check_length("tau", tau.len(), if is_held { tau.len() } else { rollout.steps * nv });
    check_length("the cotangent of the trajectory's q", trajectory.0.len(), rollout.samples() * nv);
    check_length("the cotangent of the trajectory's v", trajectory.1.len(), rollout.samples() * nv);
    check_length("the cotangent of q", by_position.len(), nv);
    check_length("the cotangent of v", by_velocity.len(), nv);
    check_length("the cotangent of tau", by_force.len(), tau.len());
    check_parameters(model, parameters);
    let Method::Explicit(stages) = rollout.integrator.method() else {
        return Err(PullbackError::Implicit { integrator: rollout.integrator });
    };
    for (quantity, numbers) in [
        ("q", q),
        ("v", v),
        ("tau", tau),
        ("the cotangent of the trajectory's q", trajectory.0),
        ("the cotangent of the trajectory's v", trajectory.1),
        ("the cotangent of q", by_position),
        ("the cotangent of v", by_velocity),
    ] {
        check_floats(quantity, numbers)?;
    }
    check_mass(model, &mut w.dynamics, q)?;
    w.by_position.copy_from_slice(by_position);
    w.by_velocity.copy_from_slice(by_velocity);
    w.parameters.fill(S::zero());
    by_force.fill(S::zero());
    let mut tables = Tables { tau, trajectory, by_force };
    let own_parameters = &mut w.parameters[..parameters.len()];
    let cotangents = (&mut w.by_position[..], &mut w.by_velocity[..]);
    let way = (rollout, stages, w.spacing);
    let pullback = NativeFunction::step_pullback(rollout.integrator, rollout.dissipation);
    let accelerations = &mut OneState { workspace: &mut w.dynamics, pullback, cotangent: &mut w.cotangent };
    let sides = (accelerations, &mut tables);
    pull_back(model, way, sides, &mut w.memory, (q, v), cotangents, own_parameters);
    for (quantity, numbers) in [
        ("the cotangent of q at the start", &w.by_position[..]),
        ("the cotangent of v at the start", &w.by_velocity),
        ("the cotangent of tau", by_force),
        ("the cotangent of a parameter", &w.parameters),
    ] {
        check_floats(quantity, numbers)?;
    }
    by_position.copy_from_slice(&w.by_position);
    by_velocity.copy_from_slice(&w.by_velocity);
    add(parameters, &w.parameters[..parameters.len()]);
    Ok(())
}
