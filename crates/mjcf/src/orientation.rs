//! Reads the placement of a frame: `pos` with `quat`, `axisangle`, `xyaxes`, `zaxis` or `euler`.

use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};
use robot_dynamics_description::Pose;
use robot_dynamics_description::plausibility::WrittenAngles;

use crate::MjcfError;
use crate::element::Element;
use crate::reader::Reader;
use crate::tree::Id;

/// Shorter directions count as zero, as in MuJoCo.
pub(crate) const LENGTH_THRESHOLD: f64 = 1e-14;

/// The attributes that give a rotation.
const ORIENTATIONS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

impl Reader<'_> {
    /// The placement of an element in its parent; the default is the identity.
    pub(crate) fn placement(&mut self, element: &Element) -> Isometry3<f64> {
        let position = self.numbers::<3>(element, "pos").unwrap_or_default();
        let turn = self.turn(element).unwrap_or_else(UnitQuaternion::identity);
        Isometry3::from_parts(Translation3::from(position), turn)
    }

    /// The rotation of an element; `None` if no attribute gives one. An attribute of the element takes
    /// precedence over those of its class, even if they differ in kind.
    pub(crate) fn turn(&mut self, element: &Element) -> Option<UnitQuaternion<f64>> {
        self.refuse_two_turns(element);
        let nodes = element.defaults.iter().copied().chain([element.node]).rev();
        let of =
            |node: Id| ORIENTATIONS.into_iter().find(|way| self.tree.nodes[node].attribute(way).is_some());
        match nodes.into_iter().find_map(of) {
            Some("axisangle") => {
                let [x, y, z, angle] = self.numbers::<4>(element, "axisangle")?;
                let axis = self.direction(element, "axisangle", Vector3::new(x, y, z));
                let half = 0.5 * self.compiler(element).angle(angle);
                Some(unit(half.cos(), axis * half.sin()))
            }
            Some("xyaxes") => {
                let [a, b, c, d, e, f] = self.numbers::<6>(element, "xyaxes")?;
                let x = self.direction(element, "xyaxes", Vector3::new(a, b, c));
                let y = Vector3::new(d, e, f);
                let y = self.direction(element, "xyaxes", y - x * x.dot(&y));
                let axes = Matrix3::from_columns(&[x, y, x.cross(&y)]);
                Some(UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes)))
            }
            Some("zaxis") => {
                let z = self.numbers::<3>(element, "zaxis")?;
                let z = self.direction(element, "zaxis", Vector3::from(z));
                Some(from_z_to(z))
            }
            Some("euler") => {
                let angles = self.numbers::<3>(element, "euler")?;
                let angles = angles.map(|angle| self.compiler(element).angle(angle));
                self.angles.push(WrittenAngles::new(element.place.clone(), angles));
                Some(self.euler(element, angles))
            }
            _ => {
                let [w, x, y, z] = self.numbers::<4>(element, "quat")?;
                let vector = Vector3::new(x, y, z);
                let length = Quaternion::new(w, x, y, z).norm();
                if length < LENGTH_THRESHOLD {
                    self.refuse_zero(element, "quat", "write \"1 0 0 0\" for no rotation");
                    return None;
                }
                Some(unit(w, vector))
            }
        }
    }

    /// The rotation by three angles \[rad\] in the order of `eulerseq`: about moving axes in lower case,
    /// about the axes of the parent in upper case.
    pub(crate) fn euler(&self, element: &Element, angles: [f64; 3]) -> UnitQuaternion<f64> {
        let mut turn = UnitQuaternion::identity();
        for (axis, angle) in self.compiler(element).euler_sequence.iter().zip(angles) {
            let direction = match axis.to_ascii_lowercase() {
                b'x' => Vector3::x(),
                b'y' => Vector3::y(),
                _ => Vector3::z(),
            };
            let step = unit((0.5 * angle).cos(), direction * (0.5 * angle).sin());
            turn = if axis.is_ascii_lowercase() { turn * step } else { step * turn };
        }
        turn
    }

    /// The unit vector in this direction; an error for the zero vector.
    pub(crate) fn direction(&mut self, element: &Element, attribute: &str, v: Vector3<f64>) -> Vector3<f64> {
        let length = v.norm();
        if length < LENGTH_THRESHOLD {
            self.refuse_zero(element, attribute, "give a direction such as \"0 0 1\"");
            return Vector3::z();
        }
        v / length
    }

    pub(crate) fn refuse_zero(&mut self, element: &Element, attribute: &str, advice: &'static str) {
        let (line, place) = (element.line, element.place.clone());
        self.errors.push(MjcfError::Zero { line, place, attribute: attribute.to_owned(), advice });
    }

    fn refuse_two_turns(&mut self, element: &Element) {
        let node = &self.tree.nodes[element.node];
        let mut given = ORIENTATIONS.into_iter().filter(|name| node.attribute(name).is_some());
        if let (Some(first), Some(second)) = (given.next(), given.next()) {
            let (line, place) = (element.line, element.place.clone());
            self.errors.push(MjcfError::Both { line, place, first: first.into(), second: second.into() });
        }
    }
}

/// The unit quaternion w + v.
fn unit(w: f64, v: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::from_parts(w, v))
}

/// The shortest rotation from z to a direction; for −z a half turn about x, as in MuJoCo.
pub(crate) fn from_z_to(direction: Vector3<f64>) -> UnitQuaternion<f64> {
    let axis = Vector3::z().cross(&direction);
    let sine = axis.norm();
    if sine < 1e-10 {
        let axis = Vector3::x();
        return if direction.z > 0.0 { UnitQuaternion::identity() } else { unit(0.0, axis) };
    }
    let half = 0.5 * sine.atan2(direction.z);
    unit(half.cos(), axis / sine * half.sin())
}

/// Converts a placement to a `Pose`.
pub(crate) fn pose(placement: &Isometry3<f64>) -> Pose {
    let q = placement.rotation.quaternion();
    let translation = placement.translation.vector.into();
    if q.w.is_finite() && q.norm() > 0.0 {
        Pose::from_translation_quaternion_xyzw(translation, [q.i, q.j, q.k, q.w])
    } else {
        // The numbers are listed as errors.
        Pose::from_translation(translation)
    }
}
