//! The part that control laws of a frame share: Λ, the posture in the null space, and effort limits.

use robot_dynamics_core::{
    FrameId, Model, RandomState, ReferenceFrame, check_configuration, difference, frame_pose, frame_velocity,
    inverse_dynamics, random_state,
};
use robot_dynamics_description::{Pose, check_length};
use robot_dynamics_number::{SplitMix64, check_number};
use robot_dynamics_simulation::motion::simulate::{check_controller_input, check_torque};
use robot_dynamics_simulation::{ControllerError, SpatialAxis};

use super::effort_limits::EffortLimits;
use super::mobility::MOST_ROWS;
use super::{
    Damping, OperationalSpace, OperationalSpaceInputs, OperationalSpaceWorkspace, TaskDeviation, TaskTarget,
    operational_space_into,
};

/// A row is damped if its mobility independent of the others is below this fraction of its typical mobility.
const DAMPING: f64 = 1e-3;

/// The number of random configurations whose mean is the typical mobility.
const TRIALS: u64 = 8;

/// The command of a law: ẍ, and a further force f at the frame, for the rows of the target.
pub(super) struct FrameCommand {
    pub(super) acceleration: [f64; MOST_ROWS],
    pub(super) force: [f64; MOST_ROWS],
}

/// τ = JᵀF + (1 − JᵀJ̄ᵀ) τ₀ with F = Λ ẍ + μ + p + f and τ₀ = C v + g + M (kr (q\* ⊖ q) − kn v), scaled to
/// the effort limits.
#[derive(Clone, Debug)]
pub(super) struct FrameLaw {
    pub(super) frame: FrameId,
    /// The controlled rows, and the index of each among the rows of the target.
    rows: Vec<SpatialAxis>,
    places: Vec<usize>,
    /// A row that depends on the others at every pose, with its mobility.
    dependent: Option<ControllerError>,
    null_damping: f64,
    /// q\* and kr.
    posture: Option<(Vec<f64>, f64)>,
    workspace: OperationalSpaceWorkspace,
    space: OperationalSpace,
    pub(super) limits: EffortLimits,
    /// kr (q\* ⊖ q) − kn v.
    rest_acceleration: Vec<f64>,
    /// τ₀.
    rest_torque: Vec<f64>,
}

impl FrameLaw {
    /// A law for all rows of a target.
    pub(super) fn new<T: TaskTarget>(
        model: &Model,
        frame: FrameId,
        null_damping: f64,
    ) -> Result<Self, ControllerError> {
        check_number("the null damping", null_damping)?;
        let nv = model.nv();
        let mut law = Self {
            frame,
            rows: Vec::new(),
            places: Vec::new(),
            dependent: None,
            null_damping,
            posture: None,
            workspace: OperationalSpaceWorkspace::of_actuated(model),
            space: OperationalSpace::zeros(model, 0),
            limits: EffortLimits::new(model),
            rest_acceleration: vec![0.0; nv],
            rest_torque: vec![0.0; nv],
        };
        law.select_rows::<T>(model, T::ROWS);
        Ok(law)
    }

    /// Selects rows of the target.
    ///
    /// # Panics
    /// Panics if no row is given, if a row is given twice, or if a row is not among the target's.
    #[track_caller]
    pub(super) fn select_rows<T: TaskTarget>(&mut self, model: &Model, rows: &[SpatialAxis]) {
        assert!(!rows.is_empty(), "a task has at least one row");
        let place = |(index, row): (usize, &SpatialAxis)| {
            assert!(!rows[..index].contains(row), "the row `{}` is given twice", row.name());
            T::ROWS.iter().position(|own| own == row).unwrap_or_else(|| {
                let names: Vec<&str> = T::ROWS.iter().map(|row| row.name()).collect();
                panic!("the row `{}` is not among {}, which the reference has", row.name(), names.join(", "))
            })
        };
        self.places = rows.iter().enumerate().map(place).collect();
        self.rows = rows.to_vec();
        self.space = OperationalSpace::zeros(model, rows.len());
        self.dependent = self.measure_mobility(model);
    }

    /// Whether Λ was damped in the last call.
    pub(super) fn is_damped(&self) -> bool {
        self.workspace.scratch.damping.as_ref().is_some_and(|damping| damping.is_active)
    }

    /// Sets the typical mobility of the rows: its mean over random configurations. Returns the error of a row
    /// that depends on the others at each of them.
    fn measure_mobility(&mut self, model: &Model) -> Option<ControllerError> {
        let Self { workspace, space, rows, frame, .. } = self;
        let (mut typical, mut regular, mut dependent) = ([0.0; MOST_ROWS], false, None);
        workspace.scratch.damping = None;
        for seed in 0..TRIALS {
            let RandomState { q, v, .. } = random_state(model, &mut SplitMix64::new(seed));
            let inputs = OperationalSpaceInputs { q: &q, v: &v, frame: *frame, rows };
            match operational_space_into(model, workspace, inputs, space) {
                Ok(()) => regular = true,
                Err(error @ ControllerError::SingularPose { .. }) => dependent = Some(error),
                Err(_) => continue,
            }
            for (k, typical) in typical.iter_mut().enumerate().take(rows.len()) {
                *typical += workspace.scratch.mobility[k] / TRIALS as f64;
            }
        }
        workspace.scratch.damping = Some(Damping { fraction: DAMPING, typical, is_active: false });
        dependent.filter(|_| !regular)
    }

    /// Adds a spring to the posture q\* with kr.
    ///
    /// # Errors
    /// [`ControllerError`] if q\* is an invalid configuration, or kr is not finite.
    pub(super) fn set_posture(
        &mut self,
        model: &Model,
        posture: &[f64],
        stiffness: f64,
    ) -> Result<(), ControllerError> {
        check_configuration(model, posture)?;
        check_number("the posture's stiffness", stiffness)?;
        self.posture = Some((posture.to_vec(), stiffness));
        Ok(())
    }

    /// τ at a state, for the command that belongs to the deviation from the target.
    pub(super) fn torque<T: TaskTarget>(
        &mut self,
        model: &Model,
        (t, q, v): (f64, &[f64], &[f64]),
        target: impl FnOnce() -> T,
        command: impl FnOnce(&TaskDeviation, &Pose) -> Result<FrameCommand, ControllerError>,
        tau: &mut [f64],
    ) -> Result<(), ControllerError> {
        check_length("tau", tau.len(), model.nv());
        check_controller_input(model, t, q, v)?;
        if let Some(error) = &self.dependent {
            return Err(error.clone());
        }
        let inputs = OperationalSpaceInputs { q, v, frame: self.frame, rows: &self.rows };
        operational_space_into(model, &mut self.workspace, inputs, &mut self.space)?;
        let dynamics = &mut self.workspace.dynamics;
        let pose = frame_pose(model, dynamics, q, self.frame);
        let aligned = ReferenceFrame::LocalWorldAligned;
        let velocity = frame_velocity(model, dynamics, q, v, self.frame, aligned);
        let command = command(&target().deviation(&pose, &velocity)?, &pose)?;

        self.set_rest_torque(model, q, v)?;
        let Self { space, limits, rest_torque, workspace, places, .. } = self;
        let count = places.len();
        let (mut acceleration, mut force) = ([0.0; MOST_ROWS], [0.0; MOST_ROWS]);
        for (k, &place) in places.iter().enumerate() {
            (acceleration[k], force[k]) = (command.acceleration[place], command.force[place]);
        }
        space.torque_with_force(&acceleration[..count], &force, rest_torque, tau)?;
        if limits.allow(tau) {
            return Ok(());
        }
        let bias = &workspace.scratch.force;
        space.torque_with_posture(&[0.0; MOST_ROWS][..count], bias, &mut limits.hold)?;
        space.torque_with_force(&acceleration[..count], &force, bias, &mut limits.with_task)?;
        limits.scale(tau);
        Ok(())
    }

    /// τ₀ = C v + g + M (kr (q\* ⊖ q) − kn v).
    fn set_rest_torque(&mut self, model: &Model, q: &[f64], v: &[f64]) -> Result<(), ControllerError> {
        let rest = &mut self.rest_acceleration[..];
        match &self.posture {
            Some((posture, _)) => difference(model, q, posture, rest),
            None => rest.fill(0.0),
        }
        let spring = self.posture.as_ref().map_or(0.0, |(_, spring)| *spring);
        rest.iter_mut().zip(v).for_each(|(rest, v)| *rest = spring * *rest - self.null_damping * v);
        let OperationalSpaceWorkspace { dynamics, scratch } = &mut self.workspace;
        if let Some(part) = &scratch.part {
            part.clear_unactuated(rest);
        }
        inverse_dynamics(model, dynamics, q, v, rest, &mut self.rest_torque);
        if let Some(part) = &mut scratch.part {
            part.reduce(&mut self.rest_torque);
        }
        Ok(check_torque(&self.rest_torque)?)
    }
}
