//! The opening: a planar arm of three links that the user drags and throws.

use dynamics::{
    Dynamics, EnergyAccount, Integrator, Link, PlanarArm, PlanarKinematics, SystemEnergy, SystemStep,
    solve_mass,
};
use nalgebra::{SMatrix, Vector2, Vector3, vector};
use wasm_bindgen::prelude::wasm_bindgen;

use super::arm_drawing::{link_ends, mobility, tip_mobility, weights};
use crate::LabError;
use crate::input::{finite, number, positive};
use crate::samples::Samples;

/// The step \[s\].
const STEP: f64 = 1e-3;

/// Sampling period of the tip's path \[s\] and the number of samples kept: 2 s.
const INTERVAL: f64 = 0.01;
const KEPT: usize = 200;

/// Natural frequency \[rad/s\] of the hand's spring in the direction of the smallest effective mass at the
/// held point.
const FREQUENCY: f64 = 40.0;

/// The largest force of the hand, as a multiple of the arm's weight on Earth.
const MOST: f64 = 5.0;

/// The energy of a thrown arm \[J\]; V is zero where the stretched arm hangs.
#[wasm_bindgen]
#[derive(Clone, Copy, Debug)]
pub struct ThrownArmEnergyAccount {
    /// K.
    #[wasm_bindgen(readonly)]
    pub kinetic: f64,
    /// V above the lowest pose.
    #[wasm_bindgen(readonly)]
    pub potential: f64,
    /// E at the start.
    #[wasm_bindgen(readonly)]
    pub start: f64,
    /// Work of the hand since the start.
    #[wasm_bindgen(readonly)]
    pub work: f64,
    /// E − E₀ − work, the integrator's error.
    #[wasm_bindgen(readonly)]
    pub unaccounted: f64,
}

/// A planar arm of three uniform rods without friction, thrown by hand.
///
/// A spring and a damper f = k (p\* − p) − d ṗ connect the hand with a point p of a link. They act on the
/// joints as u = Jᵀf, constant over each step, so that the work u·Δq is exact. Steps are Runge–Kutta 4 of 1
/// ms.
#[wasm_bindgen]
#[derive(Clone, Debug)]
pub struct ThrownArm {
    arm: PlanarArm<3>,
    q: Vector3<f64>,
    qd: Vector3<f64>,
    hand: Option<Hand>,
    steps: u64,
    /// The energy of strikes, in addition to the hand's work in the account.
    struck: f64,
    energy_account: EnergyAccount,
    samples: Samples<3>,
}

/// The grip of the hand on a point of a link.
#[derive(Clone, Copy, Debug)]
struct Hand {
    link: usize,
    along: f64,
    target: Vector2<f64>,
    stiffness: f64,
    damping: f64,
    most: f64,
}

state_getters! {
    ThrownArm:
    /// q \[rad\].
    q,
    /// q̇ \[rad/s\].
    qd
}

#[wasm_bindgen]
impl ThrownArm {
    /// Three uniform rods at rest along the x axis: lengths \[m\], masses \[kg\], gravity \[m/s²\].
    ///
    /// # Errors
    /// Fails if there are not three of each, or a length or a mass is not positive.
    #[wasm_bindgen(constructor)]
    pub fn new(lengths: &[f64], masses: &[f64], a_g: f64) -> Result<Self, LabError> {
        finite("lengths", lengths, 3)?;
        finite("masses", masses, 3)?;
        let mut arm = PlanarArm { links: [Link::rod(1.0, 1.0); 3], a_g: number("gravity", a_g)? };
        for (k, link) in arm.links.iter_mut().enumerate() {
            *link = Link::rod(positive("a length", lengths[k])?, positive("a mass", masses[k])?);
        }
        let (q, qd) = (Vector3::zeros(), Vector3::zeros());
        Ok(Self {
            arm,
            q,
            qd,
            hand: None,
            steps: 0,
            struck: 0.0,
            energy_account: EnergyAccount::open(&arm as &dyn Dynamics<3>, &q, &qd),
            samples: Samples::new(INTERVAL, STEP, KEPT),
        })
    }

    /// Puts the arm at (q, q̇), releases it, and resets the energy account.
    ///
    /// # Errors
    /// Fails if a list has the wrong length or a number is not finite.
    pub fn place(&mut self, q: &[f64], qd: &[f64]) -> Result<(), LabError> {
        (self.q, self.qd) = (crate::input::vector("q", q)?, crate::input::vector("qd", qd)?);
        (self.hand, self.steps, self.struck) = (None, 0, 0.0);
        self.energy_account = EnergyAccount::open(&self.arm as &dyn Dynamics<3>, &self.q, &self.qd);
        self.samples.clear();
        self.sample();
        Ok(())
    }

    /// Grips a link at this distance \[m\] from its joint; the hand starts at that point.
    ///
    /// # Errors
    /// Fails if the link does not exist or the distance is not finite.
    pub fn grab(&mut self, link: usize, along: f64) -> Result<(), LabError> {
        if link >= 3 {
            return Err(LabError::new(format!("no link {link} among three")));
        }
        let along = number("the distance", along)?
            .clamp(0.05 * self.arm.links[link].length, self.arm.links[link].length);
        let (target, jacobian) = self.point(link, along);
        let mobility = mobility(&self.arm.mass(&self.q), &jacobian)?;
        // In the direction of the smallest effective mass the spring is as stiff as the step allows.
        let lightest = dynamics::symmetric_eigen(&mobility).0.max();
        let masses: f64 = self.arm.links.iter().map(|link| link.mass).sum();
        self.hand = Some(Hand {
            link,
            along,
            target,
            stiffness: FREQUENCY * FREQUENCY / lightest,
            damping: FREQUENCY / lightest,
            most: MOST * masses * 9.81,
        });
        Ok(())
    }

    /// Moves the hand to this point \[m\].
    ///
    /// # Errors
    /// Fails if a number is not finite.
    #[wasm_bindgen(js_name = pullTo)]
    pub fn pull_to(&mut self, x: f64, y: f64) -> Result<(), LabError> {
        let target = vector![number("x", x)?, number("y", y)?];
        if let Some(hand) = &mut self.hand {
            hand.target = target;
        }
        Ok(())
    }

    /// Releases the arm, which keeps its velocity.
    #[wasm_bindgen(js_name = letGo)]
    pub fn let_go(&mut self) {
        self.hand = None;
    }

    /// Applies an impulse p \[N·s\] to the tip: q̇ increases by M⁻¹Jᵀp. Its work is the change of energy.
    ///
    /// # Errors
    /// Fails if a number is not finite.
    pub fn strike(&mut self, px: f64, py: f64) -> Result<(), LabError> {
        let impulse = vector![number("px", px)?, number("py", py)?];
        let (_, jacobian) = self.point(2, self.arm.links[2].length);
        let before = self.arm.kinetic_energy(&self.q, &self.qd);
        self.qd += solve_mass(&self.arm.mass(&self.q), &jacobian.tr_mul(&impulse))?;
        self.struck += self.arm.kinetic_energy(&self.q, &self.qd) - before;
        Ok(())
    }

    /// Advances by whole steps of a millisecond.
    ///
    /// # Errors
    /// Fails if a step fails or the energy is not finite; the state before that step is kept.
    pub fn advance(&mut self, steps: u32) -> Result<(), LabError> {
        // With `dyn` the page downloads the integrators once.
        let arm = self.arm;
        let arm: &dyn Dynamics<3> = &arm;
        for _ in 0..steps {
            let u = self.torque();
            let next = Integrator::RungeKutta4.step(arm, &self.q, &self.qd, &u, STEP)?;
            let mut energy_account = self.energy_account;
            energy_account.record(arm, (&self.q, &self.qd), (&next.0, &next.1), &u, STEP);
            if !energy_account.now().is_finite() {
                return Err(LabError::new("the energy is not finite; start again"));
            }
            ((self.q, self.qd), self.energy_account) = (next, energy_account);
            self.steps += 1;
            if self.samples.due(self.steps) {
                self.sample();
            }
        }
        Ok(())
    }

    /// The end of every link: x, y, x, y, … \[m\].
    #[wasm_bindgen(getter)]
    pub fn points(&self) -> Vec<f64> {
        link_ends(&self.arm, &self.q)
    }

    /// Every link's centre of mass and weight: x, y \[m\], m a_g \[N\], …
    #[wasm_bindgen(getter)]
    pub fn weights(&self) -> Vec<f64> {
        weights(&self.arm, &self.q)
    }

    /// M q̈, C q̇, g and u of every joint, one joint after another \[N·m\]; the first three add up to the
    /// fourth.
    ///
    /// # Errors
    /// Fails if the acceleration is undefined.
    #[wasm_bindgen(js_name = torqueStack)]
    pub fn torque_stack(&self) -> Result<Vec<f64>, LabError> {
        let u = self.torque();
        let qdd = self.arm.try_forward(&self.q, &self.qd, &u)?;
        let terms = [
            self.arm.mass(&self.q) * qdd,
            self.arm.velocity_product(&self.q, &self.qd),
            self.arm.gravity(&self.q),
            u,
        ];
        Ok(terms.iter().flat_map(|term| term.iter().copied()).collect())
    }

    /// J M⁻¹ Jᵀ of the tip: the greater eigenvalue, the smaller \[1/kg\], the direction of the greater, x and
    /// y.
    ///
    /// # Errors
    /// Fails if M is singular.
    #[wasm_bindgen(js_name = tipMobility)]
    pub fn tip_mobility(&self) -> Result<Vec<f64>, LabError> {
        Ok(tip_mobility(&self.arm, &self.q)?)
    }

    /// The held point, the hand \[m\] and its force \[N\]: six numbers, or none without a grip.
    #[wasm_bindgen(getter)]
    pub fn hand(&self) -> Vec<f64> {
        let (Some((place, _, force)), Some(hand)) = (self.pull(), self.hand) else { return Vec::new() };
        [place, hand.target, force].iter().flat_map(|point| [point[0], point[1]]).collect()
    }

    /// K, V and the work of the hand \[J\].
    #[wasm_bindgen(getter, js_name = energyAccount)]
    pub fn energy_account(&self) -> ThrownArmEnergyAccount {
        let mut hanging = Vector3::zeros();
        hanging[0] = -core::f64::consts::FRAC_PI_2;
        let least = self.arm.potential_energy(&hanging);
        ThrownArmEnergyAccount {
            kinetic: self.arm.kinetic_energy(&self.q, &self.qd),
            potential: self.arm.potential_energy(&self.q) - least,
            start: self.energy_account.start() - least,
            work: self.energy_account.work() + self.struck,
            unaccounted: self.arm.energy(&self.q, &self.qd)
                - self.energy_account.start()
                - self.energy_account.work()
                - self.struck,
        }
    }

    /// The tip's last two seconds: rows of t \[s\], x and y \[m\].
    pub fn samples(&self) -> Vec<f64> {
        self.samples.flat()
    }
}

impl ThrownArm {
    /// The position of a point of a link, and its Jacobian.
    fn point(&self, link: usize, along: f64) -> (Vector2<f64>, SMatrix<f64, 2, 3>) {
        let point = [along, 0.0];
        (
            self.arm.point_over(&self.q.data.0[0], link, point).into(),
            self.arm.point_jacobian(&self.q, link, point),
        )
    }

    /// The held point, its Jacobian and the force on it.
    fn pull(&self) -> Option<(Vector2<f64>, SMatrix<f64, 2, 3>, Vector2<f64>)> {
        let Hand { link, along, target, stiffness, damping, most } = self.hand?;
        let (place, jacobian) = self.point(link, along);
        let force = (target - place) * stiffness - jacobian * self.qd * damping;
        let size = force.norm();
        Some((place, jacobian, if size > most { force * (most / size) } else { force }))
    }

    fn torque(&self) -> Vector3<f64> {
        self.pull().map_or_else(Vector3::zeros, |(_, jacobian, force)| jacobian.tr_mul(&force))
    }

    fn sample(&mut self) {
        let [.., x, y] = link_ends(&self.arm, &self.q)[..] else { return };
        self.samples.push([self.steps as f64 * STEP, x, y]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A hand drags the arm for a second and throws it: the arm's energy is the work of the hand.
    #[test]
    fn what_the_hand_puts_in_is_what_the_arm_has() -> Result<(), LabError> {
        let mut arm = ThrownArm::new(&[0.6, 0.5, 0.4], &[1.2, 1.0, 0.8], 9.81)?;
        arm.place(&[-1.2, 0.4, 0.4], &[0.0; 3])?;
        arm.grab(2, 0.3)?;
        let [x, y, ..] = arm.hand()[..] else { panic!("it is held") };
        for k in 0..100 {
            let turn = f64::from(k) * 0.06;
            arm.pull_to(x - 0.5 * turn.sin(), y + 0.5 - 0.5 * turn.cos())?;
            arm.advance(10)?;
        }
        let [px, py, hx, hy, ..] = arm.hand()[..] else { panic!("it is held still") };
        assert!((px - hx).hypot(py - hy) < 0.3, "the point follows the hand");
        arm.let_go();
        assert!(arm.hand().is_empty());
        arm.strike(0.5, 1.0)?;
        arm.advance(1000)?;
        let ThrownArmEnergyAccount { kinetic, potential, start, work, unaccounted } = arm.energy_account();
        assert!(work.abs() > 1.0, "the hand did work: {work} J");
        assert!((kinetic + potential - start - work - unaccounted).abs() < 1e-9);
        assert!(unaccounted.abs() < 1e-5, "{unaccounted} J unaccounted for");
        let stack = arm.torque_stack()?;
        for joint in 0..3 {
            let sum = stack[joint] + stack[3 + joint] + stack[6 + joint] - stack[9 + joint];
            assert!(sum.abs() < 1e-9, "{stack:?}");
        }
        Ok(())
    }

    #[test]
    fn arms_of_other_counts_are_refused() {
        assert!(ThrownArm::new(&[1.0], &[1.0], 9.81).is_err());
        assert!(ThrownArm::new(&[1.0; 3], &[1.0, -1.0, 1.0], 9.81).is_err());
        let mut arm = ThrownArm::new(&[1.0; 3], &[1.0; 3], 9.81).unwrap();
        assert!(arm.grab(3, 0.1).is_err() && arm.pull_to(f64::NAN, 0.0).is_err());
    }
}
