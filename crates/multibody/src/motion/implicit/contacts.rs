//! Implicit steps on the ground.

use super::Implicit;
use crate::contact::ContactImpulses;
use crate::{ContactPoint, ContactProblem, ContactSet, Model};

impl Implicit {
    /// With the ground: contacts that neither sink nor creep, with Coulomb's friction.
    ///
    /// # Panics
    /// If the set is another robot's.
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

    /// The last step's contacts as one complementarity problem, with the answer that was taken: for comparison with other methods.
    /// `None` where nothing touched; of a step that was divided, that of its last part, of the components that moved in it.
    pub(crate) fn contact_problem(&self) -> Option<ContactProblem> {
        self.contacts.as_ref()?.last_problem()
    }
}
