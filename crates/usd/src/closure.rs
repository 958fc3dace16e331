//! Joints that close loops: equalities instead of joints of the tree.

use nalgebra::Vector3;
use robot_dynamics_description::{Disposition, Equality, EqualityDescription, Limits, PassiveForces};

use crate::assembly::Assembly;
use crate::findings::Findings;
use crate::joint::{Motion, unit_vector};

/// The distance of the two points that represent a hinge which closes a loop \[m\].
const HINGE_LENGTH: f64 = 0.1;

impl Assembly<'_> {
    /// Adds the equalities of a joint that closes a loop.
    pub(crate) fn close_loop(&mut self, index: usize, findings: &mut Findings) {
        let joint = &self.joints[index];
        let path = &self.geometry.scene.prims[joint.prim].path;
        let [a, b] = joint.nodes.map(|node| self.node_name(node));
        let [in_a, in_b] = joint.frames;
        let connect = |offset: Vector3<f64>| Equality::Connect {
            a: (a.clone(), in_a.apply(offset.into())),
            b: (b.clone(), in_b.apply(offset.into())),
        };
        let motions: Vec<Motion> = joint.dofs.iter().map(|dof| dof.motion).collect();
        let kinds = match motions[..] {
            [] => {
                let a_from_b = in_a.compose(&in_b.inverse());
                vec![Equality::weld(&a, &b, a_from_b)]
            }
            [Motion::Ball] => vec![connect(Vector3::zeros())],
            [Motion::Rotation(axis)] => {
                let half = unit_vector(axis) * (0.5 * HINGE_LENGTH);
                vec![connect(half), connect(-half)]
            }
            [Motion::Free] => return,
            _ => {
                let reason = "it closes a loop of joints; only fixed, spherical and revolute joints can: exclude another \
                              joint of the loop from the articulation";
                return findings.refuse(path, reason);
            }
        };
        let count = kinds.len();
        for (number, kind) in kinds.into_iter().enumerate() {
            let name = &self.names[index];
            let name = if count == 1 { name.clone() } else { format!("{name}_{}", number + 1) };
            self.robot.equalities.push(EqualityDescription::new(name, kind));
        }
        let is_neutral = joint.dofs.iter().all(|dof| {
            let limits = dof.limits.with_velocity(f64::INFINITY).with_effort(f64::INFINITY);
            dof.passive == PassiveForces::default() && limits == Limits::default() && dof.drive.is_none()
        });
        if is_neutral {
            let message = "it closes a loop: it is an equality and has no coordinate";
            findings.push(path, Disposition::Read, message);
        } else {
            findings.leave_out(
                path,
                "it closes a loop: its limits, damping, friction, spring and drive are not in the model",
            );
        }
    }
}
