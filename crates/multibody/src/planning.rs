//! A path with a clock.

pub(crate) mod time_parameterization;
