//! Controls of actuators for given joint torques.

use std::borrow::Borrow;

use robot_dynamics_core::{Model, check_configuration, check_vector};
use robot_dynamics_description::{ActuatorDescription, MotorLoad, check_length};
use robot_dynamics_number::{InvalidInput, check_result};
use robot_dynamics_simulation::{Actuation, ActuationWorkspace, AffineForces, ControllerError};

use crate::quadratic_program::{DualActiveSet, RowBounds};

/// The weight of the size of the forces, relative to that of the torque.
const REGULARIZATION: f64 = 1e-8;

/// The passes after the first, each of which reduces the effect of the weight by itself.
const PASSES: usize = 2;

/// The controls u of a robot's actuators whose joint torque is nearest to a given τ:
///
/// > minimize ‖R f + c − τ‖² + ε ‖f‖²,  f = diag(g) u + o,  within the bounds of f and u
///
/// R contains gears, tendons and frames ([`Actuation::affine_forces`]). Redundant actuators share the torque
/// with the least sum of squares of f; ε only decides among equal torques. With τ = g(q) this is gravity
/// compensation through gears, and with the torque of a control law it drives that law's robot by its
/// actuators.
///
/// ```
/// use robot_dynamics::control::ControlAllocation;
/// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
/// use robot_dynamics::model::Model;
/// let mut robot = pendulum(2.0, 0.5);
/// let mut motor = ActuatorDescription::new("motor", Transmission::joint("hinge", 50.0));
/// motor.control_range = [-0.1, 0.1]; // N m before the gear
/// robot.actuators.push(motor);
/// let model = Model::new(robot)?;
/// let mut allocation = ControlAllocation::new(&model)?;
/// let weight = model.gravity_forces(&[1.3])?;
/// let mut controls = [0.0];
/// let residual = allocation.controls(&[1.3], &[0.0], weight.as_slice(), &mut controls)?;
/// assert!((controls[0] - weight[0] / 50.0).abs() < 1e-12 && residual.abs() < 1e-12);
/// // The horizontal rod needs 9.81 N m, and the motor has at most 5.
/// let weight = model.gravity_forces(&[0.0])?;
/// let residual = allocation.controls(&[0.0], &[0.0], weight.as_slice(), &mut controls)?;
/// assert!((controls[0].abs() - 0.1).abs() < 1e-12 && (residual - 4.81).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ControlAllocation<M> {
    model: M,
    actuation: Actuation,
    workspace: ActuationWorkspace,
    moments: Vec<f64>,
    gains: Vec<f64>,
    offsets: Vec<f64>,
    ranges: Vec<[f64; 2]>,
    constant: Vec<f64>,
    program: DualActiveSet,
    hessian: Vec<f64>,
    gradient: Vec<f64>,
    bounds: ForceBounds,
    force: Vec<f64>,
    /// ℓ̇ of each actuator.
    speeds: Vec<f64>,
}

/// The rows f of the program.
#[derive(Clone, Debug)]
struct ForceBounds {
    identity: Vec<f64>,
    lower: Vec<f64>,
    upper: Vec<f64>,
    scales: Vec<f64>,
}

impl<M: Borrow<Model>> ControlAllocation<M> {
    /// For the actuators of the robot's description. The model is an `Arc<Model>`, a `Model`, or a reference.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if an actuator's force is not an affine function of its control
    /// ([`Actuation::check_affine`]).
    pub fn new(robot: M) -> Result<Self, ControllerError> {
        let model: &Model = robot.borrow();
        let actuation =
            Actuation::new(model).map_err(|error| InvalidInput::unmet("the robot", error.to_string()))?;
        actuation.check_affine()?;
        let (nv, nu) = (model.nv(), model.description().actuators.len());
        let mut identity = vec![0.0; nu * nu];
        (0..nu).for_each(|k| identity[k * (nu + 1)] = 1.0);
        let zeros = || vec![0.0; nu];
        Ok(Self {
            workspace: actuation.workspace(),
            actuation,
            moments: vec![0.0; nv * nu],
            gains: zeros(),
            offsets: zeros(),
            ranges: vec![[0.0; 2]; nu],
            constant: vec![0.0; nv],
            program: DualActiveSet::new(nu),
            hessian: vec![0.0; nu * nu],
            gradient: zeros(),
            bounds: ForceBounds { identity, lower: zeros(), upper: zeros(), scales: vec![1.0; nu] },
            force: zeros(),
            speeds: zeros(),
            model: robot,
        })
    }

    /// Writes u, one entry for each actuator, for τ with nv entries \[N·m or N\] at (q, v), and returns the
    /// largest |R f + c − τ|. Entries of τ without an actuator, such as those of a floating base, count in
    /// it. It does not allocate after the first call.
    ///
    /// # Errors
    /// [`ControllerError::Motion`] if an argument is invalid, or a result overflows.
    ///
    /// # Panics
    /// Panics if `controls` has the wrong length.
    #[track_caller]
    pub fn controls(
        &mut self,
        q: &[f64],
        v: &[f64],
        tau: &[f64],
        controls: &mut [f64],
    ) -> Result<f64, ControllerError> {
        let model: &Model = self.model.borrow();
        check_configuration(model, q)?;
        check_vector(model, "v", v)?;
        check_vector(model, "tau", tau)?;
        let nu = self.gains.len();
        check_length("the controls", controls.len(), nu);
        let out = AffineForces {
            moments: &mut self.moments,
            gains: &mut self.gains,
            offsets: &mut self.offsets,
            ranges: &mut self.ranges,
            constant: &mut self.constant,
        };
        self.actuation.affine_forces(model, &mut self.workspace, q, v, out);
        self.speeds.fill(0.0);
        for (row, v) in self.moments.chunks_exact(nu.max(1)).zip(v) {
            self.speeds.iter_mut().zip(row).for_each(|(speed, moment)| *speed += moment * v);
        }
        self.constant.iter_mut().zip(tau).for_each(|(constant, tau)| *constant = tau - *constant);
        self.find_forces()?;
        for k in 0..nu {
            let control =
                if self.gains[k] == 0.0 { 0.0 } else { (self.force[k] - self.offsets[k]) / self.gains[k] };
            controls[k] = control;
        }
        check_result("the controls", &*controls)?;
        let missing = |(i, wanted): (usize, &f64)| {
            let row = &self.moments[i * nu..(i + 1) * nu];
            (row.iter().zip(&self.force).map(|(moment, force)| moment * force).sum::<f64>() - wanted).abs()
        };
        Ok(self.constant.iter().enumerate().map(missing).fold(0.0, f64::max))
    }

    /// f of the last call, one entry for each actuator \[N·m or N\], before gears.
    pub fn forces(&self) -> &[f64] {
        &self.force
    }

    /// The operation of each actuator's electric motor at the forces and the speed of the last call, at
    /// ambient temperature; `None` for an actuator without one.
    ///
    /// ```
    /// use robot_dynamics::control::ControlAllocation;
    /// use robot_dynamics::description::{ElectricMotor, MotorDrive, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let motor = ElectricMotor::from_data_sheet(1.2, 300.0, 24.0); // K = 0.08 N m/A, R = 1.6 Ω
    /// robot.add_motor("hinge", &MotorDrive::new(motor, 100.0, 2e-5))?;
    /// let model = Model::new(robot)?;
    /// let mut allocation = ControlAllocation::new(&model)?;
    /// // The torque of a motion by inverse dynamics, which includes the rotor's inertia:
    /// let (q, v, a) = ([0.0], [1.0], [2.0]);
    /// let tau = model.inverse_dynamics(&q, &v, &a)?;
    /// let residual = allocation.controls(&q, &v, tau.as_slice(), &mut [0.0])?;
    /// let load = allocation.motor_loads().next().flatten().expect("a motor");
    /// assert!(residual < 1e-9 && (load.current - tau[0] / 100.0 / 0.08).abs() < 1e-9);
    /// assert!((load.voltage - (1.6 * load.current + 0.08 * 100.0)).abs() < 1e-9);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn motor_loads(&self) -> impl Iterator<Item = Option<MotorLoad>> {
        let actuators = &self.model.borrow().description().actuators;
        let operation = |((actuator, force), speed): ((&ActuatorDescription, &f64), &f64)| {
            actuator.motor.map(|motor| motor.load(*force, *speed, 0.0))
        };
        actuators.iter().zip(&self.force).zip(&self.speeds).map(operation)
    }

    /// f of the program, with `constant` as the torque that R f has to reach.
    fn find_forces(&mut self) -> Result<(), ControllerError> {
        let Self { moments, constant, program, hessian, gradient, bounds, force, ranges, .. } = self;
        let nu = force.len();
        if nu == 0 {
            return Ok(());
        }
        hessian.fill(0.0);
        for row in moments.chunks_exact(nu) {
            for i in (0..nu).filter(|&i| row[i] != 0.0) {
                (0..=i).for_each(|j| hessian[i * nu + j] += row[i] * row[j]);
            }
        }
        let largest = (0..nu).map(|k| hessian[k * (nu + 1)]).fold(0.0, f64::max);
        let weight = if largest > 0.0 { REGULARIZATION * largest } else { 1.0 };
        (0..nu).for_each(|k| hessian[k * (nu + 1)] += weight);
        for k in 0..nu {
            [bounds.lower[k], bounds.upper[k]] = ranges[k];
        }
        let rows = RowBounds {
            matrix: &bounds.identity,
            lower: &bounds.lower,
            upper: &bounds.upper,
            scales: &bounds.scales,
        };
        let unsolved = |_| InvalidInput::unmet("the actuators", "have no forces for τ");
        program.set_hessian(nu, hessian).map_err(unsolved)?;
        force.fill(0.0);
        for _ in 0..=PASSES {
            // −Rᵀ(τ − c) − ε f₋: each pass starts from the forces and the rows of the last one.
            (0..nu).for_each(|k| gradient[k] = -weight * force[k]);
            for (row, wanted) in moments.chunks_exact(nu).zip(constant.iter()) {
                gradient.iter_mut().zip(row).for_each(|(entry, moment)| *entry -= moment * wanted);
            }
            program.solve(gradient, rows, force).map_err(unsolved)?;
            for k in 0..nu {
                force[k] = force[k].clamp(ranges[k][0], ranges[k][1]);
            }
        }
        Ok(())
    }
}
