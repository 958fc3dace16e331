//! The contacts that act at a state.

use robot_dynamics_core::{FrameId, Model};
use robot_dynamics_description::Surface;

use super::active_set::ActiveSet;
use super::{ContactPartner, ContactSet, ShapePair, ShapePoint, SoftConstraints, SoftContact};

impl SoftConstraints {
    /// The limits and contacts that acted at the last state.
    pub(crate) fn active_set(&self) -> &ActiveSet {
        &self.active
    }

    /// Lets exactly these limits and contacts act from here on, at any distance; `None`: those that are near.
    pub(crate) fn fix_active_set(&mut self, set: Option<ActiveSet>) {
        self.fixed = set;
    }

    /// Adds the contacts of the shapes with the ground, and with each other.
    pub(super) fn find_contacts(&mut self, model: &Model) {
        self.active.contacts.clear();
        self.found.clear();
        self.adhesion.near.clear();
        let adheres = self.adhesion.acts();
        let Self {
            ground: Some(set), bodies, contacts, found, active, fixed, links, shapes, adhesion, ..
        } = self
        else {
            return;
        };
        let [on_grounds, of_pairs] = set.widest_margins(adheres);
        if fixed.is_none() {
            set.find_near(model, &bodies.placement, of_pairs);
        }
        let set = &*set;
        let mut add = |point: &ShapePoint, is_fixed: bool| {
            let Some((mut contact, gap)) = contact_at(set, (links, shapes), point) else { return };
            if let Some(motion) = set.surface_motion(&bodies.placement, point, contact.point.into()) {
                contact.surface_motion = motion.map(Into::into);
            }
            if contact.distance < contact.margin || (is_fixed && contact.distance.is_finite()) {
                contacts.push(contact);
                found.push((point.shape, point.against));
                active.contacts.push(point.number);
            } else if adheres && contact.distance < contact.margin + gap {
                adhesion.near.push(contact);
            }
        };
        if let Some(fixed) = fixed {
            fixed.contacts.iter().for_each(|&number| add(&set.point(&bodies.placement, number), true));
            return;
        }
        set.for_each_ground_contact(&bodies.placement, on_grounds, |point| add(&point, false));
        set.for_each_pair_contact(&bodies.placement, of_pairs, |point| add(&point, false));
    }
}

/// The contact there and its gap; `None` if the shape does not touch a ground.
fn contact_at(
    set: &ContactSet,
    (links, shapes): (&[FrameId], &[Option<FrameId>]),
    point: &ShapePoint,
) -> Option<(SoftContact, f64)> {
    let normal = point.axes[0];
    if let ContactPartner::Pair(index) = point.against {
        let ShapePair { shapes: [one, two], surface, .. } = &set.pairs[index];
        let contact = SoftContact::new(shapes[*one]?, point.at.into(), normal.into(), point.gap);
        return Some((SoftContact { other: shapes[*two], ..contact.with_surface(surface) }, surface.gap));
    }
    let shape = &set.shapes[point.shape];
    let (stated, friction, _) = set.stated(point);
    let mut surface = stated.copied().unwrap_or(shape.surface);
    surface.friction[0] = friction.unwrap_or(surface.friction[0]);
    let at = point.at - normal * (0.5 * point.gap);
    let contact = SoftContact::new(links[shape.on_ground?], at.into(), normal.into(), point.gap);
    Some((contact.with_surface(&surface), surface.gap))
}

impl ContactSet {
    /// The largest margins of contacts with grounds and of those between links \[m\], with their gaps if
    /// asked for.
    fn widest_margins(&self, with_gaps: bool) -> [f64; 2] {
        let reach = |surface: &Surface| surface.margin + if with_gaps { surface.gap } else { 0.0 };
        let shapes = self.shapes.iter().map(|shape| {
            let on_ground = shape.on_grounds.first().map(|(_, surface)| surface);
            reach(on_ground.unwrap_or(&shape.surface))
        });
        let mixes = self.ground_surfaces.iter().flatten().flatten().flatten().map(reach);
        let grounds = shapes.chain(mixes).chain(self.fields.iter().map(super::PlacedField::margin));
        // Margins of two shapes add up.
        let of_shapes = self.shapes.iter().map(|shape| 2.0 * reach(&shape.surface));
        let pairs = of_shapes.chain(self.pairs.iter().map(|pair| reach(&pair.surface)));
        [grounds.fold(0.0, f64::max), pairs.fold(0.0, f64::max)]
    }
}
