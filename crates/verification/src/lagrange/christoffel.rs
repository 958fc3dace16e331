//! Christoffel symbols, the Coriolis matrix and Ṁ, for robots with q̇ = v.

use robot_dynamics_core::Model;
use robot_dynamics_description::check_length;
use robot_dynamics_number::Dual;

use super::mass_matrix;

/// The Christoffel symbols of the first kind, Γⁱⱼₖ = ½(∂M_ij/∂qₖ + ∂M_ik/∂qⱼ − ∂M_jk/∂qᵢ). **(PRM 10.9)**
#[derive(Clone, Debug, PartialEq)]
pub struct Christoffel {
    nv: usize,
    table: Vec<f64>,
}

impl Christoffel {
    /// Γⁱⱼₖ, symmetric in j and k.
    ///
    /// # Panics
    /// Panics if an index is nv or more.
    #[track_caller]
    pub fn get(&self, i: usize, j: usize, k: usize) -> f64 {
        let nv = self.nv;
        assert!(i < nv && j < nv && k < nv, "Γ has indices 0 to {}, not ({i}, {j}, {k})", nv - 1);
        self.table[(i * nv + j) * nv + k]
    }

    /// C_ij = Σₖ Γⁱⱼₖ vₖ, nv×nv, row-major; with it Ṁ − 2C is skew-symmetric. **(MLS lemma 4.2)**
    ///
    /// # Panics
    /// Panics if v has the wrong length.
    #[track_caller]
    pub fn coriolis_matrix(&self, v: &[f64]) -> Vec<f64> {
        check_length("v", v.len(), self.nv);
        self.table
            .chunks(self.nv.max(1))
            .map(|row| row.iter().zip(v).map(|(symbol, v)| symbol * v).sum())
            .collect()
    }
}

/// Γ(q), exact to rounding: ∂M/∂q by dual numbers.
///
/// ```
/// use robot_dynamics::algorithms::christoffel_symbols;
/// use robot_dynamics::model::Workspace;
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let options = RandomRobotOptions { kinds: JointKinds::VectorSpace, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let (nv, exact) = (model.nv(), lagrange::christoffel(&model, &q));
/// let mut symbols = vec![0.0; nv * nv * nv];
/// christoffel_symbols(&model, &mut Workspace::new(&model), &q, &mut symbols);
/// let symbol = |at: usize| exact.get(at / (nv * nv), at / nv % nv, at % nv);
/// assert!((0..nv * nv * nv).all(|at| (symbols[at] - symbol(at)).abs() < 1e-11));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// Panics if q has the wrong length, or the robot has quaternion joints, for which q̇ ≠ v and (10.9) does not
/// define Γ. Check [`Model::is_vector_space`] first; [`velocity_product`](super::velocity_product) works for
/// every robot.
#[track_caller]
pub fn christoffel(model: &Model, q: &[f64]) -> Christoffel {
    const CHUNK: usize = 8;
    check_vector_space(model);
    let nv = model.nv();
    // derivative[k][i nv + j] = ∂M_ij/∂qₖ.
    let mut derivative = vec![Vec::new(); nv];
    for start in (0..nv).step_by(CHUNK) {
        let moving: Vec<Dual<f64, CHUNK>> = (0..nv)
            .map(|k| {
                let direction = k.wrapping_sub(start);
                if direction < CHUNK { Dual::variable(q[k], direction) } else { Dual::constant(q[k]) }
            })
            .collect();
        let mass = mass_matrix(model, &moving);
        for k in start..nv.min(start + CHUNK) {
            derivative[k] = mass.iter().map(|entry| entry.gradient[k - start]).collect();
        }
    }
    let d = |k: usize, i: usize, j: usize| derivative[k][i * nv + j];
    let mut table = Vec::with_capacity(nv * nv * nv);
    for i in 0..nv {
        for j in 0..nv {
            table.extend((0..nv).map(|k| 0.5 * (d(k, i, j) + d(j, i, k) - d(i, j, k))));
        }
    }
    Christoffel { nv, table }
}

/// C(q,v) from the Christoffel symbols, nv×nv, row-major.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, random_state};
/// # let options = RandomRobotOptions { kinds: JointKinds::VectorSpace, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// let c = lagrange::coriolis_matrix(&model, &q, &v);
/// let recursive = model.coriolis_matrix(&q, &v)?;
/// assert!((nalgebra::DMatrix::from_row_slice(model.nv(), model.nv(), &c) - recursive).amax() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// As [`christoffel`].
#[track_caller]
pub fn coriolis_matrix(model: &Model, q: &[f64], v: &[f64]) -> Vec<f64> {
    christoffel(model, q).coriolis_matrix(v)
}

/// Ṁ along v, nv×nv, row-major: one directional derivative of M, without Christoffel symbols.
///
/// ```
/// use robot_dynamics::verification::lagrange;
/// # use robot_dynamics::description::{JointKinds, RandomRobotOptions, random_robot};
/// # use robot_dynamics::model::{Model, RandomState, difference, random_state};
/// # let options = RandomRobotOptions { kinds: JointKinds::VectorSpace, ..Default::default() };
/// # let model = Model::new(random_robot(3, &options))?;
/// # let RandomState { q, v, a, tau } = random_state(&model, &mut robot_dynamics::number::SplitMix64::new(1));
/// // Ṁ = C + Cᵀ, with C from the recursion.
/// let rate = lagrange::mass_rate(&model, &q, &v);
/// let c = model.coriolis_matrix(&q, &v)?;
/// let difference = nalgebra::DMatrix::from_row_slice(model.nv(), model.nv(), &rate) - (&c + c.transpose());
/// assert!(difference.amax() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// As [`christoffel`].
#[track_caller]
pub fn mass_rate(model: &Model, q: &[f64], v: &[f64]) -> Vec<f64> {
    check_vector_space(model);
    check_length("q", q.len(), model.nq());
    check_length("v", v.len(), model.nv());
    let path: Vec<Dual<f64, 1>> =
        q.iter().zip(v).map(|(&value, &rate)| Dual { value, gradient: [rate] }).collect();
    mass_matrix(model, &path).iter().map(|entry| entry.gradient[0]).collect()
}

#[track_caller]
fn check_vector_space(model: &Model) {
    assert!(
        model.is_vector_space(),
        "robot `{}` has quaternion joints (nq = {}, nv = {}): its v is not the rate of q",
        model.name(),
        model.nq(),
        model.nv()
    );
}
