//! Steps of a custom method.

use core::fmt;
use core::ops::{Deref, DerefMut};

use crate::motion::simulate::Stepper;

/// A custom stepper of any type.
pub(super) struct OwnStepper(Box<dyn AnyStepper>);

impl OwnStepper {
    pub(super) fn new<S>(stepper: S) -> Self
    where
        S: Stepper + Clone + Send + Sync + 'static,
    {
        Self(Box::new(stepper))
    }
}

impl Clone for OwnStepper {
    fn clone(&self) -> Self {
        Self(self.0.copy())
    }
}

impl Deref for OwnStepper {
    type Target = dyn AnyStepper;

    fn deref(&self) -> &Self::Target {
        &*self.0
    }
}

impl DerefMut for OwnStepper {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut *self.0
    }
}

impl fmt::Debug for OwnStepper {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("OwnStepper").finish_non_exhaustive()
    }
}

/// A cloneable stepper behind a pointer.
pub(super) trait AnyStepper: Stepper + Send + Sync {
    fn copy(&self) -> Box<dyn AnyStepper>;
}

impl<S> AnyStepper for S
where
    S: Stepper + Clone + Send + Sync + 'static,
{
    fn copy(&self) -> Box<dyn AnyStepper> {
        Box::new(self.clone())
    }
}
