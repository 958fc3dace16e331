//! The spring, damper and friction of a tendon, by its length and velocity.

use robot_dynamics_description::{
    PassiveForces, PolynomialStiffnessDamping, SpatialTendonDescription, TendonDescription,
};

/// The passive law of a tendon, and the bounds on the force of its actuators.
#[derive(Clone, Debug)]
pub(super) struct TendonLaw {
    pub(super) passive: PassiveForces,
    pub(super) higher_terms: PolynomialStiffnessDamping,
    dead_band: f64,
    /// The largest elastic stretch; 0 if the spring never yields.
    spring_yield: f64,
    /// Whether the lower end of the dead band stays when the spring is stretched too far.
    keeps_slack: bool,
    actuator_force_range: [f64; 2],
}

impl TendonLaw {
    pub(super) fn of_joints(tendon: &TendonDescription) -> Self {
        let TendonDescription { passive, higher_terms, dead_band, limits, spring_yield, .. } = tendon;
        Self {
            passive: *passive,
            higher_terms: *higher_terms,
            dead_band: *dead_band,
            spring_yield: *spring_yield,
            keeps_slack: keeps_slack(passive, *dead_band),
            actuator_force_range: [-limits.effort, limits.effort],
        }
    }

    pub(super) fn of_path(tendon: &SpatialTendonDescription) -> Self {
        let SpatialTendonDescription {
            passive,
            higher_terms,
            dead_band,
            spring_yield,
            actuator_force_range,
            ..
        } = tendon;
        Self {
            passive: *passive,
            higher_terms: *higher_terms,
            dead_band: *dead_band,
            spring_yield: *spring_yield,
            keeps_slack: keeps_slack(passive, *dead_band),
            actuator_force_range: *actuator_force_range,
        }
    }

    /// Removes dry friction, which is modelled elsewhere.
    pub(super) fn forget_friction(&mut self) {
        self.passive.friction = 0.0;
    }

    /// Removes damping and friction.
    pub(super) fn forget_dissipation(&mut self) {
        self.passive.friction = 0.0;
        self.passive.damping = 0.0;
        self.higher_terms.damping = [0.0; 2];
    }

    /// Removes the spring.
    pub(super) fn forget_spring(&mut self) {
        self.passive.stiffness = 0.0;
        self.higher_terms.stiffness = [0.0; 2];
    }

    /// Takes over the dead band of the same tendon.
    pub(super) fn copy_dead_band(&mut self, from: &Self) {
        (self.passive.rest, self.dead_band) = (from.passive.rest, from.dead_band);
    }

    /// Whether the spring yields.
    pub(super) fn yields(&self) -> bool {
        self.spring_yield > 0.0
    }

    /// Moves the dead band so that the stretch at this length is elastic. Returns the energy that is lost
    /// \[J\].
    pub(super) fn yield_at(&mut self, length: f64) -> f64 {
        if self.spring_yield <= 0.0 {
            return 0.0;
        }
        let (stored, stretch) = (self.energy(length), self.stretch(length));
        let beyond = stretch - stretch.clamp(-self.spring_yield, self.spring_yield);
        if beyond > 0.0 && self.keeps_slack {
            self.dead_band += beyond;
        } else {
            self.passive.rest += beyond;
        }
        stored - self.energy(length)
    }

    fn stretch(&self, length: f64) -> f64 {
        self.passive.stretch(length, self.dead_band)
    }

    /// −k·stretch and the nonlinear terms: the spring's force.
    pub(super) fn spring_force(&self, length: f64) -> f64 {
        let stretch = self.stretch(length);
        -self.passive.stiffness * stretch + self.higher_terms.spring_force(stretch)
    }

    /// −d ℓ̇ − f sign ℓ̇ and the nonlinear terms: the dissipative force.
    pub(super) fn dissipative_force(&self, rate: f64) -> f64 {
        let sign = if rate == 0.0 { 0.0 } else { rate.signum() };
        -self.passive.damping * rate - self.passive.friction * sign + self.higher_terms.damping_force(rate)
    }

    /// ½ k·stretch² and the energy of the nonlinear terms \[J\].
    pub(super) fn energy(&self, length: f64) -> f64 {
        let stretch = self.stretch(length);
        0.5 * self.passive.stiffness * stretch.powi(2) + self.higher_terms.energy(stretch)
    }

    /// k and d.
    pub(super) fn gains(&self) -> (f64, f64) {
        (self.passive.stiffness, self.passive.damping)
    }

    /// The factor that brings a total force of the tendon's actuators into its bounds.
    pub(super) fn scale_of(&self, sum: f64) -> f64 {
        let [lower, upper] = self.actuator_force_range;
        if sum < lower {
            lower / sum
        } else if sum > upper {
            upper / sum
        } else {
            1.0
        }
    }
}

/// Whether the spring of a tendon only pulls: the dead band begins at 0.
fn keeps_slack(passive: &PassiveForces, dead_band: f64) -> bool {
    passive.rest == 0.0 && dead_band > 0.0
}
