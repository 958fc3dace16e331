//! The limits and contacts that act at a state, and their choice for other states.
//!
//! When a constraint of this law becomes active, its damping force B ṙ appears at once. So v̇ jumps where the
//! active set changes, and is differentiable only with a fixed active set.

use robot_dynamics_core::clone_in_place::clone_in_place;
use robot_dynamics_core::{FrameId, Model};

use super::{ContactPartner, ContactSet, Pair, SoftConstraints, SoftContact, TouchingPoint};

clone_in_place! {
    /// The limits and contacts that act in a step: see [`Stepper::active_set`](crate::Stepper::active_set).
    #[derive(Debug, Default, PartialEq, Eq)]
    pub struct ActiveSet {
        /// Numbers of points of the contact set.
        contacts: Vec<usize>,
        /// Numbers of limits of joints and tendons.
        limits: Vec<usize>,
    }
}

impl ActiveSet {
    /// The number of active limits and contact points.
    ///
    /// ```
    /// use robot_dynamics::contact::SoftConstraints;
    /// use robot_dynamics::description::{Limits, pendulum};
    /// use robot_dynamics::model::Model;
    /// use robot_dynamics::simulation::{MujocoEuler, StepForces, StepWorkspace, Stepper};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.joints[0].limits = Limits::new(-0.2, 0.3);
    /// let model = Model::new(robot)?;
    /// let mut stepper = MujocoEuler::new(&model, SoftConstraints::new(&model, 1e-3)?);
    /// let (mut w, forces) = (StepWorkspace::new(&model), StepForces::new(&[0.0], true));
    /// stepper.step(&model, &mut w, &forces, 1e-3, &mut [0.301], &mut [0.0])?; // beyond its limit
    /// assert_eq!(stepper.active_set().map(|set| set.len()), Some(1));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn len(&self) -> usize {
        self.contacts.len() + self.limits.len()
    }

    /// Whether the set is empty.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// The limits that act at a state.
pub(super) struct ActiveLimits<'a> {
    /// Those found so far.
    now: &'a mut Vec<usize>,
    /// The given active set, if any.
    fixed: Option<&'a [usize]>,
}

impl ActiveLimits<'_> {
    /// Whether the limit with this number acts.
    pub(super) fn admits(&mut self, number: usize, is_near: bool) -> bool {
        let acts = self.fixed.map_or(is_near, |fixed| fixed.contains(&number));
        if acts {
            self.now.push(number);
        }
        acts
    }
}

impl SoftConstraints {
    /// The limits and contacts that acted at the last state.
    pub(crate) fn active_set(&self) -> &ActiveSet {
        &self.active
    }

    /// Lets exactly these limits and contacts act from here on, at any distance; `None`: those that are near.
    pub(crate) fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        self.fixed = set;
    }

    pub(super) fn active_limits<'a>(
        active: &'a mut ActiveSet,
        fixed: Option<&'a ActiveSet>,
    ) -> ActiveLimits<'a> {
        active.limits.clear();
        ActiveLimits { now: &mut active.limits, fixed: fixed.map(|fixed| &fixed.limits[..]) }
    }

    /// Adds the contacts of the shapes with the ground, and with each other.
    pub(super) fn find_contacts(&mut self, model: &Model) {
        self.active.contacts.clear();
        self.found.clear();
        let Self { ground: Some(set), placement, contacts, found, active, fixed, links, shapes, .. } = self
        else {
            return;
        };
        let [on_grounds, of_pairs] = set.widest_margins();
        if fixed.is_none() {
            set.find_near(model, placement, of_pairs);
        }
        let set = &*set;
        let mut add = |point: &TouchingPoint, is_fixed: bool| {
            let Some(contact) = contact_at(set, (links, shapes), point) else { return };
            if contact.distance < contact.margin || (is_fixed && contact.distance.is_finite()) {
                contacts.push(contact);
                found.push((point.shape, point.against));
                active.contacts.push(point.number);
            }
        };
        if let Some(fixed) = fixed {
            fixed.contacts.iter().for_each(|&number| add(&set.point(placement, number), true));
            return;
        }
        set.look(placement, on_grounds, |point| add(&point, false));
        set.look_at_pairs(placement, of_pairs, |point| add(&point, false));
    }
}

/// The contact there; `None` if the shape does not touch a ground.
fn contact_at(
    set: &ContactSet,
    (links, shapes): (&[FrameId], &[Option<FrameId>]),
    point: &TouchingPoint,
) -> Option<SoftContact> {
    let normal = point.axes[0];
    if let ContactPartner::Pair(index) = point.against {
        let Pair { shapes: [one, two], surface, .. } = &set.pairs[index];
        let contact = SoftContact::new(shapes[*one]?, point.at.into(), normal.into(), point.gap);
        return Some(SoftContact { other: shapes[*two], ..contact.with_surface(surface) });
    }
    let shape = &set.shapes[point.shape];
    let (stated, friction, _) = set.stated(point);
    let mut surface = stated.copied().unwrap_or(shape.surface);
    surface.friction[0] = friction.unwrap_or(surface.friction[0]);
    let at = point.at - normal * (0.5 * point.gap);
    let contact = SoftContact::new(links[shape.on_ground?], at.into(), normal.into(), point.gap);
    Some(contact.with_surface(&surface))
}

impl ContactSet {
    /// The largest margins of contacts with grounds and of those between links \[m\].
    fn widest_margins(&self) -> [f64; 2] {
        let shapes = self.shapes.iter().map(|shape| {
            let on_ground = shape.on_grounds.first().map(|(_, surface)| surface);
            on_ground.unwrap_or(&shape.surface).margin
        });
        let mixes = self.ground_surfaces.iter().flatten().flatten().flatten().map(|surface| surface.margin);
        let grounds = shapes.chain(mixes).chain(self.fields.iter().map(super::PlacedField::margin));
        // Margins of two shapes add up.
        let of_shapes = self.shapes.iter().map(|shape| 2.0 * shape.surface.margin);
        let pairs = of_shapes.chain(self.pairs.iter().map(|pair| pair.surface.margin));
        [grounds.fold(0.0, f64::max), pairs.fold(0.0, f64::max)]
    }
}
