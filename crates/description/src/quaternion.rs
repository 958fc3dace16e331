//! Quaternions with named component order.

use robot_dynamics_number::Scalar;
use robot_dynamics_number::algebra::{M3, V3};

/// A quaternion x i + y j + z k + w of unit length, representing a rotation.
///
/// Functions that build or read it name the order of the four numbers, because both orders are in use: w
/// first and w last. q of this library holds x, y, z, w.
///
/// ```
/// use robot_dynamics::description::Quaternion;
/// let quarter_turn_about_z = Quaternion::from_wxyz([0.5f64.sqrt(), 0.0, 0.0, 0.5f64.sqrt()]);
/// assert_eq!(quarter_turn_about_z.to_xyzw(), [0.0, 0.0, 0.5f64.sqrt(), 0.5f64.sqrt()]);
/// let [x, y, _] = quarter_turn_about_z.rotate([1.0, 0.0, 0.0]);
/// assert!(x.abs() < 1e-15 && (y - 1.0).abs() < 1e-15);
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quaternion {
    vector: [f64; 3],
    scalar: f64,
}

impl Quaternion {
    /// The identity rotation.
    pub const IDENTITY: Self = Self { vector: [0.0; 3], scalar: 1.0 };

    /// From the order x, y, z, w, as in q of this library (and in Pinocchio, Eigen, ROS).
    ///
    /// ```
    /// // Half a turn about z.
    /// let turn = robot_dynamics::description::Quaternion::from_xyzw([0.0, 0.0, 1.0, 0.0]);
    /// assert_eq!(turn.rotate([1.0, 2.0, 3.0]), [-1.0, -2.0, 3.0]);
    /// ```
    pub fn from_xyzw([x, y, z, w]: [f64; 4]) -> Self {
        Self { vector: [x, y, z], scalar: w }
    }

    /// From the order w, x, y, z (as in MuJoCo and most textbooks).
    ///
    /// ```
    /// // Half a turn about z.
    /// let turn = robot_dynamics::description::Quaternion::from_wxyz([0.0, 0.0, 0.0, 1.0]);
    /// assert_eq!(turn.rotate([1.0, 2.0, 3.0]), [-1.0, -2.0, 3.0]);
    /// ```
    pub fn from_wxyz([w, x, y, z]: [f64; 4]) -> Self {
        Self { vector: [x, y, z], scalar: w }
    }

    /// The rotation R, given by rows, as a unit quaternion with w ≥ 0.
    ///
    /// The largest of the four numbers comes from sums of the diagonal, and the others from it, which avoids
    /// cancellation at any angle. Source: Shepperd, *Quaternion from rotation matrix*, J. Guidance and
    /// Control 1 (1978).
    ///
    /// ```
    /// use robot_dynamics::description::Quaternion;
    /// let half_turn_about_z = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]];
    /// assert_eq!(Quaternion::from_rotation(&half_turn_about_z).to_xyzw(), [0.0, 0.0, 1.0, 0.0]);
    /// ```
    #[must_use]
    pub fn from_rotation(r: &[[f64; 3]; 3]) -> Self {
        let trace = r[0][0] + r[1][1] + r[2][2];
        // 4w², 4x², 4y², 4z².
        let squares = [
            1.0 + trace,
            1.0 + 2.0 * r[0][0] - trace,
            1.0 + 2.0 * r[1][1] - trace,
            1.0 + 2.0 * r[2][2] - trace,
        ];
        let twist = [r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]];
        let largest = (0..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
        let quaternion = if largest == 0 {
            Self { vector: twist, scalar: squares[0] }
        } else {
            let i = largest - 1;
            let vector = core::array::from_fn(|j| if i == j { squares[largest] } else { r[i][j] + r[j][i] });
            Self { vector, scalar: twist[i] }
        };
        let unit = quaternion.normalized();
        if unit.scalar < 0.0 { Self { vector: unit.vector.map(|x| -x), scalar: -unit.scalar } } else { unit }
    }

    /// x, y, z, w.
    ///
    /// ```
    /// use robot_dynamics::description::Quaternion;
    /// assert_eq!(Quaternion::from_wxyz([0.8, 0.0, 0.6, 0.0]).to_xyzw(), [0.0, 0.6, 0.0, 0.8]);
    /// ```
    pub fn to_xyzw(self) -> [f64; 4] {
        let [x, y, z] = self.vector;
        [x, y, z, self.scalar]
    }

    /// w, x, y, z.
    ///
    /// ```
    /// use robot_dynamics::description::Quaternion;
    /// assert_eq!(Quaternion::from_xyzw([0.0, 0.6, 0.0, 0.8]).to_wxyz(), [0.8, 0.0, 0.6, 0.0]);
    /// ```
    pub fn to_wxyz(self) -> [f64; 4] {
        let [x, y, z] = self.vector;
        [self.scalar, x, y, z]
    }

    /// √(x² + y² + z² + w²).
    ///
    /// ```
    /// assert_eq!(robot_dynamics::description::Quaternion::from_xyzw([0.0, 3.0, 0.0, 4.0]).norm(), 5.0);
    /// ```
    pub fn norm(self) -> f64 {
        (V3::new(self.vector).dot(V3::new(self.vector)) + self.scalar * self.scalar).sqrt()
    }

    /// The same rotation with unit length; not finite if this quaternion is zero.
    ///
    /// ```
    /// use robot_dynamics::description::Quaternion;
    /// assert_eq!(Quaternion::from_xyzw([0.0, 3.0, 0.0, 4.0]).normalized().to_xyzw(), [0.0, 0.6, 0.0, 0.8]);
    /// ```
    #[must_use]
    pub fn normalized(self) -> Self {
        let norm = self.norm();
        Self { vector: self.vector.map(|x| x / norm), scalar: self.scalar / norm }
    }

    /// The inverse rotation.
    ///
    /// ```
    /// let turn = robot_dynamics::description::Quaternion::from_xyzw([0.0, 0.6, 0.0, 0.8]);
    /// assert_eq!(turn.times(turn.conjugate()).to_xyzw(), [0.0, 0.0, 0.0, 1.0]);
    /// ```
    #[must_use]
    pub fn conjugate(self) -> Self {
        Self { vector: self.vector.map(|x| -x), scalar: self.scalar }
    }

    /// The product: first `other`, then `self`; `a_from_b · b_from_c`.
    ///
    /// ```
    /// use robot_dynamics::description::Quaternion;
    /// use std::f64::consts::FRAC_PI_2;
    /// // x → y by the rotation about z, and y → z by the one about x.
    /// let (about_z, about_x) = (Quaternion::exp([0.0, 0.0, FRAC_PI_2]), Quaternion::exp([FRAC_PI_2, 0.0, 0.0]));
    /// let turned = about_x.times(about_z).rotate([1.0, 0.0, 0.0]);
    /// assert!((turned[2] - 1.0).abs() < 1e-15);
    /// ```
    #[must_use]
    pub fn times(self, other: Self) -> Self {
        let (a, b) = (V3::new(self.vector), V3::new(other.vector));
        Self {
            vector: (a * other.scalar + b * self.scalar + a.cross(b)).array(),
            scalar: self.scalar * other.scalar - a.dot(b),
        }
    }

    /// R v; the length of the quaternion does not matter.
    ///
    /// ```
    /// // A quarter turn about z, by a quaternion of length √2.
    /// let [x, y, _] = robot_dynamics::description::Quaternion::from_xyzw([0.0, 0.0, 1.0, 1.0]).rotate([2.0, 0.0, 0.0]);
    /// assert!(x.abs() < 1e-15 && (y - 2.0).abs() < 1e-15);
    /// ```
    pub fn rotate(self, v: [f64; 3]) -> [f64; 3] {
        (rotation_of(&self.to_xyzw()) * V3::new(v)).array()
    }

    /// Rᵀ v.
    ///
    /// ```
    /// let turn = robot_dynamics::description::Quaternion::exp([0.3, -0.8, 1.1]);
    /// let back = turn.rotate_back(turn.rotate([1.0, 2.0, 3.0]));
    /// assert!(back.iter().zip([1.0, 2.0, 3.0]).all(|(back, v)| (back - v).abs() < 1e-14));
    /// ```
    pub fn rotate_back(self, v: [f64; 3]) -> [f64; 3] {
        rotation_of(&self.to_xyzw()).transpose_mul(V3::new(v)).array()
    }

    /// exp(φ̂): the rotation by |φ| rad about φ. **(MLS eq. 2.14)**
    ///
    /// (φ/|φ| sin ½|φ|, cos ½|φ|); sin x / x needs no series, only its value at 0.
    ///
    /// ```
    /// use std::f64::consts::FRAC_PI_3;
    /// let sixth = robot_dynamics::description::Quaternion::exp([0.0, 0.0, FRAC_PI_3]); // 60° about z
    /// let [x, y, _] = sixth.rotate([1.0, 0.0, 0.0]);
    /// assert!((x - 0.5).abs() < 1e-15 && (y - 0.75_f64.sqrt()).abs() < 1e-15);
    /// ```
    pub fn exp(rotation_vector: [f64; 3]) -> Self {
        let phi = V3::new(rotation_vector);
        let half = 0.5 * phi.dot(phi).sqrt();
        let (sine, cosine) = half.sin_cos();
        let ratio = if half == 0.0 { 0.5 } else { 0.5 * sine / half };
        Self { vector: (phi * ratio).array(), scalar: cosine }
    }

    /// The rotation vector φ \[rad\] with |φ| ≤ π whose [`exp`](Self::exp) is this rotation.
    ///
    /// φ = 2 atan2(|v|, w) v/|v|, which is accurate up to half a turn, unlike the trace formula.
    ///
    /// ```
    /// use robot_dynamics::description::Quaternion;
    /// let phi = Quaternion::exp([0.3, -0.8, 1.1]).log();
    /// assert!(phi.iter().zip([0.3, -0.8, 1.1]).all(|(phi, x)| (phi - x).abs() < 1e-15));
    /// ```
    pub fn log(self) -> [f64; 3] {
        // q and −q are the same rotation; the one with w ≥ 0 has an angle of at most π.
        let sign = if self.scalar < 0.0 { -1.0 } else { 1.0 };
        let (v, w) = (V3::new(self.vector) * sign, self.scalar * sign);
        let sine = v.dot(v).sqrt();
        // Below 1e-100 the square of the sine underflows; atan2(s, w)/s rounds to 1/w at much larger s.
        let ratio = if sine < 1e-100 { 2.0 / w } else { 2.0 * sine.atan2(w) / sine };
        (v * ratio).array()
    }
}

/// R of the quaternion (x y z w), divided by |q|². So q need not have unit length, and the derivative along q
/// vanishes. **(RBDA eq. 4.13)**
#[doc(hidden)]
#[inline(always)]
pub fn rotation_of<S: Scalar>(&[x, y, z, w]: &[S; 4]) -> M3<S> {
    let two = S::from_f64(2.0) / (x * x + y * y + z * z + w * w);
    let one = S::one();
    M3::from_rows([
        [one - two * (y * y + z * z), two * (x * y - w * z), two * (x * z + w * y)],
        [two * (x * y + w * z), one - two * (x * x + z * z), two * (y * z - w * x)],
        [two * (x * z - w * y), two * (y * z + w * x), one - two * (x * x + y * y)],
    ])
}
