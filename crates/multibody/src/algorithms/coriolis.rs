//! The Coriolis matrix in one pass from the leaves to the root, O(n depth).
//!
//! Cut every body into points p of mass dm with Jacobians J: M = ∫ JᵀJ dm, and C = ∫ JᵀJ̇ dm is the matrix
//! of the Christoffel symbols. In an inertial frame J = (1 −\[p\]×) times the motions S of the freedoms, so a
//! rigid set of points enters with its inertia I and with
//!
//! B = ∫ (1 −\[p\]×)ᵀ(0 −\[ṗ\]×) dm = \[0 −\[f\]×; 0 tr(D) 1 − D\],  f = ∫ ṗ dm,  D = ∫ ṗ pᵀ dm.
//!
//! For freedom i and freedom j on its way to the root, with I and B of everything beyond i:
//! C_ji = S_jᵀ(I Ṡ_i + B S_i), C_ij = S_iᵀ(I Ṡ_j + B S_j). B is the matrix
//! ½((V×\*)I − I(V×) + (IV)×̄\*) of Echeandia and Wensing, *Numerical methods to compute the Coriolis matrix
//! and Christoffel symbols for rigid-body systems*, J. Comput. Nonlinear Dyn. 16 (2021), with its zeros.

mod by_blocks;

use dynamics::Scalar;
use number::View;
use number::dispatch::{Hardware, Kernel};

use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::model::{Body, WORLD};
use crate::scratch::compiled_once::{OverNumber, compiled_once, run};
use crate::scratch::native::computed_natively;
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::{M3, Sym3, V3};
use crate::spatial::screw::{Composite, Flow, Force, Screw};
use crate::stages::screws::{
    add_composite, inertia_in_world, momentum_of, move_screws, place_screws, turn_screws,
};
use crate::stages::shifts::{pass_flow, pass_inertia, pass_inward};
use crate::{Model, Workspace};

/// C(q,v), nv×nv, row-major: C v is the velocity product, Ṁ = C + Cᵀ, so Ṁ − 2C is skew-symmetric.
///
/// Where q is plain numbers, C_ij = Σₖ Γⁱⱼₖ vₖ with the Christoffel symbols of M **(PRM 10.9)**; a quaternion
/// joint has velocities that are no coordinates' rates, and its C is the same ∫ JᵀJ̇ dm. C is linear in v.
///
/// ```
/// use multibody::{
///     Base, JointDescription, JointKind, LinkDescription, Model, Pose, RobotDescription, Workspace,
///     coriolis_matrix, velocity_product,
/// };
/// # let mass = dynamics::MassProperties::new(2.0, [0.1, 0.2, 0.3].into(), nalgebra::Matrix3::identity()).ok();
/// let mut robot = RobotDescription::new("thrown body");
/// robot.base = Base::Floating;
/// robot.links.push(LinkDescription::new("body", mass));
/// let model = Model::new(robot)?;
/// let mut workspace = Workspace::new(&model);
/// let (q, v) = ([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], [0.3, 0.1, -0.2, 1.0, 2.0, -1.0]);
/// let (mut c, mut product) = ([0.0; 36], [0.0; 6]);
/// coriolis_matrix(&model, &mut workspace, &q, &v, &mut c);
/// velocity_product(&model, &mut workspace, &q, &v, &mut product);
/// for (row, product) in c.chunks(6).zip(product) {
///     let sum: f64 = row.iter().zip(v).map(|(c, v)| c * v).sum();
///     assert!((sum - product).abs() < 1e-14);
/// }
/// # Ok::<(), multibody::ModelError>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length.
#[inline]
#[track_caller]
pub fn coriolis_matrix<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    coriolis: &mut [S],
) {
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the Coriolis matrix", coriolis.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::CoriolisMatrix, &[q, v], &mut [&mut *coriolis]) {
        return;
    }
    run(&mut workspace.tree, CoriolisMatrix { model, q, v, coriolis });
}

/// The arguments of [`coriolis_matrix`].
pub(crate) struct CoriolisMatrix<'a, S> {
    model: &'a Model,
    q: &'a [S],
    v: &'a [S],
    coriolis: &'a mut [S],
}

compiled_once!(CoriolisMatrixKind, CoriolisMatrix);

impl<S: Scalar> Kernel<OverNumber, S> for CoriolisMatrix<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, coriolis } = self;
        let (q, v, coriolis) = (N::view(q), N::view(v), N::view_mut(coriolis));
        place_screws(model, tree, q);
        move_screws(model, tree, v);
        turn_screws(model, tree);
        if M3::<N>::KEEPS_TRANSPOSE && !model.couples_branches && !model.points.carried {
            by_blocks::gather_branches(model, tree);
            by_blocks::write_matrix(model, tree, coriolis);
            return;
        }
        coriolis.fill(N::zero());
        let n = model.bodies.len();
        let (bodies, world, twists) = (&model.bodies[..n], &tree.screws.world[..n], &tree.screws.twist[..n]);
        let (columns, rates) = (&tree.screws.column[..], &tree.screws.column_rate[..]);
        let levers = &tree.screws.levers[..];
        let (composites, flows) = (&mut tree.inertias.composite[..n], &mut tree.screws.flow[..n]);
        for i in 0..n {
            let inertia = inertia_in_world(&bodies[i], &world[i]);
            flows[i] = Flow::of(&inertia, &twists[i]);
            composites[i] = inertia;
        }
        for i in (0..n).rev() {
            let body = &bodies[i];
            let (mut composite, mut flow) = (composites[i], flows[i]);
            let own = body.dof..body.dof + body.motion.nv();
            for dof in own.clone() {
                let mut branch = Branch::new(&composite, &flow, &columns[dof], &rates[dof]);
                for other in own.clone() {
                    add_entry(model, coriolis, other, dof, branch.above(&columns[other]));
                }
                branch.pass_inward(body, levers);
                let mut at = body.parent;
                while at != WORLD {
                    let ancestor = &bodies[at];
                    for other in ancestor.dof..ancestor.dof + ancestor.motion.nv() {
                        let (s, rate) = (&columns[other], &rates[other]);
                        add_entry(model, coriolis, other, dof, branch.above(s));
                        add_entry(model, coriolis, dof, other, branch.beyond(s, rate));
                    }
                    branch.pass_inward(ancestor, levers);
                    at = ancestor.parent;
                }
            }
            if body.parent != WORLD {
                pass_inertia(body, levers, &mut composite);
                pass_flow(body, levers, &mut flow);
                add_composite(&mut composites[body.parent], &composite);
                flows[body.parent].add(&flow);
            }
        }
    }
}

/// Adds a tree entry C_{i j} to the reduced matrix GᵀCG.
#[inline(always)]
fn add_entry<N: Scalar>(model: &Model, matrix: &mut [N], i: usize, j: usize, entry: N) {
    if model.couples_branches {
        let (a, b) = (&model.dofs[i], &model.dofs[j]);
        matrix[a.coordinate * model.nv + b.coordinate] += entry.scale(a.ratio * b.ratio);
    } else {
        matrix[i * model.nv + j] = entry;
    }
}

impl<S: Scalar> Flow<S> {
    #[inline(always)]
    pub(crate) fn add(&mut self, other: &Self) {
        self.momentum += other.momentum;
        self.stir = self.stir + other.stir;
    }

    /// f = m u + ω × h and D = u hᵀ + \[ω\]×Σ of points that move as one rigid body, Σ = ∫ p pᵀ dm.
    #[inline(always)]
    pub(crate) fn of(inertia: &Composite<S>, twist: &Screw<S>) -> Self {
        let (u, w, h) = (twist.linear, twist.angular, inertia.first_moment);
        // Σ = ½ tr(I) 1 − I; its columns are its rows.
        let [[xx, ..], [_, yy, _], [_, _, zz]] = inertia.inertia.full().rows();
        let half_trace = Sym3::multiple_of_identity((xx + yy + zz).scale(0.5));
        let sigma = half_trace.full() - inertia.inertia.full();
        let columns = [
            w.cross(sigma.column(0)).add_scaled(h.get(0), u),
            w.cross(sigma.column(1)).add_scaled(h.get(1), u),
            w.cross(sigma.column(2)).add_scaled(h.get(2), u),
        ];
        Self { momentum: w.cross(h).add_scaled(inertia.mass, u), stir: M3::from_columns(columns) }
    }
}

/// What freedom i of a branch shows to the freedoms on its way to the root.
pub(crate) struct Branch<S: Scalar> {
    /// I Ṡ_i + B S_i.
    pub above: Force<S>,
    /// I S_i.
    pub inertial: Force<S>,
    /// The moment of Bᵀ S_i; its force is zero.
    pub turning: V3<S>,
}

impl<S: Scalar> Branch<S> {
    #[inline(always)]
    pub(crate) fn new(inertia: &Composite<S>, flow: &Flow<S>, s: &Screw<S>, rate: &Screw<S>) -> Self {
        let d = &flow.stir;
        let [[xx, ..], [_, yy, _], [_, _, zz]] = d.rows();
        let stretched = s.angular * (xx + yy + zz);
        let mut above = momentum_of(inertia, rate);
        above.linear += s.angular.cross(flow.momentum);
        above.angular += stretched - *d * s.angular;
        let turning = flow.momentum.cross(s.linear) + stretched - d.transpose_mul(s.angular);
        Self { above, inertial: momentum_of(inertia, s), turning }
    }

    /// From a body's reference point to its parent's. The moment of Bᵀ S_i has no force, and is the same at every
    /// point.
    #[inline(always)]
    pub(crate) fn pass_inward(&mut self, body: &Body, levers: &[V3<S>]) {
        pass_inward(body, levers, &mut self.above);
        pass_inward(body, levers, &mut self.inertial);
    }

    /// C_ji = S_jᵀ(I Ṡ_i + B S_i).
    #[inline(always)]
    pub(crate) fn above(&self, s: &Screw<S>) -> S {
        s.dot(&self.above)
    }

    /// C_ij = S_iᵀ(I Ṡ_j + B S_j).
    #[inline(always)]
    pub(crate) fn beyond(&self, s: &Screw<S>, rate: &Screw<S>) -> S {
        self.inertial.dot(rate) + self.turning.dot(s.angular)
    }
}

#[cfg(test)]
mod tests {
    use dynamics::SplitMix64;

    use super::*;
    use crate::stages::screws::{force_cross, motion_cross};

    /// B of the module's head, applied to each unit motion, is ½((V×*)I − I(V×) + (IV)×̄*), where
    /// F ×̄* S = S ×* F. Entries are products of three numbers below 3: 1e-13 allows some twenty roundings.
    #[test]
    fn body_matrix_is_echeandia_and_wensings() {
        let mut random = SplitMix64::new(5);
        for _ in 0..20 {
            let mut vector = || V3::new([(); 3].map(|()| random.uniform(-2.0, 2.0)));
            let twist = Force { linear: vector(), angular: vector() };
            // A point of mass and a rotational inertia: any symmetric numbers will do, the identity is algebraic.
            let ([a, b, c], [d, e, f]) = (vector().array(), vector().array());
            let inertia = Composite {
                mass: 1.7,
                first_moment: vector(),
                inertia: Sym3::from_columns(&M3::from_rows([[a, b, c], [b, d, e], [c, e, f]])),
            };
            let flow = Flow::of(&inertia, &twist);
            for axis in 0..6 {
                let mut s = Force::zero();
                let mut unit = [0.0; 3];
                unit[axis % 3] = 1.0;
                *(if axis < 3 { &mut s.linear } else { &mut s.angular }) = V3::new(unit);
                let found = Branch::new(&inertia, &flow, &s, &Force::zero()).above;
                let first = force_cross(&twist, &momentum_of(&inertia, &s));
                let second = momentum_of(&inertia, &motion_cross(&twist, &s));
                let third = force_cross(&s, &momentum_of(&inertia, &twist));
                for i in 0..3 {
                    let linear = 0.5 * (first.linear.get(i) - second.linear.get(i) + third.linear.get(i));
                    let angular = 0.5 * (first.angular.get(i) - second.angular.get(i) + third.angular.get(i));
                    assert!((found.linear.get(i) - linear).abs() < 1e-13, "{found:?}, axis {axis}");
                    assert!((found.angular.get(i) - angular).abs() < 1e-13, "{found:?}, axis {axis}");
                }
            }
        }
    }
}
