//! Implicit steps with contacts.

use robot_dynamics_core::Model;

use super::ImplicitIntegrator;
use crate::contact::ContactImpulses;
use crate::{ContactPoint, ContactProblem, ContactSet};

impl ImplicitIntegrator {
    /// Adds rigid contacts with Coulomb friction, without penetration and creep.
    ///
    /// # Panics
    /// Panics if the set belongs to another model.
    #[track_caller]
    pub(crate) fn with_contacts(mut self, model: &Model, contacts: ContactSet) -> Self {
        let mut contacts = ContactImpulses::new(model, contacts);
        contacts.watch(&self.interrupt);
        for kept in [&mut self.kept, &mut self.start] {
            kept.contacts = Some(contacts.memory().anew());
        }
        self.contacts = Some(contacts);
        self
    }

    /// The contacts at the end of the last step, with their forces.
    pub(crate) fn contact_points(&self) -> impl Iterator<Item = ContactPoint<'_>> {
        self.contacts.iter().flat_map(ContactImpulses::contact_points)
    }

    /// The links that can touch a ground.
    pub(crate) fn ground_links(&self) -> &[String] {
        self.contacts.as_ref().map_or(&[], ContactImpulses::ground_links)
    }

    /// The contacts of the last step as one complementarity problem with the computed solution, for
    /// comparison with other methods. `None` if nothing touched. If the step was divided, the problem is that
    /// of its last part and of the components that moved in it.
    pub(crate) fn contact_problem(&self) -> Option<ContactProblem> {
        self.contacts.as_ref()?.last_problem()
    }
}
