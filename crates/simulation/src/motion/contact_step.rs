//! A step with contact, joint stops and friction by a fixed number of sweeps, over any number type.
//!
//! The step is semi-implicit, with the joints' damping D at its end:
//!
//! ```text
//! (M + h D)(v₁ − v) = h(τ − C v − g − D v) + Jᵀp,   q₁ = q ⊕ h v₁
//! contact:  c_n ≥ b, p_n ≥ 0, p_n (c_n − b) = 0;  |p_t| ≤ μ p_n, p_t against c_t where it slides
//! stop:     lower ≤ v₁ ≤ upper, p against the stop;  friction:  |p| ≤ h f, p against v₁ where it slides
//! ```
//!
//! c = J v₁ is the velocity of a contact point. Its bound b is −gap/h, so a point does not pass the ground
//! within the step. If it has penetrated, b is −gap/(h + 0.1 s), which lifts it out. Bounds of stops are the
//! same. Contacts do not rebound.
//!
//! The multipliers p follow from a fixed number of projected Gauss-Seidel sweeps, which start from given
//! multipliers, mostly those of the last step. There is no branch on a value and no convergence test.
//! Therefore the step runs over traced numbers, dual numbers and lanes, and a device computes it with one
//! thread for each state. A fixed point of the sweeps satisfies Signorini's and Coulomb's laws exactly, since
//! a sweep projects normal and tangential impulses separately.
//!
//! With M + h D = LᵀDL the rows are divided by √D L, so that each row, and each update of the velocity,
//! reads only the coordinates on one path to the root. A sweep takes 12 operations for each contact and each
//! coordinate that moves it.
//!
//! Sources: Moreau, *Unilateral contact and dry friction in finite freedom dynamics* (1988), for the laws in
//! impulses. Jourdan, Alart & Jean, *A Gauss-Seidel like algorithm to solve frictional contact problems*
//! (1998), for the sweeps. RBDA §6.5 for the factor.

mod end;
mod points;
mod problem;
mod sweep;

use robot_dynamics_core::factorization::sparse::{coordinate_parents, dof_ancestors};
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_core::{Model, Workspace, dissipation_derivative};
use robot_dynamics_description::{JointKind, check_length};
use robot_dynamics_number::{InvalidInput, Scalar};

use self::points::{ContactShapePoints, shapes_on_ground};

/// The time constant with which a penetration or a violated stop is corrected \[s\].
const RETURN_TIME: f64 = crate::contact::RETURN_TIME;

/// The state and inputs of a step: \[nq\], \[nv\], \[nv\], h \[s\], μ of the ground, and the multipliers
/// that the sweeps start from.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct ContactStepInputs<'a, S> {
    /// The configuration.
    pub q: &'a [S],
    /// The velocity.
    pub v: &'a [S],
    /// The generalized force, constant over the step.
    pub tau: &'a [S],
    /// The length of the step \[s\].
    pub h: S,
    /// μ of every contact.
    pub friction: S,
    /// The initial multipliers, mostly those of the last step; see [`ContactStep::impulse_count`].
    pub impulses: &'a [S],
}

impl<'a, S> ContactStepInputs<'a, S> {
    /// The inputs in the order of the fields.
    pub const fn new([q, v, tau]: [&'a [S]; 3], h: S, friction: S, impulses: &'a [S]) -> Self {
        Self { q, v, tau, h, friction, impulses }
    }
}

/// A row of a joint: its coordinate, and what acts on it.
#[derive(Clone, Copy, Debug)]
struct JointRow {
    coordinate: usize,
    kind: JointRowKind,
}

#[derive(Clone, Copy, Debug)]
enum JointRowKind {
    /// Coulomb friction \[N·m or N\].
    Friction(f64),
    /// Limits of the entry `q` of the configuration.
    Stop { q: usize, lower: f64, upper: f64 },
}

impl JointRowKind {
    /// The count of numbers that follow the row: its mobility and its bounds.
    const fn numbers(self) -> usize {
        match self {
            Self::Friction(_) => 2,
            Self::Stop { .. } => 3,
        }
    }
}

/// A step with contact of one robot on the ground z = 0; see the module's documentation for its equations.
///
/// The collision shapes of moving links touch the ground: spheres, capsules, boxes, cylinders, ellipsoids.
/// Contacts between links are not computed.
///
/// ```
/// use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// use robot_dynamics::simulation::{ContactStep, ContactStepInputs};
/// let mut robot = pendulum(2.0, 0.5);
/// let bob = LinkShape::new("rod", ShapeRole::Collision, Pose::from_translation([0.5, 0.0, 0.0]), Shape::Sphere { radius: 0.1 });
/// robot.shapes.push(bob);
/// let model = Model::new(robot)?;
/// let step = ContactStep::new(&model, 16)?;
/// let mut impulses = vec![0.0; step.impulse_count()];
/// // The ball at the end of the rod, level with the hinge at z = 0, is below the ground and is lifted.
/// let (mut q, mut v, before) = ([0.0_f64], [0.0_f64], impulses.clone());
/// let inputs = ContactStepInputs::new([&[0.0], &[0.0], &[0.0]], 0.01, 0.8, &before);
/// step.step(&model, &mut Workspace::new(&model), &inputs, &mut q, &mut v, &mut impulses);
/// assert!((0.5 * v[0].abs() - 0.1 / 0.11).abs() < 1e-6); // gap/(h + 0.1 s) at 0.5 m
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct ContactStep {
    robot: Identity,
    sweeps: usize,
    dof_parent: Vec<usize>,
    damping: Vec<f64>,
    joints: Vec<JointRow>,
    shapes: Vec<ContactShapePoints>,
    /// For each contact point the last coordinate that moves it.
    point_coordinates: Vec<usize>,
    links: Vec<String>,
    /// Softens rows that no motion changes \[1/kg\].
    least_mobility: f64,
}

impl ContactStep {
    /// The step of this robot with this number of sweeps.
    ///
    /// # Errors
    /// [`InvalidInput`]: no sweep, a shape without known points (a mesh) that can touch the ground, or a
    /// closed loop or another equality.
    pub fn new(model: &Model, sweeps: usize) -> Result<Self, InvalidInput> {
        if sweeps == 0 {
            return Err(InvalidInput::unmet("the number of sweeps", "must be at least 1"));
        }
        if let Some(equality) = model.description().equalities.first() {
            let quantity = format!("equality `{}`", equality.name);
            let wanted = "must be removed: a step with contact by sweeps has no equalities";
            return Err(InvalidInput::unmet(quantity, wanted));
        }
        let shapes = shapes_on_ground(model)?;
        let mut damping = vec![0.0; model.nv()];
        dissipation_derivative(model, &mut damping);
        let points = shapes.iter().flat_map(|shape| vec![shape.coordinate; shape.count()]);
        let links = shapes.iter().flat_map(|shape| vec![shape.link.clone(); shape.count()]);
        Ok(Self {
            robot: model.identity.clone(),
            sweeps,
            dof_parent: coordinate_parents(model),
            damping,
            joints: joint_rows(model),
            point_coordinates: points.collect(),
            links: links.collect(),
            shapes,
            least_mobility: 1e-6 / model.mass().max(1e-6),
        })
    }

    /// The link of each contact point.
    pub fn links(&self) -> &[String] {
        &self.links
    }

    /// The number of sweeps.
    pub const fn sweeps(&self) -> usize {
        self.sweeps
    }

    /// The count of multipliers: three for each contact point (along z, x and y \[N·s\]), in the order of
    /// [`links`](Self::links), then one for each friction and stop of a joint \[N·m·s or N·s\].
    pub fn impulse_count(&self) -> usize {
        3 * self.point_coordinates.len() + self.joints.len()
    }

    /// The count of numbers of the table `problem`, which describes the problem of a step.
    pub fn problem_count(&self) -> usize {
        let path = |k: usize| self.path_length(k);
        let factor: usize = (0..self.dof_parent.len()).map(path).sum();
        let contacts: usize = self.point_coordinates.iter().map(|&k| 3 * path(k) + 3).sum();
        let joint = |row: &JointRow| path(row.coordinate) + row.kind.numbers();
        factor + self.joints.iter().map(joint).sum::<usize>() + contacts + 1
    }

    /// The number of coordinates on the path from k to the root.
    fn path_length(&self, k: usize) -> usize {
        1 + dof_ancestors(&self.dof_parent, k).count()
    }

    /// Computes a step from (q, v) to `q_next`, `v_next` and the multipliers `impulses`. It does not check
    /// that numbers are finite.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the step belongs to another robot.
    #[track_caller]
    pub fn step<S: Scalar>(
        &self,
        model: &Model,
        workspace: &mut Workspace<S>,
        inputs: &ContactStepInputs<'_, S>,
        q_next: &mut [S],
        v_next: &mut [S],
        impulses: &mut [S],
    ) {
        check_length("the multipliers", impulses.len(), self.impulse_count());
        let mut problem = vec![S::zero(); self.problem_count()];
        let mut velocity = vec![S::zero(); model.nv()];
        self.prepare(model, workspace, inputs, &mut problem, &mut velocity);
        impulses.copy_from_slice(inputs.impulses);
        self.start(&problem, impulses, &mut velocity);
        for _ in 0..self.sweeps {
            self.sweep(&problem, &mut velocity, impulses);
        }
        self.finish(model, &problem, (inputs.q, inputs.h), &velocity, q_next, v_next);
    }
}

/// The rows of joint friction and of stops.
fn joint_rows(model: &Model) -> Vec<JointRow> {
    let mut rows = Vec::new();
    for joint in model.joints().iter().filter(|joint| joint.mimic.is_none()) {
        let coordinates = joint.v_index..joint.v_index + joint.nv;
        if joint.passive.friction > 0.0 {
            let kind = JointRowKind::Friction(joint.passive.friction);
            rows.extend(coordinates.map(|coordinate| JointRow { coordinate, kind }));
        }
        let has_one = matches!(joint.kind, JointKind::Revolute { .. } | JointKind::Prismatic { .. });
        let (lower, upper) = (joint.limits.lower, joint.limits.upper);
        if has_one && (lower.is_finite() || upper.is_finite()) {
            let kind = JointRowKind::Stop { q: joint.q_index, lower, upper };
            rows.push(JointRow { coordinate: joint.v_index, kind });
        }
    }
    rows
}

/// max(x, 0) without a branch; exact.
fn positive_part<S: Scalar>(x: S) -> S {
    (x + x * x.signum0()).scale(0.5)
}
