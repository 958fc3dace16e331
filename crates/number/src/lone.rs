//! Lanes whose arithmetic is that of one state alone, to the bit.
//!
//! One state is computed over `Fused<f64>`, whose triples are whole registers (`Quad`) and round in the order of those instructions;
//! around the recursions it is computed over `f64`, which fuses nothing. Lanes have the fastest order instead, and other last digits.
//! [`Lone`] and [`Unfused`] are lanes with the order of one state: each operation of each lane is the one that a lone number takes.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::{Scalar, Symmetric, Triple};

macro_rules! operator {
    ($name:ident, $trait:ident, $method:ident) => {
        impl<S: Scalar> $trait for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(self.0.$method(other.0))
            }
        }
    };
    ($name:ident, $trait:ident, $method:ident, assign) => {
        impl<S: Scalar> $trait for $name<S> {
            #[inline(always)]
            fn $method(&mut self, other: Self) {
                self.0.$method(other.0);
            }
        }
    };
}

macro_rules! wrapper {
    ($name:ident) => {
        operator!($name, Add, add);
        operator!($name, Sub, sub);
        operator!($name, Mul, mul);
        operator!($name, Div, div);
        operator!($name, AddAssign, add_assign, assign);
        operator!($name, SubAssign, sub_assign, assign);
        operator!($name, MulAssign, mul_assign, assign);

        impl<S: Scalar> Neg for $name<S> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }
    };
}

/// The operations of a `Scalar` in which the lanes' order is that of one state.
macro_rules! scalar_by_lanes {
    () => {
        #[inline(always)]
        fn from_f64(x: f64) -> Self {
            Self(S::from_f64(x))
        }
        #[inline(always)]
        fn sin_cos(self) -> (Self, Self) {
            let (sine, cosine) = self.0.sin_cos();
            (Self(sine), Self(cosine))
        }
        #[inline(always)]
        fn sqrt(self) -> Self {
            Self(self.0.sqrt())
        }
        #[inline(always)]
        fn signum0(self) -> Self {
            Self(self.0.signum0())
        }
    };
}

wrapper!(Lone);
wrapper!(Unfused);

/// Lanes of `f64` that fuse no multiply-add, as a lone `f64`.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Unfused<S>(pub S);

impl<S: Scalar> Scalar for Unfused<S> {
    type Triple = [Self; 3];
    type Symmetric = [Self; 6];
    scalar_by_lanes!();
}

/// Lanes of `f64` with the operations and the order of the machine's number for one `f64`, up to signs of zeros.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Lone<S>(pub S);

impl<S: Scalar> Scalar for Lone<S> {
    type Triple = LoneTriple<S>;
    type Symmetric = [LoneTriple<S>; 3];
    scalar_by_lanes!();
    #[inline(always)]
    fn mul_add(self, a: Self, b: Self) -> Self {
        Self(self.0.mul_add(a.0, b.0))
    }
}

/// Three numbers, computed with as `Quad` does with those of one state.
#[derive(Clone, Copy, Debug)]
pub struct LoneTriple<S>([Lone<S>; 3]);

impl<S: Scalar> Triple<Lone<S>> for LoneTriple<S> {
    const COLUMNS: bool = true;

    #[inline(always)]
    fn new(components: [Lone<S>; 3]) -> Self {
        Self(components)
    }
    #[inline(always)]
    fn constant(components: &[f64; 4]) -> Self {
        let [x, y, z, _] = *components;
        Self([Lone::from_f64(x), Lone::from_f64(y), Lone::from_f64(z)])
    }
    #[inline(always)]
    fn array(self) -> [Lone<S>; 3] {
        self.0
    }
    #[inline(always)]
    fn get(self, i: usize) -> Lone<S> {
        self.0[i]
    }
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        let ([x, y, z], b) = (self.0, b.0);
        Self([x + b[0], y + b[1], z + b[2]])
    }
    #[inline(always)]
    fn minus(self, b: Self) -> Self {
        let ([x, y, z], b) = (self.0, b.0);
        Self([x - b[0], y - b[1], z - b[2]])
    }
    #[inline(always)]
    fn negated(self) -> Self {
        let [x, y, z] = self.0;
        Self([-x, -y, -z])
    }
    #[inline(always)]
    fn times(self, k: Lone<S>) -> Self {
        let [x, y, z] = self.0;
        Self([x * k, y * k, z * k])
    }
    #[inline(always)]
    fn times_plus(self, k: Lone<S>, b: Self) -> Self {
        let ([x, y, z], b) = (self.0, b.0);
        Self([x.mul_add(k, b[0]), y.mul_add(k, b[1]), z.mul_add(k, b[2])])
    }
    #[inline(always)]
    fn minus_times(self, k: Lone<S>, b: Self) -> Self {
        self.times_plus(-k, b)
    }
    #[inline(always)]
    fn times_lane<const I: usize>(self, v: Self) -> Self {
        self.times(v.0[I])
    }
    #[inline(always)]
    fn times_lane_plus<const I: usize>(self, v: Self, b: Self) -> Self {
        self.times_plus(v.0[I], b)
    }
    #[inline(always)]
    fn minus_times_lane<const I: usize>(self, v: Self, b: Self) -> Self {
        self.minus_times(v.0[I], b)
    }
    #[inline(always)]
    fn plus_z(self, z: Lone<S>) -> Self {
        let [x, y, own] = self.0;
        Self([x, y, own + z])
    }
    #[inline(always)]
    fn cross(self, b: Self) -> Self {
        let ([ax, ay, az], [bx, by, bz]) = (self.0, b.0);
        Self([ay.mul_add(bz, -(az * by)), az.mul_add(bx, -(ax * bz)), ax.mul_add(by, -(ay * bx))])
    }
    #[inline(always)]
    fn cross_sum(self, b: Self, c: Self, d: Self) -> Self {
        let ([cx, cy, cz], [dx, dy, dz]) = (c.0, d.0);
        let [x, y, z] = self.cross(b).0;
        Self([
            (-cz).mul_add(dy, cy.mul_add(dz, x)),
            (-cx).mul_add(dz, cz.mul_add(dx, y)),
            (-cy).mul_add(dx, cx.mul_add(dy, z)),
        ])
    }
    #[inline(always)]
    fn cross_z(self, z: Lone<S>) -> Self {
        let [x, y, _] = self.0;
        Self([y * z, x * -z, Lone::zero()])
    }
    #[inline(always)]
    fn skew(self) -> [Self; 3] {
        let ([x, y, z], o) = (self.0, Lone::zero());
        [Self([o, z, -y]), Self([-z, o, x]), Self([y, -x, o])]
    }
    #[inline(always)]
    fn spin_gradient(self, alpha: Self) -> [Self; 3] {
        let square = self.dot(self);
        let [mut x, mut y, mut z] = alpha.skew();
        x.0[0] -= square;
        y.0[1] -= square;
        z.0[2] -= square;
        [
            self.times_lane_plus::<0>(self, x),
            self.times_lane_plus::<1>(self, y),
            self.times_lane_plus::<2>(self, z),
        ]
    }
    #[inline(always)]
    fn dot(self, b: Self) -> Lone<S> {
        let ([x, y, z], b) = (self.0, b.0);
        (x * b[0] + y * b[1]) + z * b[2]
    }
    #[inline(always)]
    fn transpose([x, y, z]: [Self; 3]) -> [Self; 3] {
        let (x, y, z) = (x.0, y.0, z.0);
        [Self([x[0], y[0], z[0]]), Self([x[1], y[1], z[1]]), Self([x[2], y[2], z[2]])]
    }
    #[inline(always)]
    fn minus_scaled_outer([x, y, z]: [Self; 3], a: Self, b: Self, k: Lone<S>, _: Self) -> [Self; 3] {
        [
            a.times_lane::<0>(b).minus_times(k, x),
            a.times_lane::<1>(b).minus_times(k, y),
            a.times_lane::<2>(b).minus_times(k, z),
        ]
    }
}

/// Its three columns.
impl<S: Scalar> Symmetric<Lone<S>, LoneTriple<S>> for [LoneTriple<S>; 3] {
    #[inline(always)]
    fn from_columns(columns: [LoneTriple<S>; 3]) -> Self {
        columns
    }
    #[inline(always)]
    fn columns(self) -> [LoneTriple<S>; 3] {
        self
    }
    #[inline(always)]
    fn plus(self, b: Self) -> Self {
        [self[0].plus(b[0]), self[1].plus(b[1]), self[2].plus(b[2])]
    }
    #[inline(always)]
    fn plus_multiple_of_identity(self, k: Lone<S>) -> Self {
        let [mut x, mut y, mut z] = self;
        x.0[0] += k;
        y.0[1] += k;
        z.0[2] += k;
        [x, y, z]
    }
    #[inline(always)]
    fn minus_square(self, a: LoneTriple<S>, k: Lone<S>, scaled: LoneTriple<S>) -> Self {
        LoneTriple::minus_scaled_outer(self, a, a, k, scaled)
    }
    #[inline(always)]
    fn apply(self, v: LoneTriple<S>) -> LoneTriple<S> {
        let [x, y, z] = self;
        x.times_lane_plus::<0>(v, y.times_lane_plus::<1>(v, z.times_lane::<2>(v)))
    }
}

#[cfg(all(test, registers))]
mod tests {
    use super::*;
    use crate::fused::Fused;
    use crate::quad::Quad;
    use crate::registers::F64x4;
    use crate::{InstructionSet, SplitMix64, StateLanes};

    type Lanes = Lone<F64x4>;

    /// Each lane of a triple, as one state's.
    fn same(lanes: LoneTriple<F64x4>, each: impl Fn(usize) -> Quad) {
        for lane in 0..F64x4::LANES {
            let expected = each(lane).array().map(|x| x.0);
            assert_eq!(lanes.0.map(|x| x.0.lane(lane)), expected);
        }
    }

    /// Every operation of triples and of symmetric matrices, lane by lane.
    #[test]
    fn lanes_round_as_one_state() {
        if !InstructionSet::has_registers() {
            return;
        }
        let mut random = SplitMix64::new(4);
        for _ in 0..200 {
            let lanes: [[f64; 4]; 16] =
                core::array::from_fn(|_| core::array::from_fn(|_| random.uniform(-2.0, 2.0)));
            let number = |i: usize| Lone(F64x4::from_lanes(|lane| lanes[i][lane]));
            let triple = |i: usize| LoneTriple([number(i), number(i + 1), number(i + 2)]);
            let one = |i: usize, lane: usize| Fused(lanes[i][lane]);
            let quad = |i: usize, lane: usize| Quad::new([one(i, lane), one(i + 1, lane), one(i + 2, lane)]);
            let (a, b, c, d, k) = (triple(0), triple(3), triple(6), triple(9), number(12));
            let of =
                |lane: usize| (quad(0, lane), quad(3, lane), quad(6, lane), quad(9, lane), one(12, lane));

            same(a.plus(b), |l| of(l).0.plus(of(l).1));
            same(a.minus(b), |l| of(l).0.minus(of(l).1));
            same(a.negated(), |l| of(l).0.negated());
            same(a.times(k), |l| of(l).0.times(of(l).4));
            same(a.times_plus(k, b), |l| of(l).0.times_plus(of(l).4, of(l).1));
            same(a.minus_times(k, b), |l| of(l).0.minus_times(of(l).4, of(l).1));
            same(a.times_lane::<1>(b), |l| of(l).0.times_lane::<1>(of(l).1));
            same(a.times_lane_plus::<2>(b, c), |l| of(l).0.times_lane_plus::<2>(of(l).1, of(l).2));
            same(a.minus_times_lane::<0>(b, c), |l| of(l).0.minus_times_lane::<0>(of(l).1, of(l).2));
            same(a.plus_z(k), |l| of(l).0.plus_z(of(l).4));
            same(a.cross(b), |l| of(l).0.cross(of(l).1));
            same(a.cross_sum(b, c, d), |l| of(l).0.cross_sum(of(l).1, of(l).2, of(l).3));
            same(a.cross_z(k), |l| of(l).0.cross_z(of(l).4));
            let dot = a.dot(b);
            (0..4).for_each(|l| assert_eq!(dot.0.lane(l), of(l).0.dot(of(l).1).0));

            let columns = [a, b, c];
            let quads = |l: usize| [of(l).0, of(l).1, of(l).2];
            for j in 0..3 {
                same(a.skew()[j], |l| of(l).0.skew()[j]);
                same(a.spin_gradient(b)[j], |l| of(l).0.spin_gradient(of(l).1)[j]);
                same(LoneTriple::transpose(columns)[j], |l| Quad::transpose(quads(l))[j]);
                let outer = LoneTriple::minus_scaled_outer(columns, c, d, k, d.times(k));
                same(outer[j], |l| {
                    let (_, _, c, d, k) = of(l);
                    Quad::minus_scaled_outer(quads(l), c, d, k, d.times(k))[j]
                });
                let square = Symmetric::<Lanes, _>::minus_square(columns, d, k, d.times(k));
                same(square[j], |l| {
                    let (.., d, k) = of(l);
                    Symmetric::<Fused<f64>, _>::minus_square(quads(l), d, k, d.times(k))[j]
                });
                let sum = Symmetric::<Lanes, _>::plus_multiple_of_identity(columns, k);
                same(sum[j], |l| Symmetric::<Fused<f64>, _>::plus_multiple_of_identity(quads(l), of(l).4)[j]);
            }
            same(Symmetric::<Lanes, _>::apply(columns, d), |l| {
                Symmetric::<Fused<f64>, _>::apply(quads(l), of(l).3)
            });
            let (sine, cosine) = k.sin_cos();
            for l in 0..4 {
                let (mut s, mut c) = ([Fused(0.0)], [Fused(0.0)]);
                Fused::sin_cos_each(&[of(l).4], &mut s, &mut c);
                assert_eq!((sine.0.lane(l), cosine.0.lane(l)), (s[0].0, c[0].0));
                let (x, y) = (Unfused(number(13).0), Unfused(number(14).0));
                let plain = [12, 13, 14].map(|i| lanes[i][l]);
                assert_eq!(Unfused(k.0).mul_add(x, y).0.lane(l), plain[0] * plain[1] + plain[2]);
                assert_eq!(x.signum0().0.lane(l), plain[1].signum0());
            }
        }
    }
}
