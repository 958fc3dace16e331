//! Whether M(q) can be inverted, watched by the pivots of the articulated-body recursion, O(n).
//!
//! Eliminating freedom k leaves the pivot dₖ = sᵀIᴬs + armature, Iᴬ the inertia felt with all freedoms beyond k
//! free. It is twice the kinetic energy of one motion: z with zₖ = 1, the freedoms beyond k following without
//! force, the others at rest; dₖ = zᵀM z. **(RBDA §7.1)** M is singular exactly if some dₖ vanishes.
//!
//! In floating point none vanishes exactly, and one that should comes out with either sign, as rounding. M_ij is
//! known to about ε √(Nᵢ Nⱼ), where Nᵢ ≥ M_ii adds up the same terms as M_ii without their cancelling (see
//! [`Extent`](crate::scratch::extent::Extent)); the factorisation of M into pivots adds no more than as much again for each
//! freedom on the way. Source: Higham, *Accuracy and Stability of Numerical Algorithms* (2002), thm 10.5. So dₖ is
//! known to about ε (Σ |zᵢ| √Nᵢ)², and no motion of the robot has an energy that can be told from zero where
//!
//! dₖ ≤ 16 ε (Σ |zᵢ| √Nᵢ)².
//!
//! The bound has no unit and no scale: it asks what is left of the terms, not how large they are. A light link
//! that carries a heavy one keeps its pivot; two coaxial joints with nothing between lose theirs. Where freedom k
//! moves alone it is dₖ ≤ 16 ε Nₖ. Where the freedoms beyond k are nearly singular themselves their |zᵢ| grow, and
//! with them the noise that the pivot is compared with.
//!
//! A pivot that vanished is not divided by: its freedom is held, and the elimination goes on without it. The
//! pivots that vanish are then as many as the dimension of M's null space. All is computed along the world's axes
//! about each body's own origin, so that neither long slides nor a distant base cost digits.

mod bodies;
mod followers;
mod singular;
mod tree;

pub use singular::{SingularMass, SingularMotion};

use crate::model::length::check_length;
use crate::model::native::NativeFunction;
use crate::scratch::extent::Scratch;
use crate::scratch::native::computed_natively;
use crate::scratch::tree::TreeMemory;
use crate::{InstructionSet, Model, MotionError, Workspace, check_configuration};

/// How many roundings of (Σ |zᵢ| √Nᵢ)² a pivot must exceed.
///
/// A sum of products over a body makes some ten roundings of its largest terms, and a chain adds a few for each
/// body; they mostly cancel. Measured (see the tests): pivots that should vanish come out below 1 on hundreds of
/// singular robots of 2 to 100 joints, of masses that differ by 1e12 too. A pivot of a healthy robot is found from
/// 0.04/(κ ε) on, κ the condition of M scaled to ones on its diagonal: above 1e3 where masses differ by 1e12,
/// above 1e8 on all usual robots. 16 accuses none with κ below 1e13, whose accelerations have digits left.
const ROUNDINGS: f64 = 16.0;

/// Where dₖ/Nₖ times the least dᵢ/Nᵢ beyond is above the bound by this, z need not be known: the |zᵢ| √Nᵢ grow about
/// like the root of Nᵢ/dᵢ, and the factor is left for their sum.
const CLEAR: f64 = 1e6;

/// A pivot that vanished.
struct Vanished<'a> {
    /// Its coordinate.
    index: usize,
    /// dₖ.
    pivot: f64,
    /// Nₖ.
    inertia: f64,
    /// |zᵢ| √Nᵢ by coordinate, from `index` to the last that hangs on it.
    share: &'a [f64],
}

/// The rank of M(q) to rounding: nv, less one for each motion that moves no inertia in this configuration.
///
/// O(n), without forming M; a robot with followers (mimic) or armature on tendons takes its whole M and O(n³). A pivot that overflows
/// counts as regular: what is computed with it is not finite and says so. [`Model::singular_motions`] names the
/// joints. q is taken as it is.
///
/// ```
/// use multibody::{Model, RandomRobotOptions, Workspace, mass_rank, neutral, random_robot};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// assert_eq!(mass_rank(&model, &mut Workspace::new(&model), &neutral(&model)), model.nv());
/// # Ok::<(), multibody::ModelError>(())
/// ```
///
/// # Panics
/// If q has the wrong length.
#[track_caller]
pub fn mass_rank(model: &Model, workspace: &mut Workspace, q: &[f64]) -> usize {
    workspace.admit(model, q);
    let mut rank = model.nv;
    watch(model, &mut workspace.tree, &mut workspace.rank, q, ROUNDINGS, &mut |_| rank -= 1);
    rank
}

/// Refuses a configuration in which M(q) is singular, in the time of [`mass_rank`]; it allocates only to say so.
///
/// For loops that call [`forward_dynamics`](crate::forward_dynamics), which takes every q as it is. Runs
/// ([`Simulation`](crate::simulator::Simulation)) and the methods of [`Model`] call it themselves.
///
/// ```
/// use multibody::{Model, Workspace, check_rank, pendulum};
/// let mut robot = pendulum(2.0, 0.5);
/// let model = Model::new(robot.clone())?;
/// check_rank(&model, &mut Workspace::new(&model), &[0.3])?;
/// // With its mass in the hinge the pendulum resists no torque.
/// let point = dynamics::MassProperties::point(2.0, nalgebra::Vector3::zeros())?;
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
    workspace.admit(model, q);
    refuse_singular(model, &mut workspace.tree, &mut workspace.rank, q)
}

fn refuse_singular(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut Scratch,
    q: &[f64],
) -> Result<(), SingularMass> {
    if scratch.has_extents && is_regular_natively(model, tree, scratch, q) {
        return Ok(());
    }
    let mut motions = Vec::new();
    watch(model, tree, scratch, q, ROUNDINGS, &mut |vanished| {
        motions.push(SingularMotion::named(model, vanished));
    });
    scratch.has_extents = scratch.keeps_extents;
    if motions.is_empty() { Ok(()) } else { Err(SingularMass { motions }) }
}

/// Whether machine code finds pivots that tell beyond doubt that M is regular. N of each freedom is known from a call before.
fn is_regular_natively(model: &Model, tree: &mut TreeMemory<f64>, scratch: &mut Scratch, q: &[f64]) -> bool {
    check_length("q", q.len(), model.nq);
    let Scratch { inverse, root, .. } = scratch;
    let function = NativeFunction::InversePivots;
    computed_natively(model, &mut tree.native, function, &[q], &mut [&mut inverse[..]])
        && are_regular(inverse, root)
}

/// Whether N/d of each freedom, of 1/d and √N, is so small that no further look is needed: dₖ/Nₖ times the least dᵢ/Nᵢ is then 70 times above the
/// bound.
pub(crate) fn are_regular(inverse: &[f64], root: &[f64]) -> bool {
    const MOST: f64 = 2000.0;
    inverse.iter().zip(root).all(|(inverse, root)| {
        let ratio = inverse * root * root;
        ratio > 0.0 && ratio < MOST
    })
}

/// √N of each freedom where it is the same in all configurations, as of robots that have hinges alone.
#[cfg(all(feature = "batch", feature = "native"))]
pub(crate) fn constant_extents(model: &Model) -> Option<Vec<f64>> {
    let mut workspace = Workspace::new(model);
    if !workspace.rank.keeps_extents {
        return None;
    }
    let _ = check_rank(model, &mut workspace, &crate::neutral(model));
    Some(workspace.rank.root)
}

/// Shows every pivot that vanishes, from the last coordinate to the first.
fn watch(
    model: &Model,
    tree: &mut TreeMemory<f64>,
    scratch: &mut Scratch,
    q: &[f64],
    roundings: f64,
    see: &mut dyn FnMut(&Vanished<'_>),
) {
    check_length("q", q.len(), model.nq);
    let bound = roundings * f64::EPSILON;
    if model.couples_branches {
        followers::eliminate(model, tree, scratch, q, bound, see);
    } else {
        tree::eliminate(model, tree, scratch, q, bound, see);
    }
}

/// Whether dₖ/Nₖ is so large, beside the least dᵢ/Nᵢ beyond, that z need not be known; not where either is NaN.
#[inline(always)]
fn is_clear(left: f64, least: f64, bound: f64) -> bool {
    left > 0.0 && left * least.min(left) > CLEAR * bound
}

/// Whether dₖ is no more than rounding; `size` is Σ |zᵢ| √Nᵢ. Negative pivots are, those that overflowed are not.
#[inline(always)]
fn vanishes(pivot: f64, bound: f64, size: f64) -> bool {
    pivot.is_finite() && pivot <= bound * size * size
}

impl Model {
    /// The motions that move no inertia in this configuration: none where M(q) is positive definite, else a basis of
    /// its null space by the joints that take part in each.
    ///
    /// ```
    /// use multibody::{JointDescription, JointKind, LinkDescription, Model, Pose, RobotDescription};
    /// // Two hinges about one axis, and a link without mass between them.
    /// let rod = dynamics::MassProperties::solid_box(100.0, [0.5, 0.1, 0.1].into())?;
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
    /// [`MotionError::Configuration`] where q is no configuration.
    pub fn singular_motions(&self, q: &[f64]) -> Result<Vec<SingularMotion>, MotionError> {
        match self.check_rank(q) {
            Ok(()) => Ok(Vec::new()),
            Err(MotionError::SingularMass(mass)) => Ok(mass.motions),
            Err(error) => Err(error),
        }
    }

    /// The allocating twin of [`check_rank`], with checked input. It takes O(n) memory, unlike a [`Workspace`].
    ///
    /// # Errors
    /// [`MotionError::SingularMass`] names the joints whose motion moves no inertia; [`MotionError::Configuration`]
    /// where q is no configuration.
    pub fn check_rank(&self, q: &[f64]) -> Result<(), MotionError> {
        check_configuration(self, q)?;
        self.check_mass(q)
    }

    /// [`Model::check_rank`] of a q that was checked.
    pub(crate) fn check_mass(&self, q: &[f64]) -> Result<(), MotionError> {
        let mut tree = TreeMemory::limited(self, &[], InstructionSet::best());
        Ok(refuse_singular(self, &mut tree, &mut Scratch::new(self), q)?)
    }

    /// The joints that move no inertia along one of their axes in any pose, in the order of [`Model::joints`]: massless
    /// fingers and sensors at the ends of branches, mostly. M is singular in every pose while there are such joints;
    /// what does not invert M works. [`RobotDescription::lock_massless`](crate::RobotDescription::lock_massless)
    /// holds them still.
    ///
    /// ```
    /// use multibody::{Model, pendulum};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.links[1].mass_properties = None; // the hinge moves nothing
    /// assert!(Model::new(robot)?.massless_joints().eq(["hinge"]));
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    pub fn massless_joints(&self) -> impl Iterator<Item = &str> {
        self.massless.iter().map(|&joint| self.joints[joint].name.as_str())
    }
}

#[cfg(test)]
mod tests;
