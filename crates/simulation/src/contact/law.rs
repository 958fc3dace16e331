//! The violation of the laws of contact by impulses and velocities.

/// The violation of each of the three laws of a contact, as speeds \[m/s\]: 0 if the law holds.
///
/// The normal is n, the tangential directions are t, the impulse is p, and c is the velocity. The approximate
/// speed per unit of impulse, w, only converts an impulse to a speed:
///
/// | law | measure |
/// | --- | --- |
/// | Signorini: c_n ≥ 0, p_n ≥ 0, c_n p_n = 0 | \|min(c_n, w p_n)\| |
/// | Coulomb: \|p_t\| ≤ μ p_n | w max(0, \|p_t\| − μ p_n) |
/// | maximum dissipation: of all p_t in the disc the one that takes out most, −p_t·c_t | \|w p_t − Π(w p_t − c_t)\|, Π onto the disc of radius w μ p_n |
///
/// They are all zero exactly if the law of contact holds, with friction that sticks (c_t = 0) or slides (p_t
/// = −μ p_n c_t/|c_t|). **(Carpentier, Le Lidec & Montaut 2024, natural maps of their conditions)**
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactViolation {
    /// The violation of Signorini's law \[m/s\].
    pub signorini: f64,
    /// The violation of Coulomb's law \[m/s\].
    pub coulomb: f64,
    /// The violation of maximum dissipation \[m/s\].
    pub dissipation: f64,
}

impl ContactViolation {
    /// The violation of one contact with the coefficient of friction μ. Its velocity is c = (c_n, c_t)
    /// \[m/s\], its impulse p \[N·s\] of the same length, and its mobility w \[1/kg\]. Without friction there
    /// is only c_n.
    ///
    /// ```
    /// use robot_dynamics::contact::ContactViolation;
    /// // A body of 1 kg slides at 2 m/s with μ = 0.5, its ground gives 1 N·s: 0.5 N·s against the motion.
    /// let right = ContactViolation::of(0.5, 1.0, &[0.0, 2.0, 0.0], &[1.0, -0.5, 0.0]);
    /// assert_eq!(right.worst(), 0.0);
    /// // The cone's own law: it would rise with μ times its speed.
    /// assert_eq!(ContactViolation::of(0.5, 1.0, &[1.0, 2.0, 0.0], &[1.0, -0.5, 0.0]).signorini, 1.0);
    /// // Friction across the motion instead of against it.
    /// assert!(ContactViolation::of(0.5, 1.0, &[0.0, 2.0, 0.0], &[1.0, 0.0, 0.5]).dissipation > 0.4);
    /// ```
    ///
    /// # Panics
    /// If c and p differ in length, or are empty.
    #[track_caller]
    pub fn of(friction: f64, mobility: f64, velocity: &[f64], impulse: &[f64]) -> Self {
        assert_eq!(velocity.len(), impulse.len(), "a contact has as many velocities as impulses");
        let radius = (mobility * friction * impulse[0]).max(0.0);
        let (mut size, mut target_size) = (0.0, 0.0);
        for (c, p) in velocity.iter().zip(impulse).skip(1) {
            size += (mobility * p).powi(2);
            target_size += (mobility * p - c).powi(2);
        }
        let (size, target_size): (f64, f64) = (size.sqrt(), target_size.sqrt());
        let shrink = if target_size > radius { radius / target_size } else { 1.0 };
        let off = velocity.iter().zip(impulse).skip(1).map(|(c, p)| {
            let own = mobility * p;
            (own - shrink * (own - c)).powi(2)
        });
        Self {
            signorini: velocity[0].min(mobility * impulse[0]).abs(),
            coulomb: (size - radius).max(0.0),
            dissipation: off.sum::<f64>().sqrt(),
        }
    }

    /// The largest of the three \[m/s\].
    ///
    /// ```
    /// assert_eq!(robot_dynamics::contact::ContactViolation::of(0.0, 1.0, &[-0.25], &[1.0]).worst(), 0.25); // it goes on into the ground
    /// ```
    pub fn worst(&self) -> f64 {
        self.signorini.max(self.coulomb).max(self.dissipation)
    }

    /// The larger violation of each law.
    ///
    /// ```
    /// use robot_dynamics::contact::ContactViolation;
    /// let [into, out] = [-0.25, 0.5].map(|c| ContactViolation::of(0.0, 1.0, &[c], &[1.0]));
    /// assert_eq!(into.max(&out).signorini, 0.5);
    /// ```
    pub fn max(&self, other: &Self) -> Self {
        Self {
            signorini: self.signorini.max(other.signorini),
            coulomb: self.coulomb.max(other.coulomb),
            dissipation: self.dissipation.max(other.dissipation),
        }
    }
}

/// The accuracy of a run's own solutions by the rigid law of contact.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactLaws {
    /// The largest violation of each law, among problems with a solution of Coulomb's law.
    pub violation: ContactViolation,
    /// The number of contact problems solved; a step with an impact has up to 16.
    pub solved: usize,
    /// The number of problems without a solution of Coulomb's law. They satisfy the cone's law instead, by
    /// which sliding contacts separate.
    pub without_solution: usize,
    /// The largest violation among these.
    pub violation_without_solution: ContactViolation,
    /// The deepest penetration at the end of a step \[m\].
    pub deepest: f64,
    /// The number of steps that were divided until their budget of parts was spent, because their energy
    /// balance did not close. The rest of each was accepted as computed.
    pub unsettled: usize,
    /// The largest energy imbalance of such a rest \[J\].
    pub imbalance: f64,
}

impl ContactLaws {
    /// Adds one problem.
    pub(crate) fn enter(&mut self, violation: &ContactViolation, is_coulomb: bool) {
        self.solved += 1;
        let worst = if is_coulomb {
            &mut self.violation
        } else {
            self.without_solution += 1;
            &mut self.violation_without_solution
        };
        *worst = worst.max(violation);
    }
}
