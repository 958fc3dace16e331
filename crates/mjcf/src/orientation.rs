//! Where a frame sits and how it is turned: `pos` with `quat`, `axisangle`, `xyaxes`, `zaxis` or `euler`.

use multibody::Pose;
use multibody::plausibility::WrittenAngles;
use nalgebra::{Isometry3, Matrix3, Quaternion, Rotation3, Translation3, UnitQuaternion, Vector3};

use crate::MjcfError;
use crate::reader::{Element, Reader};
use crate::tree::Id;

/// Shorter directions count as none, as in MuJoCo.
pub(crate) const SHORTEST: f64 = 1e-14;

/// The ways to say a turn.
const WAYS: [&str; 5] = ["quat", "axisangle", "xyaxes", "zaxis", "euler"];

impl Reader<'_> {
    /// `pos` and the turn; the parent's frame where the file says nothing.
    pub(crate) fn placement(&mut self, element: &Element) -> Isometry3<f64> {
        let position = self.numbers::<3>(element, "pos").unwrap_or_default();
        let turn = self.turn(element).unwrap_or_else(UnitQuaternion::identity);
        Isometry3::from_parts(Translation3::from(position), turn)
    }

    /// The turn; `None` where the file says nothing. What the element says goes before what its class does, whichever way
    /// each says it.
    pub(crate) fn turn(&mut self, element: &Element) -> Option<UnitQuaternion<f64>> {
        self.refuse_two_turns(element);
        let nodes = element.defaults.iter().copied().chain([element.node]).rev();
        let of = |node: Id| WAYS.into_iter().find(|way| self.tree.nodes[node].attribute(way).is_some());
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
                if length < SHORTEST {
                    self.zero(element, "quat", "write \"1 0 0 0\" for no turn");
                    return None;
                }
                Some(unit(w, vector))
            }
        }
    }

    /// Turns about three axes in the order of `eulerseq`, each about an axis that the turns before it carried along, or,
    /// in upper case, about one of the parent's \[rad\].
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

    /// A vector of length one in this direction.
    pub(crate) fn direction(&mut self, element: &Element, attribute: &str, v: Vector3<f64>) -> Vector3<f64> {
        let length = v.norm();
        if length < SHORTEST {
            self.zero(element, attribute, "give a direction such as \"0 0 1\"");
            return Vector3::z();
        }
        v / length
    }

    pub(crate) fn zero(&mut self, element: &Element, attribute: &str, advice: &'static str) {
        let (line, place) = (element.line, element.place.clone());
        self.errors.push(MjcfError::Zero { line, place, attribute: attribute.to_owned(), advice });
    }

    fn refuse_two_turns(&mut self, element: &Element) {
        let node = &self.tree.nodes[element.node];
        let mut given = WAYS.into_iter().filter(|name| node.attribute(name).is_some());
        if let (Some(first), Some(second)) = (given.next(), given.next()) {
            let (line, place) = (element.line, element.place.clone());
            self.errors.push(MjcfError::Both { line, place, first: first.into(), second: second.into() });
        }
    }
}

/// w + v as a rotation.
fn unit(w: f64, v: Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_quaternion(Quaternion::from_parts(w, v))
}

/// The shortest turn that brings z to a direction; half a turn about x for −z, as in MuJoCo.
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

/// The same placement as numbers.
pub(crate) fn pose(placement: &Isometry3<f64>) -> Pose {
    let q = placement.rotation.quaternion();
    let translation = placement.translation.vector.into();
    if q.w.is_finite() && q.norm() > 0.0 {
        Pose::from_translation_quaternion_xyzw(translation, [q.i, q.j, q.k, q.w])
    } else {
        // Stands in for numbers that are listed as errors.
        Pose::from_translation(translation)
    }
}
