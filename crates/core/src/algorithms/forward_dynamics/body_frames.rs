//! The articulated-body algorithm in the bodies' own frames.
//!
//! The Newton–Euler recursion first gives the inertial forces at q̈ = 0. With them as bias, the unknown is
//! the acceleration δa that q̈ adds. Its recursion has no velocity terms: F = Iᴬ δa + pᴬ,
//! δa = X δa_parent + S q̈.
//!
//! In body frames a joint's motion S is mostly a unit vector. Then U is a column of Iᴬ, and that row and
//! column of Iᵃ are zero. With [`FOLDS_ZEROS`](robot_dynamics_number::Triple::FOLDS_ZEROS) this form takes
//! fewer operations than the form in one frame. **(RBDA §7.3)**

#![allow(non_snake_case)] // the book's U and Iᴬ

use robot_dynamics_number::algebra::{M3, Sym3, V3};
use robot_dynamics_number::{Scalar, View};

use super::spring::less_spring;
use crate::Model;
use crate::algorithms::inverse_dynamics::{accelerate_bodies, upward};
use crate::kinematics::parent_inertia::{turn_of, turned};
use crate::kinematics::placement::{evaluate_angles, motion_in_body, spread};
use crate::kinematics::wrench::{FrameWrench, subtract_wrenches};
use crate::model::{Body, WORLD};
use crate::spatial::force::ForceVector;
use crate::spatial::inertia::{ArticulatedInertia, DofElimination};
use crate::spatial::motion::MotionVector;
use crate::workspace::tree::TreeMemory;

/// Replaces τ in `tree.dofs` by a.
#[inline(always)]
pub(super) fn accelerate<S: Scalar, N: View<S>>(
    model: &Model,
    tree: &mut TreeMemory<N>,
    q: &[N],
    v: &[N],
    wrenches: &[FrameWrench<S>],
) {
    spread(model, v, &mut tree.dofs.v);
    evaluate_angles(model, tree, q);
    tree.dofs.a.fill(N::zero());
    accelerate_bodies(model, tree, q, upward(model));
    subtract_wrenches(model, &mut tree.bodies.force, wrenches);
    eliminate_dofs(model, tree, q);
    accelerate_dofs(model, tree);
}

/// The inward pass: each DoF's [`DofElimination`], and each body's contribution to its parent.
#[inline(always)]
fn eliminate_dofs<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>, q: &[S]) {
    let all = &mut tree.inertias.articulated;
    for ((own, body), force) in all.iter_mut().zip(&model.bodies).zip(&tree.bodies.force) {
        *own = own_inertia(body, force);
    }
    for (i, body) in model.bodies.iter().enumerate().rev() {
        let (mut IA, mut pA) = (six_by_six(&all[i]), six(all[i].bias.linear, all[i].bias.angular));
        for k in (0..body.motion.nv()).rev() {
            let (index, s) = (body.dof + k, direction(body, k));
            let tau = less_spring(model, index, tree.dofs.tau[index], tree.angles.angle[i]);
            let armature = model.dofs[index].passive.armature;
            tree.inertias.pivot[index] = eliminate(&mut IA, &mut pA, &s, tau, armature);
        }
        if body.parent != WORLD {
            let (turn, place) = (turn_of(model, &tree.angles, q, i), &tree.bodies.place[i]);
            let block = |row: usize, column: usize| {
                let entries = core::array::from_fn(|i| core::array::from_fn(|j| IA[row + i][column + j]));
                turned(body, &turn, &M3::from_rows(entries))
            };
            let pA = force_of(&pA);
            let mut left = ArticulatedInertia {
                mass: Sym3::from_columns(&block(0, 0)),
                coupling: block(0, 3),
                coupling_back: M3::zero(),
                inertia: Sym3::from_columns(&block(3, 3)),
                bias: ForceVector {
                    linear: place.rotation * pA.linear,
                    angular: place.rotation * pA.angular,
                },
            };
            left.shift(place.translation);
            all[body.parent].add(&left);
        }
    }
}

/// The outward pass: q̈ = (u − Uᵀδa)/d, and each body's δa in `bodies.velocity`.
#[inline(always)]
fn accelerate_dofs<S: Scalar>(model: &Model, tree: &mut TreeMemory<S>) {
    for (i, body) in model.bodies.iter().enumerate() {
        let mut own = [S::zero(); 6];
        if body.parent != WORLD {
            let carried = motion_in_body(&tree.bodies.place[i], &tree.bodies.velocity[body.parent]);
            own = six(carried.linear, carried.angular);
        }
        for k in 0..body.motion.nv() {
            let DofElimination { column, residual, .. } = &tree.inertias.pivot[body.dof + k];
            let mut a = *residual;
            for (&u, &own) in six(column.linear, column.angular).iter().zip(&own) {
                a -= u * own;
            }
            tree.dofs.a[body.dof + k] = a;
            for (own, s) in own.iter_mut().zip(direction(body, k)) {
                if s != 0.0 {
                    *own += a.scale(s);
                }
            }
        }
        let ForceVector { linear, angular } = force_of(&own);
        tree.bodies.velocity[i] = MotionVector { linear, angular };
    }
}

/// Eliminates a DoF s in place: Iᵃ = Iᴬ − U Uᵀ/d, pᵃ = pᴬ + U u/d. Along a unit vector e_k without armature,
/// row k of Iᵃ is zero and entry k of pᵃ is τ. The code writes these constants instead of computing them.
#[inline(always)]
fn eliminate<S: Scalar>(
    IA: &mut [[S; 6]; 6],
    pA: &mut [S; 6],
    s: &[f64; 6],
    tau: S,
    armature: f64,
) -> DofElimination<S> {
    let along = |row: &[S; 6]| {
        let terms = row.iter().zip(s).filter(|(_, s)| **s != 0.0);
        terms.map(|(x, s)| x.scale(*s)).reduce(|sum, x| sum + x).unwrap_or_else(S::zero)
    };
    let U: [S; 6] = core::array::from_fn(|i| along(&IA[i]));
    let d = along(&U) + S::from_f64(armature);
    let u = tau - along(pA);
    let inverse = S::one() / d;
    let (column, residual) = (U.map(|x| x * inverse), u * inverse);
    let unit = (0..6).find(|&k| armature == 0.0 && (0..6).all(|i| s[i] == f64::from(u8::from(i == k))));
    for i in 0..6 {
        for j in i..6 {
            let left =
                if unit == Some(i) || unit == Some(j) { S::zero() } else { IA[i][j] - U[i] * column[j] };
            (IA[i][j], IA[j][i]) = (left, left);
        }
        pA[i] = if unit == Some(i) { tau } else { U[i].mul_add(residual, pA[i]) };
    }
    DofElimination { column: force_of(&column), residual, inverse }
}

/// DoF k's motion S, linear before angular.
#[inline(always)]
fn direction(body: &Body, k: usize) -> [f64; 6] {
    let unit: [f64; 6] = core::array::from_fn(|at| f64::from(u8::from(at == k)));
    let MotionVector { linear, angular } = body.motion.velocity(&unit);
    six(linear, angular)
}

/// A body's own inertia, with a bias force.
#[inline(always)]
fn own_inertia<S: Scalar>(body: &Body, bias: &ForceVector<S>) -> ArticulatedInertia<S> {
    let first_moment = V3::<S>::constant(&body.first_moment);
    ArticulatedInertia {
        mass: Sym3::multiple_of_identity(S::from_f64(body.mass)),
        coupling: M3::skew(-first_moment),
        coupling_back: M3::zero(),
        inertia: Sym3::constant(&body.inertia),
        bias: *bias,
    }
}

/// [M H; Hᵀ I].
#[inline(always)]
fn six_by_six<S: Scalar>(inertia: &ArticulatedInertia<S>) -> [[S; 6]; 6] {
    let (mass, coupling) = (inertia.mass.full().rows(), inertia.coupling.rows());
    let (back, inertia) = (inertia.coupling.transpose().rows(), inertia.inertia.full().rows());
    core::array::from_fn(|i| {
        let (left, right) = if i < 3 { (mass[i], coupling[i]) } else { (back[i - 3], inertia[i - 3]) };
        core::array::from_fn(|j| if j < 3 { left[j] } else { right[j - 3] })
    })
}

#[inline(always)]
fn six<S: Scalar>(linear: V3<S>, angular: V3<S>) -> [S; 6] {
    let ([x, y, z], [nx, ny, nz]) = (linear.array(), angular.array());
    [x, y, z, nx, ny, nz]
}

#[inline(always)]
fn force_of<S: Scalar>([x, y, z, nx, ny, nz]: &[S; 6]) -> ForceVector<S> {
    ForceVector { linear: V3::new([*x, *y, *z]), angular: V3::new([*nx, *ny, *nz]) }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_description::{Base, RandomRobotOptions, random_robot};
    use robot_dynamics_number::SplitMix64;

    use super::*;
    use crate::{
        FrameWrench, RandomState, Workspace, forward_dynamics_with_wrenches, inverse_dynamics_with_wrenches,
        random_state,
    };

    /// Compares with the form in one frame, and with the forces that the accelerations need. Both agree to
    /// rounding times the condition number of M, here below 1e4.
    #[test]
    fn accelerations_are_those_in_one_frame() {
        for seed in 0..40 {
            let base = if seed % 2 == 0 { Base::Floating } else { Base::Fixed };
            let options = RandomRobotOptions { joints: 9, base, passive: 0.5, ..Default::default() };
            let model = Model::new(random_robot(seed, &options)).unwrap();
            let RandomState { q, v, tau, .. } = random_state(&model, &mut SplitMix64::new(seed));
            let frame = model.frame_named(&model.frames().last().unwrap().name).unwrap();
            let wrench =
                FrameWrench { frame, force_in_frame: [1.0, -2.0, 3.0], moment_in_frame: [0.3, 0.2, -0.1] };
            let w = &mut Workspace::<f64>::limited(&model, crate::InstructionSet::Portable);
            let mut expected = vec![0.0; model.nv()];
            forward_dynamics_with_wrenches(&model, w, &q, &v, &tau, &[wrench], &mut expected);
            w.tree.dofs.tau.copy_from_slice(&tau);
            accelerate::<f64, f64>(&model, &mut w.tree, &q, &v, &[wrench]);
            let found = w.tree.dofs.a.clone();
            let size = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
            for (found, expected) in found.iter().zip(&expected) {
                assert!((found - expected).abs() < 1e-11 * size, "{seed}: {found} {expected}");
            }
            let mut back = vec![0.0; model.nv()];
            inverse_dynamics_with_wrenches(&model, w, &q, &v, &found, &[wrench], &mut back);
            for (found, tau) in back.iter().zip(&tau) {
                assert!((found - tau).abs() < 1e-10 * (1.0 + tau.abs()), "{seed}: {found} {tau}");
            }
        }
    }
}
