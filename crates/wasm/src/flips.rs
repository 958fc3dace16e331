//! The map of first flips: many two-link arms released from rest, several in each register.
//!
//! Angles are absolute, measured from the hanging rod: θ₁ = q₁ + π/2, θ₂ = q₁ + q₂ + π/2. With δ = θ₂ − θ₁, a
//! = I₁ + m₁r₁² + m₂L₁², b = I₂ + m₂r₂², c = m₂L₁r₂, k₁ = (m₁r₁ + m₂L₁) a_g, k₂ = m₂r₂ a_g, the arm of
//! [`Reach2R`] obeys
//!
//! > a θ̈₁ + c cos δ θ̈₂ = c sin δ θ̇₂² − k₁ sin θ₁,  c cos δ θ̈₁ + b θ̈₂ = −c sin δ θ̇₁² − k₂ sin θ₂.
//!
//! A rod flips when it first points straight up, |θ| = π.

use core::f64::consts::PI;

use dynamics::Reach2R;
use robot_dynamics_number::dispatch::{Hardware, LaneKernel, LaneMemory, Storage};
use robot_dynamics_number::{InstructionSet, Scalar, StateLanes};
use wasm_bindgen::prelude::wasm_bindgen;

use crate::LabError;
use crate::input::{number, positive};

/// The number of lanes of the widest register.
const MOST: usize = 8;

/// First flips of two uniform rods, by Runge–Kutta 4.
#[wasm_bindgen]
#[derive(Debug)]
pub struct FlipMap {
    rods: Rods,
    h: f64,
    memory: LaneMemory<Pendulums>,
    steps: f64,
}

#[wasm_bindgen]
impl FlipMap {
    /// Two uniform rods, lengths \[m\], masses \[kg\], gravity \[m/s²\], and the step \[s\].
    ///
    /// # Errors
    /// Fails if a length, a mass or the step is not positive.
    #[wasm_bindgen(constructor)]
    pub fn new(l1: f64, m1: f64, l2: f64, m2: f64, a_g: f64, h: f64) -> Result<Self, LabError> {
        let (l1, m1) = (positive("length 1", l1)?, positive("mass 1", m1)?);
        let (l2, m2) = (positive("length 2", l2)?, positive("mass 2", m2)?);
        let rods = Rods::of(&Reach2R::uniform(l1, m1, l2, m2, number("gravity", a_g)?));
        let memory = LaneMemory::new::<f64>(InstructionSet::best(), ());
        Ok(Self { rods, h: positive("the step", h)?, memory, steps: 0.0 })
    }

    /// The time of the first flip of each arm \[s\], from rest at q₁, q₂, q₁, q₂, … \[rad\]. It is −1 if no
    /// rod flips within `duration` \[s\], and −2 if the energy excludes a flip.
    ///
    /// # Errors
    /// Fails if the angles are not pairs of finite numbers, or the duration is not positive.
    #[wasm_bindgen(js_name = firstFlips)]
    pub fn first_flips(&mut self, angles: &[f64], duration: f64) -> Result<Vec<f32>, LabError> {
        if !angles.len().is_multiple_of(2) {
            return Err(LabError::new(format!("expected pairs of angles, got {} numbers", angles.len())));
        }
        crate::input::finite("angles", angles, angles.len())?;
        // Saturates at a number of steps that no page reaches.
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
        let limit = (positive("the duration", duration)? / self.h).round() as u32;
        let mut times = vec![-1.0; angles.len() / 2];
        let sweep =
            Sweep { rods: self.rods, h: self.h, limit, angles, times: &mut times, steps: &mut self.steps };
        self.memory.run(sweep);
        Ok(times)
    }

    /// The number of steps of all arms so far.
    #[wasm_bindgen(getter)]
    pub fn steps(&self) -> f64 {
        self.steps
    }

    /// The number of arms in one register.
    #[wasm_bindgen(getter)]
    pub fn lanes(&self) -> usize {
        self.memory.lanes()
    }
}

/// The five numbers that determine the arm's motion.
#[derive(Clone, Copy, Debug)]
struct Rods {
    a: f64,
    b: f64,
    c: f64,
    k1: f64,
    k2: f64,
}

impl Rods {
    fn of(arm: &Reach2R) -> Self {
        let Reach2R { l1, r1, m1, i1, r2, m2, i2, a_g, .. } = *arm;
        Self {
            a: i1 + m1 * r1 * r1 + m2 * l1 * l1,
            b: i2 + m2 * r2 * r2,
            c: m2 * l1 * r2,
            k1: (m1 * r1 + m2 * l1) * a_g,
            k2: m2 * r2 * a_g,
        }
    }

    /// Whether an arm at rest has the energy of the lowest pose with a rod upright, in which only that rod is
    /// up.
    fn can_flip(&self, [t1, t2]: [f64; 2]) -> bool {
        -self.k1 * t1.cos() - self.k2 * t2.cos() >= -(self.k1 - self.k2).abs()
    }
}

/// The arm with its rods' equations divided by a and b, and the step as the unit of time:
///
/// > θ̈₁ + α cos δ θ̈₂ = α sin δ θ̇₂² − κ₁ sin θ₁,  β α cos δ θ̈₁ + θ̈₂ = −β α sin δ θ̇₁² − κ₂ α sin θ₂,
///
/// with α = c/a, β = a/b, κ₁ = k₁h²/a, κ₂ = k₂h²/(b α). The outer rod's sine and cosine are stored multiplied
/// by α, so that those of δ contain the factor.
#[derive(Clone, Copy, Debug)]
struct NormalizedArm {
    alpha: f64,
    beta: f64,
    kappa1: f64,
    kappa2: f64,
}

impl NormalizedArm {
    fn of(Rods { a, b, c, k1, k2 }: Rods, h: f64) -> Self {
        let alpha = c / a;
        Self { alpha, beta: a / b, kappa1: k1 * h * h / a, kappa2: k2 * h * h / (b * alpha) }
    }

    /// The factors of the stored sines and cosines.
    fn lengths(&self) -> [f64; 2] {
        [1.0, self.alpha]
    }

    /// θ̈, from the stored sines and cosines of θ.
    #[inline(always)]
    fn acceleration<S: Scalar>(&self, [s1, s2]: [S; 2], [c1, c2]: [S; 2], rate: [S; 2]) -> [S; 2] {
        let (sine, cosine) = (s2 * c1 - c2 * s1, c2.mul_add(c1, s2 * s1));
        let (push, off) = (sine.scale(self.beta), cosine.scale(self.beta));
        // Both right-hand sides have the opposite sign, like the inverse of the determinant.
        let f1 = s1.scale(self.kappa1) - sine * (rate[1] * rate[1]);
        let f2 = push.mul_add(rate[0] * rate[0], s2.scale(self.kappa2));
        let inverse = S::one() / off.mul_add(cosine, S::from_f64(-1.0));
        [(f1 - cosine * f2) * inverse, (f2 - off * f1) * inverse]
    }

    /// One step of the classical Runge–Kutta method.
    ///
    /// Sines and cosines are updated with the angles by rotations. The second and the last stage rotate by
    /// half a step's and a step's motion from the start. The third rotates by a₁/4 from the second, and the
    /// end of the step by (a₁ − 2a₂ + a₃)/6 from the last stage. The last two angles are of second and third
    /// order in the step and need fewer terms. Each step corrects the lengths for truncation and rounding.
    #[inline(always)]
    fn step<S: Scalar>(&self, state: &mut State<S>) {
        let State { rate: v, sine, cosine, .. } = *state;
        let half = S::from_f64(0.5);
        let of_both = |turn: &dyn Fn(usize) -> (S, S)| {
            let [(s1, c1), (s2, c2)] = [turn(0), turn(1)];
            ([s1, s2], [c1, c2])
        };
        let a1 = self.acceleration(sine, cosine, v);
        let v2 = [0, 1].map(|i| a1[i].mul_add(half, v[i]));
        let (s2, c2) = of_both(&|i| turned(sine[i], cosine[i], v[i] * half));
        let a2 = self.acceleration(s2, c2, v2);
        let v3 = [0, 1].map(|i| a2[i].mul_add(half, v[i]));
        let (s3, c3) = of_both(&|i| turned_a_little(s2[i], c2[i], a1[i].scale(0.25)));
        let a3 = self.acceleration(s3, c3, v3);
        let v4 = [0, 1].map(|i| v[i] + a3[i]);
        let (s4, c4) = of_both(&|i| turned(sine[i], cosine[i], v3[i]));
        let a4 = self.acceleration(s4, c4, v4);
        let sixth = S::from_f64(1.0 / 6.0);
        for i in 0..2 {
            let outer = a1[i] + a3[i];
            state.angle[i] += (outer + a2[i]).mul_add(sixth, v[i]);
            state.rate[i] += (a1[i] + a4[i] + (a2[i] + a3[i]).scale(2.0)) * sixth;
            let x = (outer - a2[i].scale(2.0)) * sixth;
            let (s, c) = (c4[i].mul_add(x, s4[i]), c4[i] - s4[i] * x);
            // 1/√x near 1.
            let shrunk = S::from_f64(-0.5 / self.lengths()[i].powi(2));
            let length = s.mul_add(s, c * c).mul_add(shrunk, S::from_f64(1.5));
            (state.sine[i], state.cosine[i]) = (s * length, c * length);
        }
    }
}

/// Rotates sine and cosine by x with Taylor polynomials: within 1e-10 for |x| < 0.2, which is 20 rad/s in a
/// step of 10 ms.
#[inline(always)]
fn turned<S: Scalar>(sine: S, cosine: S, x: S) -> (S, S) {
    let k = S::from_f64;
    let z = x * x;
    let s = z.mul_add(k(-1.0 / 5040.0), k(1.0 / 120.0)).mul_add(z, k(-1.0 / 6.0));
    let s = (x * z).mul_add(s, x);
    let c = z.mul_add(k(-1.0 / 720.0), k(1.0 / 24.0)).mul_add(z, k(-0.5)).mul_add(z, k(1.0));
    (sine.mul_add(c, cosine * s), cosine * c - sine * s)
}

/// The same within x³/6, for angles of second order in the step.
#[inline(always)]
fn turned_a_little<S: Scalar>(sine: S, cosine: S, x: S) -> (S, S) {
    let c = (x * x).mul_add(S::from_f64(-0.5), S::one());
    (sine.mul_add(c, cosine * x), cosine * c - sine * x)
}

/// Angles from the hanging position, their rates in radians per step, and sines and cosines with the factors
/// of [`NormalizedArm::lengths`], for one arm or several.
#[derive(Clone, Copy, Debug)]
struct State<S> {
    angle: [S; 2],
    rate: [S; 2],
    sine: [S; 2],
    cosine: [S; 2],
}

/// [`State`] over any scalar type.
struct Pendulums;

impl Storage for Pendulums {
    type Over<S: Scalar> = State<S>;
    type Input<'a> = ();

    /// The state at rest.
    fn new<S: Scalar>((): ()) -> State<S> {
        State { angle: [S::zero(); 2], rate: [S::zero(); 2], sine: [S::zero(); 2], cosine: [S::one(); 2] }
    }
}

/// One call of [`FlipMap::first_flips`].
struct Sweep<'a> {
    rods: Rods,
    h: f64,
    limit: u32,
    angles: &'a [f64],
    times: &'a mut [f32],
    steps: &'a mut f64,
}

impl LaneKernel<Pendulums, f64> for Sweep<'_> {
    /// A lane whose arm has flipped or run its time takes the next arm that can flip.
    #[inline(always)]
    fn run<N: StateLanes<Float = f64>, H: Hardware>(self, memory: &mut State<N>) {
        let Self { rods, h, limit, angles, times, steps } = self;
        let mut next = 0;
        let mut arm = [usize::MAX; MOST];
        let mut taken = [0_u32; MOST];
        let mut running = 0_usize;
        let mut take = |times: &mut [f32]| {
            while next < times.len() {
                let k = next;
                next += 1;
                let t1 = angles[2 * k] + PI / 2.0;
                let start = [t1, t1 + angles[2 * k + 1]].map(within);
                if start.iter().any(|angle| angle.abs() >= PI) {
                    times[k] = 0.0;
                } else if rods.can_flip(start) {
                    return Some((k, start));
                } else {
                    times[k] = -2.0;
                }
            }
            None
        };
        let normalized_arm = NormalizedArm::of(rods, h);
        let lengths = normalized_arm.lengths();
        let mut state = *memory;
        for lane in 0..N::LANES {
            // An unused lane holds an arm at rest in the hanging position.
            let start = take(times).map_or([0.0; 2], |(k, start)| {
                arm[lane] = k;
                running += 1;
                start
            });
            set(&mut state, lane, start, lengths);
        }
        // Steps since the lanes were last inspected, and the number until one has run its time.
        let (mut since, mut until) = (0, limit);
        while running > 0 {
            normalized_arm.step(&mut state);
            since += 1;
            if since < until && state.angle[0].all_within(PI) && state.angle[1].all_within(PI) {
                continue;
            }
            until = limit;
            for lane in 0..N::LANES {
                taken[lane] += since;
                let up = state.angle.iter().any(|angle| angle.lane(lane).abs() >= PI);
                if arm[lane] != usize::MAX && (up || taken[lane] >= limit) {
                    *steps += f64::from(taken[lane]);
                    #[allow(clippy::cast_possible_truncation)] // // seconds for a picture
                    if up {
                        times[arm[lane]] = (f64::from(taken[lane]) * h) as f32;
                    }
                    taken[lane] = 0;
                    let start = take(times);
                    arm[lane] = start.map_or(usize::MAX, |(k, _)| k);
                    running -= usize::from(start.is_none());
                    set(&mut state, lane, start.map_or([0.0; 2], |(_, start)| start), lengths);
                }
                if arm[lane] != usize::MAX {
                    until = until.min(limit - taken[lane]);
                }
            }
            since = 0;
        }
        *memory = state;
    }
}

/// Puts an arm at rest into a lane.
#[inline(always)]
fn set<N: StateLanes<Float = f64>>(state: &mut State<N>, lane: usize, angle: [f64; 2], lengths: [f64; 2]) {
    let replaced = |old: N, new: f64| N::from_lanes(|k| if k == lane { new } else { old.lane(k) });
    for i in 0..2 {
        state.angle[i] = replaced(state.angle[i], angle[i]);
        state.rate[i] = replaced(state.rate[i], 0.0);
        state.sine[i] = replaced(state.sine[i], lengths[i] * angle[i].sin());
        state.cosine[i] = replaced(state.cosine[i], lengths[i] * angle[i].cos());
    }
}

/// The angle modulo 2π, in [−π, π].
fn within(angle: f64) -> f64 {
    angle - 2.0 * PI * (angle / (2.0 * PI)).round()
}

#[cfg(test)]
mod tests {
    use dynamics::{Dynamics, rk4_step};
    use nalgebra::{Vector2, vector};

    use super::*;

    const H: f64 = 0.01;

    /// The same arm by the chapter's closed form in relative angles, one at a time. Runge–Kutta steps commute
    /// with a linear change of coordinates, so the results differ by rounding and the truncated sines only.
    fn reference(arm: &Reach2R, q: Vector2<f64>, steps: u32) -> f64 {
        let (mut q, mut qd) = (q, Vector2::zeros());
        for k in 1..=steps {
            (q, qd) = rk4_step(arm, &q, &qd, &Vector2::zeros(), H).unwrap();
            let t1 = q[0] + PI / 2.0;
            if t1.abs() >= PI || (t1 + q[1]).abs() >= PI {
                return f64::from(k) * H;
            }
        }
        -1.0
    }

    #[test]
    fn flips_are_those_of_the_chapters_arm() -> Result<(), LabError> {
        let arm = Reach2R::worked_example();
        let mut map = FlipMap::new(1.0, 2.0, 1.0, 1.0, 9.81, H)?;
        // Two seconds, in which chaos does not yet magnify rounding.
        let mut angles = Vec::new();
        for i in 0..12 {
            for j in 0..12 {
                let (t1, t2) = (-2.9 + 0.5 * f64::from(i), -2.8 + 0.5 * f64::from(j));
                angles.extend([t1 - PI / 2.0, t2 - t1]);
            }
        }
        let times = map.first_flips(&angles, 2.0)?;
        let (mut flipped, mut never) = (0, 0);
        for (k, &time) in times.iter().enumerate() {
            let q = vector![angles[2 * k], angles[2 * k + 1]];
            let expected = reference(&arm, q, 200);
            if time == -2.0 {
                never += 1;
                assert_eq!(expected, -1.0, "{q} cannot flip by its energy");
            } else {
                flipped += u32::from(time > 0.0);
                assert!((f64::from(time) - expected).abs() < 1e-6, "{q}: {time} s, not {expected} s");
            }
        }
        assert!(flipped > 30 && never > 20, "{flipped} flipped, {never} cannot");
        assert!(map.steps() > 100.0);
        Ok(())
    }

    /// Compares a second of the map's steps with the closed form, and with steps of half the length. The
    /// truncated sines add less than a thousandth of the method's own error.
    #[test]
    fn a_step_is_runge_kuttas() {
        let arm = Reach2R::worked_example();
        let normalized = NormalizedArm::of(Rods::of(&arm), H);
        let by = |q, qd, h| rk4_step(&arm, &q, &qd, &Vector2::zeros(), h).unwrap();
        let (mut short, mut own, mut fastest): (f64, f64, f64) = (0.0, 0.0, 0.0);
        for k in 0..12 {
            let t = [2.9 - 0.4 * f64::from(k), 2.0 - 0.3 * f64::from(k)];
            let start = (vector![t[0] - PI / 2.0, t[1] - t[0]], Vector2::zeros());
            let ((mut q, mut qd), (mut finer, mut finer_rate)) = (start, start);
            let mut state: State<f64> = Pendulums::new(());
            set(&mut state, 0, t, normalized.lengths());
            for _ in 0..100 {
                (q, qd) = by(q, qd, H);
                for _ in 0..2 {
                    (finer, finer_rate) = by(finer, finer_rate, H / 2.0);
                }
                normalized.step(&mut state);
            }
            let expected = [q[0] + PI / 2.0, q[0] + q[1] + PI / 2.0, qd[0], qd[0] + qd[1]];
            let found = [state.angle[0], state.angle[1], state.rate[0] / H, state.rate[1] / H];
            for i in 0..4 {
                short = short.max((found[i] - expected[i]).abs());
            }
            own = own.max((finer - q).amax()).max((finer_rate - qd).amax());
            fastest = fastest.max(expected[2].abs()).max(expected[3].abs());
        }
        assert!(short < 1e-3 * own, "{short} beside {own}, at up to {fastest} rad/s");
        assert!(fastest > 5.0, "{short} beside {own}, at up to {fastest} rad/s");
    }

    /// Runge–Kutta's energy error over 20 s in steps of 10 ms, for arms released high: the accuracy of the
    /// map's method.
    #[test]
    fn energy_is_kept_well_enough_for_a_map() {
        let arm = Reach2R::worked_example();
        let mut worst: f64 = 0.0;
        for k in 0..16 {
            let q = vector![1.2 + 0.02 * f64::from(k), 0.3];
            let drift = dynamics::energy_drift(
                &arm,
                &q,
                &Vector2::zeros(),
                &Vector2::zeros(),
                H,
                2000,
                dynamics::Integrator::RungeKutta4,
            )
            .unwrap();
            worst = worst.max(drift * arm.energy(&q, &Vector2::zeros()).abs());
        }
        assert!(worst < 0.5, "{worst} J of about 25 J");
    }

    #[test]
    fn wrong_angles_are_refused() {
        let mut map = FlipMap::new(1.0, 2.0, 1.0, 1.0, 9.81, H).unwrap();
        assert!(map.first_flips(&[1.0], 1.0).is_err());
        assert!(map.first_flips(&[1.0, f64::NAN], 1.0).is_err());
        assert!(FlipMap::new(1.0, 2.0, 1.0, 1.0, 9.81, 0.0).is_err());
        // Already upright.
        assert_eq!(map.first_flips(&[PI / 2.0, 0.0], 1.0).unwrap(), [0.0]);
    }
}
