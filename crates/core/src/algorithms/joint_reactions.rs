//! The force and moment that each joint transmits, including fixed joints.
//!
//! Let F and N be the rates of momentum of one link, less gravity and external wrenches, about the link's
//! origin. The reaction of a joint is (f, n) = Σ (F, N + r × F) over the links beyond it. Here r is the
//! vector from the joint to each link's origin. The recursion is Newton–Euler over links instead of bodies:
//! links merged by fixed joints count separately. Cost: O(n). **(RBDA §5.3)**

use robot_dynamics_description::check_length;
use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

use crate::algorithms::inverse_dynamics::{accelerate_along_world_axes, upward};
use crate::kinematics::placement::{evaluate_angles, spread};
use crate::kinematics::wrench::FrameWrench;
use crate::model::WORLD;
use crate::model::segment::Segment;
use crate::spatial::force::ForceVector;
use crate::spatial::motion::AxisMotion;
use crate::workspace::tree::TreeMemory;
use crate::{Model, Workspace};

/// The length of one reaction.
pub const NUMBERS: usize = 6;

/// The wrench that each joint transmits from its parent link to its child link, as a force-torque sensor in
/// the joint measures it. The result has six numbers per joint, \[fx, fy, fz, nx, ny, nz\] in N and N·m, in
/// the order of [`Model::joints`]. Fixed joints and mimic joints are included.
///
/// - **Side**: the wrench acts on the child; the parent receives its opposite. A robot at rest on its base
///   reads its weight upwards.
/// - **Point and axes**: moments are about the origin of the child link's frame, which is the origin of the
///   joint's frame at q. Both parts are along the axes of that frame.
/// - **Sum**: bearings, motor, spring, damping and friction between the two links act together. The component
///   along the joint's axis is the generalized force M a + C v + g without armature and springs. Armature
///   does not transmit a wrench through the joint.
/// - **Floating joints** transmit nothing. If a is the motion under the given wrenches, their six numbers are
///   zero up to rounding. Other values mean that a wrench is missing.
///
/// `wrenches` holds all external forces on links: contacts, pushes, thrusters, constraint forces of loops.
/// Wrenches on the root link of a fixed base do not pass through a joint.
///
/// ```
/// use robot_dynamics::algorithms::joint_reactions;
/// use robot_dynamics::description::{JointDescription, JointKind, LinkDescription, Pose, pendulum};
/// use robot_dynamics::model::{Model, Workspace};
/// let mut robot = pendulum(2.0, 0.5); // 2 kg at the end of a 0.5 m rod
/// let tool = robot_dynamics::description::MassProperties::point(0.3, nalgebra::Vector3::zeros())?;
/// robot.links.push(LinkDescription::new("tool", tool));
/// let at = Pose::from_translation([0.7, 0.0, 0.0]);
/// robot.joints.push(JointDescription::new("flange", JointKind::Fixed, "rod", "tool", at));
/// let model = Model::new(robot)?;
/// let mut reactions = [0.0; 12]; // two joints: hinge, flange
/// joint_reactions(&model, &mut Workspace::new(&model), &[0.0], &[3.0], &[0.0], &[], &mut reactions);
/// // The flange supports the tool's weight and its centripetal force m v² r; the hinge carries both links.
/// let flange = &reactions[6..];
/// assert!((flange[0] + 0.3 * 3.0_f64.powi(2) * 0.7).abs() < 1e-14);
/// assert!((flange[2] - 0.3 * 9.81).abs() < 1e-14);
/// assert!((reactions[2] - 2.3 * 9.81).abs() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Panics
/// If a slice has the wrong length, or the workspace or a frame belongs to another model.
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
    workspace.check_inputs(model, q);
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

/// The force that each link from number `first` on needs for its own motion and weight, along the world's
/// axes and about its origin.
pub fn inertial_forces<S: Scalar>(
    model: &Model,
    tree: &mut TreeMemory<S>,
    (q, v, a): (&[S], &[S], &[S]),
    first: usize,
    reactions: &mut [S],
) {
    evaluate_angles(model, tree, q);
    spread(model, v, &mut tree.dofs.v);
    spread(model, a, &mut tree.dofs.a);
    accelerate_along_world_axes(model, tree, q, upward(model));
    for (segment, to) in model.segments.list[first..].iter().zip(reactions.chunks_exact_mut(NUMBERS)) {
        write(&inertial_force(model, tree, segment), to);
    }
}

/// Sums the forces of single links over each link's subtree, along the axes of each link.
pub fn collect<S: Scalar>(model: &Model, tree: &TreeMemory<S>, first: usize, reactions: &mut [S]) {
    let segments = &model.segments.list;
    for index in (first..segments.len()).rev() {
        let segment = &segments[index];
        let Some(parent) = segment.parent.filter(|&parent| parent >= first) else { continue };
        let lever = lever(model, tree, &segments[parent], segment);
        let ForceVector { linear, angular } = read(&reactions[NUMBERS * (index - first)..]);
        let below = &mut reactions[NUMBERS * (parent - first)..];
        let mut sum = read(below);
        sum.linear += linear;
        sum.angular += angular + lever.cross(linear);
        write(&sum, below);
    }
    for (segment, to) in segments[first..].iter().zip(reactions.chunks_exact_mut(NUMBERS)) {
        let (turn, force) = (rotation(tree, segment), read(to));
        let own = ForceVector {
            linear: turn.transpose_mul(force.linear),
            angular: turn.transpose_mul(force.angular),
        };
        write(&own, to);
    }
}

pub fn read<S: Scalar>(from: &[S]) -> ForceVector<S> {
    let three = |at: usize| V3::new([from[at], from[at + 1], from[at + 2]]);
    ForceVector { linear: three(0), angular: three(3) }
}

pub fn write<S: Scalar>(force: &ForceVector<S>, to: &mut [S]) {
    to[..3].copy_from_slice(&force.linear.array());
    to[3..NUMBERS].copy_from_slice(&force.angular.array());
}

/// The rotation from the link's axes to the world's.
pub fn rotation<S: Scalar>(tree: &TreeMemory<S>, segment: &Segment) -> M3<S> {
    let own = M3::constant(&segment.rotation);
    match segment.body {
        Some(body) => tree.world.pose[body].rotation.times(&own),
        None => own,
    }
}

/// From the origin of the link's body (or of the world) to the link's origin, along the world's axes.
fn offset<S: Scalar>(tree: &TreeMemory<S>, segment: &Segment) -> V3<S> {
    let own = V3::constant(&segment.translation);
    match segment.body {
        Some(body) => tree.world.pose[body].rotation * own,
        None => own,
    }
}

/// From the origin of a link to that of its child link, along the world's axes.
fn lever<S: Scalar>(model: &Model, tree: &TreeMemory<S>, parent: &Segment, child: &Segment) -> V3<S> {
    let mut lever = offset(tree, child) - offset(tree, parent);
    let (mut at, end) = (child.body.unwrap_or(WORLD), parent.body.unwrap_or(WORLD));
    // A joint of several DoFs is a series of bodies.
    while at != end {
        lever += tree.world.pose[at].translation;
        at = model.bodies[at].parent;
    }
    lever
}

/// The force and moment that one link needs, about its origin, with a − g for a:
///
/// F = m a + α × h + ω × (ω × h), N = h × a + I α + ω × I ω.
fn inertial_force<S: Scalar>(model: &Model, tree: &TreeMemory<S>, segment: &Segment) -> ForceVector<S> {
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
    ForceVector { linear, angular: turn.times_plus(spin, h.cross(at)) }
}

/// Subtracts an external wrench from the reaction of its link's joint.
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
        let body = &tree.world.pose[body].rotation;
        (turn, arm) = (body.times(&turn), *body * arm);
    }
    let force = turn * V3::new(wrench.force_in_frame);
    let mut sum = read(&reactions[NUMBERS * joint..]);
    sum.linear -= force;
    sum.angular -= turn.times_plus(V3::new(wrench.moment_in_frame), arm.cross(force));
    write(&sum, &mut reactions[NUMBERS * joint..]);
}
