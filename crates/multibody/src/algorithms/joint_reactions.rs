//! The force and moment that each joint transmits, fixed joints included.
//!
//! A joint carries everything beyond it. With F and N the rates of momentum of one link less gravity and
//! external wrenches, about the link's origin, the reaction is (f, n) = Σ (F, N + r × F) over the links
//! beyond, r from the joint to each link's origin. The recursion is that of Newton and Euler over links
//! instead of bodies: links that fixed joints merge are taken one by one. **(RBDA §5.3)**

use dynamics::Scalar;

use crate::algorithms::inverse_dynamics::{accelerate_along_world_axes, upward};
use crate::model::WORLD;
use crate::model::length::check_length;
use crate::model::segment::Segment;
use crate::scratch::tree::TreeMemory;
use crate::spatial::algebra::{M3, V3};
use crate::spatial::screw::{AxisMotion, Force};
use crate::stages::place::{evaluate_angles, spread};
use crate::stages::wrench::FrameWrench;
use crate::{Model, Workspace};

/// How many numbers a reaction has.
pub(crate) const NUMBERS: usize = 6;

/// The wrench that each joint transmits from its parent link to its child link, as a force-torque sensor in
/// the joint reads it. Results are six numbers a joint, \[fx, fy, fz, nx, ny, nz\] in N and N·m, in the order
/// of [`Model::joints`]; fixed joints and joints with `mimic` have theirs.
///
/// - **Side**: the wrench acts on the child; the parent receives its opposite. A robot at rest on its base reads its
///   weight upwards.
/// - **Point and axes**: moments are about the origin of the child link's frame, which is where the joint's frame is at
///   q, and both parts are along that frame's axes.
/// - **Sum**: bearings, motor, spring, damping and friction between the two links act together. The component along the
///   joint's axis is the generalized force M a + C v + g without armature and springs. Armature does not pass the joint
///   as a wrench.
/// - **Floating joints** transmit nothing: where a is the motion under the given wrenches, their six numbers are zero to
///   rounding. Numbers that are not show a wrench that is missing.
///
/// `wrenches` holds all that acts on links from outside the tree: contacts, pushes, thrusters, the forces of
/// loops. Those on the root link of a fixed base pass no joint.
///
/// ```
/// use multibody::{JointDescription, JointKind, LinkDescription, Model, Pose, Workspace};
/// use multibody::{joint_reactions, pendulum};
/// let mut robot = pendulum(2.0, 0.5); // 2 kg at the end of a rod of 0.5 m
/// let tool = dynamics::MassProperties::point(0.3, nalgebra::Vector3::zeros())?;
/// robot.links.push(LinkDescription::new("tool", tool));
/// let at = Pose::from_translation([0.7, 0.0, 0.0]);
/// robot.joints.push(JointDescription::new("flange", JointKind::Fixed, "rod", "tool", at));
/// let model = Model::new(robot)?;
/// let mut reactions = [0.0; 12]; // two joints: hinge, flange
/// joint_reactions(&model, &mut Workspace::new(&model), &[0.0], &[3.0], &[0.0], &[], &mut reactions);
/// // The flange lifts the tool and pulls it towards the hinge, m v² r; the hinge carries both.
/// let flange = &reactions[6..];
/// assert!((flange[0] + 0.3 * 3.0_f64.powi(2) * 0.7).abs() < 1e-14);
/// assert!((flange[2] - 0.3 * 9.81).abs() < 1e-14);
/// assert!((reactions[2] - 2.3 * 9.81).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace or a frame is another model's.
#[doc(alias = "force-torque sensor")]
#[doc(alias = "constraint forces")]
#[track_caller]
pub fn joint_reactions<S: Scalar>(
    model: &Model,
    workspace: &mut Workspace<S>,
    q: &[S],
    v: &[S],
    a: &[S],
    wrenches: &[FrameWrench<S>],
    reactions: &mut [S],
) {
    workspace.admit(model, q);
    check_length("v", v.len(), model.nv);
    check_length("a", a.len(), model.nv);
    check_length("the reactions", reactions.len(), NUMBERS * model.joints.len());
    let (tree, first) = (&mut workspace.tree, model.segments.first);
    inertial_forces(model, tree, (q, v, a), first, reactions);
    for wrench in wrenches {
        subtract_wrench(model, tree, wrench, reactions);
    }
    collect(model, tree, first, reactions);
}

/// The force that each link from number `first` on takes for itself, against gravity, along the world's axes
/// and about its origin.
pub(crate) fn inertial_forces<S: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<S>,
    (q, v, a): (&[S], &[S], &[S]),
    first: usize,
    reactions: &mut [S],
) {
    evaluate_angles(model, tree, q);
    spread(model, v, &mut tree.freedoms.v);
    spread(model, a, &mut tree.freedoms.a);
    accelerate_along_world_axes(model, tree, q, upward(model));
    for (segment, to) in model.segments.list[first..].iter().zip(reactions.chunks_exact_mut(NUMBERS)) {
        write(&inertial_force(model, tree, segment), to);
    }
}

/// From forces of single links to forces of all that is beyond, along the axes of each link.
pub(crate) fn collect<S: Scalar>(model: &Model, tree: &TreeMemory<S>, first: usize, reactions: &mut [S]) {
    let segments = &model.segments.list;
    for index in (first..segments.len()).rev() {
        let segment = &segments[index];
        let Some(parent) = segment.parent.filter(|&parent| parent >= first) else { continue };
        let lever = lever(model, tree, &segments[parent], segment);
        let Force { linear, angular } = read(&reactions[NUMBERS * (index - first)..]);
        let below = &mut reactions[NUMBERS * (parent - first)..];
        let mut sum = read(below);
        sum.linear += linear;
        sum.angular += angular + lever.cross(linear);
        write(&sum, below);
    }
    for (segment, to) in segments[first..].iter().zip(reactions.chunks_exact_mut(NUMBERS)) {
        let (turn, force) = (rotation(tree, segment), read(to));
        let own =
            Force { linear: turn.transpose_mul(force.linear), angular: turn.transpose_mul(force.angular) };
        write(&own, to);
    }
}

pub(crate) fn read<S: Scalar>(from: &[S]) -> Force<S> {
    let three = |at: usize| V3::new([from[at], from[at + 1], from[at + 2]]);
    Force { linear: three(0), angular: three(3) }
}

pub(crate) fn write<S: Scalar>(force: &Force<S>, to: &mut [S]) {
    to[..3].copy_from_slice(&force.linear.array());
    to[3..NUMBERS].copy_from_slice(&force.angular.array());
}

/// The link's axes in the world.
pub(crate) fn rotation<S: Scalar>(tree: &TreeMemory<S>, segment: &Segment) -> M3<S> {
    let own = M3::constant(&segment.rotation);
    match segment.body {
        Some(body) => tree.screws.world[body].rotation.times(&own),
        None => own,
    }
}

/// From the origin of the link's body, or of the world, to the link's, along the world's axes.
fn offset<S: Scalar>(tree: &TreeMemory<S>, segment: &Segment) -> V3<S> {
    let own = V3::constant(&segment.translation);
    match segment.body {
        Some(body) => tree.screws.world[body].rotation * own,
        None => own,
    }
}

/// From the origin of a link to that of one that it carries, along the world's axes.
fn lever<S: Scalar>(model: &Model, tree: &TreeMemory<S>, parent: &Segment, child: &Segment) -> V3<S> {
    let mut lever = offset(tree, child) - offset(tree, parent);
    let (mut at, end) = (child.body.unwrap_or(WORLD), parent.body.unwrap_or(WORLD));
    // A joint of several freedoms is several bodies in series.
    while at != end {
        lever += tree.screws.world[at].translation;
        at = model.bodies[at].parent;
    }
    lever
}

/// F = m a + α × h + ω × (ω × h) and N = h × a + I α + ω × I ω of one link, about its origin, a − g for a.
fn inertial_force<S: Scalar>(model: &Model, tree: &TreeMemory<S>, segment: &Segment) -> Force<S> {
    let still = AxisMotion { angular: V3::zero(), alpha: V3::zero(), origin: V3::from_f64(upward(model)) };
    let motion = segment.body.map_or(still, |body| tree.bodies.axis_motion[body]);
    let AxisMotion { angular, alpha, origin } = motion;
    let arm = offset(tree, segment);
    let at = if segment.body.is_some() {
        origin + alpha.cross_sum(arm, angular, angular.cross(arm))
    } else {
        origin
    };
    let turn = rotation(tree, segment);
    let h = turn * V3::constant(&segment.first_moment);
    let linear = alpha.cross_sum(h, angular, angular.cross(h)).add_scaled(S::from_f64(segment.mass), at);
    let inertia = M3::constant(&segment.inertia);
    let (own_angular, own_alpha) = (turn.transpose_mul(angular), turn.transpose_mul(alpha));
    let spin = inertia.times_plus(own_alpha, own_angular.cross(inertia * own_angular));
    Force { linear, angular: turn.times_plus(spin, h.cross(at)) }
}

/// Takes an external wrench off what the joint of its link must supply.
fn subtract_wrench<S: Scalar>(
    model: &Model,
    tree: &TreeMemory<S>,
    wrench: &FrameWrench<S>,
    reactions: &mut [S],
) {
    let frame = model.frame_of(wrench.frame);
    let index = model.segments.of_link[frame.link];
    let Some(joint) = index.checked_sub(model.segments.first) else { return };
    let (segment, mut turn) = (&model.segments.list[index], M3::constant(&frame.rotation));
    let mut arm = V3::constant(&frame.translation) - V3::constant(&segment.translation);
    if let Some(body) = frame.body {
        let body = &tree.screws.world[body].rotation;
        (turn, arm) = (body.times(&turn), *body * arm);
    }
    let force = turn * V3::new(wrench.force_in_frame);
    let mut sum = read(&reactions[NUMBERS * joint..]);
    sum.linear -= force;
    sum.angular -= turn.times_plus(V3::new(wrench.moment_in_frame), arm.cross(force));
    write(&sum, &mut reactions[NUMBERS * joint..]);
}
