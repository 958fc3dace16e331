//! Lists of the pairs of links that may touch.

use super::{SimulationBuilder, SimulationError};
use crate::ContactSet;

impl SimulationBuilder<'_> {
    /// Without contacts between the links of these pairs, beside those that the description excludes: as
    /// [`ContactSet::without_link_pairs`].
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(SimulationBuilder::new(&model).ignore_contacts([("ceiling", "rod")]).build().is_ok());
    /// assert!(SimulationBuilder::new(&model).ignore_contacts([("ceiling", "road")]).build().is_err());
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    #[must_use]
    pub fn ignore_contacts<N: Into<String>>(mut self, pairs: impl IntoIterator<Item = (N, N)>) -> Self {
        self.ignored_pairs.extend(pairs.into_iter().map(|(a, b)| (a.into(), b.into())));
        self
    }

    /// With contacts between links for these pairs alone: as [`ContactSet::with_only_link_pairs`].
    ///
    /// ```
    /// use multibody::{Model, pendulum, simulator::SimulationBuilder};
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(SimulationBuilder::new(&model).only_contacts([("ceiling", "rod")]).build().is_ok());
    /// # Ok::<(), multibody::ModelError>(())
    /// ```
    #[must_use]
    pub fn only_contacts<N: Into<String>>(mut self, pairs: impl IntoIterator<Item = (N, N)>) -> Self {
        let pairs = pairs.into_iter().map(|(a, b)| (a.into(), b.into()));
        self.only_pairs.get_or_insert_with(Vec::new).extend(pairs);
        self
    }

    /// The contacts of the pairs of links that may touch.
    pub(super) fn of_pairs(&self, set: ContactSet) -> Result<ContactSet, SimulationError> {
        let set = match &self.only_pairs {
            Some(pairs) => set.with_only_link_pairs(&self.model, pairs)?,
            None => set,
        };
        Ok(set.without_link_pairs(&self.model, &self.ignored_pairs)?)
    }
}
