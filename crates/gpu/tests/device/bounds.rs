//! Bounds on the difference between singles and doubles.
//!
//! A recursion passes along the tree outward and inward with some sixteen operations a joint on the longest
//! chain. Each operation has an error of ε/2 of a number that is at most as large as the sum that it belongs
//! to. A sine has 2 ε, a quotient 2.5 ε. Signs of errors are random, so within a joint they grow as the root
//! of their number; over joints they are added. This gives k = 4 nv roundings ε of the intermediate numbers.
//! Their size follows from rᵢ². If joint i is prismatic, rᵢ² is the mass of its subtree. Otherwise it is the
//! subtree's moment of inertia about the worst axis through the joint's origin or that of a joint before it.
//! M and a are found in a frame with the origin of one of these (`core/src/kinematics/world_frame.rs`). By
//! Cauchy and Schwarz no part of M_ij exceeds rᵢ rⱼ, and no part of τᵢ exceeds rᵢ f,
//!
//! f = Σ rⱼ |aⱼ| + Σ |ωₖ| Σ rⱼ |vⱼ| + √m |g|,
//!
//! with the rotational ones among v for ω, and springs in addition to the weight. So δM_ij ≤ k ε rᵢ rⱼ and
//! δτᵢ ≤ k ε rᵢ f. As rᵢ δaᵢ solves with M̂_ij = M_ij/(rᵢ rⱼ), it is at most k ε κ (f + max |τᵢ|/rᵢ), κ =
//! 1/λ(M̂), λ the least eigenvalue.

use nalgebra::{DMatrix, Vector3};
use robot_dynamics::description::CoordinateKind;
use robot_dynamics::model::Model;
use robot_dynamics_gpu::Function;

/// The bounds on the errors of a state's results.
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
        // An eigenvalue below the rounding of the largest is indistinguishable from that.
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

    /// The bounds for accelerations.
    pub(crate) fn acceleration(&self, tau: &[f64]) -> Vec<f64> {
        let given = tau.iter().zip(&self.roots).map(|(tau, root)| (tau / root).abs()).fold(0.0, f64::max);
        let off = self.rounding * self.condition * (self.force + given);
        self.roots.iter().map(|root| off / root).collect()
    }

    /// Whether singles determine M at all.
    pub(crate) fn is_known(&self) -> bool {
        self.rounding * self.condition < 0.1
    }
}

/// Whether the bounds of a function contain κ: it inverts M.
pub(crate) fn inverts_mass(function: &Function) -> bool {
    let symbol = function.symbol();
    let inverts = ["forward_dynamics", "inverse_mass_matrix", "mass_matrix_factor"];
    inverts.iter().any(|name| symbol.starts_with(name)) || symbol.contains("_step")
}

/// For each coordinate of v, whether it is rotational.
fn turns(model: &Model) -> Vec<bool> {
    let mut turns = vec![false; model.nv()];
    for joint in model.joints().iter().filter(|joint| joint.nv > 0) {
        for (k, velocity) in joint.kind.velocities().iter().enumerate() {
            turns[joint.v_index + k] = velocity.kind == CoordinateKind::Angle;
        }
    }
    turns
}

/// rᵢ, including the mimic joints of joint i, and at least √M_ii, which includes armature and rotors.
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
            let there = hanging_on(model, q, &joint.child_link, &about.child_link);
            hanging = there.0;
            moment = moment.max(there.1);
            origin = model.joints().iter().find(|before| before.child_link == about.parent_link);
        }
        for (k, velocity) in joint.kind.velocities().iter().enumerate() {
            let square = if velocity.kind == CoordinateKind::Angle { moment } else { hanging };
            squares[first + k] += ratio * ratio * square;
        }
    }
    squares.iter().enumerate().map(|(i, square)| square.max(mass[(i, i)]).sqrt()).collect()
}

/// The mass of a link's subtree, and its largest possible moment about a link's origin: a moment is at most
/// half of the trace.
fn hanging_on(model: &Model, q: &[f64], link: &str, about: &str) -> (f64, f64) {
    let pose = |link: &str| model.frame_pose(q, model.frame_named(link).unwrap()).unwrap();
    let origin = Vector3::from(pose(about).translation);
    let mut pending = vec![link];
    let (mut mass, mut trace) = (0.0, 0.0);
    while let Some(name) = pending.pop() {
        pending.extend(
            model
                .joints()
                .iter()
                .filter(|joint| joint.parent_link == name)
                .map(|joint| joint.child_link.as_str()),
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
