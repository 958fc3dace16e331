//! Triples and symmetric 3×3 matrices as arrays: the layout of all numbers but a single hardware float.

use crate::{Scalar, Symmetric, Triple};

impl<S: Scalar> Triple<S> for [S; 3] {
    const COLUMNS: bool = false;

    #[inline(always)]
    fn new(components: [S; 3]) -> Self {
        components
    }
    #[inline(always)]
    fn constant(c: &[f64; 4]) -> Self {
        [S::from_f64(c[0]), S::from_f64(c[1]), S::from_f64(c[2])]
    }
    #[inline(always)]
    fn array(self) -> [S; 3] {
        self
    }
    #[inline(always)]
    fn get(self, i: usize) -> S {
        self[i]
    }
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        [self[0] + b[0], self[1] + b[1], self[2] + b[2]]
    }
    #[inline(always)]
    fn minus(self, b: Self) -> Self {
        [self[0] - b[0], self[1] - b[1], self[2] - b[2]]
    }
    #[inline(always)]
    fn negated(self) -> Self {
        [-self[0], -self[1], -self[2]]
    }
    #[inline(always)]
    fn times(self, k: S) -> Self {
        [self[0] * k, self[1] * k, self[2] * k]
    }
    #[inline(always)]
    fn times_plus(self, k: S, b: Self) -> Self {
        [k.mul_add(self[0], b[0]), k.mul_add(self[1], b[1]), k.mul_add(self[2], b[2])]
    }
    #[inline(always)]
    fn minus_times(self, k: S, b: Self) -> Self {
        self.times_plus(-k, b)
    }
    #[inline(always)]
    fn times_lane<const I: usize>(self, v: Self) -> Self {
        self.times(v[I])
    }
    #[inline(always)]
    fn times_lane_plus<const I: usize>(self, v: Self, b: Self) -> Self {
        self.times_plus(v[I], b)
    }
    #[inline(always)]
    fn minus_times_lane<const I: usize>(self, v: Self, b: Self) -> Self {
        self.times_plus(-v[I], b)
    }
    #[inline(always)]
    fn cross(self, b: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (self, b);
        [ay.mul_add(bz, -(az * by)), az.mul_add(bx, -(ax * bz)), ax.mul_add(by, -(ay * bx))]
    }
    #[inline(always)]
    fn cross_sum(self, b: Self, c: Self, d: Self) -> Self {
        self.cross(b).plus(c.cross(d))
    }
    #[inline(always)]
    fn plus_z(self, z: S) -> Self {
        [self[0], self[1], self[2] + z]
    }
    #[inline(always)]
    fn cross_z(self, z: S) -> Self {
        [self[1] * z, -(self[0] * z), S::zero()]
    }
    #[inline(always)]
    fn skew(self) -> [Self; 3] {
        let ([x, y, z], o) = (self, S::zero());
        [[o, z, -y], [-z, o, x], [y, -x, o]]
    }
    #[inline(always)]
    fn spin_gradient(self, alpha: Self) -> [Self; 3] {
        let ([wx, wy, wz], [ax, ay, az]) = (self, alpha);
        let (xx, yy, zz) = (wx * wx, wy * wy, wz * wz);
        let (xy, xz, yz) = (wx * wy, wx * wz, wy * wz);
        [[-(yy + zz), xy + az, xz - ay], [xy - az, -(xx + zz), yz + ax], [xz + ay, yz - ax, -(xx + yy)]]
    }
    #[inline(always)]
    fn dot(self, b: Self) -> S {
        self[0].mul_add(b[0], self[1].mul_add(b[1], self[2] * b[2]))
    }
    #[inline(always)]
    fn transpose([x, y, z]: [Self; 3]) -> [Self; 3] {
        [[x[0], y[0], z[0]], [x[1], y[1], z[1]], [x[2], y[2], z[2]]]
    }
    #[inline(always)]
    fn minus_scaled_outer([x, y, z]: [Self; 3], a: Self, _: Self, _: S, scaled: Self) -> [Self; 3] {
        [
            a.minus_times_lane::<0>(scaled, x),
            a.minus_times_lane::<1>(scaled, y),
            a.minus_times_lane::<2>(scaled, z),
        ]
    }
}

/// The entries xx, xy, xz, yy, yz, zz.
impl<S: Scalar> Symmetric<S, [S; 3]> for [S; 6] {
    #[inline(always)]
    fn from_columns([x, y, z]: [[S; 3]; 3]) -> Self {
        [x[0], y[0], z[0], y[1], z[1], z[2]]
    }
    #[inline(always)]
    fn columns(self) -> [[S; 3]; 3] {
        let [xx, xy, xz, yy, yz, zz] = self;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    }
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        [self[0] + b[0], self[1] + b[1], self[2] + b[2], self[3] + b[3], self[4] + b[4], self[5] + b[5]]
    }
    #[inline(always)]
    fn plus_multiple_of_identity(self, k: S) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self;
        [xx + k, xy, xz, yy + k, yz, zz + k]
    }
    #[inline(always)]
    fn minus_square(self, a: [S; 3], _: S, b: [S; 3]) -> Self {
        let [xx, xy, xz, yy, yz, zz] = self;
        let [x, y, z] = [-a[0], -a[1], -a[2]];
        [
            x.mul_add(b[0], xx),
            x.mul_add(b[1], xy),
            x.mul_add(b[2], xz),
            y.mul_add(b[1], yy),
            y.mul_add(b[2], yz),
            z.mul_add(b[2], zz),
        ]
    }
    #[inline(always)]
    fn apply(self, v: [S; 3]) -> [S; 3] {
        let [x, y, z] = self.columns();
        [x.dot(v), y.dot(v), z.dot(v)]
    }
}
