//! Converts bodies to links and joints.
//!
//! A body with the joints j₁ … jₙ at the anchors p₁ … pₙ becomes a chain of links. The frame of each joint is
//! at its anchor, and the links between the joints have no mass. The last link is the body; a shift by −pₙ
//! puts its frame where the file has it.

use std::collections::HashMap;

use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use robot_dynamics_description::{
    FrameDescription, JointDescription, JointKind, Limits, LinkDescription, Pose, PoseSpring,
    RobotDescription,
};
use robot_dynamics_xml::excerpt;

use crate::MjcfError;
use crate::body::Body;
use crate::joint::{Joint, JointType};
use crate::mass::Mass;
use crate::names::Names;
use crate::option::DisabledForces;
use crate::orientation::pose;
use crate::reader::Reader;
use crate::simple_slides::bodies_weighed_by_mass;
use crate::tree::Id;

/// The links, joints and sites that the names of the file refer to.
#[derive(Default)]
pub(crate) struct ElementTable {
    /// For each body the name of its link.
    pub(crate) links: Vec<String>,
    /// The moving joints in MuJoCo's order.
    pub(crate) joints: Vec<JointEntry>,
    joint_of: HashMap<String, usize>,
    sites: HashMap<String, SiteEntry>,
}

impl ElementTable {
    /// The joint of this name in the file.
    pub(crate) fn joint(&self, name: &str) -> Option<&JointEntry> {
        self.joint_of.get(name).map(|&joint| &self.joints[joint])
    }

    /// The site of this name in the file.
    pub(crate) fn site(&self, name: &str) -> Option<&SiteEntry> {
        self.sites.get(name)
    }
}

/// A site of the file and its frame in the robot.
pub(crate) struct SiteEntry {
    /// The frame's name.
    pub(crate) frame: String,
    /// The index of its body.
    pub(crate) body: usize,
    pub(crate) body_from_site: Isometry3<f64>,
}

/// A joint of the file and its name in the robot.
pub(crate) struct JointEntry {
    pub(crate) name: String,
    /// The file's element.
    pub(crate) node: Id,
    pub(crate) motion: JointType,
    /// q in the pose of the file; for a free joint x y z and the quaternion x y z w.
    pub(crate) initial: Vec<f64>,
    /// The rest position of its spring, whether or not it has one.
    pub(crate) rest: f64,
    pub(crate) limits: Limits,
    /// `springdamper`.
    pub(crate) spring_damper: Option<[f64; 2]>,
}

/// A robot under construction.
struct Assembly<'r> {
    robot: &'r mut RobotDescription,
    links: Names,
    joints: Names,
    table: ElementTable,
    disabled: DisabledForces,
}

impl Reader<'_> {
    /// Adds links, joints and frames to the robot.
    pub(crate) fn assemble(
        &mut self,
        robot: &mut RobotDescription,
        bodies: &[Body],
        masses: &[Mass],
        disabled: DisabledForces,
    ) -> ElementTable {
        let mut assembly = Assembly {
            robot,
            links: Names::default(),
            joints: Names::default(),
            table: ElementTable::default(),
            disabled,
        };
        self.reserve_names(bodies, &mut assembly);
        let by_mass = bodies_weighed_by_mass(bodies, masses);
        for (index, body) in bodies.iter().enumerate() {
            let link = self.link_name(index, body, &mut assembly);
            if index > 0 {
                self.check_joints(body);
                let first = assembly.robot.joints.len();
                self.chain(body, &link, &mut assembly);
                for joint in &mut assembly.robot.joints[first..] {
                    joint.softness.is_weighed_by_mass = by_mass[index];
                }
            }
            let mut description = LinkDescription::new(link.clone(), masses[index].properties);
            description.gravity_compensation = body.gravity_compensation;
            assembly.robot.links.push(description);
            assembly.table.links.push(link);
            if body.mocap {
                self.report_default(&body.element, "a mocap body: it is fixed at its pose in the file");
            }
        }
        self.frames(bodies, &mut assembly);
        let Assembly { table, .. } = assembly;
        self.check_moved_mass(bodies, masses);
        table
    }

    /// Reserves the names of the file, before others are generated. A repeated name is an error.
    fn reserve_names(&mut self, bodies: &[Body], assembly: &mut Assembly<'_>) {
        let mut lines = HashMap::new();
        let named = bodies.iter().flat_map(|body| {
            let own = core::iter::once(("body", body.name.as_str(), &body.element));
            own.chain(body.joints.iter().map(|joint| ("joint", joint.name.as_str(), &joint.element)))
        });
        for (what, name, element) in named.filter(|(_, name, _)| !name.is_empty()) {
            let taken = if what == "body" { &mut assembly.links } else { &mut assembly.joints };
            if !taken.reserve(name) {
                let (line, place, name) = (element.line, element.place.clone(), excerpt(name));
                let first = lines.get(&(what, name.clone())).copied().unwrap_or(1);
                self.errors.push(MjcfError::DuplicateName { line, place, what, name, first });
            }
            lines.entry((what, excerpt(name))).or_insert(element.line);
        }
    }

    fn link_name(&mut self, index: usize, body: &Body, assembly: &mut Assembly<'_>) -> String {
        if !body.name.is_empty() {
            return body.name.clone();
        }
        let name = assembly.links.unique(&format!("body_{index}"));
        self.report_default(&body.element, format!("no name: taken as {name:?}"));
        name
    }

    /// Refuses combinations of joints that have no meaning in MJCF.
    fn check_joints(&mut self, body: &Body) {
        let is_free = |joint: &&Joint| joint.motion == JointType::Free;
        if let Some(free) = body.joints.iter().find(is_free) {
            if body.parent != 0 {
                self.refuse(
                    &free.element,
                    "a free joint is only supported for a child of the world; use other joints",
                );
            } else if body.joints.len() > 1 {
                self.refuse(
                    &free.element,
                    "a free joint must be the only joint of its body; remove the others",
                );
            }
        }
        let dofs: usize = body.joints.iter().map(|joint| joint.motion.dof_count()).sum();
        if dofs > 6 && !body.joints.iter().any(|joint| is_free(&joint)) {
            self.refuse(
                &body.element,
                format!("its joints have {dofs} degrees of freedom; a body has at most six"),
            );
        }
        if body.mocap && !body.joints.is_empty() {
            self.refuse(&body.element, "a mocap body cannot have joints; remove them, or mocap");
        }
    }

    /// Adds the joints of a body as a chain; the last joint moves the link of the body.
    fn chain(&mut self, body: &Body, link: &str, assembly: &mut Assembly<'_>) {
        let mut parent = assembly.table.links[body.parent].clone();
        let mut parent_from_here = body.parent_from_body;
        for (at, joint) in body.joints.iter().enumerate() {
            let is_last = at + 1 == body.joints.len();
            // The anchor has no effect for a slide or a free joint.
            let turns = matches!(joint.motion, JointType::Hinge | JointType::Ball);
            let anchor = if turns { joint.anchor } else { Vector3::zeros() };
            let name = self.joint_name(joint, link, assembly);
            let child = if is_last && anchor == Vector3::zeros() {
                link.to_owned()
            } else {
                assembly.links.unique(&format!("{link}/{name}"))
            };
            let parent_from_joint = match joint.motion {
                JointType::Free => Isometry3::identity(),
                _ => parent_from_here * Translation3::from(anchor) * to_zero_position(joint),
            };
            let initial = initial_position(joint, &body.parent_from_body);
            let mut description =
                JointDescription::new(name.clone(), kind(joint), &parent, &child, pose(&parent_from_joint));
            description.limits = joint.limits;
            description.passive = joint.passive;
            description.higher_terms = joint.higher_terms;
            description.spring_yield = joint.spring_yield;
            description.softness = joint.softness;
            description.spring = pose_spring(joint, joint.placement_stiffness, &body.parent_from_body);
            let (passive, higher) = (&mut description.passive, &mut description.higher_terms);
            if assembly.disabled.springs {
                (passive.stiffness, higher.stiffness, description.spring) = (0.0, [0.0; 2], None);
            }
            if assembly.disabled.dampers {
                (passive.damping, higher.damping) = (0.0, [0.0; 2]);
            }
            if assembly.disabled.friction {
                passive.friction = 0.0;
            }
            description.actuator_force_range = joint.actuator_force_range;
            description.actuator_compensates_gravity = joint.actuator_compensates_gravity;
            assembly.robot.joints.push(description);
            let Joint { motion, limits, spring_damper, passive, .. } = joint;
            let (motion, limits, spring_damper, rest) = (*motion, *limits, *spring_damper, passive.rest);
            let index = assembly.table.joints.len();
            assembly.table.joint_of.entry(joint.name.clone()).or_insert(index);
            assembly.table.joints.push(JointEntry {
                name,
                node: joint.element.node,
                motion,
                initial,
                rest,
                limits,
                spring_damper,
            });
            self.report_read(
                &joint.element,
                format!("{} joint of body {:?}", joint.motion.word(), excerpt(link)),
            );
            if child != link {
                assembly.robot.links.push(LinkDescription::new(child.clone(), None));
            }
            parent = child;
            parent_from_here = Isometry3::from(Translation3::from(-anchor));
        }
        if parent != link {
            let name = assembly.joints.unique(&format!("{link}_fixed"));
            let place = pose(&parent_from_here);
            assembly.robot.joints.push(JointDescription::new(name, JointKind::Fixed, parent, link, place));
        }
    }

    fn joint_name(&mut self, joint: &Joint, link: &str, assembly: &mut Assembly<'_>) -> String {
        if !joint.name.is_empty() {
            return joint.name.clone();
        }
        let name = assembly.joints.unique(&format!("{link}_{}", joint.motion.word()));
        self.report_default(&joint.element, format!("no name: taken as {name:?}"));
        name
    }

    /// Adds the sites with a name as frames, which share a namespace with the links.
    fn frames(&mut self, bodies: &[Body], assembly: &mut Assembly<'_>) {
        for (index, body) in bodies.iter().enumerate() {
            for site in &body.sites {
                let name = assembly.links.unique(&site.name);
                if name != site.name {
                    let message = format!(
                        "a body or another site has this name: the frame of this site is named {name:?}"
                    );
                    self.warn(&site.element, message);
                }
                let link = assembly.table.links[index].clone();
                let place = pose(&site.body_from_site);
                assembly.robot.frames.push(FrameDescription::new(name.clone(), link, place));
                let placed = SiteEntry { frame: name, body: index, body_from_site: site.body_from_site };
                assembly.table.sites.entry(site.name.clone()).or_insert(placed);
            }
        }
    }

    /// Warns of bodies that move without mass, which MuJoCo refuses.
    fn check_moved_mass(&mut self, bodies: &[Body], masses: &[Mass]) {
        // Whether the body, or a body fixed to it, has mass.
        let mut has_mass: Vec<bool> = masses.iter().map(|mass| mass.properties.is_some()).collect();
        for (index, body) in bodies.iter().enumerate().skip(1).rev() {
            if body.joints.is_empty() {
                has_mass[body.parent] |= has_mass[index];
            }
        }
        for (body, _) in bodies.iter().zip(has_mass).filter(|(_, has_mass)| !has_mass) {
            if !body.joints.is_empty() {
                let message = "it moves, but neither it nor a body fixed to it has mass, which MuJoCo refuses: the mass matrix \
                               may be singular; give it an <inertial> or a geom";
                self.warn(&body.element, message);
            }
        }
    }
}

fn kind(joint: &Joint) -> JointKind {
    let axis = joint.axis.into();
    match joint.motion {
        JointType::Hinge if joint.limits.lower == f64::NEG_INFINITY => JointKind::Continuous { axis },
        JointType::Hinge => JointKind::Revolute { axis },
        JointType::Slide => JointKind::Prismatic { axis },
        JointType::Ball => JointKind::Spherical,
        JointType::Free => JointKind::Floating,
    }
}

/// The transform from the placement in the file, which is that of q = `ref`, to that of q = 0.
fn to_zero_position(joint: &Joint) -> Isometry3<f64> {
    match joint.motion {
        JointType::Hinge => {
            let axis = Unit::new_unchecked(joint.axis);
            Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&axis, -joint.reference),
            )
        }
        JointType::Slide => Translation3::from(joint.axis * -joint.reference).into(),
        JointType::Ball | JointType::Free => Isometry3::identity(),
    }
}

/// The spring of a ball or free joint, which is at rest in the pose of the file.
pub(crate) fn pose_spring(
    joint: &Joint,
    stiffness: f64,
    parent_from_body: &Isometry3<f64>,
) -> Option<PoseSpring> {
    let rest = if joint.motion == JointType::Free { pose(parent_from_body) } else { Pose::IDENTITY };
    let has_one = stiffness != 0.0 && matches!(joint.motion, JointType::Ball | JointType::Free);
    // The higher terms of a free joint's spring have the same rest.
    let has_higher = joint.motion == JointType::Free && joint.higher_terms.stiffness != [0.0; 2];
    (has_one || has_higher).then_some(PoseSpring { stiffness, rest })
}

/// q in the pose of the file.
fn initial_position(joint: &Joint, parent_from_body: &Isometry3<f64>) -> Vec<f64> {
    match joint.motion {
        JointType::Hinge | JointType::Slide => vec![joint.reference],
        JointType::Ball => vec![0.0, 0.0, 0.0, 1.0],
        JointType::Free => {
            let (x, q) = (parent_from_body.translation.vector, parent_from_body.rotation.quaternion());
            vec![x.x, x.y, x.z, q.i, q.j, q.k, q.w]
        }
    }
}
