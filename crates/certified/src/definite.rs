//! Proofs that M(q) is positive definite in a box of configurations.
//!
//! 2 K = vᵀM v is the sum of the bodies' energies and those of the rotors. If the spatial inertia of every
//! body is positive definite, or all of its joint's DoFs have a rotor, the first moving joint from the root
//! has energy: M is positive definite in every configuration. Otherwise the box is divided, and the pivots of
//! M = L D Lᵀ are computed in intervals.

use robot_dynamics_core::joint::PrimitiveJoint;
use robot_dynamics_core::model::{Body, WORLD};
use robot_dynamics_core::{Model, Workspace, mass_matrix};

use crate::linear::{check_box, is_positive_definite, one_turn};
use crate::search::{Divisions, SearchOptions, middle};
use crate::{EnclosureError, Interval};

/// The result of a search for a proof.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Definiteness {
    /// Proven in every configuration, since every body has inertia or rotors of its own.
    ByOwnInertias,
    /// Proven in the box, by this many parts of it.
    ByDivision {
        /// The number of boxes.
        boxes: usize,
        /// The divisions.
        tree: Divisions,
    },
    /// M is not positive definite at this configuration, or so near to it that rounding hides it.
    Disproven {
        /// The configuration.
        q: Vec<f64>,
    },
    /// The search ended before a proof. M is not proven to be positive definite in this box.
    Open {
        /// The box.
        region: Vec<Interval>,
    },
}

impl Definiteness {
    /// Whether M is proven to be positive definite.
    pub fn is_proven(&self) -> bool {
        matches!(self, Self::ByOwnInertias | Self::ByDivision { .. })
    }
}

/// Whether M(q) is positive definite for every q in a box.
///
/// ```
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::Model;
/// use robot_dynamics_certified::{Interval, SearchOptions, mass_matrix_definiteness};
/// let model = Model::new(pendulum(2.0, 0.5))?;
/// let found = mass_matrix_definiteness(&model, &[Interval::new(-3.2, 3.2)], &SearchOptions::default())?;
/// assert!(found.is_proven());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`EnclosureError`] if an interval is unbounded or a box of quaternions. Configurations do not matter if
/// every body has inertia of its own, so those boxes are accepted then.
///
/// # Panics
/// If q has the wrong length.
pub fn mass_matrix_definiteness(
    model: &Model,
    q: &[Interval],
    options: &SearchOptions,
) -> Result<Definiteness, EnclosureError> {
    assert_eq!(q.len(), model.nq(), "q has {} entries, but {} are needed", q.len(), model.nq());
    let has_no_negative_rotor = model.dofs.iter().all(|dof| dof.passive.armature >= 0.0)
        && model.description().tendons.iter().all(|tendon| tendon.passive.armature >= 0.0);
    if has_no_negative_rotor && model.bodies.iter().all(|body| has_energy(model, body)) {
        return Ok(Definiteness::ByOwnInertias);
    }
    let q = relevant(model, turns_once(model, q));
    check_box(model, &q)?;
    let nv = model.nv();
    let mut workspace = Workspace::new(model);
    let mut mass = vec![Interval::from(0.0); nv * nv];
    let mut is_definite = |q: &[Interval]| {
        mass_matrix(model, &mut workspace, q, &mut mass);
        is_positive_definite(&mass, nv)
    };
    let mut tree = Divisions::root();
    let mut pending = vec![(q, 0)];
    let mut boxes = 0;
    while let Some((region, node)) = pending.pop() {
        boxes += 1;
        if is_definite(&region) {
            continue;
        }
        let point: Vec<Interval> = middle(&region).into_iter().map(Interval::from).collect();
        if !is_definite(&point) {
            return Ok(Definiteness::Disproven { q: middle(&region) });
        }
        let width = |k: &usize| region[*k].width();
        let widest = (0..region.len()).max_by(|a, b| width(a).total_cmp(&width(b)));
        let Some(widest) = widest.filter(|_| boxes < options.boxes && !options.is_interrupted()) else {
            return Ok(Definiteness::Open { region });
        };
        for (node, half) in tree.divide(node, widest).into_iter().zip(region[widest].halves()) {
            let mut region = region.clone();
            region[widest] = half;
            pending.push((region, node));
        }
    }
    Ok(Definiteness::ByDivision { boxes, tree })
}

/// The box with one turn for each revolute joint that has a wider interval and no mimic joints.
pub(crate) fn turns_once(model: &Model, q: &[Interval]) -> Vec<Interval> {
    let mut q = q.to_vec();
    if model.has_mimic() {
        return q;
    }
    for body in model.bodies.iter().filter(|body| body.motion == PrimitiveJoint::Revolute) {
        q[body.q_index] = one_turn(q[body.q_index]);
    }
    q
}

/// The box with a single configuration of the joints at the root, as M does not depend on it.
fn relevant(model: &Model, mut q: Vec<Interval>) -> Vec<Interval> {
    if model.has_mimic() {
        return q;
    }
    let neutral = robot_dynamics_core::neutral(model);
    for body in model.bodies.iter().filter(|body| body.parent == WORLD) {
        let count = match body.motion.nv() {
            1 => 1,
            several => several + 1,
        };
        for k in body.q_index..body.q_index + count {
            q[k] = Interval::from(neutral[k]);
        }
    }
    q
}

/// Whether every motion of the body relative to its parent has kinetic energy, whatever the parent does.
fn has_energy(model: &Model, body: &Body) -> bool {
    let dofs = &model.dofs[body.dof..body.dof + body.motion.nv()];
    dofs.iter().all(|dof| dof.passive.armature > 0.0) || is_positive_definite(&spatial_inertia(body), 6)
}

/// \[m 1, −h×; h×, I\] about the body's origin, 6 × 6.
fn spatial_inertia(body: &Body) -> [Interval; 36] {
    let mut inertia = [Interval::from(0.0); 36];
    let [x, y, z, ..] = body.first_moment;
    let cross = [[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]];
    for i in 0..3 {
        inertia[7 * i] = body.mass.into();
        for j in 0..3 {
            inertia[6 * (i + 3) + j] = cross[i][j].into();
            inertia[6 * i + j + 3] = cross[j][i].into();
            inertia[6 * (i + 3) + j + 3] = body.inertia[j][i].into();
        }
    }
    inertia
}
