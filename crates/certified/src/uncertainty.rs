//! Sets of robots: masses, payload, friction and gravity in intervals.

use core::fmt;
use std::error::Error;

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_number::{Classified, ErrorKind};

use crate::Interval;
use crate::support::dot;

/// The robots that a bound is proven for. The default is the model alone.
#[derive(Clone, Debug)]
pub struct Uncertainty {
    /// For each of [`Model::moving_links`], the factor on its mass, first moment and inertia.
    pub(crate) mass_factors: Vec<Interval>,
    /// The factor on damping and dry friction of all joints; 0 for none.
    pub(crate) friction_factor: Interval,
    /// The acceleration of gravity \[m/s²\].
    pub(crate) gravity: [Interval; 3],
    pub(crate) payload: Option<Payload>,
}

/// A rigid body that a frame carries, in addition to the robot's links.
#[derive(Clone, Copy, Debug)]
pub struct Payload {
    /// The frame.
    pub frame: FrameId,
    /// Its mass \[kg\].
    pub mass: Interval,
    /// Its center of mass in the frame \[m\].
    pub center_of_mass: [Interval; 3],
    /// The largest radius of gyration about its center of mass \[m\]: no principal moment exceeds the mass
    /// times its square.
    pub radius_of_gyration: f64,
}

/// A set of robots is invalid.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum InvalidUncertainty {
    /// No moving link has this name.
    Link {
        /// The name.
        name: String,
    },
    /// The interval contains a negative number, or is unbounded.
    Negative {
        /// The quantity.
        quantity: &'static str,
    },
    /// The frame belongs to another model, or to a link that does not move.
    Frame,
}

impl fmt::Display for InvalidUncertainty {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Link { name } => write!(f, "the robot has no moving link {name:?}"),
            Self::Negative { quantity } => write!(f, "{quantity} must be finite, and zero or positive"),
            Self::Frame => f.write_str("the frame of the payload must belong to a moving link of this robot"),
        }
    }
}

impl Error for InvalidUncertainty {}

impl Classified for InvalidUncertainty {
    fn kind(&self) -> ErrorKind {
        match self {
            Self::Link { .. } => ErrorKind::UnknownName,
            Self::Negative { .. } | Self::Frame => ErrorKind::InvalidInput,
        }
    }
}

impl Uncertainty {
    /// The robot as its model states it, without joint friction.
    pub fn none(model: &Model) -> Self {
        Self {
            mass_factors: vec![Interval::from(1.0); model.moving_links().count()],
            friction_factor: Interval::from(0.0),
            gravity: model.gravity().map(Interval::from),
            payload: None,
        }
    }

    /// The same factor on the mass, first moment and inertia of every moving link; each link has its own
    /// number of the interval.
    ///
    /// # Errors
    /// [`InvalidUncertainty`] if the interval contains a negative number, or is unbounded.
    pub fn with_mass_factor(mut self, factor: Interval) -> Result<Self, InvalidUncertainty> {
        check_not_negative("the factor on masses", factor)?;
        self.mass_factors.fill(factor);
        Ok(self)
    }

    /// The factor on the mass, first moment and inertia of one moving link, and of the links fixed to it.
    ///
    /// # Errors
    /// [`InvalidUncertainty`] if no moving link has the name, or the interval contains a negative number.
    pub fn with_mass_factor_of(
        mut self,
        model: &Model,
        link: &str,
        factor: Interval,
    ) -> Result<Self, InvalidUncertainty> {
        check_not_negative("the factor on a mass", factor)?;
        let index = model.moving_links().position(|name| name == link);
        let index = index.ok_or_else(|| InvalidUncertainty::Link { name: link.to_owned() })?;
        self.mass_factors[index] = factor;
        Ok(self)
    }

    /// The factor on damping and dry friction of all joints.
    ///
    /// # Errors
    /// [`InvalidUncertainty`] if the interval contains a negative number, or is unbounded.
    pub fn with_friction_factor(mut self, factor: Interval) -> Result<Self, InvalidUncertainty> {
        check_not_negative("the factor on friction", factor)?;
        self.friction_factor = factor;
        Ok(self)
    }

    /// The acceleration of gravity \[m/s²\], such as that of a base on a slope.
    #[must_use]
    pub fn with_gravity(mut self, gravity: [Interval; 3]) -> Self {
        self.gravity = gravity;
        self
    }

    /// A payload.
    ///
    /// # Errors
    /// [`InvalidUncertainty`] if the frame does not belong to a moving link of the model, the mass is
    /// negative, or a number is not finite.
    pub fn with_payload(mut self, model: &Model, payload: Payload) -> Result<Self, InvalidUncertainty> {
        if !model.has_frame(payload.frame) || model.frame_of(payload.frame).body.is_none() {
            return Err(InvalidUncertainty::Frame);
        }
        check_not_negative("the mass of the payload", payload.mass)?;
        check_not_negative("the radius of gyration", payload.radius_of_gyration.into())?;
        for coordinate in payload.center_of_mass {
            check_not_negative("the distance of the center of mass", coordinate.magnitude().into())?;
        }
        self.payload = Some(payload);
        Ok(self)
    }
}

fn check_not_negative(quantity: &'static str, x: Interval) -> Result<(), InvalidUncertainty> {
    if x.lower() >= 0.0 && x.is_bounded() { Ok(()) } else { Err(InvalidUncertainty::Negative { quantity }) }
}

impl Payload {
    /// The center of mass in the frame of the link that carries the payload.
    pub(crate) fn center_in_link(&self, model: &Model) -> [Interval; 3] {
        let frame = model.frame_of(self.frame);
        let body = &model.bodies[frame.body.expect("checked when the payload was set")];
        // link_from_frame = body_from_link⁻¹ · body_from_frame. The rotations are multiplied first: turning a
        // box twice would widen it twice.
        let (of_link, of_frame) = (&body.body_from_link, &frame.body_from_frame);
        core::array::from_fn(|i| {
            let axis = [0, 1, 2].map(|row| Interval::from(of_link.rotation[row][i]));
            let turned = [0, 1, 2].map(|j| dot(axis, [0, 1, 2].map(|row| of_frame.rotation[row][j].into())));
            let offset = [0, 1, 2].map(|row| {
                Interval::from(of_frame.translation[row]) - Interval::from(of_link.translation[row])
            });
            dot(turned, self.center_of_mass) + dot(axis, offset)
        })
    }

    /// Masses and centers in the link's frame of some payloads of the set: all combinations of bounds.
    pub(crate) fn examples(&self, model: &Model) -> Vec<(Interval, [Interval; 3])> {
        let mut examples = Vec::new();
        for bits in 0_u32..16 {
            let pick = |k: u32, x: Interval| if bits >> k & 1 == 0 { x.lower() } else { x.upper() };
            let [x, y, z] = self.center_of_mass;
            let center = [pick(0, x), pick(1, y), pick(2, z)].map(Interval::from);
            let center = Self { center_of_mass: center, ..*self }.center_in_link(model);
            examples.push((Interval::from(pick(3, self.mass)), center));
        }
        examples
    }
}
