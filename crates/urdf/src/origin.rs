//! `<origin xyz rpy>`: where a frame sits.

use multibody::Pose;

use crate::UrdfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::unread::Unknown;

impl<'a> Reader<'a> {
    /// The parent's `<origin>`: R = Rz(yaw) Ry(pitch) Rx(roll), or by quaternion; identity by default.
    pub(crate) fn origin(&mut self, parent: &Element<'a>) -> Result<Pose, UrdfError> {
        let Some(element) = self.child(parent, "origin")? else {
            self.defaulted(parent, "no <origin>: taken as xyz=\"0 0 0\" rpy=\"0 0 0\"");
            return Ok(Pose::IDENTITY);
        };
        self.list_unread(&element, &["xyz", "rpy", "quat_xyzw"], &[], Unknown::IsPhysics)?;
        let xyz = element.numbers::<3>("xyz")?;
        let rpy = element.numbers::<3>("rpy")?;
        let quaternion = element.numbers::<4>("quat_xyzw")?;
        if xyz.is_none() {
            self.defaulted(&element, "no xyz: taken as \"0 0 0\"");
        }
        let xyz = xyz.unwrap_or_default();
        let pose = match (rpy, quaternion) {
            (Some(_), Some(_)) => {
                let Element { line, place, .. } = element;
                return Err(UrdfError::Both { line, place, first: "rpy", second: "quat_xyzw" });
            }
            (Some(rpy), None) => Pose::from_xyz_rpy(xyz, rpy),
            (None, Some(quaternion)) => {
                // Smaller ones lose their direction when squared.
                if quaternion.iter().all(|c| c.abs() < 1e-100) {
                    return Err(UrdfError::ZeroQuaternion { line: element.line, place: element.place });
                }
                Pose::from_translation_quaternion_xyzw(xyz, quaternion)
            }
            (None, None) => {
                self.defaulted(&element, "no rpy: taken as \"0 0 0\"");
                Pose::from_translation(xyz)
            }
        };
        self.read(&element, "placement");
        Ok(pose)
    }
}
