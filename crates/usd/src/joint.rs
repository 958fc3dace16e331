//! Reads joints: their frames, degrees of freedom, limits and passive forces.

use nalgebra::{Matrix3, Vector3};
use robot_dynamics_description::{Limits, PassiveForces, Pose};

use crate::drive::{Drive, read_drive};
use crate::findings::Findings;
use crate::geometry::{Geometry, WORLD_NODE};
use crate::prim::Prim;
use crate::transform::quaternion;

/// Limits of at least this size stand for unlimited motion.
const UNLIMITED: f64 = 1e30;

/// The motion of one degree of freedom, or of a ball joint, in the frame of the joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Motion {
    Rotation(usize),
    Translation(usize),
    Ball,
    Free,
}

#[derive(Clone, Debug)]
pub(crate) struct Dof {
    /// The name among those of the joint, as `rotX`.
    pub(crate) name: &'static str,
    pub(crate) motion: Motion,
    pub(crate) limits: Limits,
    pub(crate) passive: PassiveForces,
    pub(crate) drive: Option<Drive>,
}

/// A joint between two nodes.
#[derive(Clone, Debug)]
pub(crate) struct UsdJoint {
    pub(crate) prim: usize,
    pub(crate) nodes: [usize; 2],
    /// The frames of the joint in the two nodes.
    pub(crate) frames: [Pose; 2],
    /// Whether it closes a loop.
    pub(crate) is_excluded: bool,
    pub(crate) dofs: Vec<Dof>,
}

const AXES: [&str; 6] = ["transX", "transY", "transZ", "rotX", "rotY", "rotZ"];

/// Reads the joints of a stage in the order of the file.
pub(crate) fn read_joints(geometry: &Geometry<'_>, findings: &mut Findings) -> Vec<UsdJoint> {
    let mut joints = Vec::new();
    for (at, prim) in geometry.scene.prims.iter().enumerate() {
        let is_joint = prim.type_name.starts_with("Physics") && prim.type_name.ends_with("Joint");
        if !is_joint {
            continue;
        }
        if prim.flag("physics:jointEnabled") == Some(false) {
            mark_used(prim);
            findings.ignore(&prim.path, "the joint is disabled");
            continue;
        }
        let Some((nodes, frames)) = ends(geometry, prim, findings) else { continue };
        let Some(dofs) = degrees_of_freedom(geometry, prim, findings) else { continue };
        let is_excluded = prim.flag("physics:excludeFromArticulation") == Some(true);
        warn_of_breaking(prim, findings);
        joints.push(UsdJoint { prim: at, nodes, frames, is_excluded, dofs });
    }
    joints
}

fn mark_used(prim: &Prim) {
    for property in prim.properties.values() {
        property.is_used.set(true);
    }
}

/// The nodes of a joint, and its frame in each.
fn ends(geometry: &Geometry<'_>, prim: &Prim, findings: &mut Findings) -> Option<([usize; 2], [Pose; 2])> {
    let mut nodes = [WORLD_NODE; 2];
    let mut frames = [Pose::IDENTITY; 2];
    for side in 0..2 {
        let targets = prim.targets(&format!("physics:body{side}"));
        let target = match targets {
            [] => 0,
            [target, ..] => {
                let Some(found) = geometry.scene.find(target) else {
                    let reason = format!("its body{side} <{target}> does not exist; correct the path");
                    findings.refuse(&prim.path, reason);
                    return None;
                };
                found
            }
        };
        let point = prim.vector(&format!("physics:localPos{side}")).unwrap_or_default();
        let name = format!("physics:localRot{side}");
        let rotation = match prim.numbers(&name) {
            Some(&[w, x, y, z]) => quaternion([w, x, y, z]).unwrap_or_else(|| {
                findings.refuse(&prim.path, format!("{name} is zero; write (1, 0, 0, 0) for no rotation"));
                Matrix3::identity()
            }),
            _ => Matrix3::identity(),
        };
        nodes[side] = geometry.node_of[target];
        frames[side] = geometry.frame(target, point, rotation);
        if !frames[side].translation.iter().all(|x| x.abs() < UNLIMITED) {
            findings.refuse(&prim.path, format!("physics:localPos{side} is not finite; correct it"));
            return None;
        }
    }
    if nodes[0] == nodes[1] {
        let reason =
            "both sides are on one body; body0 and body1 must be on different bodies, or one on the world";
        findings.refuse(&prim.path, reason);
        return None;
    }
    Some((nodes, frames))
}

/// The axis of a joint, X by default.
fn axis(prim: &Prim, findings: &mut Findings) -> usize {
    match prim.word("physics:axis") {
        None | Some("X") => 0,
        Some("Y") => 1,
        Some("Z") => 2,
        Some(other) => {
            findings.refuse(&prim.path, format!("physics:axis = {other:?} is unknown; use X, Y or Z"));
            0
        }
    }
}

/// The free axes of a joint; `None` for one that is not in the model.
fn degrees_of_freedom(geometry: &Geometry<'_>, prim: &Prim, findings: &mut Findings) -> Option<Vec<Dof>> {
    let reader = DofReader { geometry, prim };
    Some(match prim.type_name.as_str() {
        "PhysicsFixedJoint" => Vec::new(),
        "PhysicsRevoluteJoint" => {
            let limits = reader.limits("physics:lowerLimit", "physics:upperLimit", true);
            vec![reader.dof("", Motion::Rotation(axis(prim, findings)), limits, &["angular"], findings)]
        }
        "PhysicsPrismaticJoint" => {
            let limits = reader.limits("physics:lowerLimit", "physics:upperLimit", false);
            vec![reader.dof("", Motion::Translation(axis(prim, findings)), limits, &["linear"], findings)]
        }
        "PhysicsSphericalJoint" => {
            axis(prim, findings);
            let cones = ["physics:coneAngle0Limit", "physics:coneAngle1Limit"].map(|name| prim.number(name));
            if cones.iter().flatten().any(|&angle| (0.0..UNLIMITED).contains(&angle)) {
                findings
                    .leave_out(&prim.path, "a cone limit is not in the model: the ball joint has no limits");
            }
            vec![reader.dof("", Motion::Ball, Limits::default(), &["angular"], findings)]
        }
        "PhysicsDistanceJoint" => {
            mark_used(prim);
            findings.leave_out(&prim.path, "a joint that limits a distance is not in the model");
            return None;
        }
        "PhysicsJoint" => reader.generic(findings),
        other => {
            mark_used(prim);
            let reason =
                format!("joints of type {other} are not read; use a joint of UsdPhysics, or delete it");
            findings.refuse(&prim.path, reason);
            return None;
        }
    })
}

struct DofReader<'a> {
    geometry: &'a Geometry<'a>,
    prim: &'a Prim,
}

impl DofReader<'_> {
    /// Limits in rad or m.
    fn limits(&self, lower: &str, upper: &str, is_angle: bool) -> Limits {
        let scale = if is_angle { 1_f64.to_radians() } else { self.geometry.meters };
        let bound = |name: &str, default: f64| match self.prim.number(name) {
            Some(value) if value.abs() < UNLIMITED => value * scale,
            _ => default,
        };
        Limits::new(bound(lower, f64::NEG_INFINITY), bound(upper, f64::INFINITY))
    }

    fn dof(
        &self,
        name: &'static str,
        motion: Motion,
        mut limits: Limits,
        drives: &[&str],
        findings: &mut Findings,
    ) -> Dof {
        let is_angle = !matches!(motion, Motion::Translation(_));
        if limits.lower > limits.upper {
            let message =
                format!("its lower limit is above the upper one: {} > {}", limits.lower, limits.upper);
            findings.warn(&self.prim.path, message);
        }
        let axis = |attribute: &str| self.axis_number(drives, attribute);
        if let Some(speed) = self.velocity_limit(is_angle, axis("maxJointVelocity")) {
            limits = limits.with_velocity(speed);
        }
        let passive = self.passive(is_angle, axis, findings);
        let drive = drives
            .iter()
            .find_map(|instance| read_drive(self.geometry, self.prim, instance, is_angle, findings));
        if let Some(effort) = self.effort_limit(is_angle, drive.as_ref()) {
            limits = limits.with_effort(effort);
        }
        Dof { name, motion, limits, passive, drive }
    }

    /// An attribute of PhysX for one axis. It has precedence over that for all axes of the joint.
    fn axis_number(&self, axes: &[&str], attribute: &str) -> Option<f64> {
        axes.iter().find_map(|axis| self.prim.number(&format!("physxJointAxis:{axis}:{attribute}")))
    }

    /// The largest speed: in degrees per second for angles, in Newton's and PhysX's schemas.
    fn velocity_limit(&self, is_angle: bool, of_axis: Option<f64>) -> Option<f64> {
        let scale = if is_angle { 1_f64.to_radians() } else { self.geometry.meters };
        let of_joint = self.prim.first_number(&["newton:velocityLimit", "physxJoint:maxJointVelocity"]);
        let written = of_axis.or(of_joint)?;
        (written > 0.0 && written < UNLIMITED).then_some(written * scale)
    }

    fn effort_limit(&self, is_angle: bool, drive: Option<&Drive>) -> Option<f64> {
        let written =
            self.prim.number("urdf:limit:effort").filter(|effort| *effort > 0.0 && *effort < UNLIMITED);
        let written = written.map(|effort| effort * self.geometry.force_unit(is_angle));
        written.or(drive.map(|drive| drive.max_force).filter(|force| *force > 0.0 && *force < UNLIMITED))
    }

    /// Armature, damping, friction and spring, in the schemas of Newton, MuJoCo and PhysX. MuJoCo's are in
    /// rad. `axis` gives PhysX's attributes of the axis.
    fn passive(
        &self,
        is_angle: bool,
        axis: impl Fn(&str) -> Option<f64>,
        findings: &mut Findings,
    ) -> PassiveForces {
        let (geometry, prim) = (self.geometry, self.prim);
        let force = geometry.force_unit(is_angle);
        let inertia = geometry.kilograms * if is_angle { geometry.meters * geometry.meters } else { 1.0 };
        let degrees = if is_angle { 1_f64.to_degrees() } else { 1.0 / geometry.meters };
        let radians = if is_angle { 1.0 } else { 1.0 / geometry.meters };
        let positive = |value: Option<f64>| value.filter(|value| value.is_finite()).unwrap_or_default();
        let damping = axis("viscousFrictionCoefficient").or(prim.number("newton:damping"));
        let damping = damping.map(|damping| damping * force * degrees);
        let own_damping = prim.number("mjc:damping").map(|damping| damping * force * radians);
        let stiffness = positive(prim.number("mjc:stiffness")) * force * radians;
        let rest = positive(prim.number("mjc:springref"))
            * if is_angle { geometry.mujoco_angle } else { geometry.meters };
        let of_joint = prim.first_number(&["newton:armature", "mjc:armature", "physxJoint:armature"]);
        let armature = axis("armature").or(of_joint);
        let [sliding, sticking] = ["dynamicFrictionEffort", "staticFrictionEffort"].map(axis);
        if let (Some(sliding), Some(sticking)) = (sliding, sticking)
            && sliding != sticking
        {
            let message = format!(
                "a static friction of {sticking} is not in the model; the dynamic one, {sliding}, is"
            );
            findings.leave_out(&prim.path, message);
        }
        let of_joint = prim.first_number(&["newton:friction", "mjc:frictionloss"]);
        let friction = sliding.or(sticking).or(of_joint);
        let mut passive = PassiveForces::default()
            .with_armature(inertia * positive(armature))
            .with_damping(positive(damping.or(own_damping)))
            .with_friction(force * positive(friction));
        if stiffness != 0.0 {
            passive = passive.with_spring(stiffness, rest);
        }
        passive
    }

    /// A joint with six axes, each free, limited or locked. Translations come first.
    fn generic(&self, findings: &mut Findings) -> Vec<Dof> {
        let prim = self.prim;
        let mut free = Vec::new();
        for (number, name) in AXES.into_iter().enumerate() {
            let [low, high] = ["low", "high"].map(|end| format!("limit:{name}:physics:{end}"));
            let is_locked = match (prim.number(&low), prim.number(&high)) {
                (Some(low), Some(high)) => low >= high,
                _ => false,
            };
            if !is_locked {
                free.push((number, self.limits(&low, &high, number >= 3)));
            }
        }
        let rotations = free.iter().filter(|(number, _)| *number >= 3).count();
        let is_limited = free.iter().any(|(_, limits)| *limits != Limits::default());
        let turns = free.iter().filter(|(number, _)| *number >= 3);
        if free.len() == 6 && !is_limited {
            return vec![self.dof("", Motion::Free, Limits::default(), &[], findings)];
        }
        let is_ball = rotations == 3 && turns.clone().all(|(_, limits)| *limits == Limits::default());
        if rotations >= 2 && !is_ball {
            let message = "several of its rotations are free: they are rotations about X, Y and Z in series, and other \
                           programs may measure the angles in another way";
            findings.warn(&prim.path, message);
        }
        let mut dofs = Vec::new();
        for (number, limits) in free {
            let motion = if number < 3 { Motion::Translation(number) } else { Motion::Rotation(number - 3) };
            if number < 3 || !is_ball {
                dofs.push(self.dof(AXES[number], motion, limits, &[AXES[number]], findings));
            }
        }
        if is_ball {
            dofs.push(self.dof("ball", Motion::Ball, Limits::default(), &["rotX"], findings));
        }
        if let [dof] = &mut dofs[..] {
            dof.name = "";
        }
        dofs
    }
}

/// Forces at which a joint breaks.
fn warn_of_breaking(prim: &Prim, findings: &mut Findings) {
    let limits = ["physics:breakForce", "physics:breakTorque"].map(|name| prim.number(name));
    if limits.iter().flatten().any(|limit| limit.abs() < UNLIMITED) {
        findings.leave_out(&prim.path, "a force at which the joint breaks is not in the model");
    }
}

impl Geometry<'_> {
    /// A unit of force or moment in SI.
    pub(crate) fn force_unit(&self, is_moment: bool) -> f64 {
        self.kilograms * self.meters * if is_moment { self.meters } else { 1.0 }
    }
}

/// A coordinate axis.
pub(crate) fn unit_vector(axis: usize) -> Vector3<f64> {
    Vector3::ith(axis, 1.0)
}
