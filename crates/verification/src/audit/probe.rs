//! The random states of an audit, and bounds of their rounding errors.

use std::collections::HashMap;

use nalgebra::DMatrix;
use robot_dynamics_core::{Joint, Model, SingularMass, Workspace, check_rank, neutral, random_within_limits};
use robot_dynamics_description::{CoordinateKind, JointKind, MassProperties};
use robot_dynamics_number::SplitMix64;

/// A robot and its states.
pub(super) struct Probe<'a> {
    pub model: &'a Model,
    /// The robot of the second computation of each number, normally the same. A test uses a slightly heavier
    /// one, which every check must detect.
    pub reference: &'a Model,
    pub states: Vec<State>,
    /// m |gravity| times the robot's reach: a bound of the terms of g \[N·m\].
    pub weight: f64,
    /// The cause if M is singular in the zero configuration.
    pub singular_at_zeros: Option<SingularMass>,
}

/// A state with the magnitudes of its quantities.
pub(super) struct State {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    pub tau: Vec<f64>,
    /// M by the recursion, row-major.
    pub mass: Vec<f64>,
    /// The largest |M_ij|.
    pub inertia: f64,
    /// κ(M) by eigenvalues; infinite if M is singular.
    pub condition: f64,
    /// The cause of a singular M.
    pub singular: Option<SingularMass>,
    /// |v|.
    pub speed: f64,
    /// |M⁻¹| by entries; empty if M is singular.
    inverse: Vec<f64>,
    /// nᵢⱼ: a bound of the sum of the terms of M_ij.
    terms: Vec<f64>,
    /// A bound of the sum of the terms of (τ − C v − g)ᵢ.
    forces: Vec<f64>,
}

/// The rounding error of a sum: up to 4500 roundings of its largest term.
pub(super) const ROUNDING: f64 = 1e-12;

impl<'a> Probe<'a> {
    pub(super) fn new(model: &'a Model, states: u32, seed: u64) -> Self {
        let acceleration = model.gravity().iter().fold(0.0_f64, |norm, x| norm.hypot(*x));
        let has_slides = model
            .joints()
            .iter()
            .any(|joint| matches!(joint.kind, JointKind::Helical { .. }) || slides(joint, 0));
        // A slide carries the weight itself, which corresponds to an arm of one meter.
        let arm = if has_slides { reach(model).max(1.0) } else { reach(model) };
        let weight = model.mass() * acceleration * arm;
        let mut random = SplitMix64::new(seed);
        let arms = Arms::of(model);
        let states = (0..states).map(|_| State::draw(model, &mut random, &arms)).collect();
        let singular_at_zeros = check_rank(model, &mut Workspace::new(model), &neutral(model)).err();
        Self { model, reference: model, states, weight, singular_at_zeros }
    }

    /// Whether M is positive definite at every state, so that accelerations exist.
    pub(super) fn has_accelerations(&self) -> bool {
        self.states.iter().all(|state| state.condition.is_finite() && !state.inverse.is_empty())
    }

    /// The states with their indices.
    pub(super) fn states(&self) -> impl Iterator<Item = (usize, &State)> {
        self.states.iter().enumerate()
    }
}

impl State {
    /// Draws a state: q within the limits, speeds up to the limits but at most 2 rad/s, and accelerations up
    /// to 5 rad/s². Motor forces would accelerate each joint alone by as much, in addition to its weight.
    fn draw(model: &Model, random: &mut SplitMix64, arms: &Arms) -> Self {
        let (nv, workspace) = (model.nv(), &mut Workspace::new(model));
        let q = random_within_limits(model, random);
        let limits = model.coordinate_limits();
        let v: Vec<f64> = limits.iter().map(|l| l.velocity.min(2.0) * random.uniform(-1.0, 1.0)).collect();
        let a: Vec<f64> = (0..nv).map(|_| random.uniform(-5.0, 5.0)).collect();
        let mut mass = vec![0.0; nv * nv];
        robot_dynamics_core::mass_matrix(model, workspace, &q, &mut mass);
        let mut tau = vec![0.0; nv];
        robot_dynamics_core::gravity(model, workspace, &q, &mut tau);
        // g includes springs, which may exceed any weight.
        let springs = tau.clone();
        for (i, tau) in tau.iter_mut().enumerate() {
            *tau += mass[i * nv + i] * random.uniform(-5.0, 5.0);
        }
        let (inertia, speed) = (largest(&mass), norm(&v));
        let singular = check_rank(model, workspace, &q).err();
        let condition = if singular.is_some() { f64::INFINITY } else { condition(&mass, nv) };
        let (inverse, terms) = (inverse(&mass, nv), arms.mass_terms(&mass));
        let force = |i: usize| tau[i].abs() + springs[i].abs() + arms.force_terms(i, speed);
        let forces = (0..nv).map(force).collect();
        Self { q, v, a, tau, mass, inertia, condition, singular, speed, inverse, terms, forces }
    }

    /// The rounding of each row of M a + C v + g = τ, for sums of these terms. It is 64 ε Σ|terms|, because a
    /// tree is at most some tens of joints deep.
    fn force_errors(&self, a: &[f64]) -> Vec<f64> {
        let row = |i: usize| -> f64 {
            a.iter().zip(&self.terms[i * a.len()..]).map(|(a, term)| term * a.abs()).sum()
        };
        (0..a.len()).map(|i| 64.0 * f64::EPSILON * (row(i) + self.forces[i])).collect()
    }

    /// The effect of rounding on each entry of the solution of M a = f. Errors δ of the rows change it by at
    /// most |M⁻¹| δ, entry by entry. **(Skeel 1979)** Unlike κ(M) ‖δ‖ this does not grow with the ratio of
    /// heavy to light links, or of meters to radians.
    pub(super) fn acceleration_errors(&self, a: &[f64]) -> Vec<f64> {
        let errors = self.force_errors(a);
        let rows = self.inverse.chunks(a.len());
        rows.map(|row| row.iter().zip(&errors).map(|(m, error)| m * error).sum()).collect()
    }

    /// The rounding of the power vᵀ(M a + C v + g − τ). An acceleration that solves its equation up to
    /// rounding has a residual within the rows' errors, however ill-conditioned M is.
    pub(super) fn power_error(&self, a: &[f64]) -> f64 {
        self.v.iter().zip(self.force_errors(a)).map(|(v, error)| v.abs() * error).sum()
    }
}

/// The magnitudes of the terms that the recursions add for each coordinate. They are forces and inertias of
/// all bodies that it moves, about points at the distance of the robot's reach.
struct Arms {
    /// The mass that each coordinate moves \[kg\].
    mass: Vec<f64>,
    /// Its lever arm: the robot's reach for a rotation, 1 for a slide \[m or 1\].
    lever: Vec<f64>,
    /// Whether it rotates bodies that slides carry.
    shifts_reference_point: Vec<bool>,
    reach: f64,
    gravity: f64,
}

impl Arms {
    fn of(model: &Model) -> Self {
        let links = model.description().links.iter();
        let mut below: HashMap<&str, f64> = links
            .map(|link| (link.name.as_str(), link.mass_properties.as_ref().map_or(0.0, MassProperties::mass)))
            .collect();
        let reach = reach(model).max(f64::MIN_POSITIVE);
        let (mut mass, mut lever) = (vec![0.0; model.nv()], vec![0.0_f64; model.nv()]);
        // Children follow their parents.
        for joint in model.joints().iter().rev() {
            let moved = below.get(joint.child_link.as_str()).copied().unwrap_or_default();
            *below.entry(joint.parent_link.as_str()).or_default() += moved;
            let leader = joint.mimic.as_ref().and_then(|m| model.joints().iter().find(|j| j.name == m.joint));
            let (first, count) =
                leader.map_or((joint.v_index, joint.nv), |leader| (leader.v_index, leader.nv));
            let ratio = joint.mimic.as_ref().map_or(1.0, |mimic| mimic.ratio.abs());
            for i in first..first + count {
                let is_screw = matches!(joint.kind, JointKind::Helical { .. });
                mass[i] += moved;
                // A screw joint does both.
                let arm = if slides(joint, i - first) { 1.0 } else { reach + f64::from(u8::from(is_screw)) };
                lever[i] = lever[i].max(ratio * arm);
            }
        }
        let gravity = norm(&model.gravity());
        let slide =
            |joint: &Joint, i: usize| slides(joint, i) || matches!(joint.kind, JointKind::Helical { .. });
        let has_slides = model.joints().iter().any(|joint| (0..joint.nv).any(|i| slide(joint, i)));
        let mut shifts_reference_point = vec![false; model.nv()];
        for joint in model.joints() {
            for i in 0..joint.nv {
                shifts_reference_point[joint.v_index + i] |= has_slides && !slides(joint, i);
            }
        }
        Self { mass, lever, shifts_reference_point, reach, gravity }
    }

    /// |M_ij| + m lᵢ lⱼ, where m is the mass that both move.
    fn mass_terms(&self, mass: &[f64]) -> Vec<f64> {
        let n = self.mass.len();
        let coarse = |i: usize, j: usize| self.mass[i].min(self.mass[j]) * self.lever[i] * self.lever[j];
        (0..n * n).map(|at| mass[at].abs() + coarse(at / n, at % n)).collect()
    }

    /// m lᵢ (g + r ω²): weight, and centrifugal forces at the robot's reach r. If slides move it at the
    /// velocity u, the moment u × m u is zero, but the products in it are m u².
    fn force_terms(&self, i: usize, speed: f64) -> f64 {
        let carried = if self.shifts_reference_point[i] { speed * speed } else { 0.0 };
        self.mass[i] * (self.lever[i] * (self.gravity + self.reach * speed * speed) + carried)
    }
}

/// |M⁻¹| by entries, empty if M is not positive definite: D (D M D)⁻¹ D with D = diag(M)^(−½), which keeps the digits of light links next to heavy ones.
fn inverse(mass: &[f64], n: usize) -> Vec<f64> {
    let scale: Vec<f64> = (0..n).map(|i| mass[i * n + i].sqrt().recip()).collect();
    let scaled = DMatrix::from_fn(n, n, |i, j| scale[i] * mass[i * n + j] * scale[j]);
    let Some(factor) = scaled.cholesky() else { return Vec::new() };
    let inverse = factor.inverse();
    (0..n * n).map(|at| (scale[at / n] * inverse[(at / n, at % n)] * scale[at % n]).abs()).collect()
}

/// λmax/λmin, at most 1/ε: a smaller λmin is below the rounding of λmax.
fn condition(mass: &[f64], nv: usize) -> f64 {
    let eigenvalues = DMatrix::from_row_slice(nv, nv, mass).symmetric_eigenvalues();
    let (low, high) = (eigenvalues.min(), eigenvalues.max());
    high / low.max(f64::EPSILON * high)
}

/// An upper bound of the distance of any mass from the root: the sum of offsets, slides and centers of mass
/// \[m\].
pub(super) fn reach(model: &Model) -> f64 {
    let description = model.description();
    let length = |x: &[f64]| norm(x);
    let offsets: f64 =
        description.joints.iter().map(|joint| length(&joint.parent_from_joint.translation)).sum();
    let slides: f64 = model
        .joints()
        .iter()
        .filter(|joint| matches!(joint.kind, JointKind::Prismatic { .. }))
        .map(|joint| [joint.limits.lower, joint.limits.upper].into_iter().filter(|x| x.is_finite()))
        .map(|bounds| bounds.fold(0.0_f64, |most, x| most.max(x.abs())))
        .sum();
    let centers = description.links.iter().filter_map(|link| link.mass_properties.as_ref());
    let centers = centers.map(|properties| properties.center_of_mass().norm()).fold(0.0, f64::max);
    offsets + slides + centers
}

/// The defect |aᵢ − bᵢ| and its bound, for the i with the largest ratio; NaN if any entry is NaN.
pub(super) fn worst_entry(a: &[f64], b: &[f64], allowed: &[f64]) -> (f64, f64) {
    let defects = a.iter().zip(b).zip(allowed).map(|((a, b), allowed)| ((a - b).abs(), *allowed));
    let ratio = |(found, allowed): (f64, f64)| if found == 0.0 { 0.0 } else { found / allowed };
    defects.fold((0.0, 0.0), |worst, entry| {
        let is_worse = worst.1 == 0.0 || ratio(entry) > ratio(worst) || entry.0.is_nan();
        if is_worse && !worst.0.is_nan() { entry } else { worst }
    })
}

/// max |aᵢ − bᵢ|; NaN if any entry is NaN.
pub(super) fn difference(a: &[f64], b: &[f64]) -> f64 {
    let defects = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    defects.fold(0.0, |worst: f64, x| if x.is_nan() || worst.is_nan() { f64::NAN } else { worst.max(x) })
}

/// max |aᵢ|.
pub(super) fn largest(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |worst: f64, x| worst.max(x.abs()))
}

/// |a|.
pub(super) fn norm(a: &[f64]) -> f64 {
    a.iter().fold(0.0, |norm: f64, x| norm.hypot(*x))
}

/// a·b.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Whether entry k of a joint's v is the rate of a length.
fn slides(joint: &Joint, k: usize) -> bool {
    joint.kind.velocities().get(k).is_some_and(|velocity| velocity.kind == CoordinateKind::Length)
}
