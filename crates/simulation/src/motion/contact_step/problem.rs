//! The problem of a step: the rows of contacts and joints in the coordinates √D L v, and the velocity without
//! multipliers.

use robot_dynamics_core::factorization::sparse::{dof_ancestors, factor};
use robot_dynamics_core::{Model, Workspace, bias, mass_matrix};
use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;

use super::{ContactStep, ContactStepInputs, JointRowKind, RETURN_TIME, positive_part};

/// Reads the table of a problem in order.
pub(super) struct Reader<'a, S> {
    rest: &'a [S],
}

impl<'a, S: Scalar> Reader<'a, S> {
    pub(super) fn new(problem: &'a [S]) -> Self {
        Self { rest: problem }
    }

    pub(super) fn one(&mut self) -> S {
        self.many(1)[0]
    }

    pub(super) fn many(&mut self, count: usize) -> &'a [S] {
        let (first, rest) = self.rest.split_at(count);
        self.rest = rest;
        first
    }
}

/// The factor of M + h D = LᵀDL, with 1/√D.
struct ScaledFactor<'a, S> {
    dof_parent: &'a [usize],
    lower: Vec<S>,
    inverse_roots: Vec<S>,
}

impl<S: Scalar> ScaledFactor<'_, S> {
    /// L_ki.
    fn entry(&self, k: usize, i: usize) -> S {
        self.lower[k * self.dof_parent.len() + i]
    }

    /// x ← D^-½ L⁻ᵀ x for an x with entries at k and its ancestors. Returns these, the last first.
    fn divided(&self, k: usize, mut x: Vec<S>) -> Vec<S> {
        let path = || core::iter::once(k).chain(dof_ancestors(self.dof_parent, k));
        for at in path() {
            for i in dof_ancestors(self.dof_parent, at) {
                let product = self.entry(at, i) * x[at];
                x[i] -= product;
            }
        }
        path().map(|at| x[at] * self.inverse_roots[at]).collect()
    }
}

impl ContactStep {
    /// The problem of a step, and √D L v of the velocity without multipliers. It does not read the
    /// multipliers of the inputs.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the step belongs to another robot.
    #[track_caller]
    pub fn prepare<S: Scalar>(
        &self,
        model: &Model,
        workspace: &mut Workspace<S>,
        inputs: &ContactStepInputs<'_, S>,
        problem: &mut [S],
        velocity: &mut [S],
    ) {
        model.check_identity(&self.robot, "the contact step");
        check_length("q", inputs.q.len(), model.nq());
        check_length("v", inputs.v.len(), model.nv());
        check_length("tau", inputs.tau.len(), model.nv());
        check_length("the problem", problem.len(), self.problem_count());
        let factor = self.factor(model, workspace, inputs);
        self.free_velocity(model, workspace, inputs, &factor, velocity);
        let mut numbers = Vec::with_capacity(problem.len());
        for k in 0..model.nv() {
            numbers.push(factor.inverse_roots[k]);
            numbers.extend(dof_ancestors(&self.dof_parent, k).map(|i| factor.entry(k, i)));
        }
        for row in &self.joints {
            let mut unit = vec![S::zero(); model.nv()];
            unit[row.coordinate] = S::one();
            let x = factor.divided(row.coordinate, unit);
            self.push_joint(inputs, row.kind, &x, &mut numbers);
        }
        let mut points = Vec::new();
        self.shapes.iter().for_each(|shape| shape.add_rows(model, workspace, inputs.q, &mut points));
        for (point, &k) in points.into_iter().zip(&self.point_coordinates) {
            let rows = point.rows.map(|row| factor.divided(k, row));
            self.push_contact(inputs.h, point.gap, &rows, &mut numbers);
        }
        numbers.push(inputs.friction);
        problem.copy_from_slice(&numbers);
    }

    fn factor<S: Scalar>(
        &self,
        model: &Model,
        workspace: &mut Workspace<S>,
        inputs: &ContactStepInputs<'_, S>,
    ) -> ScaledFactor<'_, S> {
        let nv = model.nv();
        let mut lower = vec![S::zero(); nv * nv];
        mass_matrix(model, workspace, inputs.q, &mut lower);
        for (k, &damping) in self.damping.iter().enumerate() {
            lower[k * nv + k] += inputs.h.scale(damping);
        }
        factor(&self.dof_parent, &mut lower);
        let inverse_roots = (0..nv).map(|k| S::one() / lower[k * nv + k].sqrt()).collect();
        ScaledFactor { dof_parent: &self.dof_parent, lower, inverse_roots }
    }

    /// √D L v without multipliers: √D L v₀ + D^-½ L⁻ᵀ h(τ − C v − g − D v).
    fn free_velocity<S: Scalar>(
        &self,
        model: &Model,
        workspace: &mut Workspace<S>,
        inputs: &ContactStepInputs<'_, S>,
        factor: &ScaledFactor<'_, S>,
        velocity: &mut [S],
    ) {
        let (nv, v) = (model.nv(), inputs.v);
        check_length("the velocity", velocity.len(), nv);
        let mut force = vec![S::zero(); nv];
        bias(model, workspace, inputs.q, v, &mut force);
        for k in 0..nv {
            force[k] = inputs.h * (inputs.tau[k] - force[k] - v[k].scale(self.damping[k]));
        }
        for k in (0..nv).rev() {
            for i in dof_ancestors(&self.dof_parent, k) {
                let product = factor.entry(k, i) * force[k];
                force[i] -= product;
            }
        }
        for k in 0..nv {
            let ancestors = dof_ancestors(&self.dof_parent, k);
            let combined = ancestors.fold(v[k], |sum, i| sum + factor.entry(k, i) * v[i]);
            let inverse_root = factor.inverse_roots[k];
            velocity[k] = combined / inverse_root + force[k] * inverse_root;
        }
    }

    /// The row of a joint, its mobility, and its bounds.
    fn push_joint<S: Scalar>(
        &self,
        inputs: &ContactStepInputs<'_, S>,
        kind: JointRowKind,
        row: &[S],
        numbers: &mut Vec<S>,
    ) {
        let h = inputs.h;
        numbers.extend_from_slice(row);
        numbers.push(self.mobility(row));
        match kind {
            JointRowKind::Friction(force) => numbers.push(h.scale(force)),
            JointRowKind::Stop { q, lower, upper } => {
                // A missing limit is far away.
                let far = S::from_f64(FAR);
                let is_there = |limit: f64| limit.is_finite();
                let at = inputs.q[q];
                numbers.push(if is_there(lower) { speed_at_gap(h, at - S::from_f64(lower)) } else { -far });
                numbers.push(if is_there(upper) { -speed_at_gap(h, S::from_f64(upper) - at) } else { far });
            }
        }
    }

    /// The rows of a contact, the inverses of its normal and its largest tangential mobility, and its bound.
    fn push_contact<S: Scalar>(&self, h: S, gap: S, rows: &[Vec<S>; 3], numbers: &mut Vec<S>) {
        for row in rows {
            numbers.extend_from_slice(row);
        }
        let [normal, one, two] = rows;
        let (a, d) = (self.mobility(one), self.mobility(two));
        let b = one.iter().zip(two).fold(S::zero(), |sum, (&x, &y)| sum + x * y);
        let half = (a - d).scale(0.5);
        let largest = (a + d).scale(0.5) + (half * half + b * b + S::from_f64(TINY)).sqrt();
        numbers.push(S::one() / self.mobility(normal));
        numbers.push(S::one() / largest);
        numbers.push(speed_at_gap(h, gap));
    }

    /// The speed of a row per unit of its multiplier.
    fn mobility<S: Scalar>(&self, row: &[S]) -> S {
        row.iter().fold(S::from_f64(self.least_mobility), |sum, &x| sum + x * x)
    }
}

/// Keeps the derivative of a root finite at 0.
pub(super) const TINY: f64 = 1e-20;

/// The speed of a limit that is missing.
const FAR: f64 = 1e9;

/// The least speed away from a bound: −gap/h above it, and what lifts a penetration out.
fn speed_at_gap<S: Scalar>(h: S, gap: S) -> S {
    positive_part(-gap) / (h + S::from_f64(RETURN_TIME)) - positive_part(gap) / h
}
