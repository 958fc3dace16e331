//! The dynamics from an actuator's control to its activation.

#[cfg(feature = "serde")]
use serde::{Deserialize, Serialize};

/// The dynamics from the control to the activation u.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(Serialize, Deserialize))]
pub enum Activation {
    /// u is the control.
    #[default]
    None,
    /// u̇ is the control.
    Integrator,
    /// u̇ = (control − u)/T.
    Filter {
        /// T \[s\].
        time_constant: f64,
    },
    /// u follows the control at no more than this rate: |u̇| ≤ rate.
    RateLimit {
        /// The largest rate, in units of the control by s.
        rate: f64,
    },
    /// The activation of a muscle, u̇ = (c − u)/T(c − u, u) with the control c limited to [0, 1]. Rising, T is
    /// rise·(½ + 3/2 u). Falling, it is fall/(½ + 3/2 u), with u limited to [0, 1] in both **(Millard et al.
    /// 2013)**.
    Muscle {
        /// The time constant of rising activation \[s\].
        rise: f64,
        /// The time constant of falling activation \[s\].
        fall: f64,
        /// The width in c − u of a smooth change between both; 0 for a sudden one.
        width: f64,
    },
}

impl Activation {
    /// u̇ for the limited control c.
    ///
    /// ```
    /// use robot_dynamics::description::Activation;
    /// assert_eq!(Activation::Filter { time_constant: 0.5 }.rate(3.0, 1.0), 4.0);
    /// ```
    pub fn rate(&self, control: f64, u: f64) -> f64 {
        match *self {
            Self::None => 0.0,
            Self::Integrator => control,
            Self::Filter { time_constant } => (control - u) / time_constant,
            Self::RateLimit { .. } if control == u => 0.0,
            Self::RateLimit { rate } => rate.copysign(control - u),
            Self::Muscle { rise, fall, width } => {
                MuscleActivation { rise, fall, width }.rate(control.clamp(0.0, 1.0), u)
            }
        }
    }

    /// u after h \[s\] of the limited control c. It is exact, except for a muscle with a smooth change
    /// of its time constant, whose relative error is below 1e-10.
    ///
    /// ```
    /// use robot_dynamics::description::Activation;
    /// let filter = Activation::Filter { time_constant: 0.5 };
    /// assert!((filter.after(0.5, 1.0, 0.0) - (1.0 - (-1.0_f64).exp())).abs() < 1e-15);
    /// ```
    pub fn after(&self, h: f64, control: f64, u: f64) -> f64 {
        match *self {
            Self::None => control,
            Self::Integrator => u + h * control,
            Self::Filter { time_constant } => u + (control - u) * -(-h / time_constant).exp_m1(),
            Self::RateLimit { rate } if (control - u).abs() <= rate * h => control,
            Self::RateLimit { rate } => u + (rate * h).copysign(control - u),
            Self::Muscle { rise, fall, width } => MuscleActivation { rise, fall, width }.after(h, control, u),
        }
    }
}

/// The activation of a muscle with the time constants of [`Activation::Muscle`].
#[derive(Clone, Copy, Debug)]
struct MuscleActivation {
    rise: f64,
    fall: f64,
    width: f64,
}

impl MuscleActivation {
    /// u̇ for a control between 0 and 1.
    fn rate(&self, control: f64, u: f64) -> f64 {
        let excess = control - u;
        let slowing = 0.5 + 1.5 * u.clamp(0.0, 1.0);
        let (rise, fall) = (self.rise * slowing, self.fall / slowing);
        let share = if self.width > 0.0 {
            smooth_step(excess / self.width + 0.5)
        } else if excess > 0.0 {
            1.0
        } else {
            0.0
        };
        excess / (fall + (rise - fall) * share)
    }

    fn after(&self, h: f64, control: f64, u: f64) -> f64 {
        let control = control.clamp(0.0, 1.0);
        if self.width > 0.0 || !(0.0..=1.0).contains(&u) {
            self.by_small_steps(h, control, u)
        } else if control > u {
            risen(h / self.rise, control, u)
        } else {
            fallen(h / self.fall, control, u)
        }
    }

    /// The classical Runge–Kutta method with steps of 1/400 of the smallest time constant. The rate changes
    /// up to four times as fast as that constant, so a step has an error of about (4/400)⁵/120.
    fn by_small_steps(&self, h: f64, control: f64, mut u: f64) -> f64 {
        let longest = 0.5 * self.rise.min(self.fall) / 400.0;
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 1 and 1e6
        let count = (h / longest).ceil().clamp(1.0, 1e6) as u32;
        let step = h / f64::from(count);
        for _ in 0..count {
            let a = self.rate(control, u);
            let b = self.rate(control, u + 0.5 * step * a);
            let c = self.rate(control, u + 0.5 * step * b);
            let d = self.rate(control, u + step * c);
            u += step / 6.0 * (a + 2.0 * (b + c) + d);
        }
        u
    }
}

/// With e = c − u, k = ½ + 3/2 c and y = ln(e₀/e), the solution of ė = −e/(k − 3/2 e) is k y − 3/2 e₀ (1
/// − e⁻ʸ) = t. The left side is convex with a slope of at least ½, so Newton's method converges from
/// above.
fn risen(t: f64, control: f64, u: f64) -> f64 {
    let (k, gap) = (0.5 + 1.5 * control, control - u);
    let mut y = 2.0 * t;
    for _ in 0..100 {
        let value = k.mul_add(y, 1.5 * gap * (-y).exp_m1()) - t;
        let step = value / (k - 1.5 * gap * (-y).exp());
        y -= step;
        if step.abs() <= 2.0 * f64::EPSILON * y {
            break;
        }
    }
    u - gap * (-y).exp_m1()
}

/// With e = u − c and k = ½ + 3/2 c, ė = −e (k + 3/2 e) is linear in 1/e.
fn fallen(t: f64, control: f64, u: f64) -> f64 {
    let (k, gap) = (0.5 + 1.5 * control, u - control);
    control + gap / ((k * t).exp() + 1.5 * gap * (k * t).exp_m1() / k)
}

/// 0 below 0, 1 above 1, and x³ (6x² − 15x + 10) between.
fn smooth_step(x: f64) -> f64 {
    let x = x.clamp(0.0, 1.0);
    x.powi(3) * (x * (6.0 * x - 15.0) + 10.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The closed forms against the Runge–Kutta method with steps of 1/4000 of the smallest time constant,
    /// whose error is about (1/1000)⁴/120. The rounding of a hundred thousand steps is below 1e-12.
    #[test]
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // at most a million parts
    fn muscles_rise_and_fall_as_their_equation_says() {
        let muscle = MuscleActivation { rise: 0.01, fall: 0.04, width: 0.0 };
        for (control, u) in [(1.0, 0.0), (0.6, 0.2), (0.3, 0.9), (0.0, 1.0), (0.4, 0.4), (0.0, 0.0)] {
            for h in [1e-5, 0.002, 0.02, 0.1] {
                let parts = (h / (0.5 * muscle.rise) * 4000.0).ceil();
                let mut stepped = u;
                for _ in 0..parts as u32 {
                    stepped = muscle.by_small_steps(h / parts, control, stepped);
                }
                let closed = muscle.after(h, control, u);
                assert!((closed - stepped).abs() < 1e-12, "{control} {u} {h}: {closed} {stepped}");
                let coarse = muscle.by_small_steps(h, control, u);
                assert!((closed - coarse).abs() < 1e-11, "{control} {u} {h}: {closed} {coarse}");
            }
        }
    }

    /// A wide change of the time constant joins both, and activations outside [0, 1] return.
    #[test]
    fn muscles_with_a_smooth_change_reach_the_control() {
        let activation = Activation::Muscle { rise: 0.01, fall: 0.04, width: 0.2 };
        for u in [-0.3, 0.0, 0.5, 1.4] {
            assert!((activation.after(2.0, 0.7, u) - 0.7).abs() < 1e-12);
        }
        assert_eq!(activation.rate(0.5, 0.5), 0.0);
    }
}
