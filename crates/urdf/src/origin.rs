//! Reads `<origin xyz rpy>`: the placement of a frame.

use robot_dynamics_description::Pose;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread_parts::UnknownPart;

impl<'a> Reader<'a> {
    /// Reads the `<origin>` of an element: R = Rz(yaw) Ry(pitch) Rx(roll), or a quaternion. The default is
    /// the identity.
    pub(crate) fn origin(&mut self, parent: &Element<'a>) -> Pose {
        let Some(element) = self.child(parent, "origin") else {
            self.report_default(parent, "no <origin>: taken as xyz=\"0 0 0\" rpy=\"0 0 0\"");
            return Pose::IDENTITY;
        };
        self.list_unread(&element, &["xyz", "rpy", "quat_xyzw"], &[], UnknownPart::Physics);
        let xyz = self.numbers::<3>(&element, "xyz");
        let rpy = self.numbers::<3>(&element, "rpy");
        let quaternion = self.numbers::<4>(&element, "quat_xyzw");
        if xyz.is_none() {
            self.report_default(&element, "no xyz: taken as \"0 0 0\"");
        }
        let xyz = xyz.unwrap_or_default();
        let pose = match (rpy, quaternion) {
            (Some(_), Some(_)) => {
                let Element { line, place, .. } = element;
                self.refuse(UrdfError::Both { line, place, first: "rpy", second: "quat_xyzw" });
                return Pose::IDENTITY;
            }
            (Some(rpy), None) => Pose::from_xyz_rpy(xyz, rpy),
            (None, Some(quaternion)) => {
                // NaN: the error is listed.
                if quaternion.iter().any(|c| c.is_nan()) {
                    return Pose::IDENTITY;
                }
                // The squares of smaller numbers underflow.
                if quaternion.iter().all(|c| c.abs() < 1e-100) {
                    self.refuse(UrdfError::ZeroQuaternion { line: element.line, place: element.place });
                    return Pose::IDENTITY;
                }
                Pose::from_translation_quaternion_xyzw(xyz, quaternion)
            }
            (None, None) => {
                self.report_default(&element, "no rpy: taken as \"0 0 0\"");
                Pose::from_translation(xyz)
            }
        };
        self.report_read(&element, "placement");
        pose
    }
}
