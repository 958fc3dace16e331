//! The Coriolis matrix in one pass from the leaves to the root, O(n depth).
//!
//! Divide each body into points p of mass dm with Jacobians J. Then M = ∫ JᵀJ dm, and C = ∫ JᵀJ̇ dm is the
//! matrix of the Christoffel symbols. In an inertial frame, J is (1 −\[p\]×) times the motions S of the DoFs.
//! A rigid set of points therefore enters with its inertia I and with
//!
//! B = ∫ (1 −\[p\]×)ᵀ(0 −\[ṗ\]×) dm = \[0 −\[f\]×; 0 tr(D) 1 − D\],  f = ∫ ṗ dm,  D = ∫ ṗ pᵀ dm.
//!
//! Let j be an ancestor of i, and I and B those of the subtree of i. Then C_ji = S_jᵀ(I Ṡ_i + B S_i) and
//! C_ij = S_iᵀ(I Ṡ_j + B S_j).
//!
//! B is the matrix ½((V×\*)I − I(V×) + (IV)×̄\*) with its zeros. Source: Echeandia, Wensing, *Numerical
//! methods to compute the Coriolis matrix and Christoffel symbols for rigid-body systems*, J. Comput.
//! Nonlinear Dyn. 16 (2021).

mod by_blocks;

use robot_dynamics_description::check_length;
use robot_dynamics_number::algebra::{M3, Sym3, V3};
use robot_dynamics_number::dispatch::{Hardware, Kernel};
use robot_dynamics_number::{Scalar, View};

use crate::kinematics::screws::{
    add_composite, inertia_in_world, momentum_of, move_screws, place_screws, turn_screws,
};
use crate::kinematics::shifts::{pass_flow, pass_inertia, pass_inward};
use crate::model::native::NativeFunction;
use crate::model::{Body, WORLD};
use crate::spatial::screw::{Force, MassFlux, Screw, SpatialInertia};
use crate::workspace::compiled_once::{OverNumber, compiled_once, run};
use crate::workspace::native::computed_natively;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// C(q,v), nv×nv, row-major: C v is the velocity product, Ṁ = C + Cᵀ, so Ṁ − 2C is skew-symmetric.
///
/// C is linear in v. If q̇ = v for every joint, C_ij = Σₖ Γⁱⱼₖ vₖ with the Christoffel symbols of M. **(PRM
/// 10.9)** The velocities of a quaternion joint are not rates of its coordinates; its C is the same integral
/// ∫ JᵀJ̇ dm.
///
/// ```
/// use robot_dynamics::algorithms::{coriolis_matrix, velocity_product};
/// use robot_dynamics::description::{Base, JointDescription, JointKind, LinkDescription, Pose};
/// use robot_dynamics::description::RobotDescription;
/// use robot_dynamics::model::{Model, Workspace};
/// # let mass = robot_dynamics::description::MassProperties::new(2.0, [0.1, 0.2, 0.3].into(), nalgebra::Matrix3::identity()).ok();
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
/// # Ok::<(), robot_dynamics::description::ModelError>(())
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
    workspace.check_inputs(model, q);
    check_length("v", v.len(), model.nv);
    check_length("the Coriolis matrix", coriolis.len(), model.nv * model.nv);
    let native = &mut workspace.tree.native;
    if computed_natively(model, native, NativeFunction::CoriolisMatrix, &[q, v], &mut [&mut *coriolis]) {
        return;
    }
    run(&mut workspace.tree, CoriolisMatrix { model, q, v, coriolis });
}

/// The arguments of [`coriolis_matrix`].
pub struct CoriolisMatrix<'a, S> {
    model: &'a Model,
    q: &'a [S],
    v: &'a [S],
    coriolis: &'a mut [S],
}

compiled_once!(pub CoriolisMatrixKind, CoriolisMatrix);

impl<S: Scalar> Kernel<OverNumber, S> for CoriolisMatrix<'_, S> {
    #[inline(always)]
    fn run<N: View<S>, H: Hardware>(self, tree: &mut TreeMemory<N>) {
        let Self { model, q, v, coriolis } = self;
        let (q, v, coriolis) = (N::view(q), N::view(v), N::view_mut(coriolis));
        place_screws(model, tree, q);
        move_screws(model, tree, v);
        turn_screws(model, tree);
        if M3::<N>::KEEPS_TRANSPOSE && !model.needs_dense_factor && !model.points.carried {
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
            flows[i] = MassFlux::of(&inertia, &twists[i]);
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
    if model.needs_dense_factor {
        let (a, b) = (&model.dofs[i], &model.dofs[j]);
        matrix[a.coordinate * model.nv + b.coordinate] += entry.scale(a.ratio * b.ratio);
    } else {
        matrix[i * model.nv + j] = entry;
    }
}

impl<S: Scalar> MassFlux<S> {
    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        self.momentum += other.momentum;
        self.stir = self.stir + other.stir;
    }

    /// f = m u + ω × h and D = u hᵀ + \[ω\]×Σ of a rigid set of points, with Σ = ∫ p pᵀ dm.
    #[inline(always)]
    pub fn of(inertia: &SpatialInertia<S>, twist: &Screw<S>) -> Self {
        let (u, w, h) = (twist.linear, twist.angular, inertia.first_moment);
        // Σ = ½ tr(I) 1 − I is symmetric: its columns are its rows.
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

/// The subtree of a DoF i, reduced to three vectors for its ancestors.
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
    pub(crate) fn new(
        inertia: &SpatialInertia<S>,
        flow: &MassFlux<S>,
        s: &Screw<S>,
        rate: &Screw<S>,
    ) -> Self {
        let d = &flow.stir;
        let [[xx, ..], [_, yy, _], [_, _, zz]] = d.rows();
        let stretched = s.angular * (xx + yy + zz);
        let mut above = momentum_of(inertia, rate);
        above.linear += s.angular.cross(flow.momentum);
        above.angular += stretched - *d * s.angular;
        let turning = flow.momentum.cross(s.linear) + stretched - d.transpose_mul(s.angular);
        Self { above, inertial: momentum_of(inertia, s), turning }
    }

    /// Moves the vectors from a body's reference point to its parent's. The moment of Bᵀ S_i has no force, so
    /// it is the same about every point.
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
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::kinematics::screws::{force_cross, motion_cross};

    /// B of the module's documentation, applied to each unit motion, is ½((V×*)I − I(V×) + (IV)×̄*), where
    /// F ×̄* S = S ×* F. Entries are products of three numbers below 3: 1e-13 allows about twenty rounding
    /// errors.
    #[test]
    fn body_matrix_is_echeandia_and_wensings() {
        let mut random = SplitMix64::new(5);
        for _ in 0..20 {
            let mut vector = || V3::new([(); 3].map(|()| random.uniform(-2.0, 2.0)));
            let twist = Force { linear: vector(), angular: vector() };
            // A point mass and a rotational inertia. The identity is algebraic, so any symmetric numbers will
            // do.
            let ([a, b, c], [d, e, f]) = (vector().array(), vector().array());
            let inertia = SpatialInertia {
                mass: 1.7,
                first_moment: vector(),
                inertia: Sym3::from_columns(&M3::from_rows([[a, b, c], [b, d, e], [c, e, f]])),
            };
            let flow = MassFlux::of(&inertia, &twist);
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
