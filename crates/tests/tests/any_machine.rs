//! Every scalar type and every instruction set that a program may ask for, on the machine at hand. Safe code
//! never executes an instruction that the machine lacks, and all results agree with the Lagrange recipe.
//!
//! The test also runs on emulated machines, old ones and one of another architecture, so it is short.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};
use std::io::Write;

use robot_dynamics::algorithms::{bias, forward_dynamics, inverse_dynamics, mass_matrix};
use robot_dynamics::batch;
use robot_dynamics::batch::{BatchFloat, BatchOptions, BatchWorkspace};
use robot_dynamics::derivatives::{
    ForwardDynamicsDerivativesMut, InverseDynamicsDerivativesMut, forward_dynamics_derivatives,
    inverse_dynamics_derivatives,
};
use robot_dynamics::description::{Base, RandomRobotOptions, random_robot};
use robot_dynamics::model::{InstructionSet, Model, Workspace, random_state};
use robot_dynamics::number::{Dual, Scalar, SplitMix64};
use robot_dynamics::verification::lagrange;

/// Some robots with a few joints of every kind, one of them with a floating base.
fn models() -> Vec<Model> {
    let robot = |seed, base| {
        let options = RandomRobotOptions { joints: 5, base, ..Default::default() };
        Model::new(random_robot(seed, &options)).unwrap()
    };
    vec![robot(1, Base::Fixed), robot(2, Base::Floating)]
}

/// A scalar type that is defined outside the library.
#[derive(Clone, Copy, Debug)]
struct Own(f64);

macro_rules! operators {
    ($($trait:ident $method:ident $assign:ident $assign_method:ident;)*) => {
        $(
            impl $trait for Own {
                type Output = Self;
                fn $method(self, other: Self) -> Self {
                    Self(self.0.$method(other.0))
                }
            }
            impl $assign for Own {
                fn $assign_method(&mut self, other: Self) {
                    self.0.$assign_method(other.0);
                }
            }
        )*
    };
}
operators! { Add add AddAssign add_assign; Sub sub SubAssign sub_assign; Mul mul MulAssign mul_assign; }

impl Div for Own {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        Self(self.0 / other.0)
    }
}

impl Neg for Own {
    type Output = Self;
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Scalar for Own {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];
    fn from_f64(x: f64) -> Self {
        Self(x)
    }
    fn sin_cos(self) -> (Self, Self) {
        let (sine, cosine) = self.0.sin_cos();
        (Self(sine), Self(cosine))
    }
    fn sqrt(self) -> Self {
        Self(self.0.sqrt())
    }
    fn signum0(self) -> Self {
        Self(self.0.signum0())
    }
}

/// The largest difference, relative to the largest expected number.
fn difference(found: impl Iterator<Item = f64>, expected: &[f64]) -> f64 {
    let size = expected.iter().fold(1.0_f64, |size, x| size.max(x.abs()));
    found.zip(expected).fold(0.0, |worst: f64, (x, y)| worst.max((x - y).abs())) / size
}

/// M, C v + g, τ, a and the derivatives over one scalar type against the Lagrange recipe. `rounding` is the
/// rounding that a few dozen joints leave.
fn assert_one_state_matches_the_recipe<S: Scalar>(value: fn(S) -> f64, rounding: f64) {
    for model in models() {
        let state = random_state(&model, &mut SplitMix64::new(3));
        let to = |x: &[f64]| x.iter().map(|&x| S::from_f64(x)).collect::<Vec<S>>();
        let (q, v, a) = (to(&state.q), to(&state.v), to(&state.a));
        let nv = model.nv();
        let mass = lagrange::mass_matrix(&model, &state.q);
        let biases = lagrange::bias(&model, &state.q, &state.v);
        let torque = lagrange::inverse_dynamics(&model, &state.q, &state.v, &state.a);
        for &limit in InstructionSet::ALL {
            let mut workspace = Workspace::<S>::limited(&model, limit);
            assert!(workspace.instruction_set().is_available());
            let mut matrix = vec![S::zero(); nv * nv];
            mass_matrix(&model, &mut workspace, &q, &mut matrix);
            let error = difference(matrix.iter().map(|&x| value(x)), &mass);
            assert!(error < rounding, "M up to {limit}: {error:e}");
            let mut forces = vec![S::zero(); nv];
            bias(&model, &mut workspace, &q, &v, &mut forces);
            let error = difference(forces.iter().map(|&x| value(x)), &biases);
            assert!(error < rounding, "C v + g up to {limit}: {error:e}");
            inverse_dynamics(&model, &mut workspace, &q, &v, &a, &mut forces);
            let error = difference(forces.iter().map(|&x| value(x)), &torque);
            assert!(error < rounding, "τ up to {limit}: {error:e}");
            // a → τ → a multiplies a rounding by κ(M), which is below 1e4 here.
            let mut found = vec![S::zero(); nv];
            forward_dynamics(&model, &mut workspace, &q, &v, &forces, &mut found);
            let error = difference(found.iter().map(|&x| value(x)), &state.a);
            assert!(error < 1e4 * rounding, "a up to {limit}: {error:e}");
            let [mut by_q, mut by_v, mut by_tau] = [(); 3].map(|()| vec![S::zero(); nv * nv]);
            let out = InverseDynamicsDerivativesMut { by_position: &mut by_q, by_velocity: &mut by_v };
            inverse_dynamics_derivatives(&model, &mut workspace, &q, &v, &a, out);
            let derivatives: Vec<f64> = by_q.iter().map(|&x| value(x)).collect();
            let out = ForwardDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
                by_force: &mut by_tau,
            };
            forward_dynamics_derivatives(&model, &mut workspace, &q, &v, &forces, out);
            // M ∂a/∂q = −∂τ/∂q.
            let entry =
                |i: usize, j: usize| (0..nv).map(|k| mass[i * nv + k] * value(by_q[k * nv + j])).sum::<f64>();
            let product = (0..nv * nv).map(|at| -entry(at / nv, at % nv));
            let error = difference(product, &derivatives);
            assert!(error < 1e4 * rounding, "the derivatives up to {limit}: {error:e}");
        }
    }
}

#[test]
fn every_scalar_type_runs_on_this_machine() {
    let _ = writeln!(std::io::stderr(), "this machine: {}", InstructionSet::best());
    assert_one_state_matches_the_recipe::<f64>(|x| x, 1e-13);
    assert_one_state_matches_the_recipe::<f32>(f64::from, 5e-5);
    assert_one_state_matches_the_recipe::<Own>(|x| x.0, 1e-13);
    assert_one_state_matches_the_recipe::<Dual<f64, 1>>(|x| x.value, 1e-13);
    assert_one_state_matches_the_recipe::<Dual<f32, 2>>(|x| f64::from(x.value), 5e-5);
}

/// A batch whose number of states is not a multiple of the number of lanes.
fn assert_batches_match_single_calls<T: BatchFloat + Into<f64>>(rounding: f64) {
    const COUNT: usize = 21;
    for model in models() {
        let (nq, nv) = (model.nq(), model.nv());
        let mut random = SplitMix64::new(4);
        let (mut q, mut v, mut a, mut expected) = (vec![], vec![], vec![], vec![]);
        let mut single = Workspace::<f64>::limited(&model, InstructionSet::Portable);
        for _ in 0..COUNT {
            let state = random_state(&model, &mut random);
            let mut tau = vec![0.0; nv];
            inverse_dynamics(&model, &mut single, &state.q, &state.v, &state.a, &mut tau);
            expected.extend(tau);
            q.extend(state.q.iter().map(|&x| T::from_f64(x)));
            v.extend(state.v.iter().map(|&x| T::from_f64(x)));
            a.extend(state.a.iter().map(|&x| T::from_f64(x)));
        }
        for &limit in InstructionSet::ALL {
            let mut options = BatchOptions::default();
            (options.limit, options.threads) = (Some(limit), 1);
            let mut workspace = BatchWorkspace::<T>::with_options(&model, options).unwrap();
            assert!(workspace.instruction_set().is_available());
            let mut tau = vec![T::zero(); COUNT * nv];
            batch::inverse_dynamics(&model, &mut workspace, &q, &v, &a, &mut tau).unwrap();
            let error = difference(tau.iter().map(|&x| x.into()), &expected);
            assert!(error < rounding, "{COUNT} states up to {limit}: {error:e}");
            let mut mass = vec![T::zero(); COUNT * nv * nv];
            batch::mass_matrix(&model, &mut workspace, &q, &mut mass).unwrap();
            let mut last = vec![0.0; nv * nv];
            let q_last: Vec<f64> = q[(COUNT - 1) * nq..].iter().map(|&x| x.into()).collect();
            mass_matrix(&model, &mut single, &q_last, &mut last);
            let error = difference(mass[(COUNT - 1) * nv * nv..].iter().map(|&x| x.into()), &last);
            assert!(error < rounding, "the last M up to {limit}: {error:e}");
        }
    }
}

#[test]
fn batches_run_on_this_machine() {
    assert_batches_match_single_calls::<f64>(1e-13);
    assert_batches_match_single_calls::<f32>(5e-5);
}
