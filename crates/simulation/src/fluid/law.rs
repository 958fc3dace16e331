//! The force of a fluid on one shape, as a function of the shape's velocity, and its derivatives.
//!
//! Vectors are along the shape's axes, at its centre, relative to the fluid.

mod ellipsoid;
mod inertia_box;

use nalgebra::Matrix6;
use robot_dynamics_description::{FluidForm, Medium};

use self::ellipsoid::EllipsoidLaw;
use self::inertia_box::BoxLaw;
use crate::fluid::pair::Pair;

/// The law of one shape in one medium.
#[derive(Clone, Debug)]
pub(super) enum ShapeLaw {
    Box(BoxLaw),
    Ellipsoid(EllipsoidLaw),
}

impl ShapeLaw {
    pub(super) fn new(form: &FluidForm, medium: &Medium) -> Self {
        match form {
            FluidForm::InertiaBox { size } => Self::Box(BoxLaw::new(*size, medium)),
            FluidForm::Ellipsoid(ellipsoid) => Self::Ellipsoid(EllipsoidLaw::new(ellipsoid, medium)),
        }
    }

    /// Force \[N\] and moment \[N·m\].
    pub(super) fn force(&self, velocity: &Pair) -> Pair {
        match self {
            Self::Box(law) => law.force(velocity),
            Self::Ellipsoid(law) => law.force(velocity),
        }
    }

    /// The derivative of [`force`](Self::force) by the velocity.
    pub(super) fn derivative(&self, velocity: &Pair) -> Matrix6<f64> {
        match self {
            Self::Box(law) => law.derivative(velocity),
            Self::Ellipsoid(law) => law.derivative(velocity),
        }
    }

    /// A symmetric positive semidefinite part of minus the derivative: that of the drag.
    pub(super) fn damping(&self, velocity: &Pair) -> Matrix6<f64> {
        match self {
            Self::Box(law) => -law.derivative(velocity),
            Self::Ellipsoid(law) => law.damping(velocity),
        }
    }
}
