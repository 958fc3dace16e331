//! Position control of the joints of many simulations, evaluated in each step.

use robot_dynamics_core::Model;
use robot_dynamics_number::InvalidInput;
use robot_dynamics_simulation::simulator::Simulation;

use crate::tables::check_table;

/// Proportional-derivative control of joints in each simulation of a batch.
///
/// Each step begins with τ = stiffness (target − q) − damping v, cut off at ±limit. This is added to the
/// torques that are set. The gains are initially 0, so the control has no effect.
///
/// New targets act after a delay of whole steps; until then the targets before them act. A delay that is
/// longer than the time between two calls of [`set_targets`](Self::set_targets) is shortened to that time.
#[derive(Clone, Debug)]
pub struct PositionControl {
    /// The index in q of each degree of freedom; `None` if its joint has several.
    coordinates: Vec<Option<usize>>,
    /// Rows of one number for each degree of freedom.
    stiffness: Vec<f64>,
    damping: Vec<f64>,
    limits: Vec<f64>,
    targets: Vec<f64>,
    earlier: Vec<f64>,
    /// The delay of each simulation, and the number of steps until its targets act.
    delays: Vec<usize>,
    waiting: Vec<usize>,
}

impl PositionControl {
    pub(super) fn new(model: &Model, count: usize) -> Self {
        let nv = model.nv();
        let mut coordinates = vec![None; nv];
        for joint in model.joints().iter().filter(|joint| (joint.nq, joint.nv) == (1, 1)) {
            coordinates[joint.v_index] = Some(joint.q_index);
        }
        let zeros = vec![0.0; count * nv];
        Self {
            coordinates,
            stiffness: zeros.clone(),
            damping: zeros.clone(),
            limits: vec![f64::INFINITY; count * nv],
            targets: zeros.clone(),
            earlier: zeros,
            delays: vec![0; count],
            waiting: vec![0; count],
        }
    }

    /// Sets the gains and the largest torques of all simulations \[count\]\[nv\].
    ///
    /// # Errors
    /// [`InvalidInput`] if a number is negative or NaN, if a gain is infinite, or if a joint with several
    /// degrees of freedom has a stiffness.
    ///
    /// # Panics
    /// Panics if a table does not have one row for each simulation.
    #[track_caller]
    pub fn set_gains(
        &mut self,
        stiffness: &[f64],
        damping: &[f64],
        limits: &[f64],
    ) -> Result<(), InvalidInput> {
        let (count, nv) = (self.delays.len(), self.coordinates.len());
        let tables = [("a stiffness", stiffness), ("a damping", damping), ("a limit of torque", limits)];
        for (name, table) in tables {
            check_table(name, table.len(), count, nv);
            let is_limit = core::ptr::eq(table, limits);
            if let Some(wrong) = table.iter().find(|x| !(**x >= 0.0 && (is_limit || x.is_finite()))) {
                return Err(InvalidInput::out_of_range(name, *wrong, "", "finite and not negative"));
            }
        }
        for row in stiffness.chunks_exact(nv.max(1)) {
            for (dof, (stiffness, coordinate)) in row.iter().zip(&self.coordinates).enumerate() {
                if *stiffness != 0.0 && coordinate.is_none() {
                    let quantity = format!("the stiffness of degree of freedom {dof}");
                    return Err(InvalidInput::unmet(
                        quantity,
                        "it must be 0, because the joint has several degrees of freedom",
                    ));
                }
            }
        }
        self.stiffness.copy_from_slice(stiffness);
        self.damping.copy_from_slice(damping);
        self.limits.copy_from_slice(limits);
        Ok(())
    }

    /// Sets the number of steps after which new targets act, for each simulation.
    ///
    /// # Panics
    /// Panics if there is not one number for each simulation.
    #[track_caller]
    pub fn set_delays(&mut self, delays: &[usize]) {
        check_table("delays", delays.len(), self.delays.len(), 1);
        self.delays.copy_from_slice(delays);
    }

    /// The targets \[count\]\[nv\] \[rad or m\].
    pub fn targets(&self) -> &[f64] {
        &self.targets
    }

    /// Sets the targets \[count\]\[nv\] \[rad or m\]; those of degrees of freedom without stiffness have no
    /// effect.
    ///
    /// # Panics
    /// Panics if the table does not have one row for each simulation.
    #[track_caller]
    pub fn set_targets(&mut self, targets: &[f64]) {
        check_table("targets", targets.len(), self.delays.len(), self.coordinates.len());
        core::mem::swap(&mut self.targets, &mut self.earlier);
        self.targets.copy_from_slice(targets);
        self.waiting.copy_from_slice(&self.delays);
    }

    /// Makes the configuration q of a simulation its target, without delay.
    pub(super) fn hold(&mut self, number: usize, q: &[f64]) {
        let nv = self.coordinates.len();
        for (dof, coordinate) in self.coordinates.iter().enumerate() {
            let target = coordinate.map_or(0.0, |index| q[index]);
            (self.targets[number * nv + dof], self.earlier[number * nv + dof]) = (target, target);
        }
        self.waiting[number] = 0;
    }

    /// Counts the steps that a simulation has taken.
    pub(super) fn count_steps(&mut self, number: usize, steps: usize) {
        self.waiting[number] = self.waiting[number].saturating_sub(steps);
    }

    /// Adds the torques of a simulation's next step to `torques`. `done` is the number of steps since the
    /// last call of [`count_steps`](Self::count_steps).
    pub(super) fn add_torques(
        &self,
        number: usize,
        done: usize,
        simulation: &Simulation,
        torques: &mut [f64],
    ) {
        let (q, v, nv) = (simulation.q(), simulation.v(), self.coordinates.len());
        let targets = if done < self.waiting[number] { &self.earlier } else { &self.targets };
        for (dof, torque) in torques.iter_mut().enumerate() {
            let k = number * nv + dof;
            let error = self.coordinates[dof].map_or(0.0, |index| targets[k] - q[index]);
            let own = self.stiffness[k] * error - self.damping[k] * v[dof];
            *torque += own.clamp(-self.limits[k], self.limits[k]);
        }
    }
}
