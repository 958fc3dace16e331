//! The terms of the equation of motion on batches.

use robot_dynamics_core::Model;

use crate::computation::recursions::Forces;
use crate::float::Quantity;
use crate::tables::InputTables;
use crate::{BadStates, BatchFloat, BatchWorkspace};

/// τ = M(q) a + C(q,v) v + g(q) of each state; see [`inverse_dynamics`](robot_dynamics_core::inverse_dynamics).
///
/// q is \[batch\]\[nq\]; v, a and tau are \[batch\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let mut random = robot_dynamics::number::SplitMix64::new(1);
/// # let (one, two) = (random_state(&model, &mut random), random_state(&model, &mut random));
/// let q = [&one.q[..], &two.q].concat();
/// let (v, a) = ([&one.v[..], &two.v].concat(), [&one.a[..], &two.a].concat());
/// let mut tau = vec![0.0; 2 * model.nv()];
/// batch::inverse_dynamics(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &v, &a, &mut tau)?;
/// let alone = model.inverse_dynamics(&two.q, &two.v, &two.a)?;
/// assert!(tau[model.nv()..].iter().zip(&alone).all(|(tau, alone)| (tau - alone).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "RNEA")]
#[track_caller]
pub fn inverse_dynamics<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    a: &[T],
    tau: &mut [T],
) -> Result<(), BadStates> {
    let tables =
        InputTables { names: ["q", "v", "a"], widths: [model.nq, model.nv, model.nv], rows: [q, v, a] };
    T::compute(model, workspace, Quantity::Forces(Forces::Inverse), &tables, "tau", tau)
}

/// C(q,v) v + g(q) of each state; see [`bias`](robot_dynamics_core::bias).
///
/// q is \[batch\]\[nq\]; v and the bias are \[batch\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// # use robot_dynamics::algorithms::bias;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let mut random = robot_dynamics::number::SplitMix64::new(1);
/// # let (one, two) = (random_state(&model, &mut random), random_state(&model, &mut random));
/// let (q, v) = ([&one.q[..], &two.q].concat(), [&one.v[..], &two.v].concat());
/// let mut bias = vec![0.0; 2 * model.nv()];
/// batch::bias(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &v, &mut bias)?;
/// let alone = model.bias(&two.q, &two.v)?;
/// assert!(bias[model.nv()..].iter().zip(&alone).all(|(bias, alone)| (bias - alone).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn bias<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    bias: &mut [T],
) -> Result<(), BadStates> {
    let tables = InputTables { names: ["q", "v", ""], widths: [model.nq, model.nv, 0], rows: [q, v, &[]] };
    T::compute(model, workspace, Quantity::Forces(Forces::Bias), &tables, "the bias", bias)
}

/// g(q) of each state; see [`gravity`](robot_dynamics_core::gravity).
///
/// q is \[batch\]\[nq\]; the gravity forces are \[batch\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// // A horizontal state, a hanging state, and an invalid one, which is reported and does not affect the
/// // others.
/// let (q, mut g) = ([0.0, std::f64::consts::FRAC_PI_2, f64::NAN], [0.0; 3]);
/// let bad = batch::gravity(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &mut g).unwrap_err();
/// assert!((g[0] + 2.0 * 9.81 * 0.5).abs() < 1e-14 && g[1].abs() < 1e-14 && g[2].is_nan());
/// assert_eq!(bad.states, [2]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn gravity<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    gravity: &mut [T],
) -> Result<(), BadStates> {
    let tables = InputTables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    T::compute(model, workspace, Quantity::Forces(Forces::Gravity), &tables, "gravity", gravity)
}

/// a = M⁻¹(τ − C v − g) of each state; see [`forward_dynamics`](robot_dynamics_core::forward_dynamics).
///
/// q is \[batch\]\[nq\]; v, tau and the accelerations are \[batch\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let mut random = robot_dynamics::number::SplitMix64::new(1);
/// # let (one, two) = (random_state(&model, &mut random), random_state(&model, &mut random));
/// let q = [&one.q[..], &two.q].concat();
/// let (v, tau) = ([&one.v[..], &two.v].concat(), [&one.tau[..], &two.tau].concat());
/// let mut a = vec![0.0; 2 * model.nv()];
/// batch::forward_dynamics(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &v, &tau, &mut a)?;
/// let alone = model.forward_dynamics(&two.q, &two.v, &two.tau)?;
/// assert!(a[model.nv()..].iter().zip(&alone).all(|(a, alone)| (a - alone).abs() < 1e-9 * (1.0 + a.abs())));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result, including those with a singular M; all other
/// results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "ABA")]
#[track_caller]
pub fn forward_dynamics<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    v: &[T],
    tau: &[T],
    acceleration: &mut [T],
) -> Result<(), BadStates> {
    let tables =
        InputTables { names: ["q", "v", "tau"], widths: [model.nq, model.nv, model.nv], rows: [q, v, tau] };
    T::compute(model, workspace, Quantity::Acceleration, &tables, "the acceleration", acceleration)
}

/// M(q) of each state, both triangles; see [`mass_matrix`](robot_dynamics_core::mass_matrix).
///
/// q is \[batch\]\[nq\]; the mass matrices are \[batch\]\[nv\]\[nv\].
///
/// ```
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let mut random = robot_dynamics::number::SplitMix64::new(1);
/// # let (one, two) = (random_state(&model, &mut random), random_state(&model, &mut random));
/// let (q, size) = ([&one.q[..], &two.q].concat(), model.nv() * model.nv());
/// let mut mass = vec![0.0; 2 * size];
/// batch::mass_matrix(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &mut mass)?;
/// let alone = model.mass_matrix(&two.q)?; // symmetric: rows are columns
/// assert!(mass[size..].iter().zip(&alone).all(|(mass, alone)| (mass - alone).abs() < 1e-12));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result; all other results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[doc(alias = "CRBA")]
#[track_caller]
pub fn mass_matrix<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    mass: &mut [T],
) -> Result<(), BadStates> {
    let tables = InputTables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    T::compute(model, workspace, Quantity::Mass, &tables, "the mass matrix", mass)
}

/// M(q)⁻¹ of each state, both triangles; see [`inverse_mass_matrix`](robot_dynamics_core::inverse_mass_matrix).
///
/// q is \[batch\]\[nq\]; the inverses are \[batch\]\[nv\]\[nv\].
///
/// ```
/// use nalgebra::DMatrix;
/// use robot_dynamics::batch;
/// use robot_dynamics::batch::BatchWorkspace;
/// # use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, random_state};
/// # let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// # let mut random = robot_dynamics::number::SplitMix64::new(1);
/// # let (one, two) = (random_state(&model, &mut random), random_state(&model, &mut random));
/// let (q, nv) = ([&one.q[..], &two.q].concat(), model.nv());
/// let mut inverse = vec![0.0; 2 * nv * nv];
/// batch::inverse_mass_matrix(&model, &mut BatchWorkspace::<f64>::new(&model), &q, &mut inverse)?;
/// let product = model.mass_matrix(&two.q)? * DMatrix::from_row_slice(nv, nv, &inverse[nv * nv..]);
/// assert!((product - DMatrix::identity(nv, nv)).amax() < 1e-9); // κ(M) times rounding
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`BadStates`] lists the states without a valid result, including those with a singular M; all other
/// results are valid.
///
/// # Panics
/// Panics if a table has the wrong length, or the workspace belongs to another model.
#[track_caller]
pub fn inverse_mass_matrix<T: BatchFloat>(
    model: &Model,
    workspace: &mut BatchWorkspace<T>,
    q: &[T],
    inverse: &mut [T],
) -> Result<(), BadStates> {
    let tables = InputTables { names: ["q", "", ""], widths: [model.nq, 0, 0], rows: [q, &[], &[]] };
    T::compute(model, workspace, Quantity::InverseMass, &tables, "the inverse mass matrix", inverse)
}
