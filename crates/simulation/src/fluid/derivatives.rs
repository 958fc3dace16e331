//! The derivatives of the fluid's forces by position and by velocity, and the matrix of its damping.
//!
//! S_k is the motion of DoF k, and Bᶜ the derivative of the force Fᶜ on a subtree by its velocity. V is the
//! velocity of the body before joint k relative to the fluid. For a DoF m and the first body d that both
//! move,
//!
//! ```text
//! ∂τ_m/∂v_k = S_mᵀ Bᶜ_d S_k,   ∂τ_m/∂q_k = S_mᵀ (Bᶜ_d (V × S_k) + S_k ×* Fᶜ_k),
//! ```
//!
//! the last term only if the joint of k is beyond that of m. A rotation about S_k turns all beyond the joint
//! and their forces alike. It changes their velocities along their own axes by V × S_k, because the part that
//! comes from before the joint does not turn. Cost: O(n depth).

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use robot_dynamics_core::Model;
use robot_dynamics_core::kinematics::placement::motion_in_body;
use robot_dynamics_core::model::{Body, WORLD};
use robot_dynamics_core::spatial::transform::Transform;
use robot_dynamics_description::check_length;

use super::law::ShapeLaw;
use super::pair::Pair;
use super::{FluidForces, FluidWorkspace, PlacedShape, pair};

impl FluidForces {
    /// Writes the derivatives of [`forces`](Self::forces) by the displacement of q (see `integrate`) and by
    /// v, nv×nv, row-major. Cost: O(n depth).
    ///
    /// ```
    /// use robot_dynamics::description::{Medium, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::FluidForces;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.immerse(Medium::still(0.0, 9e-4));
    /// let model = Model::new(robot)?;
    /// let fluid = FluidForces::new(&model);
    /// let (memory, mut tau) = (&mut fluid.workspace(&model), [0.0]);
    /// let (mut by_position, mut by_velocity) = ([0.0], [0.0]);
    /// fluid.forces(&model, memory, &[0.3], &[2.0], &mut tau);
    /// fluid.derivatives(&model, memory, &[0.3], &[2.0], &mut by_position, &mut by_velocity);
    /// // Viscous drag is linear in v, and independent of the angle.
    /// assert!((by_velocity[0] * 2.0 - tau[0]).abs() < 1e-15 && by_position[0].abs() < 1e-15);
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    ///
    /// # Panics
    /// As [`forces`](Self::forces).
    #[track_caller]
    pub fn derivatives(
        &self,
        model: &Model,
        workspace: &mut FluidWorkspace,
        q: &[f64],
        v: &[f64],
        by_position: &mut [f64],
        by_velocity: &mut [f64],
    ) {
        let nv = model.nv;
        model.check_identity(&self.robot, "the fluid");
        check_length("q", q.len(), model.nq);
        check_length("v", v.len(), nv);
        check_length("the derivative by q", by_position.len(), nv * nv);
        check_length("the derivative by v", by_velocity.len(), nv * nv);
        self.compute(model, workspace, q, v);
        self.compute_composites(model, workspace, ShapeLaw::derivative);
        by_position.fill(0.0);
        by_velocity.fill(0.0);
        let memory = &*workspace;
        let add = |matrix: &mut [f64], row: usize, column: usize, entry: f64| {
            let (row, column) = (&model.dofs[row], &model.dofs[column]);
            matrix[row.coordinate * nv + column.coordinate] += row.ratio * column.ratio * entry;
        };
        for (i, body) in model.bodies.iter().enumerate() {
            let before = self.velocity_before(model, memory, i);
            let force: Pair =
                [memory.force[i].linear, memory.force[i].angular].map(|part| part.array().into());
            for k in 0..body.motion.nv() {
                let dof = body.dof + k;
                let own = column(body, k);
                let turned = motion_cross(&before, &own);
                let (by_v, by_q) = (memory.composite[i] * own, memory.composite[i] * turned);
                for m in 0..body.motion.nv() {
                    let other = column(body, m);
                    add(by_velocity, body.dof + m, dof, other.dot(&by_v));
                    add(by_position, body.dof + m, dof, other.dot(&by_q));
                }
                let carried = by_q + force_cross(&own, &force);
                for_each_ancestor(model, memory, i, [by_v, carried], |row, axis, [by_v, by_q]| {
                    add(by_velocity, row, dof, axis.dot(by_v));
                    add(by_position, row, dof, axis.dot(by_q));
                });
                // The row of this DoF, in the columns of its ancestors.
                let row = memory.composite[i].transpose() * own;
                for_each_ancestor(model, memory, i, [row], |ancestor, axis, [row]| {
                    add(by_velocity, dof, ancestor, axis.dot(row));
                    let before = self.velocity_before(model, memory, model.dofs[ancestor].body);
                    add(by_position, dof, ancestor, motion_cross(&before, axis).dot(row));
                });
            }
        }
    }

    /// Calls `add` with the entries of a symmetric positive semidefinite matrix, the part of −∂τ/∂v that the
    /// drag contributes: row, column ≤ row among coordinates, entry. The same entry may come in parts.
    pub(crate) fn for_each_damping(
        &self,
        model: &Model,
        workspace: &mut FluidWorkspace,
        (q, v): (&[f64], &[f64]),
        mut add: impl FnMut(usize, usize, f64),
    ) {
        self.move_bodies(model, workspace, q, v);
        self.compute_composites(model, workspace, ShapeLaw::damping);
        let memory = &*workspace;
        let mut add_dofs = |row: usize, column: usize, entry: f64| {
            let (one, other) = (&model.dofs[row], &model.dofs[column]);
            let (i, j) = (one.coordinate.max(other.coordinate), one.coordinate.min(other.coordinate));
            let entry = one.ratio * other.ratio * entry;
            // Two DoFs of one coordinate contribute by both of their off-diagonal entries.
            add(i, j, if i == j && row != column { 2.0 * entry } else { entry });
        };
        for (i, body) in model.bodies.iter().enumerate() {
            for k in 0..body.motion.nv() {
                let force = memory.composite[i] * column(body, k);
                for m in 0..=k {
                    add_dofs(body.dof + k, body.dof + m, column(body, m).dot(&force));
                }
                for_each_ancestor(model, memory, i, [force], |ancestor, axis, [force]| {
                    add_dofs(body.dof + k, ancestor, axis.dot(force));
                });
            }
        }
    }

    /// The sum of a derivative over each subtree, in the frame of its first body.
    fn compute_composites(
        &self,
        model: &Model,
        workspace: &mut FluidWorkspace,
        derivative: fn(&ShapeLaw, &Pair) -> Matrix6<f64>,
    ) {
        let FluidWorkspace { dynamics, velocity, composite, .. } = workspace;
        composite.clear();
        composite.resize(model.bodies.len(), Matrix6::zeros());
        for shape in &self.shapes {
            let PlacedShape { body, law, .. } = shape;
            let place = shape.place();
            let own = derivative(law, &pair(&motion_in_body(&place, &velocity[*body])));
            composite[*body] += in_parent(&place, &own);
        }
        for (i, body) in model.bodies.iter().enumerate().rev() {
            if body.parent != WORLD {
                let moved = in_parent(&dynamics.tree.bodies.place[i], &composite[i]);
                composite[body.parent] += moved;
            }
        }
    }

    /// The velocity before the joint of a body, relative to the fluid, in the body's frame.
    fn velocity_before(&self, model: &Model, memory: &FluidWorkspace, body: usize) -> Pair {
        let parent = model.bodies[body].parent;
        let parent = if parent == WORLD { self.of_base() } else { memory.velocity[parent] };
        pair(&motion_in_body(&memory.dynamics.tree.bodies.place[body], &parent))
    }
}

/// Calls `visit` with each DoF of the ancestors of a body, its motion, and the forces, all in the ancestor's
/// frame.
fn for_each_ancestor<const N: usize>(
    model: &Model,
    memory: &FluidWorkspace,
    mut body: usize,
    mut forces: [Vector6<f64>; N],
    mut visit: impl FnMut(usize, &Vector6<f64>, [&Vector6<f64>; N]),
) {
    while model.bodies[body].parent != WORLD {
        let place = &memory.dynamics.tree.bodies.place[body];
        forces = forces.map(|force| force_in_parent(place, &force));
        body = model.bodies[body].parent;
        let own = &model.bodies[body];
        for k in 0..own.motion.nv() {
            visit(own.dof + k, &column(own, k), forces.each_ref());
        }
    }
}

/// The motion of DoF k of a body, in the body's frame.
fn column(body: &Body, k: usize) -> Vector6<f64> {
    let mut rates = [0.0; 6];
    rates[k] = 1.0;
    let [linear, angular] = pair(&body.motion.velocity(&rates[..body.motion.nv()]));
    joined(linear, angular)
}

fn joined(linear: Vector3<f64>, angular: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(linear.x, linear.y, linear.z, angular.x, angular.y, angular.z)
}

fn parts(x: &Vector6<f64>) -> Pair {
    [x.fixed_rows::<3>(0).into_owned(), x.fixed_rows::<3>(3).into_owned()]
}

/// V × S.
fn motion_cross([u, w]: &Pair, s: &Vector6<f64>) -> Vector6<f64> {
    let [linear, angular] = parts(s);
    joined(w.cross(&linear) + u.cross(&angular), w.cross(&angular))
}

/// S ×* F.
fn force_cross(s: &Vector6<f64>, [force, moment]: &Pair) -> Vector6<f64> {
    let [u, w] = parts(s);
    joined(w.cross(force), w.cross(moment) + u.cross(force))
}

fn matrices(place: &Transform<f64>) -> (Matrix3<f64>, Vector3<f64>) {
    let rows = place.rotation.rows();
    (Matrix3::from_fn(|i, j| rows[i][j]), Vector3::from(place.translation.array()))
}

fn force_in_parent(place: &Transform<f64>, force: &Vector6<f64>) -> Vector6<f64> {
    let (turn, shift) = matrices(place);
    let [linear, angular] = parts(force);
    let linear = turn * linear;
    joined(linear, turn * angular + shift.cross(&linear))
}

/// Xᵀ B X, where X maps a motion of the parent to the body's frame.
fn in_parent(place: &Transform<f64>, derivative: &Matrix6<f64>) -> Matrix6<f64> {
    let (turn, shift) = matrices(place);
    let back = turn.transpose();
    let lever = -back * shift.cross_matrix();
    let mut motion = Matrix6::zeros();
    motion.fixed_view_mut::<3, 3>(0, 0).copy_from(&back);
    motion.fixed_view_mut::<3, 3>(0, 3).copy_from(&lever);
    motion.fixed_view_mut::<3, 3>(3, 3).copy_from(&back);
    motion.transpose() * derivative * motion
}
