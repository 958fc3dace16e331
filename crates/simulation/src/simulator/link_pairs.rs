//! Selection of the pairs of links that may touch.

use super::{SimulationBuilder, SimulationError};
use crate::ContactSet;

impl SimulationBuilder<'_> {
    /// Ignores contacts between the links of these pairs, in addition to the pairs that the description
    /// excludes; see [`ContactSet::without_link_pairs`].
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(SimulationBuilder::new(&model).ignore_contacts([("ceiling", "rod")]).build().is_ok());
    /// assert!(SimulationBuilder::new(&model).ignore_contacts([("ceiling", "road")]).build().is_err());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
    /// ```
    #[must_use]
    pub fn ignore_contacts<N: Into<String>>(mut self, pairs: impl IntoIterator<Item = (N, N)>) -> Self {
        self.ignored_pairs.extend(pairs.into_iter().map(|(a, b)| (a.into(), b.into())));
        self
    }

    /// Restricts contacts between links to these pairs; see [`ContactSet::with_only_link_pairs`].
    ///
    /// ```
    /// use robot_dynamics::description::pendulum;
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::SimulationBuilder;
    /// let model = Model::new(pendulum(2.0, 0.5))?;
    /// assert!(SimulationBuilder::new(&model).only_contacts([("ceiling", "rod")]).build().is_ok());
    /// # Ok::<(), robot_dynamics::description::ModelError>(())
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
