//! From bodies to links and joints.
//!
//! A body with the joints j₁ … jₙ at the anchors p₁ … pₙ becomes a chain: each joint's frame sits at its anchor, the links
//! between them have no mass, and the last one, shifted back by −pₙ, is the body. Its frame is so where the file has it.

use std::collections::HashMap;

use multibody::{
    FrameDescription, JointDescription, JointKind, Limits, LinkDescription, PlacementSpring, Pose,
    RobotDescription,
};
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use robot_xml::excerpt;

use crate::MjcfError;
use crate::body::Body;
use crate::joint::{Joint, Motion};
use crate::mass::Mass;
use crate::names::Names;
use crate::option::Disabled;
use crate::orientation::pose;
use crate::reader::Reader;
use crate::simple_slides::weighed_by_mass;
use crate::tree::Id;

/// What the file's names and numbers became.
#[derive(Default)]
pub(crate) struct Places {
    /// For each body its link's name.
    pub(crate) links: Vec<String>,
    /// The moving joints in MuJoCo's order: name, motion, and q in the file's pose.
    pub(crate) joints: Vec<Placed>,
    joint_of: HashMap<String, usize>,
    sites: HashMap<String, PlacedSite>,
}

impl Places {
    /// The joint that the file names so.
    pub(crate) fn joint(&self, name: &str) -> Option<&Placed> {
        self.joint_of.get(name).map(|&joint| &self.joints[joint])
    }

    /// The site that the file names so.
    pub(crate) fn site(&self, name: &str) -> Option<&PlacedSite> {
        self.sites.get(name)
    }
}

/// A site of the file, by its frame in the robot.
pub(crate) struct PlacedSite {
    /// The frame's name.
    pub(crate) frame: String,
    /// Which body it is on.
    pub(crate) body: usize,
    pub(crate) body_from_site: Isometry3<f64>,
}

/// A joint of the file, by its name in the robot.
pub(crate) struct Placed {
    pub(crate) name: String,
    /// The file's element.
    pub(crate) node: Id,
    pub(crate) motion: Motion,
    /// q where the body is as the file places it: of a free joint x y z and x y z w.
    pub(crate) initial: Vec<f64>,
    /// Where its spring is relaxed, whether it has one or not.
    pub(crate) rest: f64,
    pub(crate) limits: Limits,
    /// `springdamper`.
    pub(crate) spring_damper: Option<[f64; 2]>,
}

/// Names under construction.
struct Assembly<'r> {
    robot: &'r mut RobotDescription,
    links: Names,
    joints: Names,
    places: Places,
    disabled: Disabled,
}

impl Reader<'_> {
    /// Adds links, joints and frames to the robot.
    pub(crate) fn assemble(
        &mut self,
        robot: &mut RobotDescription,
        bodies: &[Body],
        masses: &[Mass],
        disabled: Disabled,
    ) -> Places {
        let mut assembly = Assembly {
            robot,
            links: Names::default(),
            joints: Names::default(),
            places: Places::default(),
            disabled,
        };
        self.take_names(bodies, &mut assembly);
        let by_mass = weighed_by_mass(bodies, masses);
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
            assembly.places.links.push(link);
            if body.mocap {
                self.defaulted(
                    &body.element,
                    "a mocap body, which a user moves: it stands where the file puts it",
                );
            }
        }
        self.frames(bodies, &mut assembly);
        let Assembly { places, .. } = assembly;
        self.check_moved_mass(bodies, masses);
        places
    }

    /// The file's own names go before those that are made up; one used twice is an error.
    fn take_names(&mut self, bodies: &[Body], assembly: &mut Assembly<'_>) {
        let mut lines = HashMap::new();
        let named = bodies.iter().flat_map(|body| {
            let own = core::iter::once(("body", body.name.as_str(), &body.element));
            own.chain(body.joints.iter().map(|joint| ("joint", joint.name.as_str(), &joint.element)))
        });
        for (what, name, element) in named.filter(|(_, name, _)| !name.is_empty()) {
            let taken = if what == "body" { &mut assembly.links } else { &mut assembly.joints };
            if !taken.take(name) {
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
        let name = assembly.links.free(&format!("body_{index}"));
        self.defaulted(&body.element, format!("no name: taken as {name:?}"));
        name
    }

    /// What MuJoCo's equations have no meaning for.
    fn check_joints(&mut self, body: &Body) {
        let is_free = |joint: &&Joint| joint.motion == Motion::Free;
        if let Some(free) = body.joints.iter().find(is_free) {
            if body.parent != 0 {
                self.misplaced(
                    &free.element,
                    "a free joint is for a body in the world; use other joints inside a body",
                );
            } else if body.joints.len() > 1 {
                self.misplaced(&free.element, "a free joint stands alone; remove the body's other joints");
            }
        }
        let freedoms: usize = body.joints.iter().map(|joint| joint.motion.freedoms()).sum();
        if freedoms > 6 && !body.joints.iter().any(|joint| is_free(&joint)) {
            self.misplaced(
                &body.element,
                format!("its joints have {freedoms} freedoms; a body has at most six"),
            );
        }
        if body.mocap && !body.joints.is_empty() {
            self.misplaced(&body.element, "a mocap body has no joints: remove them, or mocap");
        }
    }

    /// The joints of a body, one after the other, the last one moving the body's own link.
    fn chain(&mut self, body: &Body, link: &str, assembly: &mut Assembly<'_>) {
        let mut parent = assembly.places.links[body.parent].clone();
        let mut parent_from_here = body.parent_from_body;
        for (at, joint) in body.joints.iter().enumerate() {
            let is_last = at + 1 == body.joints.len();
            // A slide has no use for its anchor, and a free joint none.
            let turns = matches!(joint.motion, Motion::Hinge | Motion::Ball);
            let anchor = if turns { joint.anchor } else { Vector3::zeros() };
            let name = self.joint_name(joint, link, assembly);
            let child = if is_last && anchor == Vector3::zeros() {
                link.to_owned()
            } else {
                assembly.links.free(&format!("{link}/{name}"))
            };
            let parent_from_joint = match joint.motion {
                Motion::Free => Isometry3::identity(),
                _ => parent_from_here * Translation3::from(anchor) * back_by(joint),
            };
            let initial = initial(joint, &body.parent_from_body);
            let mut description =
                JointDescription::new(name.clone(), kind(joint), &parent, &child, pose(&parent_from_joint));
            description.limits = joint.limits;
            description.passive = joint.passive;
            description.higher_terms = joint.higher_terms;
            description.softness = joint.softness;
            description.spring = placement_spring(joint, joint.placement_stiffness, &body.parent_from_body);
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
            let index = assembly.places.joints.len();
            assembly.places.joint_of.entry(joint.name.clone()).or_insert(index);
            assembly.places.joints.push(Placed {
                name,
                node: joint.element.node,
                motion,
                initial,
                rest,
                limits,
                spring_damper,
            });
            self.read(&joint.element, format!("{} joint of body {:?}", joint.motion.word(), excerpt(link)));
            if child != link {
                assembly.robot.links.push(LinkDescription::new(child.clone(), None));
            }
            parent = child;
            parent_from_here = Isometry3::from(Translation3::from(-anchor));
        }
        if parent != link {
            let name = assembly.joints.free(&format!("{link}_fixed"));
            let place = pose(&parent_from_here);
            assembly.robot.joints.push(JointDescription::new(name, JointKind::Fixed, parent, link, place));
        }
    }

    fn joint_name(&mut self, joint: &Joint, link: &str, assembly: &mut Assembly<'_>) -> String {
        if !joint.name.is_empty() {
            return joint.name.clone();
        }
        let name = assembly.joints.free(&format!("{link}_{}", joint.motion.word()));
        self.defaulted(&joint.element, format!("no name: taken as {name:?}"));
        name
    }

    /// Sites with a name become frames; frames and links share their names here.
    fn frames(&mut self, bodies: &[Body], assembly: &mut Assembly<'_>) {
        for (index, body) in bodies.iter().enumerate() {
            for site in &body.sites {
                let name = assembly.links.free(&site.name);
                if name != site.name {
                    self.defaulted(&site.element, format!("the name is taken: the site's frame is {name:?}"));
                }
                let link = assembly.places.links[index].clone();
                let place = pose(&site.body_from_site);
                assembly.robot.frames.push(FrameDescription::new(name.clone(), link, place));
                let placed = PlacedSite { frame: name, body: index, body_from_site: site.body_from_site };
                assembly.places.sites.entry(site.name.clone()).or_insert(placed);
            }
        }
    }

    /// MuJoCo refuses a body that moves without mass; here it loads, with a warning.
    fn check_moved_mass(&mut self, bodies: &[Body], masses: &[Mass]) {
        // Mass of the body, or of one fixed to it.
        let mut has_mass: Vec<bool> = masses.iter().map(|mass| mass.properties.is_some()).collect();
        for (index, body) in bodies.iter().enumerate().skip(1).rev() {
            if body.joints.is_empty() {
                has_mass[body.parent] |= has_mass[index];
            }
        }
        for (body, _) in bodies.iter().zip(has_mass).filter(|(_, has_mass)| !has_mass) {
            if !body.joints.is_empty() {
                let message = "it moves, but neither it nor what is fixed to it has mass, which MuJoCo refuses: the mass matrix \
                               may be singular; give it an <inertial> or a geom";
                self.as_written(&body.element, message);
            }
        }
    }
}

fn kind(joint: &Joint) -> JointKind {
    let axis = joint.axis.into();
    match joint.motion {
        Motion::Hinge if joint.limits.lower == f64::NEG_INFINITY => JointKind::Continuous { axis },
        Motion::Hinge => JointKind::Revolute { axis },
        Motion::Slide => JointKind::Prismatic { axis },
        Motion::Ball => JointKind::Spherical,
        Motion::Free => JointKind::Floating,
    }
}

/// From where the joint is at q = `ref`, which is where the file places the body, to where it is at q = 0.
fn back_by(joint: &Joint) -> Isometry3<f64> {
    match joint.motion {
        Motion::Hinge => {
            let axis = Unit::new_unchecked(joint.axis);
            Isometry3::from_parts(
                Translation3::identity(),
                UnitQuaternion::from_axis_angle(&axis, -joint.reference),
            )
        }
        Motion::Slide => Translation3::from(joint.axis * -joint.reference).into(),
        Motion::Ball | Motion::Free => Isometry3::identity(),
    }
}

/// The spring of a ball or free joint; it rests where the file places the body.
pub(crate) fn placement_spring(
    joint: &Joint,
    stiffness: f64,
    parent_from_body: &Isometry3<f64>,
) -> Option<PlacementSpring> {
    let rest = if joint.motion == Motion::Free { pose(parent_from_body) } else { Pose::IDENTITY };
    let has_one = stiffness != 0.0 && matches!(joint.motion, Motion::Ball | Motion::Free);
    // A higher term of a free joint's spring has the same rest.
    let has_higher = joint.motion == Motion::Free && joint.higher_terms.stiffness != [0.0; 2];
    (has_one || has_higher).then_some(PlacementSpring { stiffness, rest })
}

/// q in the file's own pose.
fn initial(joint: &Joint, parent_from_body: &Isometry3<f64>) -> Vec<f64> {
    match joint.motion {
        Motion::Hinge | Motion::Slide => vec![joint.reference],
        Motion::Ball => vec![0.0, 0.0, 0.0, 1.0],
        Motion::Free => {
            let (x, q) = (parent_from_body.translation.vector, parent_from_body.rotation.quaternion());
            vec![x.x, x.y, x.z, q.i, q.j, q.k, q.w]
        }
    }
}
