//! `<origin xyz rpy>`: where a frame sits.

use multibody::Pose;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// The parent's `<origin>`: R = Rz(yaw) Ry(pitch) Rx(roll), or by quaternion; identity by default.
    pub(crate) fn origin(&mut self, parent: &Element<'a>) -> Pose {
        let Some(element) = self.child(parent, "origin") else {
            self.defaulted(parent, "no <origin>: taken as xyz=\"0 0 0\" rpy=\"0 0 0\"");
            return Pose::IDENTITY;
        };
        self.list_unread(&element, &["xyz", "rpy", "quat_xyzw"], &[], Unknown::IsPhysics);
        let xyz = self.numbers::<3>(&element, "xyz");
        let rpy = self.numbers::<3>(&element, "rpy");
        let quaternion = self.numbers::<4>(&element, "quat_xyzw");
        if xyz.is_none() {
            self.defaulted(&element, "no xyz: taken as \"0 0 0\"");
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
                // NaN stands for an error that is listed already.
                if quaternion.iter().any(|c| c.is_nan()) {
                    return Pose::IDENTITY;
                }
                // Smaller ones lose their direction when squared.
                if quaternion.iter().all(|c| c.abs() < 1e-100) {
                    self.refuse(UrdfError::ZeroQuaternion { line: element.line, place: element.place });
                    return Pose::IDENTITY;
                }
                Pose::from_translation_quaternion_xyzw(xyz, quaternion)
            }
            (None, None) => {
                self.defaulted(&element, "no rpy: taken as \"0 0 0\"");
                Pose::from_translation(xyz)
            }
        };
        self.read(&element, "placement");
        pose
    }
}
