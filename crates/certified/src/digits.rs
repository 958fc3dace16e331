//! Enclosures of all quantities at single states, and the digits that they prove.

use robot_dynamics_core::{
    Model, Workspace, bias, coriolis_matrix, gravity, inverse_dynamics, kinetic_energy, mass_matrix,
    potential_energy,
};
use robot_dynamics_number::Scalar;

use crate::linear::forward_dynamics;
use crate::{EnclosureError, Interval};

/// A quantity at a state: its enclosure, and the numbers that double precision gives.
#[derive(Clone, Debug)]
pub struct EnclosedQuantity {
    /// Its name.
    pub name: &'static str,
    /// The exact numbers are in these intervals.
    pub enclosure: Vec<Interval>,
    /// The library's results in double precision.
    pub computed: Vec<f64>,
}

impl EnclosedQuantity {
    /// A proven bound of the error of the results in double precision, relative to the largest of them.
    pub fn relative_error(&self) -> f64 {
        let scale = self.computed.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        let error =
            self.enclosure.iter().zip(&self.computed).fold(0.0, |most: f64, (enclosure, x)| {
                most.max((*enclosure - Interval::from(*x)).magnitude())
            });
        if error == 0.0 { 0.0 } else { (Interval::from(error) / Interval::from(scale)).upper() }
    }

    /// The proven digits: −log₁₀ of [`Self::relative_error`], at most 17.
    pub fn digits(&self) -> f64 {
        (-self.relative_error().log10()).clamp(0.0, 17.0)
    }
}

/// A state: configuration, velocity, acceleration of the inverse and torque of the forward dynamics.
#[derive(Clone, Copy, Debug)]
pub struct EnclosedState<'a> {
    /// Configuration, nq numbers.
    pub q: &'a [f64],
    /// Velocity, nv numbers.
    pub v: &'a [f64],
    /// Acceleration, nv numbers.
    pub a: &'a [f64],
    /// Torque, nv numbers.
    pub tau: &'a [f64],
}

/// Enclosures of M, C, g, C v + g, τ, the energies and a at a state.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_certified::{EnclosedState, enclose_state};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let state = EnclosedState { q: &[0.3], v: &[1.0], a: &[2.0], tau: &[0.5] };
/// let quantities = enclose_state(&model, state)?;
/// let mass = quantities.iter().find(|quantity| quantity.name == "mass_matrix").unwrap();
/// assert!(mass.enclosure[0].contains(0.5) && mass.digits() > 15.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EnclosureError`] if M is singular, or nearly so.
///
/// # Panics
/// If a slice has the wrong length.
pub fn enclose_state(
    model: &Model,
    state: EnclosedState<'_>,
) -> Result<Vec<EnclosedQuantity>, EnclosureError> {
    let enclosures = quantities::<Interval>(model, state);
    let plain = model.without_native_code();
    let computed = quantities::<f64>(&plain, state);
    let intervals = |x: &[f64]| -> Vec<Interval> { x.iter().copied().map(Interval::from).collect() };
    let acceleration =
        forward_dynamics(model, &intervals(state.q), &intervals(state.v), &intervals(state.tau))?;
    let mut a = vec![0.0; model.nv()];
    let workspace = &mut Workspace::new(&plain);
    robot_dynamics_core::forward_dynamics(&plain, workspace, state.q, state.v, state.tau, &mut a);
    let all = enclosures
        .into_iter()
        .zip(computed)
        .map(|((name, enclosure), (_, computed))| EnclosedQuantity { name, enclosure, computed });
    let acceleration = EnclosedQuantity { name: "forward_dynamics", enclosure: acceleration, computed: a };
    Ok(all.chain([acceleration]).collect())
}

fn quantities<S: Scalar>(model: &Model, state: EnclosedState<'_>) -> Vec<(&'static str, Vec<S>)> {
    let over = |x: &[f64]| -> Vec<S> { x.iter().map(|x| S::from_f64(*x)).collect() };
    let [q, v, a] = [state.q, state.v, state.a].map(over);
    let (n, w) = (model.nv(), &mut Workspace::<S>::new(model));
    let mut all = Vec::new();
    let mut add = |name, length: usize, compute: &mut dyn FnMut(&mut Workspace<S>, &mut [S])| {
        let mut out = vec![S::zero(); length];
        compute(w, &mut out);
        all.push((name, out));
    };
    add("mass_matrix", n * n, &mut |w, out| mass_matrix(model, w, &q, out));
    add("coriolis_matrix", n * n, &mut |w, out| coriolis_matrix(model, w, &q, &v, out));
    add("gravity_forces", n, &mut |w, out| gravity(model, w, &q, out));
    add("bias", n, &mut |w, out| bias(model, w, &q, &v, out));
    add("inverse_dynamics", n, &mut |w, out| inverse_dynamics(model, w, &q, &v, &a, out));
    add("kinetic_energy", 1, &mut |w, out| out[0] = kinetic_energy(model, w, &q, &v));
    add("potential_energy", 1, &mut |w, out| out[0] = potential_energy(model, w, &q));
    all
}
