//! Affine transforms of prims, from their `xformOp` stacks.

use nalgebra::{Matrix3, Rotation3, Unit, Vector3};
use robot_dynamics_description::Pose;

use crate::prim::Prim;

/// x ↦ L x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Affine {
    pub(crate) linear: Matrix3<f64>,
    pub(crate) translation: Vector3<f64>,
}

impl Affine {
    pub(crate) const IDENTITY: Self = Self {
        linear: Matrix3::new(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        translation: Vector3::new(0.0, 0.0, 0.0),
    };

    pub(crate) fn linear(linear: Matrix3<f64>) -> Self {
        Self { linear, translation: Vector3::zeros() }
    }

    pub(crate) fn apply(&self, point: Vector3<f64>) -> Vector3<f64> {
        self.linear * point + self.translation
    }

    pub(crate) fn compose(&self, child: &Self) -> Self {
        Self { linear: self.linear * child.linear, translation: self.apply(child.translation) }
    }

    fn inverse(&self) -> Option<Self> {
        let linear = self.linear.try_inverse()?;
        Some(Self { linear, translation: -(linear * self.translation) })
    }

    /// The rotation and translation, without scale.
    pub(crate) fn rigid(&self) -> Pose {
        let rotation = rotation_part(&self.linear);
        Pose {
            rotation: core::array::from_fn(|i| core::array::from_fn(|j| rotation[(i, j)])),
            translation: self.translation.into(),
        }
    }

    /// Rᵀ L: scale and shear in the axes of the rigid part.
    pub(crate) fn stretch(&self) -> Matrix3<f64> {
        rotation_part(&self.linear).transpose() * self.linear
    }
}

/// The rotation nearest to L without its scale: its columns, if they are orthogonal. A reflection is that of
/// all three axes.
fn rotation_part(linear: &Matrix3<f64>) -> Matrix3<f64> {
    let sign = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let columns: Vec<Vector3<f64>> =
        linear.column_iter().map(|column| sign * column / column.norm()).collect();
    let rotation = Matrix3::from_columns(&columns);
    let defect = (rotation.transpose() * rotation - Matrix3::identity()).amax();
    if defect < 1e-12 {
        return rotation;
    }
    // A float rounds to 1e-7; a sheared or flat transform has no exact rotation either.
    let Some(svd) = linear.try_svd(true, true, f64::EPSILON, 100) else { return Matrix3::identity() };
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return Matrix3::identity() };
    let product = u * v_t;
    if product.iter().any(|x| !x.is_finite()) {
        return Matrix3::identity();
    }
    product * product.determinant().signum()
}

/// The rotation of a quaternion w, x, y, z of any length; `None` for zero.
pub(crate) fn quaternion([w, x, y, z]: [f64; 4]) -> Option<Matrix3<f64>> {
    let norm = w.hypot(x).hypot(y.hypot(z));
    if norm == 0.0 || !norm.is_finite() {
        return None;
    }
    let pose = Pose::from_translation_quaternion_wxyz([0.0; 3], [w, x, y, z].map(|c| c / norm));
    Some(matrix(&pose))
}

pub(crate) fn matrix(pose: &Pose) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| pose.rotation[i][j])
}

/// The transform of a prim in its parent, and whether it ignores the transforms of its ancestors.
pub(crate) fn local_transform(prim: &Prim) -> Result<(Affine, bool), String> {
    let mut total = Affine::IDENTITY;
    let mut resets = false;
    for name in prim.words("xformOpOrder").unwrap_or_default() {
        if name == "!resetXformStack!" {
            (total, resets) = (Affine::IDENTITY, true);
            continue;
        }
        let (inverts, plain) = match name.strip_prefix("!invert!") {
            Some(plain) => (true, plain),
            None => (false, name.as_str()),
        };
        let numbers = prim.numbers(plain).ok_or_else(|| format!("{plain} has no value; give it one"))?;
        let mut step = operation(plain, numbers)?;
        if inverts {
            step = step.inverse().ok_or_else(|| format!("{plain} has no inverse; remove !invert!"))?;
        }
        total = total.compose(&step);
    }
    if total.linear.iter().chain(&total.translation).any(|x| !x.is_finite() || x.abs() > 1e30) {
        return Err("its transform is not finite; correct its xformOps".to_owned());
    }
    Ok((total, resets))
}

/// The transform of one operation.
fn operation(name: &str, numbers: &[f64]) -> Result<Affine, String> {
    let kind = name.split(':').nth(1).unwrap_or_default();
    let about = |axis: usize, degrees: f64| {
        let axis = Unit::new_unchecked(Vector3::ith(axis, 1.0));
        *exact_quarter_turn(axis, degrees).matrix()
    };
    let linear = match (kind, numbers) {
        ("translate", &[x, y, z]) => {
            return Ok(Affine { linear: Matrix3::identity(), translation: Vector3::new(x, y, z) });
        }
        ("translateX" | "translateY" | "translateZ", &[x]) => {
            let axis = "XYZ".find(&kind[9..]).unwrap_or_default();
            return Ok(Affine { linear: Matrix3::identity(), translation: Vector3::ith(axis, x) });
        }
        ("scale", &[x, y, z]) => Matrix3::from_diagonal(&Vector3::new(x, y, z)),
        ("scaleX" | "scaleY" | "scaleZ", &[x]) => {
            let mut scale = Vector3::repeat(1.0);
            scale["XYZ".find(&kind[5..]).unwrap_or_default()] = x;
            Matrix3::from_diagonal(&scale)
        }
        ("rotateX" | "rotateY" | "rotateZ", &[angle]) => {
            about("XYZ".find(&kind[6..]).unwrap_or_default(), angle)
        }
        ("rotateXYZ" | "rotateXZY" | "rotateYXZ" | "rotateYZX" | "rotateZXY" | "rotateZYX", &[x, y, z]) => {
            // The first letter turns first.
            kind[6..].chars().fold(Matrix3::identity(), |turned, letter| {
                let axis = "XYZ".find(letter).unwrap_or_default();
                about(axis, [x, y, z][axis]) * turned
            })
        }
        ("orient", &[w, x, y, z]) => quaternion([w, x, y, z])
            .ok_or_else(|| format!("{name} is zero; write (1, 0, 0, 0) for no rotation"))?,
        ("transform", numbers) if numbers.len() == 16 => {
            // Rows of USD are columns here.
            let linear = Matrix3::from_fn(|i, j| numbers[4 * j + i]);
            return Ok(Affine { linear, translation: Vector3::new(numbers[12], numbers[13], numbers[14]) });
        }
        _ => return Err(format!("{name} with {} numbers is not an operation; correct it", numbers.len())),
    };
    Ok(Affine::linear(linear))
}

/// A rotation, exact for multiples of 90°.
fn exact_quarter_turn(axis: Unit<Vector3<f64>>, degrees: f64) -> Rotation3<f64> {
    let turned = Rotation3::from_axis_angle(&axis, degrees.to_radians());
    if degrees % 90.0 == 0.0 {
        Rotation3::from_matrix_unchecked(turned.matrix().map(f64::round))
    } else {
        turned
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rotations about x, then y, then z, as in the documentation of USD.
    #[test]
    fn rotations_in_series() {
        let turned = operation("xformOp:rotateXYZ", &[90.0, 0.0, 90.0]).unwrap().linear;
        // y goes to z by the first rotation, and stays there; x goes to y.
        assert_eq!(turned * Vector3::y(), Vector3::z());
        assert_eq!(turned * Vector3::x(), Vector3::y());
        let moved = operation(
            "xformOp:transform",
            &[0.0, 2.0, 0.0, 0.0, -2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 0.0, 5.0, 6.0, 7.0, 1.0],
        );
        let moved = moved.unwrap();
        assert_eq!(moved.apply(Vector3::x()), Vector3::new(5.0, 8.0, 7.0));
        assert_eq!(moved.stretch(), 2.0 * Matrix3::identity());
    }
}
