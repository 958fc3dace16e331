//! The numerical rank of M(q), from the pivots of the articulated-body recursion, O(n).
//!
//! Eliminating DoF k leaves the pivot dₖ = sᵀIᴬs + armature, with Iᴬ the inertia while all DoFs beyond k are
//! free. The pivot is dₖ = zᵀM z, twice the kinetic energy of a motion z. In it zₖ = 1, the DoFs beyond k
//! move without force, and the others rest. **(RBDA §7.1)** M is singular exactly if some dₖ vanishes.
//!
//! In floating point a vanishing pivot comes out as rounding of either sign. The error of M_ij is about
//! ε √(Nᵢ Nⱼ). Here Nᵢ ≥ M_ii adds the terms of M_ii without cancellation (see
//! [`MassExtent`](crate::workspace::extent::MassExtent)). The factorization adds at most the same error for each DoF
//! on the way. Source: Higham, *Accuracy and Stability of Numerical Algorithms* (2002), thm 10.5. So the
//! error of dₖ is about ε (Σ |zᵢ| √Nᵢ)², and the motion z has no energy distinguishable from zero if
//!
//! dₖ ≤ 16 ε (Σ |zᵢ| √Nᵢ)².
//!
//! The bound has no unit and no scale: it depends on the cancellation of the terms, not on their size. A
//! light link that carries a heavy one keeps its pivot; two coaxial joints with no inertia between them lose
//! theirs. If DoF k moves alone, the bound is dₖ ≤ 16 ε Nₖ. If the DoFs beyond k are nearly singular, their
//! |zᵢ| grow, and so does the bound.
//!
//! The elimination skips a vanished pivot: it locks that DoF and goes on without it. The number of vanished
//! pivots is the dimension of M's null space. All quantities are along the world's axes about each body's own
//! origin, so that long slides and a distant base do not cost accuracy.

mod bodies;
mod coupled_branches;
mod singular_mass;
mod tree;
mod vanished_pivot;

pub use singular_mass::{SingularMass, SingularMotion};
use vanished_pivot::{ROUNDINGS, VanishedPivot};

use robot_dynamics_description::check_length;

use crate::model::native::NativeFunction;
use crate::workspace::extent::RankBuffers;
use crate::workspace::native::computed_natively;
use crate::workspace::tree::TreeMemory;
use crate::{InstructionSet, Model, MotionError, Workspace, check_configuration};

/// The numerical rank of M(q): nv, less one for each motion that moves no inertia in this configuration.
///
/// O(n), without M; for a robot with mimic joints or armature on tendons, O(n³) with the whole M. A pivot
/// that overflows counts as regular: results computed with it are not finite. [`Model::singular_motions`]
/// names the joints. The function does not check or normalize q.
///
/// ```
/// use robot_dynamics::algorithms::mass_rank;
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, Workspace, neutral};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// assert_eq!(mass_rank(&model, &mut Workspace::new(&model), &neutral(&model)), model.nv());
/// # Ok::<(), robot_dynamics::description::ModelError>(())
/// ```
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn mass_rank(model: &Model, workspace: &mut Workspace, q: &[f64]) -> usize {
    workspace.check_inputs(model, q);
    let mut rank = model.nv;
    for_each_vanished(model, &mut workspace.tree, &mut workspace.rank, q, ROUNDINGS, &mut |_| rank -= 1);
    rank
}

/// Rejects a configuration in which M(q) is singular, in the time of [`mass_rank`]. It allocates only for the
/// error.
///
/// For loops that call [`forward_dynamics`](crate::forward_dynamics), which does not check. Runs
/// (`Simulation`) and the methods of [`Model`] call this function themselves.
///
/// ```
/// use robot_dynamics::algorithms::check_rank;
/// use robot_dynamics::description::pendulum;
/// use robot_dynamics::model::{Model, Workspace};
/// let mut robot = pendulum(2.0, 0.5);
/// let model = Model::new(robot.clone())?;
/// check_rank(&model, &mut Workspace::new(&model), &[0.3])?;
/// // With its mass at the hinge the pendulum has no inertia.
/// let point = robot_dynamics::description::MassProperties::point(2.0, nalgebra::Vector3::zeros())?;
/// robot.links[1].mass_properties = Some(point);
/// let model = Model::new(robot)?;
/// let refused = check_rank(&model, &mut Workspace::new(&model), &[0.3]).unwrap_err();
/// assert!(refused.to_string().contains("hinge"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`SingularMass`] names the joints whose motion moves no inertia.
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn check_rank(model: &Model, workspace: &mut Workspace, q: &[f64]) -> Result<(), SingularMass> {
    workspace.check_inputs(model, q);
    refuse_singular(model, &mut workspace.tree, &mut workspace.rank, q)
}

fn refuse_singular(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut RankBuffers,
    q: &[f64],
) -> Result<(), SingularMass> {
    if scratch.has_extents && is_regular_natively(model, tree, scratch, q) {
        return Ok(());
    }
    let mut motions = Vec::new();
    for_each_vanished(model, tree, scratch, q, ROUNDINGS, &mut |vanished| {
        motions.push(SingularMotion::named(model, vanished));
    });
    scratch.has_extents = scratch.keeps_extents;
    if motions.is_empty() { Ok(()) } else { Err(SingularMass { motions }) }
}

/// Whether machine code finds pivots that prove M regular. N of each DoF is known from a previous call.
fn is_regular_natively(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut RankBuffers,
    q: &[f64],
) -> bool {
    check_length("q", q.len(), model.nq);
    let RankBuffers { inverse, root, .. } = scratch;
    let function = NativeFunction::InversePivots;
    computed_natively(model, &mut tree.native, function, &[q], &mut [&mut inverse[..]])
        && are_regular(inverse, root)
}

/// Whether N/d of each DoF, from 1/d and √N, is small enough to skip the exact test. Then dₖ/Nₖ times the
/// least dᵢ/Nᵢ is at least 70 times the bound.
pub fn are_regular(inverse: &[f64], root: &[f64]) -> bool {
    const MOST: f64 = 2000.0;
    inverse.iter().zip(root).all(|(inverse, root)| {
        let ratio = inverse * root * root;
        ratio > 0.0 && ratio < MOST
    })
}

/// √N of each DoF if it is the same in all configurations, as for robots with revolute joints only.
#[cfg(feature = "native")]
pub fn constant_extents(model: &Model) -> Option<Vec<f64>> {
    let mut workspace = Workspace::new(model);
    if !workspace.rank.keeps_extents {
        return None;
    }
    let _ = check_rank(model, &mut workspace, &crate::neutral(model));
    Some(workspace.rank.root)
}

/// Calls `on_vanished` for every pivot that vanishes, from the last coordinate to the first.
fn for_each_vanished(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut RankBuffers,
    q: &[f64],
    roundings: f64,
    on_vanished: &mut dyn FnMut(&VanishedPivot<'_>),
) {
    check_length("q", q.len(), model.nq);
    let bound = roundings * f64::EPSILON;
    if model.needs_dense_factor {
        coupled_branches::eliminate(model, tree, scratch, q, bound, on_vanished);
    } else {
        tree::eliminate(model, tree, scratch, q, bound, on_vanished);
    }
}

impl Model {
    /// The motions that move no inertia in this configuration, each given by the joints that take part. They
    /// are a basis of the null space of M(q). Empty if M(q) is positive definite.
    ///
    /// ```
    /// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose};
    /// use robot_dynamics::description::RobotDescription;
    /// use robot_dynamics::model::Model;
    /// // Two hinges about one axis, with a massless link between them.
    /// let rod = robot_dynamics::description::MassProperties::solid_box(100.0, [0.5, 0.1, 0.1].into())?;
    /// let mut robot = RobotDescription::new("twice");
    /// for (name, mass_properties) in [("base", None), ("ghost", None), ("rod", Some(rod))] {
    ///     robot.links.push(LinkDescription::new(name, mass_properties));
    /// }
    /// for (name, parent, child) in [("first", "base", "ghost"), ("second", "ghost", "rod")] {
    ///     let hinge = JointKind::Revolute { axis: [0.0, 0.0, 1.0] };
    ///     robot.joints.push(JointDescription::new(name, hinge, parent, child, Pose::IDENTITY));
    /// }
    /// let motions = Model::new(robot)?.singular_motions(&[0.1, 0.2])?;
    /// assert_eq!(motions.len(), 1);
    /// assert_eq!(motions[0].joints, ["first", "second"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`MotionError::Input`] if q is an invalid configuration.
    pub fn singular_motions(&self, q: &[f64]) -> Result<Vec<SingularMotion>, MotionError> {
        match self.check_rank(q) {
            Ok(()) => Ok(Vec::new()),
            Err(MotionError::SingularMass(mass)) => Ok(mass.motions),
            Err(error) => Err(error),
        }
    }

    /// [`check_rank`] with checked input. It allocates O(n) memory, but no [`Workspace`].
    ///
    /// # Errors
    /// [`MotionError::SingularMass`] names the joints whose motion moves no inertia.
    /// [`MotionError::Input`] reports an invalid configuration q.
    pub fn check_rank(&self, q: &[f64]) -> Result<(), MotionError> {
        check_configuration(self, q)?;
        self.check_mass(q)
    }

    /// Whether M is positive definite in every configuration because each link behind a joint is a body with
    /// inertia in all directions. If not, M may still be positive definite, and [`check_rank`] decides in
    /// each configuration. It computes the principal moments of all links; store the answer for loops.
    ///
    /// ```
    /// use robot_dynamics::description::{RandomRobotOptions, pendulum, random_robot};
    /// use robot_dynamics::model::Model;
    /// assert!(Model::new(random_robot(3, &RandomRobotOptions::default()))?.is_always_regular());
    /// assert!(!Model::new(pendulum(2.0, 0.5))?.is_always_regular()); // a point mass on a rod
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn is_always_regular(&self) -> bool {
        let description = self.description();
        let moved = description.joints.iter().filter(|joint| joint.kind.nv() > 0);
        moved.map(|joint| &joint.child).all(|child| {
            let link = description.links.iter().find(|link| link.name == *child);
            link.and_then(|link| link.mass_properties.as_ref()).is_some_and(|body| {
                let moments = body.inertia_about_center_of_mass().symmetric_eigenvalues();
                body.mass() > 0.0 && moments.min() > 1e-9 * moments.max()
            })
        })
    }

    /// [`Model::check_rank`] for a q that is already checked.
    pub fn check_mass(&self, q: &[f64]) -> Result<(), MotionError> {
        let mut tree = TreeMemory::limited(self, &[], InstructionSet::best());
        Ok(refuse_singular(self, &mut tree, &mut RankBuffers::new(self), q)?)
    }

    /// The joints that move no inertia along one of their axes in any pose, in the order of
    /// [`Model::joints`]. Mostly these are massless fingers and sensors at the ends of branches. With such
    /// joints M is singular in every pose; functions that do not invert M work.
    /// [`lock_massless`](crate::lock_massless) locks them.
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.links[1].mass_properties = None; // the hinge moves no mass
    /// assert!(Model::new(robot)?.massless_joints().eq(["hinge"]));
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    pub fn massless_joints(&self) -> impl Iterator<Item = &str> {
        self.massless.iter().map(|&joint| self.joints[joint].name.as_str())
    }
}

#[cfg(test)]
mod tests;
