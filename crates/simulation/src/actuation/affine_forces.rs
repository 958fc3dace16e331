//! The forces of actuators as affine functions of their controls.

use robot_dynamics_core::Model;
use robot_dynamics_description::{Activation, ActuatorDescription, check_length};
use robot_dynamics_number::InvalidInput;

use super::Actuation;
use super::law::within;
use super::transmission::Drive;
use super::workspace::ActuationWorkspace;

/// The forces of actuators at a state: τ = R f + c with f = diag(g) u + o, within bounds of f.
#[derive(Debug)]
pub struct AffineForces<'a> {
    /// R, nv×nu, row-major: ∂ℓ̇/∂v transposed.
    pub moments: &'a mut [f64],
    /// g, nu.
    pub gains: &'a mut [f64],
    /// o, nu.
    pub offsets: &'a mut [f64],
    /// The bounds of f, nu: those of the force, and those of the control at this state.
    pub ranges: &'a mut [[f64; 2]],
    /// c, nv: the carried weight that comes from the actuators, and cogging.
    pub constant: &'a mut [f64],
}

impl Actuation {
    /// Checks that every actuator's force is an affine function of its control, or of its activation at rest.
    /// The force of an electric motor is the torque that its controller requests.
    ///
    /// # Errors
    /// [`InvalidInput`] with the first actuator that has an integral term, takes a voltage at the terminals
    /// of its motor, adds to another, integrates its control, or pulls at contacts.
    pub fn check_affine(&self) -> Result<(), InvalidInput> {
        let problem = |actuator: &ActuatorDescription, drive: &Drive| match actuator {
            own if own.at_terminals => Some("takes the voltage at the terminals of a motor"),
            own if own.integral.is_some() => Some("has an integral term"),
            own if own.adds_to.is_some() => Some("adds to another actuator"),
            own if own.activation == Activation::Integrator => Some("integrates its control"),
            _ if matches!(drive, Drive::Contacts { .. }) => Some("pulls at contacts"),
            _ => None,
        };
        for (actuator, drive) in &self.actuators {
            if let Some(problem) = problem(actuator, drive) {
                let requirement = format!("{problem}; its force is not an affine function of the control");
                return Err(InvalidInput::unmet(format!("actuator `{}`", actuator.name), requirement));
            }
        }
        Ok(())
    }

    /// Writes the affine functions at (q, v), for actuators that pass [`check_affine`](Self::check_affine). The
    /// bounds of an electric motor are those of its current and voltage at this speed and at ambient
    /// temperature, without changes of its current and without its friction. The bounds that joints and
    /// tendons put on the sum of several actuators are left out.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Actuation, AffineForces};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 50.0)).servo(2.0, 0.1);
    /// robot.actuators.push(servo);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let ([mut moments, mut gains, mut offsets, mut constant], mut ranges) = ([[0.0]; 4], [[0.0; 2]]);
    /// let out = AffineForces {
    ///     moments: &mut moments,
    ///     gains: &mut gains,
    ///     offsets: &mut offsets,
    ///     ranges: &mut ranges,
    ///     constant: &mut constant,
    /// };
    /// // f = 2 (u − ℓ) − 0.1 ℓ̇ with ℓ = 50 q, and τ = 50 f
    /// actuation.affine_forces(&model, &mut actuation.workspace(), &[0.2], &[0.4], out);
    /// assert_eq!((moments, gains, offsets, constant), ([50.0], [2.0], [-2.0 * 10.0 - 0.1 * 20.0], [0.0]));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// If a slice has the wrong length, or the model belongs to another robot.
    #[track_caller]
    pub fn affine_forces(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        q: &[f64],
        v: &[f64],
        out: AffineForces<'_>,
    ) {
        let AffineForces { moments, gains, offsets, ranges, constant } = out;
        let (nv, nu) = (model.nv(), self.actuators.len());
        self.check(model, q, v, constant);
        check_length("the moments", moments.len(), nv * nu);
        for (name, length) in
            [("the gains", gains.len()), ("the offsets", offsets.len()), ("the ranges", ranges.len())]
        {
            check_length(name, length, nu);
        }
        self.place_tendons(workspace, q);
        for (k, (actuator, drive)) in self.actuators.iter().enumerate() {
            let column = &mut *constant;
            column.fill(0.0);
            drive.spread(model, &self.tendons, &mut workspace.transmissions, q, 1.0, column);
            for i in 0..nv {
                moments[i * nu + k] = column[i];
            }
            let (length, rate) =
                drive.length_and_rate(model, &self.tendons, &mut workspace.transmissions, (q, v));
            offsets[k] = actuator.unbounded_force(0.0, length, rate);
            gains[k] = actuator.unbounded_force(1.0, length, rate) - offsets[k];
            workspace.cogging[k] = actuator.cogging.map_or(0.0, |cogging| cogging.torque(length));
            ranges[k] = force_range(actuator, gains[k], offsets[k]);
            if let Some(motor) = &actuator.motor {
                let range = motor.torque_range(rate, 0.0);
                ranges[k] = ranges[k].map(|end| within(end, range));
            }
        }
        self.carry(workspace, q);
        constant.fill(0.0);
        for (i, constant) in constant.iter_mut().enumerate() {
            let row = &moments[i * nu..(i + 1) * nu];
            *constant = row.iter().zip(&workspace.cogging).map(|(moment, torque)| moment * torque).sum();
        }
        for &k in &self.by_actuators {
            constant[k] += workspace.weight[k];
        }
    }
}

/// The bounds of g u + o by those of the control, the activation and the force.
fn force_range(actuator: &ActuatorDescription, gain: f64, offset: f64) -> [f64; 2] {
    let [lower, upper] = actuator.control_range;
    let [least, most] = match actuator.activation {
        Activation::None => [lower, upper],
        _ => [lower.max(actuator.activation_range[0]), upper.min(actuator.activation_range[1])],
    };
    if gain == 0.0 {
        let force = within(offset, actuator.force_range);
        return [force, force];
    }
    let ends = [gain * least + offset, gain * most + offset];
    [ends[0].min(ends[1]), ends[0].max(ends[1])].map(|end| within(end, actuator.force_range))
}
