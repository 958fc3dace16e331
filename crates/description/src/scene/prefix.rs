//! A description with a prefix on every name.

use crate::actuator::Transmission;
use crate::joint::{JointDescription, Mimic};
use crate::robot::LinkDescription;
use crate::{
    ActuatorDescription, ContactPairDescription, EndEffectorDescription, Equality, EqualityDescription,
    FluidShape, FrameDescription, GroupDescription, LinkShape, NamedPose, RobotDescription,
    SensorDescription, SensorObject, SpatialTendonDescription, TendonDescription, TendonPathElement,
};

/// The new name of each object, by its old name.
///
/// Links and frames share one space of names. The names of all other objects get the prefix only. An empty
/// name stays empty, because it stands for an object without a name.
pub(super) struct Renaming<'a> {
    pub(super) prefix: &'a str,
    /// A link with another new name than the prefix gives.
    pub(super) root: (&'a str, &'a str),
}

impl Renaming<'_> {
    fn object(&self, name: &mut String) {
        if !name.is_empty() {
            name.insert_str(0, self.prefix);
        }
    }

    pub(super) fn link(&self, name: &mut String) {
        if name == self.root.0 {
            self.root.1.clone_into(name);
        } else {
            self.object(name);
        }
    }

    /// Renames everything in a description. Each structure is taken apart in full, so that a new field needs
    /// a decision here.
    pub(super) fn apply(&self, robot: &mut RobotDescription) {
        let RobotDescription {
            name: _,
            gravity: _,
            base: _,
            links,
            joints,
            frames,
            shapes,
            contact_exclusions,
            contact_pairs,
            tendons,
            medium: _,
            fluid_shapes,
            spatial_tendons,
            equalities,
            actuators,
            sensors,
            poses,
            groups,
            end_effectors,
            actuated_joints,
            time_step: _,
            impratio: _,
        } = robot;
        for LinkDescription { name, mass_properties: _, gravity_compensation: _ } in links {
            self.link(name);
        }
        for joint in joints {
            self.joint(joint);
        }
        for FrameDescription { name, link, link_from_frame: _ } in frames {
            self.object(name);
            self.link(link);
        }
        for LinkShape { link, name, .. } in shapes {
            self.link(link);
            self.object(name);
        }
        for (one, other) in contact_exclusions {
            self.link(one);
            self.link(other);
        }
        for ContactPairDescription { name, shapes, .. } in contact_pairs {
            self.object(name);
            for shape in shapes {
                self.object(shape);
            }
        }
        for FluidShape { link, link_from_shape: _, form: _ } in fluid_shapes {
            self.link(link);
        }
        self.tendons(tendons, spatial_tendons);
        for equality in equalities {
            self.equality(equality);
        }
        for ActuatorDescription { name, transmission, adds_to, .. } in actuators {
            for name in adds_to.iter_mut().chain([name]) {
                self.object(name);
            }
            match transmission {
                Transmission::Joint { joint, gear: _ }
                | Transmission::JointInParent { joint, gear: _, moment_in_child: _ } => self.object(joint),
                Transmission::Tendon { tendon, gear: _ } => self.object(tendon),
                Transmission::Frame { frame: link, gear: _ } | Transmission::Contacts { link } => {
                    self.link(link);
                }
                Transmission::RelativeFrame { frame: one, reference: other, gear: _ }
                | Transmission::SliderCrank { crank: one, slider: other, rod_length: _, gear: _ } => {
                    self.link(one);
                    self.link(other);
                }
            }
        }
        for SensorDescription { name, object, reference, .. } in sensors {
            self.object(name);
            self.sensed(object);
            if let Some(reference) = reference {
                self.sensed(reference);
            }
        }
        for NamedPose { name, positions, velocities, group, controls: _ } in poses {
            self.object(name);
            if let Some(group) = group {
                self.object(group);
            }
            for (joint, _) in positions.iter_mut().chain(velocities) {
                self.object(joint);
            }
        }
        self.groups(groups, end_effectors);
        for joint in actuated_joints.iter_mut().flatten() {
            self.object(joint);
        }
    }

    fn tendons(&self, tendons: &mut [TendonDescription], spatial_tendons: &mut [SpatialTendonDescription]) {
        for TendonDescription { name, terms, .. } in tendons {
            self.object(name);
            for (joint, _) in terms {
                self.object(joint);
            }
        }
        for SpatialTendonDescription { name, path, .. } in spatial_tendons {
            self.object(name);
            for element in path {
                self.path_element(element);
            }
        }
    }

    fn groups(&self, groups: &mut [GroupDescription], end_effectors: &mut [EndEffectorDescription]) {
        for GroupDescription { name, links, joints, chains, subgroups } in groups {
            for name in joints.iter_mut().chain(subgroups).chain([name]) {
                self.object(name);
            }
            for link in links.iter_mut().chain(chains.iter_mut().flat_map(|(base, tip)| [base, tip])) {
                self.link(link);
            }
        }
        for EndEffectorDescription { name, group, parent_link, parent_group } in end_effectors {
            for name in parent_group.iter_mut().chain([name, group]) {
                self.object(name);
            }
            self.link(parent_link);
        }
    }

    fn joint(&self, joint: &mut JointDescription) {
        let JointDescription { name, parent, child, mimic, .. } = joint;
        self.object(name);
        self.link(parent);
        self.link(child);
        if let Some(Mimic { joint, ratio: _, offset: _ }) = mimic {
            self.object(joint);
        }
    }

    fn path_element(&self, element: &mut TendonPathElement) {
        match element {
            TendonPathElement::Point { frame } => self.link(frame),
            TendonPathElement::Surface { link, side, link_from_surface: _, surface: _, radius: _ } => {
                self.link(link);
                if let Some(side) = side {
                    self.link(side);
                }
            }
            TendonPathElement::Pulley { divisor: _ } => {}
        }
    }

    fn equality(&self, equality: &mut EqualityDescription) {
        let EqualityDescription { name, kind, .. } = equality;
        self.object(name);
        match kind {
            Equality::Joints { joint: own, leader, polynomial: _ }
            | Equality::Tendons { tendon: own, leader, polynomial: _ } => {
                self.object(&mut own.0);
                if let Some((leader, _)) = leader {
                    self.object(leader);
                }
            }
            Equality::Connect { a, b } => {
                self.link(&mut a.0);
                self.link(&mut b.0);
            }
            Equality::Weld { a, b, a_from_b: _, anchor: _, torque_scale: _ } => {
                self.link(a);
                self.link(b);
            }
        }
    }

    fn sensed(&self, object: &mut SensorObject) {
        match object {
            SensorObject::Robot => {}
            SensorObject::Named(name) | SensorObject::CenterOfMass(name) => self.link(name),
            SensorObject::Shape(name) => self.object(name),
        }
    }
}
