//! Joints that close loops: equalities instead of joints of the tree.

use robot_dynamics_description::{Disposition, Equality, EqualityDescription, PassiveForces};

use super::assembly::{Assembly, bad, norm};
use super::graph::Edge;
use super::parts::JointType;
use crate::reader::Reader;

/// The distance of the two points that represent a hinge which closes a loop \[m\].
const HINGE_LENGTH: f64 = 0.1;

impl Assembly<'_, '_> {
    /// Adds the equalities of a joint that closes a loop.
    pub(super) fn close_loop(&mut self, reader: &mut Reader<'_>, edge: &Edge) {
        let joint = &self.parts.joints[edge.joint];
        let nodes = [edge.parent, edge.child];
        let [a, b] = nodes.map(|node| self.node_name(node));
        let [world_from_a, world_from_b] = nodes.map(|node| self.world_from(node));
        let connect = |point: [f64; 3]| Equality::Connect {
            a: (a.clone(), world_from_a.inverse().apply(point)),
            b: (b.clone(), world_from_b.inverse().apply(point)),
        };
        let center = self.resolved.world_from_frame[joint.frame].translation;
        let kinds = match joint.kind {
            JointType::Fixed => {
                let a_from_b = world_from_a.inverse().compose(&world_from_b);
                vec![Equality::weld(&a, &b, a_from_b)]
            }
            JointType::Ball => vec![connect(center)],
            JointType::Revolute | JointType::Continuous => {
                let axes = self.world_axes(reader, joint);
                let Some((world_from_axis, xyz)) = axes.first() else { return };
                let axis = world_from_axis.rotate(*xyz);
                let scale = 0.5 * HINGE_LENGTH / norm(axis);
                let end = |sign: f64| core::array::from_fn(|i| center[i] + sign * scale * axis[i]);
                vec![connect(end(1.0)), connect(end(-1.0))]
            }
            JointType::Prismatic | JointType::Screw | JointType::TwoAxes => {
                let reason = "it closes a loop of joints; only fixed, ball, revolute and continuous joints can: move \
                              it before the other joints of the loop in the file";
                return reader.refuse(bad(joint, reason.to_owned()));
            }
        };
        let (line, place) = (joint.at.line, joint.at.place.clone());
        let count = kinds.len();
        for (number, kind) in kinds.into_iter().enumerate() {
            let name = if count == 1 { joint.name.clone() } else { format!("{}_{}", joint.name, number + 1) };
            self.robot.equalities.push(EqualityDescription::new(name, kind));
        }
        let axis = joint.axes.first();
        let neutral = PassiveForces::default();
        let has_forces = axis.is_some_and(|axis| axis.passive != neutral || axis.mimic.is_some());
        let is_bounded =
            axis.is_some_and(|axis| axis.limits.lower.is_finite() || axis.limits.upper.is_finite());
        if has_forces || is_bounded {
            let message =
                "it closes a loop: its limits, damping, friction, spring and mimic are not in the model";
            reader.report_ignored_physics(line, place, message);
        } else {
            let message = "it closes a loop: it is an equality and has no coordinate";
            reader.push(line, place, Disposition::Read, message.to_owned());
        }
    }
}
