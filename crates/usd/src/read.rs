//! Makes a robot from a stage.

use std::collections::{BTreeSet, HashMap, HashSet};

use nalgebra::Vector3;
use robot_dynamics_description::plausibility::WrittenAngles;
use robot_dynamics_description::{Base, JointKind, LoadReport, Mimic, RobotDescription};

use crate::assembly::Assembly;
use crate::collider::{UsdShape, read_shapes};
use crate::findings::Findings;
use crate::geometry::{Geometry, WORLD_NODE};
use crate::joint::read_joints;
use crate::mass::MassShape;
use crate::prim::{Prim, Scene};
use crate::tree::{self, Step};
use crate::unread::report_unread;
use crate::{LoadError, LoadOptions, UsdError, mass_check};

/// A robot and the report of how it was read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Robot {
    /// Links and joints.
    pub description: RobotDescription,
    /// Everything that was read, defaulted, suspicious or ignored.
    pub report: LoadReport,
    /// Always empty: a stage has no angles of frames.
    pub angles: Vec<WrittenAngles>,
}

/// Makes the robot of a stage. `stem` is its name if the stage has none.
pub(crate) fn robot(scene: &Scene, stem: &str, options: &LoadOptions) -> Result<Robot, LoadError> {
    let mut findings = Findings::new(options.clone());
    for fault in &scene.faults {
        findings.leave_out("/", fault.clone());
    }
    let geometry = Geometry::new(scene, &mut findings);
    let joints = read_joints(&geometry, &mut findings);
    let shapes = read_shapes(&geometry, &mut findings);
    if geometry.bodies.is_empty() && findings.errors.is_empty() {
        findings.errors.push(UsdError::BadFile {
            reason: "it has no rigid bodies: apply PhysicsRigidBodyAPI to the prims of the robot's links"
                .to_owned(),
        });
    }
    let default = scene.default_prim.as_ref().and_then(|name| scene.find(&format!("/{name}")));
    let name = default.map_or(stem, |prim| scene.prims[prim].shown_name()).to_owned();
    let mut assembly = Assembly::new(&geometry, &joints, &name);
    add_masses(&mut assembly, &shapes, &mut findings);
    add_tree(&mut assembly, &mut findings);
    assembly.free_name();
    assembly.add_frames();
    add_mimics(&mut assembly, &mut findings);
    let driven = assembly.add_actuators(&mut findings);
    assembly.add_drives(&driven, &mut findings);
    add_shapes(&mut assembly, &shapes);
    add_exclusions(&mut assembly, &mut findings);
    read_scene(&geometry, &mut assembly.robot, &mut findings);
    let mut robot = assembly.robot;
    report_unread(scene, &mut findings);
    if findings.errors.is_empty() {
        add_floating_base(&mut robot, &mut findings);
        mass_check::check(&robot, &mut findings);
    }
    finish(scene, robot, findings)
}

fn finish(scene: &Scene, robot: RobotDescription, mut findings: Findings) -> Result<Robot, LoadError> {
    let mut report = core::mem::take(&mut findings.report);
    report.add_files(scene.files.iter().map(std::path::PathBuf::as_path));
    robot.name.clone_into(&mut report.robot);
    report.counts.links = robot.links.len();
    report.counts.joints = robot.joints.len();
    let free = robot.joints.iter().filter(|joint| joint.mimic.is_none());
    report.counts.degrees_of_freedom =
        free.map(|joint| joint.kind.nv()).sum::<usize>() + if robot.base == Base::Floating { 6 } else { 0 };
    findings.errors.append(&mut findings.refused_warnings);
    if findings.errors.is_empty() {
        Ok(Robot { description: robot, report, angles: Vec::new() })
    } else {
        Err(LoadError::new(findings.errors, UsdError::line, report))
    }
}

fn add_masses(assembly: &mut Assembly<'_>, shapes: &[UsdShape], findings: &mut Findings) {
    let mut of_node: HashMap<usize, Vec<MassShape<'_>>> = HashMap::new();
    for shape in shapes {
        if let Some(mass_shape) = shape.for_mass() {
            of_node.entry(shape.node).or_default().push(mass_shape);
        }
    }
    for (number, &body) in assembly.geometry.bodies.iter().enumerate() {
        let node = number + 1;
        let shapes = of_node.remove(&node).unwrap_or_default();
        let prim = &assembly.geometry.scene.prims[body];
        let link = &mut assembly.robot.links[node];
        link.mass_properties = assembly.geometry.mass_properties(body, &shapes, findings);
        if prim.flag("physxRigidBody:disableGravity") == Some(true) {
            link.gravity_compensation = 1.0;
        }
        if prim.vector("physics:velocity").is_some_and(|v| v.amax() != 0.0)
            || prim.vector("physics:angularVelocity").is_some_and(|v| v.amax() != 0.0)
        {
            findings.ignore(
                &prim.path,
                "its initial velocity is not in the model; give the velocity of the motion",
            );
        }
    }
}

/// Adds the joints from the world outwards, and the loops.
fn add_tree(assembly: &mut Assembly<'_>, findings: &mut Findings) {
    let geometry = assembly.geometry;
    let nodes = geometry.bodies.len() + 1;
    let is_kinematic = |node: usize| {
        node != WORLD_NODE && geometry.body(node).flag("physics:kinematicEnabled") == Some(true)
    };
    let mut roots = Vec::new();
    for node in 1..nodes {
        if geometry.body(node).has("PhysicsArticulationRootAPI") {
            roots.push(node);
        }
    }
    let stacks = geometry.scene.prims.iter().any(|prim| prim.flag("newton:jointsAddMobility") == Some(true));
    let tree = tree::build(assembly.joints, nodes, &roots, stacks);
    for step in tree.steps {
        match step {
            Step::Root(node) if is_kinematic(node) => {
                let path = &geometry.body(node).path;
                findings.warn(path, "the body is kinematic: it is fixed to the world at its pose");
                assembly.fix(node);
            }
            Step::Root(node) => assembly.add_root(node),
            Step::Joints(group) => assembly.add_group(&group, findings),
        }
    }
    for index in tree.loops {
        assembly.close_loop(index, findings);
    }
}

/// The joint that a joint mimics, and the factor c and offset b of q = c q_leader + b, in degrees and units
/// of length. Newton writes them in this way, and PhysX as q + gearing q_leader + offset = 0.
fn mimic_relation(prim: &Prim) -> Option<(&str, [f64; 2])> {
    let number = |name: &str, default: f64| prim.number(name).filter(|x| x.is_finite()).unwrap_or(default);
    if let [leader, ..] = prim.targets("newton:mimicJoint")
        && prim.flag("newton:mimicEnabled") != Some(false)
    {
        return Some((leader, [number("newton:mimicCoef1", 1.0), number("newton:mimicCoef0", 0.0)]));
    }
    ["rotX", "rotY", "rotZ"].into_iter().find_map(|axis| {
        let own = |name: &str| format!("physxMimicJoint:{axis}:{name}");
        let [leader, ..] = prim.targets(&own("referenceJoint")) else { return None };
        // The axes of joints with one degree of freedom, and the softness of the relation.
        for name in ["referenceJointAxis", "naturalFrequency", "dampingRatio"] {
            prim.value(&own(name));
        }
        Some((leader.as_str(), [-number(&own("gearing"), 1.0), -number(&own("offset"), 0.0)]))
    })
}

/// Adds mimic joints.
fn add_mimics(assembly: &mut Assembly<'_>, findings: &mut Findings) {
    let scene = assembly.geometry.scene;
    let joint_of: HashMap<usize, usize> =
        assembly.joints.iter().enumerate().map(|(index, joint)| (joint.prim, index)).collect();
    for (index, joint) in assembly.joints.iter().enumerate() {
        let prim = &scene.prims[joint.prim];
        let Some((target, [ratio, offset])) = mimic_relation(prim) else { continue };
        let leader = scene.find(target).and_then(|target| joint_of.get(&target));
        let Some(&leader) = leader else {
            let reason = format!("it mimics <{target}>, which is not a joint; correct the path");
            findings.refuse(&prim.path, reason);
            continue;
        };
        let (Some([own]), Some([other])) =
            (assembly.made.get(index).map(Vec::as_slice), assembly.made.get(leader).map(Vec::as_slice))
        else {
            findings.refuse(
                &prim.path,
                "it mimics a joint, but both must have one degree of freedom in the tree",
            );
            continue;
        };
        let (own, other) = (own.clone(), other.clone());
        let Some(made) = assembly.robot.joints.iter().find(|made| made.name == own) else { continue };
        let is_angle = !matches!(made.kind, JointKind::Prismatic { .. });
        let offset = offset * if is_angle { 1_f64.to_radians() } else { assembly.geometry.meters };
        if !assembly.robot.follow(&own, &Mimic::new(other, ratio, offset)) {
            let reason = "it mimics itself, directly or through other joints; remove one relation";
            findings.refuse(&prim.path, reason);
        }
    }
}

fn add_shapes(assembly: &mut Assembly<'_>, shapes: &[UsdShape]) {
    for shape in shapes {
        let link = assembly.node_name(shape.node);
        let name = assembly.geometry.scene.prims[shape.prim].shown_name().to_owned();
        assembly.robot.shapes.push(shape.to_link_shape(&link, name));
    }
}

/// Pairs of bodies that never touch: those of filtered pairs, and of joints without collisions.
fn add_exclusions(assembly: &mut Assembly<'_>, findings: &mut Findings) {
    let geometry = assembly.geometry;
    let mut pairs: BTreeSet<(usize, usize)> = BTreeSet::new();
    let mut add = |a: usize, b: usize| {
        if a != b {
            pairs.insert((a.min(b), a.max(b)));
        }
    };
    for joint in assembly.joints {
        if geometry.scene.prims[joint.prim].flag("physics:collisionEnabled") != Some(true) {
            add(joint.nodes[0], joint.nodes[1]);
        }
    }
    for (at, prim) in geometry.scene.prims.iter().enumerate() {
        for target in prim.targets("physics:filteredPairs") {
            match geometry.scene.find(target) {
                Some(other) => add(geometry.node_of[at], geometry.node_of[other]),
                None => findings.warn(&prim.path, format!("its filtered pair <{target}> does not exist")),
            }
        }
    }
    for (a, b) in pairs {
        let pair = (assembly.node_name(a), assembly.node_name(b));
        assembly.robot.contact_exclusions.push(pair);
    }
}

/// Gravity and the time step of the physics scene.
fn read_scene(geometry: &Geometry<'_>, robot: &mut RobotDescription, findings: &mut Findings) {
    let scenes: Vec<_> =
        geometry.scene.prims.iter().filter(|prim| prim.type_name == "PhysicsScene").collect();
    let Some(prim) = scenes.first() else { return };
    if let Some(other) = scenes.get(1) {
        findings.ignore(&other.path, format!("a second physics scene; the first, {}, counts", prim.path));
    }
    let direction =
        prim.vector("physics:gravityDirection").filter(|v| v.amax() > 0.0 && v.norm().is_finite());
    let direction =
        direction.map_or(-Vector3::z(), |direction| geometry.world_from_stage * direction.normalize());
    let magnitude = prim.number("physics:gravityMagnitude").filter(|g| *g >= 0.0 && g.is_finite());
    let mut magnitude = magnitude.map_or(9.81, |magnitude| magnitude * geometry.meters);
    if prim.flag("newton:gravityEnabled") == Some(false) {
        magnitude = 0.0;
    }
    robot.gravity = (direction * magnitude).map(|c| c + 0.0).into();
    let steps = prim.number("newton:timeStepsPerSecond").filter(|rate| *rate > 0.0).map(|rate| 1.0 / rate);
    robot.time_step =
        prim.number("mjc:option:timestep").filter(|step| *step > 0.0 && step.is_finite()).or(steps);
}

/// Gives the robot a floating base, unless its root link floats.
fn add_floating_base(robot: &mut RobotDescription, findings: &mut Findings) {
    if !findings.options.floating_base {
        return;
    }
    let free: HashSet<&str> = robot
        .joints
        .iter()
        .filter(|joint| joint.kind == JointKind::Floating)
        .map(|joint| joint.child.as_str())
        .collect();
    if free.is_empty() {
        robot.base = Base::Floating;
    } else {
        findings.ignore("/", "the root link has a floating joint: the floating base is omitted");
    }
}
