//! Implicit damping, forces on links, and dissipated power of the constraints, for a stepper.

use robot_dynamics_core::FrameId;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_integrators::IntegratorError;

use super::SoftConstraints;
use super::reference::RowOrigin;
use crate::ContactPoint;

impl SoftConstraints {
    /// The links that can touch a ground.
    pub(crate) fn ground_links(&self) -> &[String] {
        self.ground.as_ref().map_or(&[], |set| set.links())
    }

    pub fn dissipates(&mut self, dissipates: bool) {
        self.dissipates = dissipates;
    }

    /// Lets Newton's method start from the last state's acceleration.
    pub(crate) fn warm(&mut self) {
        self.is_warm = true;
    }

    /// Lets the next solution start without forces.
    pub(crate) fn cool(&mut self) {
        self.is_warm = false;
    }

    /// Changes v̇ of the last state to (M + hD)⁻¹M v̇, both with the free bodies' transport ω × u; D is
    /// diagonal.
    ///
    /// # Errors
    /// [`IntegratorError::SingularMass`]: M + hD is singular.
    pub(crate) fn damp(
        &mut self,
        (h, damping): (f64, &[f64]),
        acceleration: &mut [f64],
    ) -> Result<(), IntegratorError> {
        let Self { mass, dof_parents: [dof_parent, _], transport, speeds: momentum, .. } = self;
        let n = damping.len();
        acceleration.iter_mut().zip(&*transport).for_each(|(a, transport)| *a += transport);
        momentum.clear();
        let product = |row: &[f64]| row.iter().zip(&*acceleration).map(|(m, a)| m * a).sum::<f64>();
        momentum.extend(mass.chunks_exact(n).map(product));
        for k in 0..n {
            mass[k * n + k] += h * damping[k];
        }
        sparse::factor_watched(dof_parent, mass, |_| f64::MIN_POSITIVE)?;
        sparse::solve(dof_parent, mass, momentum);
        for k in 0..n {
            acceleration[k] = momentum[k] - transport[k];
        }
        Ok(())
    }

    /// Sets the links whose contacts are pulled together at the next states, each with the force that they
    /// share \[N\].
    pub(crate) fn set_adhesion(&mut self, links: impl Iterator<Item = (FrameId, f64)>) {
        self.adhesion.set(links);
    }

    /// The generalized forces of adhesion at the last state, nv entries \[N·m or N\].
    pub(crate) fn adhesion_forces(&self) -> &[f64] {
        self.adhesion.forces()
    }

    /// The number of links that can touch the ground.
    pub(crate) fn link_count(&self) -> usize {
        self.links.len()
    }

    /// Adds the ground's force on each of these links in the last state.
    pub(crate) fn add_link_forces(&self, forces: &mut [[f64; 3]]) {
        forces.fill([0.0; 3]);
        for (contact, force) in self.contacts().filter(|(contact, _)| contact.other.is_none()) {
            if let Some(link) = self.links.iter().position(|link| *link == contact.link) {
                (0..3).for_each(|k| forces[link][k] += force[k]);
            }
        }
    }

    /// The power that joint friction, limits and equalities, tangential contact forces, and normal contact
    /// forces take at the velocity v \[W\].
    pub(crate) fn losses(&mut self, v: &[f64]) -> [f64; 4] {
        let Self { problem, speeds, asked, .. } = self;
        problem.find_products(v, speeds);
        let mut losses = [0.0; 4];
        for asked in asked {
            for row in asked.row..asked.row + asked.rows {
                let kind = match asked.of {
                    RowOrigin::Friction => 0,
                    RowOrigin::Stop | RowOrigin::Limit(..) | RowOrigin::TendonLimit(..) => 1,
                    RowOrigin::Contact if row > asked.row => 2,
                    RowOrigin::Contact => 3,
                };
                losses[kind] -= problem.multiplier[row] * speeds[row];
            }
        }
        losses
    }

    /// Adds the generalized forces of position limits in the last state, and the force of each tendon's
    /// limits along its length \[N·m or N\]. The limits of ball joints' angles are not included.
    pub(crate) fn add_limit_forces(&self, coordinates: &mut [f64], tendons: &mut [f64]) {
        for asked in &self.asked {
            let force = self.problem.multiplier[asked.row];
            match asked.of {
                RowOrigin::Limit(coordinate, factor) => coordinates[coordinate] += factor * force,
                RowOrigin::TendonLimit(tendon, sign) => tendons[tendon] += sign * force,
                _ => {}
            }
        }
    }

    /// The contacts of the last state with the grounds and between links, in the order of
    /// [`contacts`](Self::contacts) after the given ones.
    pub(crate) fn contact_points(&self) -> impl Iterator<Item = ContactPoint<'_>> {
        let given = self.contacts.len() - self.found.len();
        let wrenches = self.contact_wrenches().skip(given);
        self.ground.iter().flat_map(move |set| {
            self.found.iter().zip(wrenches.clone()).map(|(found, (contact, force, moment))| {
                let at = (contact.point.into(), contact.normal.into(), contact.distance);
                set.contact_point(*found, at, (force, moment))
            })
        })
    }
}
