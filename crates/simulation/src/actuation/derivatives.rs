//! The derivatives of the forces by position, velocity and control.
//!
//! Those of a fluid are analytic ([`FluidForces::derivatives`](crate::FluidForces::derivatives)). The others
//! are central differences of sixth order (`difference`).

use robot_dynamics_core::{Model, integrate};
use robot_dynamics_description::check_length;

use super::Actuation;
use super::difference::{Column, DifferenceMemory, NEAR_KINK};
use super::workspace::ActuationWorkspace;

/// One-sided derivatives by a control that differ by more than this fraction belong to a bound of the control
/// or of a force.
const KINK: f64 = 1e-3;

/// The derivatives of [`Actuation::forces`]: row-major, one row for each degree of freedom.
#[derive(Debug)]
pub struct ActuationDerivatives<'a> {
    /// ∂τ/∂q, nv×nv, by the displacement of q (see `integrate`).
    pub by_position: &'a mut [f64],
    /// ∂τ/∂v, nv×nv.
    pub by_velocity: &'a mut [f64],
    /// ∂τ/∂u, with a column for each entry of u. If it is empty, it is not computed.
    pub by_control: &'a mut [f64],
}

impl Actuation {
    /// Writes the derivatives of [`forces`](Self::forces) by the displacement of q, by v and by u. At a kink,
    /// such as a bound of a force, the derivative by q or v is the mean of both sides, and that by a control
    /// is the one of larger controls. Cost: O(nv + nu) evaluations of the forces.
    ///
    /// ```
    /// use robot_dynamics::description::{ActuatorDescription, Transmission, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{Actuation, ActuationDerivatives};
    /// let mut robot = pendulum(2.0, 0.5);
    /// let servo = ActuatorDescription::new("servo", Transmission::joint("hinge", 1.0)).servo(100.0, 5.0);
    /// robot.actuators.push(servo);
    /// let model = Model::new(robot)?;
    /// let actuation = Actuation::new(&model)?;
    /// let [mut by_q, mut by_v, mut by_u] = [[0.0]; 3];
    /// let out = ActuationDerivatives {
    ///     by_position: &mut by_q,
    ///     by_velocity: &mut by_v,
    ///     by_control: &mut by_u,
    /// };
    /// // τ = 100 (u − q) − 5 v
    /// actuation.derivatives(&model, &mut actuation.workspace(), &[0.5], &[0.2], &[0.1], out);
    /// assert!((by_q[0] + 100.0).abs() < 1e-9 && (by_v[0] + 5.0).abs() < 1e-9 && (by_u[0] - 100.0).abs() < 1e-9);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn derivatives(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        q: &[f64],
        v: &[f64],
        out: ActuationDerivatives<'_>,
    ) {
        let ActuationDerivatives { by_position, by_velocity, by_control } = out;
        self.check(model, q, v, v);
        self.check_controls(u);
        check_length("the derivative by q", by_position.len(), model.nv * model.nv);
        check_length("the derivative by v", by_velocity.len(), model.nv * model.nv);
        if let Some(fluid) = &self.fluid {
            let memory = workspace.fluid.get_or_insert_with(|| fluid.workspace(model));
            fluid.derivatives(model, memory, q, v, by_position, by_velocity);
        } else {
            by_position.fill(0.0);
            by_velocity.fill(0.0);
        }
        self.add_derivatives_without_fluid(model, workspace, u, (q, v), (by_position, by_velocity));
        if !by_control.is_empty() {
            check_length("the derivative by u", by_control.len(), model.nv * u.len());
            self.derivatives_by_control(model, workspace, u, (q, v), by_control);
        }
    }

    /// Adds ∂τ/∂q and ∂τ/∂v of all forces but those of a fluid.
    pub(crate) fn add_derivatives_without_fluid(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        (q, v): (&[f64], &[f64]),
        (by_position, by_velocity): (&mut [f64], &mut [f64]),
    ) {
        let nv = model.nv;
        let mut memory = self.difference_memory(workspace, u, (q, v));
        let DifferenceMemory { way, q: moved, v: speed, column, .. } = &mut memory;
        let add = |matrix: &mut [f64], k: usize, derivative: &[f64]| {
            derivative.iter().enumerate().for_each(|(i, entry)| matrix[i * nv + k] += entry);
        };
        for k in 0..nv {
            column.differentiate(|by, forces| {
                way[k] = by;
                integrate(model, q, way, moved);
                self.forces_without_fluid(model, workspace, u, (moved, v), forces);
            });
            way[k] = 0.0;
            add(by_position, k, &column.derivative);
            column.differentiate(|by, forces| {
                speed[k] = v[k] + by;
                self.forces_without_fluid(model, workspace, u, (q, speed), forces);
            });
            speed[k] = v[k];
            add(by_velocity, k, &column.derivative);
        }
        workspace.differences = Some(memory);
    }

    /// Writes ∂τ/∂u, nv×u.len(). At a bound it is that of larger controls. Returns whether a control is at a
    /// bound.
    pub(crate) fn derivatives_by_control(
        &self,
        model: &Model,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        (q, v): (&[f64], &[f64]),
        by_control: &mut [f64],
    ) -> bool {
        let (mut is_at_bound, width) = (false, u.len());
        let mut memory = self.difference_memory(workspace, u, (q, v));
        let DifferenceMemory { u: control, column, way: middle, .. } = &mut memory;
        for k in 0..width {
            let mut at = |by: f64, forces: &mut [f64]| {
                control[k] = u[k] + by;
                self.forces_without_fluid(model, workspace, control, (q, v), forces);
            };
            let is_smooth = column.differentiate(&mut at);
            if !is_smooth {
                at(0.0, middle);
            }
            control[k] = u[k];
            for (i, derivative) in column.derivative.iter_mut().enumerate().filter(|_| !is_smooth) {
                let sides = [column.after[i] - middle[i], middle[i] - column.before[i]];
                let [up, down] = sides.map(|force| force / NEAR_KINK);
                if (up - down).abs() > KINK * up.abs().max(down.abs()).max(KINK) {
                    is_at_bound = true;
                    *derivative = up;
                }
            }
            column.derivative.iter().enumerate().for_each(|(i, entry)| by_control[i * width + k] = *entry);
        }
        workspace.differences = Some(memory);
        is_at_bound
    }

    /// The memory of a workspace, with the state. The displacement is zero.
    fn difference_memory(
        &self,
        workspace: &mut ActuationWorkspace,
        u: &[f64],
        (q, v): (&[f64], &[f64]),
    ) -> DifferenceMemory {
        let mut memory = workspace.differences.take().unwrap_or_default();
        let DifferenceMemory { way, q: moved, v: speed, u: control, column } = &mut memory;
        let Column { derivative, fourth_order, after, before } = column;
        for zeros in [way, derivative, fourth_order, after, before] {
            zeros.clear();
            zeros.resize(self.nv, 0.0);
        }
        for (own, given) in [(moved, q), (speed, v), (control, u)] {
            own.clear();
            own.extend_from_slice(given);
        }
        memory
    }
}
