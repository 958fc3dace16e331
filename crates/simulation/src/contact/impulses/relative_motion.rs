//! The relative motion of a contact: of a shape against the ground or another link's shape.

use nalgebra::Vector3;
use robot_dynamics_core::Model;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_core::factorization::sparse::NONE;
use robot_dynamics_core::model::{Dof, WORLD};
use robot_dynamics_description::Surface;

use super::axes::{along_axes, in_world};
use super::{ContactImpulses, MOST_ROWS};
use crate::contact::contact_shape::ContactShape;
use crate::contact::shape_point::{ContactPartner, ShapePoint};
use crate::contact::{Components, ContactSet};
use crate::placement::{Placement, Twist};

impl ContactShape {
    /// The tree that moves it, or [`NONE`].
    pub(super) fn tree(&self, components: &Components) -> usize {
        self.coordinates.last().map_or(NONE, |coordinate| components.tree_of(*coordinate))
    }
}

impl ContactSet {
    /// Calls `visit` with each degree of freedom that moves the first shape relative to its contact partner.
    /// The other arguments are the velocity at a point and ω of that motion.
    #[inline]
    pub(super) fn each_relative_motion(
        &self,
        model: &Model,
        placement: &Placement,
        point: &ShapePoint,
        mut visit: impl FnMut(&Dof, Vector3<f64>, Vector3<f64>),
    ) {
        let body = self.shapes[point.shape].body;
        match point.against {
            ContactPartner::Ground(_) | ContactPartner::Field(_) => {
                placement.each_motion(model, body, point.at, visit);
            }
            ContactPartner::Pair(pair) => {
                let pair = &self.pairs[pair];
                let other = self.shapes[pair.shapes[1]].body;
                placement.each_motion_on(model, [body, pair.common], point.at, &mut visit);
                placement.each_motion_on(model, [other, pair.common], point.at, |dof, velocity, spin| {
                    visit(dof, -velocity, -spin);
                });
            }
        }
    }

    /// The bodies that move there, the first shape's with 1 and the other's with −1.
    pub(super) fn sides(&self, point: &ShapePoint) -> impl Iterator<Item = (usize, f64)> {
        let other = match point.against {
            ContactPartner::Ground(_) | ContactPartner::Field(_) => WORLD,
            ContactPartner::Pair(pair) => self.shapes[self.pairs[pair].shapes[1]].body,
        };
        let sides = [(self.shapes[point.shape].body, 1.0), (other, -1.0)];
        sides.into_iter().filter(|(body, _)| *body != WORLD)
    }

    /// The trees of the two sides of a contact.
    pub(super) fn trees(&self, components: &Components, point: &ShapePoint) -> [usize; 2] {
        let tree = |shape: usize| self.shapes[shape].tree(components);
        let other = match point.against {
            ContactPartner::Ground(_) | ContactPartner::Field(_) => NONE,
            ContactPartner::Pair(pair) => tree(self.pairs[pair].shapes[1]),
        };
        [tree(point.shape), other]
    }

    /// Adds a contact's force and moment to those of its bodies, about the world's origin.
    pub(super) fn add_wrench(&self, point: &ShapePoint, force: &[f64; MOST_ROWS], wrenches: &mut [Twist]) {
        let (force, moment) = in_world(point, force);
        let moment = moment + point.at.cross(&force);
        for (body, sign) in self.sides(point) {
            wrenches[body][0] += force * sign;
            wrenches[body][1] += moment * sign;
        }
    }

    /// The coordinates of the relative motion, in increasing order.
    pub(super) fn coordinates(&self, point: &ShapePoint) -> &[usize] {
        match point.against {
            ContactPartner::Ground(_) | ContactPartner::Field(_) => &self.shapes[point.shape].coordinates,
            ContactPartner::Pair(pair) => &self.pairs[pair].coordinates,
        }
    }

    /// The surface given for the contact, its coefficient of sliding friction, and its restitution; `None` if
    /// not given.
    pub(in crate::contact) fn stated(&self, point: &ShapePoint) -> (Option<&Surface>, Option<f64>, f64) {
        let on_ground = self.shapes[point.shape].on_grounds.first().map(|(_, surface)| surface);
        match point.against {
            ContactPartner::Ground(ground) => {
                let surfaces = self.ground_surfaces[ground].as_ref();
                let ground = &self.grounds[ground].0;
                let stated = surfaces.map_or(on_ground, |surfaces| surfaces[point.shape].as_ref());
                (stated, ground.friction, ground.restitution)
            }
            ContactPartner::Field(field) => {
                let field = &self.fields[field];
                let surfaces = field.surfaces.as_ref();
                let stated = surfaces.map_or(on_ground, |surfaces| surfaces[point.shape].as_ref());
                (stated, field.friction, field.restitution)
            }
            ContactPartner::Pair(pair) => (Some(&self.pairs[pair].surface), None, self.link_restitution),
        }
    }

    /// The coefficients of restitution of the grounds, the height fields and the links.
    pub(in crate::contact) fn restitutions(&self) -> impl Iterator<Item = f64> + '_ {
        let grounds = self.grounds.iter().map(|(ground, _)| ground.restitution);
        let fields = self.fields.iter().map(|field| field.restitution);
        let links = (!self.pairs.is_empty()).then_some(self.link_restitution);
        grounds.chain(fields).chain(links)
    }

    /// The surface of the contact, or the shape's own if none is given, with the coefficients of sliding
    /// friction and of restitution.
    pub(super) fn surface(&self, point: &ShapePoint) -> (&Surface, f64, f64) {
        let (stated, friction, restitution) = self.stated(point);
        let surface = stated.unwrap_or(&self.shapes[point.shape].surface);
        (surface, friction.unwrap_or(surface.friction[0]).max(0.0), restitution)
    }
}

impl ContactImpulses {
    /// Normal and tangential velocity of a contact, then its angular velocity about the same axes.
    pub(super) fn velocity(
        &self,
        model: &Model,
        placement: &Placement,
        number: usize,
        v: &[f64],
    ) -> [f64; MOST_ROWS] {
        let point = self.set.point(placement, number);
        let (mut velocity, mut spin) = (Vector3::zeros(), Vector3::zeros());
        self.set.each_relative_motion(model, placement, &point, |dof, u, w| {
            let rate = dof.ratio * v[dof.coordinate];
            velocity += u * rate;
            spin += w * rate;
        });
        along_axes(&point, &velocity, &spin)
    }

    /// Whether surfaces of shapes move, which can supply energy.
    pub(crate) fn has_moving_surfaces(&self) -> bool {
        self.set.has_moving_surfaces
    }

    /// The motion of the surfaces at a contact in addition to that of their bodies, along the axes of the
    /// contact. Only sliding and torsional friction count it.
    pub(super) fn surface_motion(&self, point: &ShapePoint) -> [f64; MOST_ROWS] {
        let Some([velocity, spin]) = self.set.surface_motion(&self.placement, point, point.at) else {
            return [0.0; MOST_ROWS];
        };
        let [_, s, t, n, _, _] = along_axes(point, &velocity, &spin);
        [0.0, s, t, n, 0.0, 0.0]
    }

    /// Computes λ of the zeros that remain when links touch each other: a pair's contact couples the
    /// coordinates of both links.
    pub(super) fn couple(&mut self, dof_parent: &[usize]) {
        self.dof_parent.clear();
        self.dof_parent.extend_from_slice(dof_parent);
        for active in &self.active {
            if let ContactPartner::Pair(pair) = active.point.against
                && let Some(ends) = self.set.pairs[pair].ends
            {
                sparse::couple(&mut self.dof_parent, ends);
            }
        }
    }
}
