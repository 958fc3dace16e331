//! The derivative of the momentum correction.
//!
//! Degree of freedom j carries bodies with the mass m, the first moment m c and the momentum p. Its column is
//! (u, w) at a point o. The motion of its carrier there is (v, ω).
//!
//! ```text
//! ∂P/∂vⱼ = m u + w × m(c − o),
//! ∂P/∂qⱼ = w × p − m(w × v + u × ω) − (w × ω) × m(c − o).
//! ```

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_core::model::WORLD;
use robot_dynamics_core::{Model, PARAMETERS_PER_LINK};

use super::super::joints::Joints;
use super::{FreeTranslations, Root, axis_of};
use crate::placement::Placement;

/// The derivatives of the target momenta, three rows of `width` columns for each free body.
#[derive(Debug)]
pub(in super::super) struct TargetChanges {
    width: usize,
    /// The first column of the inertial parameters, if there are any.
    inertial: Option<usize>,
    rows: Vec<f64>,
}

/// The derivatives of the momentum of a body with its subtree by the mass and the first moment of a link.
struct LinkMomentum {
    /// The link's place among the moving links.
    link: usize,
    by_mass: Vector3<f64>,
    by_moment: [Vector3<f64>; 3],
}

/// ∂P/∂q and ∂P/∂v of the momentum of a body with its subtree, one column per coordinate.
struct MomentumDerivatives {
    by_position: Vec<Vector3<f64>>,
    by_velocity: Vec<Vector3<f64>>,
}

impl FreeTranslations {
    /// The change of the momenta at the start by (δq, δv, …), the first two blocks of `width` columns.
    pub(in super::super) fn start_changes(
        &self,
        (model, placement): (&Model, &Placement),
        h: f64,
        v: &[f64],
        (width, inertial): (usize, Option<usize>),
    ) -> TargetChanges {
        let nv = model.nv;
        let mut rows = vec![0.0; self.roots.len() * 3 * width];
        for (root, rows) in self.roots.iter().zip(rows.chunks_exact_mut((3 * width).max(1))) {
            let by = root.momentum_derivatives(model, placement, v);
            for k in 0..nv {
                for i in 0..3 {
                    rows[i * width + k] = by.by_position[k][i];
                    rows[i * width + nv + k] = by.by_velocity[k][i];
                }
            }
            let Some(first) = inertial else { continue };
            let weight = Vector3::from(model.gravity()) * h;
            root.for_each_link(model, placement, v, |LinkMomentum { link, by_mass, by_moment }| {
                let first = first + PARAMETERS_PER_LINK * link;
                for i in 0..3 {
                    rows[i * width + first] += by_mass[i] + weight[i];
                    for (k, by_moment) in by_moment.iter().enumerate() {
                        rows[i * width + first + 1 + k] += by_moment[i];
                    }
                }
            });
        }
        TargetChanges { width, inertial, rows }
    }

    /// Adds the change of `factor` times generalized impulses at the configuration q.
    pub(in super::super) fn add_changes(
        &self,
        model: &Model,
        (q, q_change): (&[f64], &[f64]),
        (impulse, impulse_change): (&[f64], &[f64]),
        factor: f64,
        targets: &mut TargetChanges,
    ) {
        let width = targets.width;
        for (root, rows) in self.roots.iter().zip(targets.rows.chunks_exact_mut((3 * width).max(1))) {
            let axes = root.axes(&model.bodies[root.body], q);
            for k in 0..root.count {
                let (axis, coordinate) = (axis_of(&axes, root.count, k), root.first + k);
                let own = &impulse_change[coordinate * width..(coordinate + 1) * width];
                for column in 0..width {
                    let turn = root.turn(&axes, q_change, width, column);
                    let change = (turn.cross(&axis) * impulse[coordinate] + axis * own[column]) * factor;
                    (0..3).for_each(|i| rows[i * width + column] += change[i]);
                }
            }
        }
    }

    /// Adds the change of the correction at the configuration q, which led from one velocity to the other.
    pub(in super::super) fn restore_changes(
        &self,
        (model, placement): (&Model, &Placement),
        joints: &Joints,
        (q, q_change): (&[f64], &[f64]),
        (v_before, v_after): (&[f64], &[f64]),
        targets: &TargetChanges,
        v_change: &mut [f64],
    ) {
        let width = targets.width;
        let before = v_change.to_vec();
        for (root, rows) in self.roots.iter().zip(targets.rows.chunks_exact((3 * width).max(1))) {
            let coordinates = root.first..root.first + root.count;
            if coordinates.clone().any(|k| joints.resists(k)) {
                continue;
            }
            let by = root.momentum_derivatives(model, placement, v_before);
            let axes = root.axes(&model.bodies[root.body], q);
            let moves =
                |k: &usize| by.by_position[*k] != Vector3::zeros() || by.by_velocity[*k] != Vector3::zeros();
            let moving: Vec<usize> = (0..model.nv).filter(moves).collect();
            let mut missing = Vector3::zeros();
            for (k, coordinate) in coordinates.clone().enumerate() {
                missing += axis_of(&axes, root.count, k) * (v_after[coordinate] - v_before[coordinate]);
            }
            for column in 0..width {
                let mut change = Vector3::from_fn(|i, _| rows[i * width + column]);
                for &k in &moving {
                    change -= by.by_position[k] * q_change[k * width + column];
                    change -= by.by_velocity[k] * before[k * width + column];
                }
                let turn = root.turn(&axes, q_change, width, column);
                for (k, coordinate) in coordinates.clone().enumerate() {
                    let axis = axis_of(&axes, root.count, k);
                    v_change[coordinate * width + column] +=
                        axis.dot(&change) / root.mass + turn.cross(&axis).dot(&missing);
                }
            }
            let Some(first) = targets.inertial else { continue };
            root.for_each_link(model, placement, v_before, |LinkMomentum { link, by_mass, by_moment }| {
                let first = first + PARAMETERS_PER_LINK * link;
                for (k, coordinate) in coordinates.clone().enumerate() {
                    let axis = axis_of(&axes, root.count, k);
                    let to = &mut v_change[coordinate * width + first..][..4];
                    to[0] -= axis.dot(&(by_mass + missing)) / root.mass;
                    to[1..].iter_mut().zip(&by_moment).for_each(|(to, by)| *to -= axis.dot(by) / root.mass);
                }
            });
        }
    }
}

impl Root {
    /// The rotation of its axes by one column of a change of q.
    fn turn(&self, axes: &Matrix3<f64>, q_change: &[f64], width: usize, column: usize) -> Vector3<f64> {
        if self.count == 1 {
            return Vector3::zeros();
        }
        let angular = |k: usize| q_change[(self.first + 3 + k) * width + column];
        axes.column(0) * angular(0) + axes.column(1) * angular(1) + axes.column(2) * angular(2)
    }

    /// Calls `visit` with each link of the subtree.
    fn for_each_link(
        &self,
        model: &Model,
        placement: &Placement,
        v: &[f64],
        mut visit: impl FnMut(LinkMomentum),
    ) {
        let bodies = &model.bodies;
        let mut velocities = Vec::with_capacity(bodies.len());
        placement.velocities(model, v, &mut velocities);
        let (mut is_own, mut link) = (vec![false; bodies.len()], 0);
        for (i, body) in bodies.iter().enumerate() {
            is_own[i] = i == self.body || (body.parent != WORLD && is_own[body.parent]);
            // For joints of several degrees of freedom in series, the last body has the link.
            if bodies.get(i + 1).is_some_and(|next| next.link == body.link) {
                continue;
            }
            if is_own[i] {
                let [by_mass, spin] = velocities[i];
                let (rotation, _) = placement.body(i);
                let turn = body.body_from_link.rotation;
                let by_moment = core::array::from_fn(|k| {
                    let axis = Vector3::from_fn(|row, _| turn[row][k]);
                    spin.cross(&(rotation * axis))
                });
                visit(LinkMomentum { link, by_mass, by_moment });
            }
            link += 1;
        }
    }

    fn momentum_derivatives(&self, model: &Model, placement: &Placement, v: &[f64]) -> MomentumDerivatives {
        let bodies = &model.bodies;
        let mut velocities = Vec::with_capacity(bodies.len());
        placement.velocities(model, v, &mut velocities);
        // Mass, first moment about the world's origin, and momentum of each body with its subtree.
        let mut carried: Vec<(f64, Vector3<f64>, Vector3<f64>)> = bodies
            .iter()
            .enumerate()
            .map(|(i, body)| {
                let (rotation, origin) = placement.body(i);
                let [x, y, z, ..] = body.first_moment;
                let own = rotation * Vector3::new(x, y, z);
                let [velocity, spin] = velocities[i];
                (body.mass, origin * body.mass + own, velocity * body.mass + spin.cross(&own))
            })
            .collect();
        for i in (0..bodies.len()).rev().filter(|i| bodies[*i].parent != WORLD) {
            let (own, sum) = (carried[i], &mut carried[bodies[i].parent]);
            *sum = (sum.0 + own.0, sum.1 + own.1, sum.2 + own.2);
        }
        let zeros = || vec![Vector3::zeros(); model.nv];
        let (mut by_position, mut by_velocity) = (zeros(), zeros());
        let mut is_own = vec![false; bodies.len()];
        for (i, body) in bodies.iter().enumerate() {
            is_own[i] = i == self.body || (body.parent != WORLD && is_own[body.parent]);
            if !is_own[i] {
                continue;
            }
            let at = placement.origin(i);
            let [mut carrier, mut spin] = [Vector3::zeros(); 2];
            if body.parent != WORLD {
                [carrier, spin] = velocities[body.parent];
                carrier += spin.cross(&(at - placement.origin(body.parent)));
            }
            let (mass, moment, momentum) = carried[i];
            let about = moment - at * mass;
            placement.each_motion_on(model, [i, body.parent], at, |dof, u, w| {
                by_velocity[dof.coordinate] += (u * mass + w.cross(&about)) * dof.ratio;
                let bent = (w.cross(&carrier) + u.cross(&spin)) * mass + w.cross(&spin).cross(&about);
                by_position[dof.coordinate] += (w.cross(&momentum) - bent) * dof.ratio;
            });
        }
        MomentumDerivatives { by_position, by_velocity }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::{Model, Workspace, integrate, random_state};
    use robot_dynamics_description::{Base, RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::super::FreeTranslations;
    use crate::placement::Placement;

    /// Central differences with increments of 1e-6 have an error of 1e-12 times third derivatives, and
    /// rounding of 1e-10 of the momentum.
    #[test]
    fn momentum_has_its_derivatives() {
        let mut tested = 0;
        for seed in 0..12 {
            let options = RandomRobotOptions { base: Base::Floating, ..Default::default() };
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let mut translations = FreeTranslations::new(&model);
            let state = random_state(&model, &mut SplitMix64::new(seed));
            let (mut workspace, mut placement) = (Workspace::new(&model), Placement::new(&model));
            placement.set(&model, &mut workspace, &state.q);
            for index in 0..translations.roots.len() {
                tested += 1;
                let body = translations.roots[index].body;
                let by = translations.roots[index].momentum_derivatives(&model, &placement, &state.v);
                let mut momentum = |q: &[f64], v: &[f64]| {
                    translations.find_momenta(&model, &mut workspace, (q, v));
                    nalgebra::Vector3::from(translations.momenta[body])
                };
                for k in 0..model.nv {
                    const E: f64 = 1e-6;
                    let mut at = |by_q: f64, by_v: f64| {
                        let (mut way, mut q, mut v) = (vec![0.0; model.nv], state.q.clone(), state.v.clone());
                        way[k] = by_q;
                        v[k] += by_v;
                        integrate(&model, &state.q, &way, &mut q);
                        momentum(&q, &v)
                    };
                    let size = 1e-8 * (1.0 + at(0.0, 0.0).norm());
                    let by_q = (at(E, 0.0) - at(-E, 0.0)) / (2.0 * E);
                    let by_v = (at(0.0, E) - at(0.0, -E)) / (2.0 * E);
                    let off = (by_q - by.by_position[k]).norm().max((by_v - by.by_velocity[k]).norm());
                    assert!(off < size, "seed {seed}, coordinate {k}: {off:e} of {size:e}");
                }
            }
        }
        assert!(tested >= 12, "{tested}");
    }
}
