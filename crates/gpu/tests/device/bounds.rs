//! How far singles may be from doubles.
//!
//! A recursion passes along the tree outward and inward with some sixteen operations a joint on the longest chain, each off by
//! ε/2 of a number that is no larger than what it is part of, by 2 ε for a sine and 2.5 ε for a quotient. Errors are as often up as
//! down, so that they grow as the root of their number within a joint, and are let add up over joints: k = 4 nv roundings ε
//! of the numbers on the way. How large these are: let rᵢ² be what hangs on joint i, its mass where the joint slides, where it turns its
//! moment of inertia about the worst axis through the joint's origin or that of one before it, as M and a are found in a frame with
//! the origin of one of these (`multibody/src/stages/screws.rs`). By Cauchy and Schwarz no part of M_ij is beyond rᵢ rⱼ, and no part of
//! τᵢ beyond rᵢ f,
//!
//! f = Σ rⱼ |aⱼ| + Σ |ωₖ| Σ rⱼ |vⱼ| + √m |g|,
//!
//! with the turning ones among v for ω, and springs beside the weight. So δM_ij ≤ k ε rᵢ rⱼ, δτᵢ ≤ k ε rᵢ f, and as rᵢ δaᵢ
//! solves with M̂_ij = M_ij/(rᵢ rⱼ), it is at most k ε κ (f + max |τᵢ|/rᵢ), κ = 1/λ(M̂), λ the least eigenvalue.

use gpu::Function;
use multibody::{Measure, Model};
use nalgebra::{DMatrix, Vector3};

/// What a state's results may be off by.
pub(crate) struct Bounds {
    /// k ε.
    pub(crate) rounding: f64,
    /// rᵢ.
    pub(crate) roots: Vec<f64>,
    /// κ.
    pub(crate) condition: f64,
    /// f.
    pub(crate) force: f64,
}

/// max |x|.
pub(crate) fn size(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

impl Bounds {
    pub(crate) fn new(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Self {
        let nv = model.nv();
        let mass = model.mass_matrix(q).unwrap();
        let roots = roots(model, q, &mass);
        let scaled = DMatrix::from_fn(nv, nv, |i, j| mass[(i, j)] / (roots[i] * roots[j]));
        // An eigenvalue below the rounding of the largest is not known any better than that.
        let least = scaled.symmetric_eigenvalues().min().max(f64::EPSILON);
        let sum = |x: &[f64]| x.iter().zip(&roots).map(|(x, root)| (x * root).abs()).sum::<f64>();
        let turning: f64 = v.iter().zip(turns(model)).filter(|(_, turns)| *turns).map(|(v, _)| v.abs()).sum();
        let [x, y, z] = model.gravity();
        let weight = (model.mass() * (x * x + y * y + z * z)).sqrt();
        let gravity = model.gravity_forces(q).unwrap();
        let springs = gravity.iter().zip(&roots).map(|(g, root)| (g / root).abs()).fold(0.0, f64::max);
        Self {
            rounding: 4.0 * nv as f64 * f64::from(f32::EPSILON),
            condition: 1.0 / least,
            force: sum(a) + turning * sum(v) + weight + springs,
            roots,
        }
    }

    /// Of accelerations.
    pub(crate) fn acceleration(&self, tau: &[f64]) -> Vec<f64> {
        let given = tau.iter().zip(&self.roots).map(|(tau, root)| (tau / root).abs()).fold(0.0, f64::max);
        let off = self.rounding * self.condition * (self.force + given);
        self.roots.iter().map(|root| off / root).collect()
    }

    /// Whether M is known to singles at all.
    pub(crate) fn is_known(&self) -> bool {
        self.rounding * self.condition < 0.1
    }
}

/// Whether a function's results have κ in them: those that invert M.
pub(crate) fn inverts_mass(function: &Function) -> bool {
    let symbol = function.symbol();
    let inverts = ["forward_dynamics", "inverse_mass_matrix", "mass_matrix_factor"];
    inverts.iter().any(|name| symbol.starts_with(name)) || symbol.contains("_step")
}

/// Whether each coordinate of v turns.
fn turns(model: &Model) -> Vec<bool> {
    let mut turns = vec![false; model.nv()];
    for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
        for (k, velocity) in joint.kind.velocities().iter().enumerate() {
            turns[joint.v_index + k] = velocity.measure == Measure::Angle;
        }
    }
    turns
}

/// rᵢ, those of joints that follow one with it, and at least √M_ii, which has armature and rotors too.
fn roots(model: &Model, q: &[f64], mass: &DMatrix<f64>) -> Vec<f64> {
    let mut squares = vec![0.0; model.nv()];
    for joint in model.joints() {
        let (first, ratio) = match &joint.mimic {
            Some(mimic) => {
                let leader = model.joints().iter().find(|leader| leader.name == mimic.joint).unwrap();
                (leader.v_index, mimic.ratio)
            }
            None => (joint.v_index, 1.0),
        };
        let (mut hanging, mut moment, mut origin) = (0.0, 0.0_f64, Some(joint));
        while let Some(about) = origin {
            let there = hanging_on(model, q, &joint.child, &about.child);
            hanging = there.0;
            moment = moment.max(there.1);
            origin = model.joints().iter().find(|before| before.child == about.parent);
        }
        for (k, velocity) in joint.kind.velocities().iter().enumerate() {
            let square = if velocity.measure == Measure::Angle { moment } else { hanging };
            squares[first + k] += ratio * ratio * square;
        }
    }
    squares.iter().enumerate().map(|(i, square)| square.max(mass[(i, i)]).sqrt()).collect()
}

/// The mass of a link and of all that hangs on it, and its largest possible moment about a link's origin: a moment is at most half of
/// the trace.
fn hanging_on(model: &Model, q: &[f64], link: &str, about: &str) -> (f64, f64) {
    let pose = |link: &str| model.frame_pose(q, model.frame_named(link).unwrap()).unwrap();
    let origin = Vector3::from(pose(about).translation);
    let mut pending = vec![link];
    let (mut mass, mut trace) = (0.0, 0.0);
    while let Some(name) = pending.pop() {
        pending.extend(
            model.joints().iter().filter(|joint| joint.parent == name).map(|joint| joint.child.as_str()),
        );
        let description = model.description().links.iter().find(|there| there.name == name).unwrap();
        let Some(properties) = &description.mass_properties else { continue };
        let center = Vector3::from(pose(name).apply(properties.center_of_mass().into()));
        mass += properties.mass();
        trace += properties.inertia_about_center_of_mass().trace();
        trace += 2.0 * properties.mass() * (center - origin).norm_squared();
    }
    (mass, 0.5 * trace)
}
