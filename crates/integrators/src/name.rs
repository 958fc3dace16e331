//! Integrators by name.

use core::fmt;
use core::str::FromStr;

use crate::{Integrator, IntegratorError};

impl Integrator {
    /// The row with this name.
    ///
    /// # Errors
    /// [`IntegratorError::UnknownName`], whose message lists the valid names.
    ///
    /// ```
    /// use robot_dynamics_integrators::Integrator;
    /// assert_eq!(Integrator::from_name("rk4")?.order(), 4);
    /// # Ok::<(), robot_dynamics_integrators::IntegratorError>(())
    /// ```
    pub fn from_name(name: &str) -> Result<Self, IntegratorError> {
        let mut rows = Self::ALL.into_iter();
        rows.find(|row| row.name() == name)
            .ok_or_else(|| IntegratorError::UnknownName { name: name.to_owned() })
    }
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Integrator {
    type Err = IntegratorError;
    fn from_str(name: &str) -> Result<Self, IntegratorError> {
        Self::from_name(name)
    }
}
