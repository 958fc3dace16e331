//! The softness and reference acceleration of a constraint.
//!
//! At a violation r = distance − margin with rate ṙ, the reference acceleration is −B ṙ − K d r. With solref
//! = (t, ζ), K = 1/(d_w t ζ)² and B = 2/(d_w t). With solref = (−k, −b), K = k/d_w² and B = b/d_w. d_w is the
//! impedance at the width. The constraint yields by R = w (1 − d)/d for each unit of force, where w is its
//! inverse inertia. **(MuJoCo, "Computation", Constraint model)**

use robot_dynamics_description::SolverImpedance;

/// Bounds of impedances, and what counts as zero.
const LEAST: f64 = 1e-4;
const MOST: f64 = 0.9999;
const TINY: f64 = 1e-15;

/// The parameters of one constraint.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// d.
    impedance: f64,
    /// K d r \[m/s² or rad/s²\].
    pub(super) spring: f64,
    /// B \[1/s\].
    pub(super) damping: f64,
}

impl Response {
    /// The parameters at the violation r, for steps of h: a time constant below 2h counts as 2h.
    pub(super) fn new(softness: &SolverImpedance, h: f64, violation: f64) -> Self {
        let SolverImpedance { solref, solimp } = *softness;
        // The two forms do not mix.
        let [time, ratio] =
            if (solref[0] > 0.0) == (solref[1] > 0.0) { solref } else { SolverImpedance::default().solref };
        let widest = solimp[1].clamp(LEAST, MOST);
        let impedance = impedance(&solimp, violation);
        let (stiffness, damping) = if time > 0.0 {
            let time = time.max(2.0 * h);
            ((widest * time * ratio).powi(2).max(TINY).recip(), 2.0 / (widest * time).max(TINY))
        } else {
            (-time / (widest * widest).max(TINY), -ratio / widest)
        };
        Self { impedance, spring: stiffness * impedance * violation, damping }
    }

    /// R, for the inverse inertia w.
    pub(super) fn softness(&self, weight: f64) -> f64 {
        ((1.0 - self.impedance) / self.impedance * weight).max(TINY)
    }
}

/// d at the violation r: it rises from d₀ to d_w along two powers that meet at the midpoint.
fn impedance(solimp: &[f64; 5], violation: f64) -> f64 {
    let [at_none, at_width, width, midpoint, power] = *solimp;
    let (at_none, at_width) = (at_none.clamp(LEAST, MOST), at_width.clamp(LEAST, MOST));
    let (midpoint, power) = (midpoint.clamp(LEAST, MOST), power.max(1.0));
    if at_none == at_width || width <= TINY {
        return 0.5 * (at_none + at_width);
    }
    let x = (violation / width).abs();
    let share = if x >= 1.0 {
        1.0
    } else if power == 1.0 {
        x
    } else if x <= midpoint {
        x.powf(power) / midpoint.powf(power - 1.0)
    } else {
        1.0 - (1.0 - x).powf(power) / (1.0 - midpoint).powf(power - 1.0)
    };
    at_none + share * (at_width - at_none)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// d rises continuously from its first value to its second, and stays.
    #[test]
    fn impedance_grows_with_the_violation() {
        let solimp = [0.8, 0.95, 0.01, 0.4, 3.0];
        assert_eq!((impedance(&solimp, 0.0), impedance(&solimp, -0.02)), (0.8, 0.95));
        let mut before = 0.8;
        for k in 0..=1000 {
            let now = impedance(&solimp, f64::from(k) * 1e-5);
            assert!(now >= before && now - before < 1e-3, "{k}: {before} {now}");
            before = now;
        }
        assert_eq!(before, 0.95);
    }

    /// A constraint with solref (t, ζ) at its full width: r̈ = −2/t ṙ − r/(tζ)² once d_w is included, so K d
    /// r with d = d_w.
    #[test]
    fn the_reference_is_a_damped_spring() {
        let softness = SolverImpedance { solref: [0.05, 0.7], solimp: [0.5, 0.9, 1e-3, 0.5, 2.0] };
        let response = Response::new(&softness, 1e-3, -0.2);
        let (time, ratio, widest) = (0.05, 0.7, 0.9);
        let expected = -0.2 / (widest * (time * ratio) * (time * ratio));
        assert!((response.spring - expected).abs() < 1e-9 * expected.abs());
        assert!((response.damping - 2.0 / (widest * time)).abs() < 1e-12);
        // Direct: −(k, b).
        let direct = SolverImpedance { solref: [-100.0, -3.0], ..softness };
        let response = Response::new(&direct, 1e-3, -0.2);
        assert!((response.spring - 100.0 / 0.81 * 0.9 * -0.2).abs() < 1e-9);
        assert!((response.damping - 3.0 / 0.9).abs() < 1e-12);
        assert!((response.softness(2.0) - 2.0 * 0.1 / 0.9).abs() < 1e-12);
    }
}
