//! Dissipated energy by cause.

/// Dissipated energy by cause \[J\]; no entry except `corrections` ever decreases.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Losses {
    /// Viscous damping of joints: the impulse D∫v dt times the mean of the velocities at the step's ends.
    pub damping: f64,
    /// Dry friction of joints, −λ times the same mean velocity, and the energy that springs lose as they
    /// yield.
    pub friction: f64,
    /// Stops: the same expression with their impulses.
    pub stops: f64,
    /// Position corrections of states that begin a step more than 0.1 mm beyond a stop or inside a contact;
    /// negative if they added energy.
    pub corrections: f64,
    /// Sliding friction of contacts: the same expression with their impulses. The work of moving surfaces is
    /// a negative loss.
    pub sliding: f64,
    /// Impacts on the ground: the normal impulse times the mean of the normal velocities before and after.
    pub impacts: f64,
}

impl Losses {
    /// The sum of all entries.
    ///
    /// ```
    /// assert_eq!(robot_dynamics::simulation::Losses::default().total(), 0.0);
    /// ```
    pub fn total(&self) -> f64 {
        self.damping + self.friction + self.stops + self.corrections + self.sliding + self.impacts
    }

    pub fn add(&mut self, other: &Self) {
        self.damping += other.damping;
        self.friction += other.friction;
        self.stops += other.stops;
        self.corrections += other.corrections;
        self.sliding += other.sliding;
        self.impacts += other.impacts;
    }
}
