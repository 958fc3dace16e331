//! The quantities of actuators, tendons and springs that sensors measure.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;

use super::law::within;
use super::pose_spring::PoseSpring;
use super::transmission::Drive;
use super::{Actuation, ActuationWorkspace};

impl Actuation {
    /// Returns τ of actuators with known forces before their gears \[N·m or N\], nv entries. It includes the
    /// carried weight if that comes from them, and is within the bounds of the joints.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.actuators.push(ActuatorDescription::new("motor", Transmission::joint("hinge", 50.0)));
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let mut tau = [0.0];
    /// actuation.torques_of_forces(&model, &mut actuation.workspace(), &[0.3], &[0.0], &mut tau);
    /// assert_eq!(tau, [50.0 * 0.3]);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn torques_of_forces(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        forces: &[f64],
        q: &[f64],
        tau: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the actuation");
        check_length("q", q.len(), model.nq);
        check_length("tau", tau.len(), model.nv);
        check_length("the forces", forces.len(), self.actuators.len());
        self.carry(workspace, q);
        self.place_tendons(workspace, q);
        tau.fill(0.0);
        for ((_, drive), &force) in self.actuators.iter().zip(forces) {
            drive.spread(model, &self.tendons, &mut workspace.transmissions, q, force, tau);
        }
        for &k in &self.by_actuators {
            tau[k] += workspace.weight[k];
        }
        for &(k, range) in &self.bounded {
            tau[k] = within(tau[k], range);
        }
    }

    /// ℓ and ℓ̇ of a spatial tendon by its number among these.
    pub(crate) fn path_length_and_rate(
        &self,
        workspace: &mut ActuationWorkspace,
        tendon: usize,
        (q, v): (&[f64], &[f64]),
    ) -> (f64, f64) {
        self.place_tendons(workspace, q);
        let memory = workspace.transmissions.spatial.as_ref();
        memory.map_or((0.0, 0.0), |memory| (memory.length(tendon), memory.rate(tendon, v)))
    }

    /// ℓ and ℓ̇ of an actuator's transmission.
    pub(crate) fn length_and_rate(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        actuator: usize,
        state: (&[f64], &[f64]),
    ) -> (f64, f64) {
        self.place_tendons(workspace, state.0);
        self.actuators[actuator].1.length_and_rate(model, &self.tendons, &mut workspace.transmissions, state)
    }

    /// Returns ℓ \[m or rad\] and ℓ̇ of each actuator's transmission, in the description's order.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// // The pendulum is a crank of 0.5 m, and the slider's axis is vertical.
    /// let mut robot = pendulum(2.0, 0.5);
    /// let (crank, slider) = ("tip".to_owned(), "ceiling".to_owned());
    /// let transmission = Transmission::SliderCrank { crank, slider, rod_length: 1.3, gear: 1.0 };
    /// robot.actuators.push(ActuatorDescription::new("press", transmission));
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let (mut length, mut rate) = ([0.0], [0.0]);
    /// let state = (&[0.0][..], &[1.0][..]); // the crank is level
    /// actuation.actuator_lengths(&model, &mut actuation.workspace(), state, &mut length, &mut rate);
    /// assert!((length[0] + 1.2).abs() < 1e-15 && (rate[0].abs() - 0.5).abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model belongs to another robot.
    #[track_caller]
    pub fn actuator_lengths(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        (q, v): (&[f64], &[f64]),
        lengths: &mut [f64],
        rates: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the actuation");
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), model.nv);
        check_length("the lengths", lengths.len(), self.actuators.len());
        check_length("the rates", rates.len(), self.actuators.len());
        for (k, (length, rate)) in lengths.iter_mut().zip(rates).enumerate() {
            (*length, *rate) = self.length_and_rate(model, workspace, k, (q, v));
        }
    }

    /// Returns ℓ of all tendons \[m or rad\], and their Jacobian ∂ℓ̇/∂v by rows, one row of nv entries a
    /// tendon. Tendons over joints come first, then spatial tendons, each in the description's order.
    ///
    /// ```
    /// use robot_dynamics::description::{SpatialTendonDescription, TendonPathElement, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::Actuation;
    /// // A cable from the pivot of a pendulum to its tip is always as long as the rod.
    /// let mut robot = pendulum(2.0, 0.5);
    /// let ends = ["ceiling", "tip"].map(|frame| TendonPathElement::Point { frame: frame.into() });
    /// robot.spatial_tendons.push(SpatialTendonDescription::new("cable", ends));
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let (mut length, mut jacobian) = ([0.0], [1.0]);
    /// actuation.tendon_lengths(&model, &mut actuation.workspace(), &[0.7], &mut length, &mut jacobian);
    /// assert!((length[0] - 0.5).abs() < 1e-15 && jacobian[0].abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model belongs to another robot.
    #[track_caller]
    pub fn tendon_lengths(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        q: &[f64],
        lengths: &mut [f64],
        jacobian: &mut [f64],
    ) {
        model.check_identity(&self.robot, "the actuation");
        check_length("q", q.len(), model.nq);
        let over_joints = model.description().tendons.len();
        let count = over_joints + model.description().spatial_tendons.len();
        check_length("the lengths", lengths.len(), count);
        check_length("the Jacobian", jacobian.len(), count * model.nv);
        self.place_tendons(workspace, q);
        jacobian.fill(0.0);
        for (k, length) in lengths.iter_mut().enumerate() {
            let row = &mut jacobian[k * model.nv..(k + 1) * model.nv];
            if k < over_joints {
                *length = self.tendons[k].length.at(q);
                self.tendons[k].length.spread(1.0, row);
            } else if let Some(memory) = &workspace.transmissions.spatial {
                *length = memory.length(k - over_joints);
                row.copy_from_slice(memory.row(k - over_joints));
            }
        }
    }

    /// The sum of the actuators' forces on a spatial tendon by its number among these, before their gears.
    pub(crate) fn force_on_path(&self, tendon: usize, forces: &[f64]) -> f64 {
        self.force_on_tendon(self.tendons.len() + tendon, forces)
    }

    /// The sum of the actuators' forces on a tendon by its number, before their gears.
    pub(crate) fn force_on_tendon(&self, tendon: usize, forces: &[f64]) -> f64 {
        let on_it = |drive: &Drive| self.driven_tendon(drive) == Some(tendon);
        self.actuators.iter().zip(forces).filter(|((_, drive), _)| on_it(drive)).map(|(_, force)| force).sum()
    }

    /// The energy of tendons' springs, of springs of ball and floating joints, and of nonlinear terms \[J\].
    pub(crate) fn spring_energy(&self, workspace: &mut ActuationWorkspace, q: &[f64]) -> f64 {
        let tendons: f64 = self.tendons.iter().map(|tendon| tendon.law.energy(tendon.length.at(q))).sum();
        self.place_tendons(workspace, q);
        let along_paths = match (&self.spatial, &workspace.transmissions.spatial) {
            (Some(spatial), Some(memory)) => spatial.energy(memory),
            _ => 0.0,
        };
        tendons + along_paths + self.springs.iter().map(|spring: &PoseSpring| spring.energy(q)).sum::<f64>()
    }
}
