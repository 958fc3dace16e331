//! Motion along a path: torques for a time parameterisation of a curve.

use nalgebra::{SMatrix, SVector, matrix, vector};

use crate::Dynamics;

/// A point of a path with its first two derivatives by the path parameter s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathPoint<const N: usize> {
    /// q(s) \[rad or m\].
    pub q: SVector<f64, N>,
    /// q′ = dq/ds.
    pub dq: SVector<f64, N>,
    /// q″ = d²q/ds².
    pub ddq: SVector<f64, N>,
}

/// A curve q(s), twice differentiable, without a time parameterisation.
pub trait Path<const N: usize> {
    /// q, q′ and q″ at s.
    fn at(&self, s: f64) -> PathPoint<N>;
}

/// A closed curve by Fourier coefficients: q(s) = centre + Σₖ (cosineₖ cos ks + sineₖ sin ks), k = 1..H.
///
/// One turn is s from 0 to 2π; the curve is smooth everywhere, the closing point included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FourierLoop<const N: usize, const H: usize> {
    /// The mean of q over the loop.
    pub centre: SVector<f64, N>,
    /// Column k − 1 holds the amplitudes of cos ks.
    pub cosines: SMatrix<f64, N, H>,
    /// Column k − 1 holds the amplitudes of sin ks.
    pub sines: SMatrix<f64, N, H>,
}

impl<const N: usize, const H: usize> Path<N> for FourierLoop<N, H> {
    fn at(&self, s: f64) -> PathPoint<N> {
        let mut point = PathPoint { q: self.centre, dq: SVector::zeros(), ddq: SVector::zeros() };
        for i in 0..H {
            let k = (i + 1) as f64;
            let (sine, cosine) = (k * s).sin_cos();
            let (a, b) = (self.cosines.column(i), self.sines.column(i));
            let harmonic = a * cosine + b * sine;
            point.q += harmonic;
            point.dq += (b * cosine - a * sine) * k;
            point.ddq -= harmonic * (k * k);
        }
        point
    }
}

/// The curve that the 2R arm follows: q1 = −π/2 + 0.6 cos s, q2 = −0.8 + 1.2 sin s + 0.2 cos 2s \[rad\].
///
/// At ṡ = [`REACH_REPLAY_SPEED`] the torques of [`Reach2R::worked_example`](crate::Reach2R::worked_example)
/// peak at 8.5 and 4.9 N·m, within the limits of 20 and 12 N·m. At twice that speed they peak at 49.7 and
/// 18.9 N·m, beyond both.
///
/// ```
/// use dynamics::{REACH_REPLAY_SPEED, Reach2R, peak_torque, reach_replay};
/// let arm = Reach2R::worked_example();
/// let peak = |times: f64| peak_torque(&arm, &reach_replay(), times * REACH_REPLAY_SPEED, 400);
/// assert!(peak(1.0)[0] < 20.0 && peak(1.0)[1] < 12.0);
/// assert!(peak(2.0)[0] > 20.0 && peak(2.0)[1] > 12.0);
/// ```
pub fn reach_replay() -> FourierLoop<2, 2> {
    FourierLoop {
        centre: vector![-core::f64::consts::FRAC_PI_2, -0.8],
        cosines: matrix![0.6, 0.0; 0.0, 0.2],
        sines: matrix![0.0, 0.0; 1.2, 0.0],
    }
}

/// ṡ of [`reach_replay`] at 1× \[1/s\]: one loop takes 2π/2.5 = 2.51 s.
pub const REACH_REPLAY_SPEED: f64 = 2.5;

/// The dynamics of a system on a path: a(s) s̈ + b(s) ṡ² + c(s) = τ. **(PRM ch. 11; MR §9.4)**
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathDynamics<const N: usize> {
    /// a = M q′.
    pub a: SVector<f64, N>,
    /// b = M q″ + q′ᵀΓq′.
    pub b: SVector<f64, N>,
    /// c = g(q).
    pub c: SVector<f64, N>,
}

impl<const N: usize> PathDynamics<N> {
    /// The coefficients at a point of a path, without dissipation.
    pub fn new<D: Dynamics<N> + ?Sized>(system: &D, point: &PathPoint<N>) -> Self {
        let mass = system.mass(&point.q);
        Self {
            a: mass * point.dq,
            // q̇ = q′ ṡ, and the velocity product is quadratic in q̇.
            b: mass * point.ddq + system.velocity_product(&point.q, &point.dq),
            c: system.gravity(&point.q),
        }
    }

    /// τ = a s̈ + b ṡ² + c \[N·m or N\].
    pub fn torque(&self, speed: f64, acceleration: f64) -> SVector<f64, N> {
        self.motion_torque(speed, acceleration) + self.c
    }

    /// The velocity part a s̈ + b ṡ²: with k times the speed (ṡ by k, s̈ by k²) it grows by k².
    pub fn motion_torque(&self, speed: f64, acceleration: f64) -> SVector<f64, N> {
        self.a * acceleration + self.b * (speed * speed)
    }
}

/// The largest |τ| of each joint over one loop of a path, s in \[0, 2π\], at constant ṡ = `speed` \[1/s\].
///
/// The loop is sampled at `samples` equal steps.
///
/// ```
/// use dynamics::{FourierLoop, PlanarBody, peak_torque};
/// use nalgebra::vector;
/// // A body of 2 kg on a circle of 0.5 m: the force is m r ṡ², and each axis sees all of it.
/// let (body, zero) = (PlanarBody { m: 2.0, i_zz: 0.1, a_g: 0.0 }, vector![0.0, 0.0, 0.0]);
/// let circle = FourierLoop { centre: zero, cosines: vector![0.5, 0.0, 0.0], sines: vector![0.0, 0.5, 0.0] };
/// assert!((peak_torque(&body, &circle, 3.0, 400) - vector![9.0, 9.0, 0.0]).norm() < 1e-14);
/// ```
///
/// # Panics
/// If `samples` is 0.
pub fn peak_torque<D, P, const N: usize>(system: &D, path: &P, speed: f64, samples: usize) -> SVector<f64, N>
where
    D: Dynamics<N> + ?Sized,
    P: Path<N> + ?Sized,
{
    assert!(samples > 0, "a loop needs at least one sample");
    (0..samples).fold(SVector::zeros(), |peak: SVector<f64, N>, i| {
        let s = core::f64::consts::TAU * i as f64 / samples as f64;
        peak.sup(&PathDynamics::new(system, &path.at(s)).torque(speed, 0.0).abs())
    })
}

/// The largest constant ṡ \[1/s\] at which every |τᵢ| over the loop stays within its limit.
///
/// |bᵢ ṡ² + cᵢ| ≤ limitᵢ bounds ṡ² by (limitᵢ − cᵢ)/bᵢ if bᵢ > 0 and by (limitᵢ + cᵢ)/(−bᵢ) if bᵢ < 0; the
/// result is the smallest bound over `samples` points. `None` if gravity alone exceeds a limit; infinite if
/// no torque on the path depends on speed.
///
/// ```
/// use dynamics::{Reach2R, fastest_constant_speed, peak_torque, reach_replay};
/// use nalgebra::vector;
/// // At that speed one motor is at its limit, the other within its own.
/// let (arm, limits) = (Reach2R::worked_example(), vector![20.0, 12.0]);
/// let speed = fastest_constant_speed(&arm, &reach_replay(), &limits, 400).expect("it can carry its weight");
/// let used = peak_torque(&arm, &reach_replay(), speed, 400).component_div(&limits);
/// assert!((used.max() - 1.0).abs() < 1e-14);
/// // Motors that cannot hold the arm cannot move it either.
/// assert_eq!(fastest_constant_speed(&arm, &reach_replay(), &vector![1.0, 1.0], 400), None);
/// ```
///
/// # Panics
/// If `samples` is 0.
pub fn fastest_constant_speed<D, P, const N: usize>(
    system: &D,
    path: &P,
    limits: &SVector<f64, N>,
    samples: usize,
) -> Option<f64>
where
    D: Dynamics<N> + ?Sized,
    P: Path<N> + ?Sized,
{
    assert!(samples > 0, "a loop needs at least one sample");
    let mut square = f64::INFINITY;
    for sample in 0..samples {
        let s = core::f64::consts::TAU * sample as f64 / samples as f64;
        let PathDynamics { b, c, .. } = PathDynamics::new(system, &path.at(s));
        for i in 0..N {
            if c[i].abs() > limits[i] {
                return None;
            }
            if b[i] != 0.0 {
                square = square.min((limits[i] - c[i] * b[i].signum()) / b[i].abs());
            }
        }
    }
    Some(square.sqrt())
}
