//! Where the energy went.

/// Energy taken out of a motion, by cause \[J\]; none but `corrections` ever decreases.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Losses {
    /// By the joints' viscous damping: the impulse D∫v dt times the mean of the velocities at the step's ends.
    pub damping: f64,
    /// By the joints' dry friction: −λ times that mean.
    pub friction: f64,
    /// By stops, the same.
    pub stops: f64,
    /// By moving back what began a step more than 0.1 mm beyond a stop or within what it touches; negative where that put energy in.
    pub corrections: f64,
    /// By the friction of contacts, the same.
    pub sliding: f64,
    /// By impacts on the ground: the normal impulse times the mean of the normal velocities before and after.
    pub impacts: f64,
}

impl Losses {
    /// Their sum.
    ///
    /// ```
    /// assert_eq!(multibody::Losses::default().total(), 0.0);
    /// ```
    pub fn total(&self) -> f64 {
        self.damping + self.friction + self.stops + self.corrections + self.sliding + self.impacts
    }

    pub(crate) fn add(&mut self, other: &Self) {
        self.damping += other.damping;
        self.friction += other.friction;
        self.stops += other.stops;
        self.corrections += other.corrections;
        self.sliding += other.sliding;
        self.impacts += other.impacts;
    }
}
