//! The energy account of a run: the work of the forces, the dissipation, and the error of the integrator.

/// The energy account of a run, with one entry per step: E = E₀ + (work of u) − (dissipation by b) + (error
/// of the integrator).
///
/// Energies are in J. For a run without u and b the imbalance is the energy drift.
///
/// ```
/// let mut account = robot_dynamics_integrators::EnergyAccount::new(1.0, 2.0);
/// account.enter(1.5, 2.5, 1.0, 0.0); // the motors' work is the gain
/// assert_eq!((account.now(), account.imbalance()), (4.0, 0.0));
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(alias = "EnergyLedger")]
pub struct EnergyAccount {
    start: f64,
    kinetic: f64,
    potential: f64,
    work: f64,
    dissipated: f64,
    max_change: f64,
    max_imbalance: f64,
    max_kinetic: f64,
    potentials: [f64; 2],
    max_through: f64,
}

impl EnergyAccount {
    /// Starts the account at K and V \[J\].
    pub fn new(kinetic: f64, potential: f64) -> Self {
        Self {
            start: kinetic + potential,
            kinetic,
            potential,
            work: 0.0,
            dissipated: 0.0,
            max_change: 0.0,
            max_imbalance: 0.0,
            max_kinetic: kinetic,
            potentials: [potential; 2],
            max_through: 0.0,
        }
    }

    /// Adds an entry: the current K and V, and all work and dissipation since the start \[J\].
    pub fn enter(&mut self, kinetic: f64, potential: f64, work: f64, dissipated: f64) {
        (self.kinetic, self.potential, self.work, self.dissipated) = (kinetic, potential, work, dissipated);
        self.max_kinetic = self.max_kinetic.max(kinetic);
        let [least, most] = self.potentials;
        self.potentials = [least.min(potential), most.max(potential)];
        self.max_through = self.max_through.max(work.abs()).max(dissipated.abs());
        self.max_change = self.max_change.max((self.now() - self.start).abs());
        self.max_imbalance = self.max_imbalance.max(self.imbalance().abs());
    }

    /// E₀ \[J\].
    pub fn start(&self) -> f64 {
        self.start
    }

    /// E after the last step \[J\].
    pub fn now(&self) -> f64 {
        self.kinetic + self.potential
    }

    /// K after the last step \[J\].
    pub fn kinetic(&self) -> f64 {
        self.kinetic
    }

    /// V after the last step \[J\].
    pub fn potential(&self) -> f64 {
        self.potential
    }

    /// ∫ u·q̇ dt so far \[J\].
    pub fn work(&self) -> f64 {
        self.work
    }

    /// ∫ b·q̇ dt so far \[J\]: positive if b removes energy.
    pub fn dissipated(&self) -> f64 {
        self.dissipated
    }

    /// E − E₀ − work + dissipated \[J\]: zero for the exact motion.
    pub fn imbalance(&self) -> f64 {
        self.now() - self.start - self.work + self.dissipated
    }

    /// The largest |imbalance| so far \[J\].
    pub fn max_imbalance(&self) -> f64 {
        self.max_imbalance
    }

    /// Whether work and dissipation are zero so far, so that E should equal E₀.
    pub fn is_conservative(&self) -> bool {
        self.max_through == 0.0
    }

    /// The energy converted in the run \[J\]: max K + max V − min V, or the largest |work| or |dissipated| if
    /// that is more. Unlike |E₀| it does not depend on the zero of V.
    pub fn energy_moved(&self) -> f64 {
        let [least, most] = self.potentials;
        (self.max_kinetic + most - least).max(self.max_through)
    }

    /// max |imbalance| / [`energy_moved`](Self::energy_moved): the relative error of any run, including
    /// driven and damped ones.
    ///
    /// ```
    /// let mut energy_account = robot_dynamics_integrators::EnergyAccount::new(0.0, -1000.0);
    /// energy_account.enter(3.0, -999.0, 4.5, 0.48); // motors add 4.5 J, dampers remove 0.48 J
    /// assert!((energy_account.energy_moved() - 4.5).abs() < 1e-12);
    /// assert!((energy_account.relative_imbalance() - 0.02 / 4.5).abs() < 1e-12);
    /// assert!(!energy_account.is_conservative());
    /// ```
    pub fn relative_imbalance(&self) -> f64 {
        if self.max_imbalance == 0.0 { 0.0 } else { self.max_imbalance / self.energy_moved() }
    }

    /// max |E − E₀| / [`scale`](Self::scale): the relative error of a conservative run. For other runs it
    /// includes the work of motors and dampers; use [`relative_imbalance`](Self::relative_imbalance) instead.
    pub fn drift(&self) -> f64 {
        if self.max_change == 0.0 { 0.0 } else { self.max_change / self.scale() }
    }

    /// The reference energy, [`energy_scale`] of the run so far \[J\].
    pub fn scale(&self) -> f64 {
        energy_scale(self.start, self.max_kinetic)
    }
}

/// The reference energy for energy errors \[J\]: |E₀|, or the largest kinetic energy of the run if |E₀| is
/// below 1e-9 of it. The zero of V is a convention, so E₀ may be zero.
///
/// ```
/// assert_eq!(robot_dynamics_integrators::energy_scale(-85.4, 70.0), 85.4);
/// assert_eq!(robot_dynamics_integrators::energy_scale(1e-12, 70.0), 70.0);
/// ```
pub fn energy_scale(start: f64, largest_kinetic: f64) -> f64 {
    if start.abs() > 1e-9 * largest_kinetic { start.abs() } else { largest_kinetic }
}
