//! The random states an audit looks at, and how large rounding errors may be there.

use dynamics::SplitMix64;
use multibody::{Model, Workspace, random_within_limits};
use nalgebra::DMatrix;

/// A robot and the states to look at.
pub(crate) struct Probe<'a> {
    pub model: &'a Model,
    pub states: Vec<State>,
    /// m |gravity| times the robot's reach: what the terms of g add up to at most \[N·m\].
    pub weight: f64,
}

/// A state with its scales.
pub(crate) struct State {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    pub tau: Vec<f64>,
    /// M by the recursion, row-major.
    pub mass: Vec<f64>,
    /// The largest |M_ij|.
    pub inertia: f64,
    /// κ(M) by eigenvalues; infinite where M is not positive definite.
    pub condition: f64,
    /// |v|.
    pub speed: f64,
    /// What the terms of τ − C v − g add up to at most.
    pub force: f64,
}

/// Rounding of a sum: up to 4500 roundings of its largest term.
pub(crate) const ROUNDING: f64 = 1e-12;

impl<'a> Probe<'a> {
    pub(crate) fn new(model: &'a Model, states: u32, seed: u64) -> Self {
        let acceleration = model.gravity().iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
        let has_slides = model
            .joints()
            .iter()
            .any(|joint| matches!(joint.kind, "prismatic" | "floating" | "planar" | "helical"));
        // A slide bears the weight itself, as if its arm were a metre.
        let arm = if has_slides { reach(model).max(1.0) } else { reach(model) };
        let weight = model.mass() * acceleration * arm;
        let mut random = SplitMix64::new(seed);
        let states = (0..states).map(|_| State::draw(model, &mut random, weight)).collect();
        Self { model, states, weight }
    }

    /// Whether M is positive definite wherever it was looked at, so that accelerations exist.
    pub(crate) fn has_accelerations(&self) -> bool {
        self.states.iter().all(|state| state.condition.is_finite())
    }

    /// The states with their numbers.
    pub(crate) fn states(&self) -> impl Iterator<Item = (usize, &State)> {
        self.states.iter().enumerate()
    }
}

impl State {
    /// q within the limits; speeds up to the limits, but 2 rad/s at most; accelerations up to 5 rad/s²; motor
    /// forces that would accelerate each joint alone by as much, beside its weight.
    fn draw(model: &Model, random: &mut SplitMix64, weight: f64) -> Self {
        let (nv, workspace) = (model.nv(), &mut Workspace::new(model));
        let q = random_within_limits(model, random);
        let limits = model.coordinate_limits();
        let v: Vec<f64> = limits.iter().map(|l| l.velocity.min(2.0) * random.uniform(-1.0, 1.0)).collect();
        let a: Vec<f64> = (0..nv).map(|_| random.uniform(-5.0, 5.0)).collect();
        let mut mass = vec![0.0; nv * nv];
        multibody::mass_matrix(model, workspace, &q, &mut mass);
        let mut tau = vec![0.0; nv];
        multibody::gravity(model, workspace, &q, &mut tau);
        let springs = largest(&tau);
        for (i, tau) in tau.iter_mut().enumerate() {
            *tau += mass[i * nv + i] * random.uniform(-5.0, 5.0);
        }
        let (inertia, speed) = (largest(&mass), norm(&v));
        let force = norm(&tau) + springs + weight + inertia * speed * speed;
        let condition = condition(&mass, nv);
        Self { q, v, a, tau, mass, inertia, condition, speed, force }
    }

    /// How far rounding may move the solution of M a = f: an error δ of f or of M a moves it by M⁻¹δ, at most
    /// κ(M) δ/‖M‖. 64 ε for each, as a tree is at most some tens of joints deep.
    pub(crate) fn acceleration_error(&self, a: &[f64]) -> f64 {
        64.0 * f64::EPSILON * self.condition * (self.force / self.inertia + norm(a))
    }
}

/// λmax/λmin; infinite where λmin is not above the rounding of λmax.
fn condition(mass: &[f64], nv: usize) -> f64 {
    let eigenvalues = DMatrix::from_row_slice(nv, nv, mass).symmetric_eigenvalues();
    let (low, high) = (eigenvalues.min(), eigenvalues.max());
    if low > f64::EPSILON * high { high / low } else { f64::INFINITY }
}

/// An upper bound of how far any mass gets from the root: offsets, slides and centres of mass added up \[m\].
pub(crate) fn reach(model: &Model) -> f64 {
    let description = model.description();
    let length = |x: &[f64]| norm(x);
    let offsets: f64 =
        description.joints.iter().map(|joint| length(&joint.parent_from_joint.translation)).sum();
    let slides: f64 = model
        .joints()
        .iter()
        .filter(|joint| joint.kind == "prismatic")
        .map(|joint| [joint.limits.lower, joint.limits.upper].into_iter().filter(|x| x.is_finite()))
        .map(|bounds| bounds.fold(0.0_f64, |most, x| most.max(x.abs())))
        .sum();
    let centers = description.links.iter().filter_map(|link| link.mass_properties.as_ref());
    let centers = centers.map(|properties| properties.center_of_mass().norm()).fold(0.0, f64::max);
    offsets + slides + centers
}

/// max |aᵢ − bᵢ|; NaN if any is.
pub(crate) fn difference(a: &[f64], b: &[f64]) -> f64 {
    let defects = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    defects.fold(0.0, |worst: f64, x| if x.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(x) })
}

/// max |aᵢ|.
pub(crate) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()))
}

/// |a|.
pub(crate) fn norm(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |norm: f64, x| norm.hypot(*x))
}

/// a·b.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
