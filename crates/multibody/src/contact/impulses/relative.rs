//! How a contact moves: one shape against the ground, or against another link's.

use nalgebra::Vector3;

use super::{ContactImpulses, MOST_ROWS, in_world};
use crate::contact::placement::{Placement, Twist};
use crate::contact::touch::{Against, TouchingPoint};
use crate::contact::{Components, ContactSet, Touching, rows_of};
use crate::factor::sparse::{self, NONE};
use crate::model::{Dof, WORLD};
use crate::{Model, Surface};

impl Touching {
    /// The tree that moves it, [`NONE`] where nothing does.
    pub(super) fn tree(&self, components: &Components) -> usize {
        self.coordinates.last().map_or(NONE, |coordinate| components.tree_of(*coordinate))
    }
}

impl ContactSet {
    /// Calls `look` with each freedom that moves the first shape against what it touches, and the velocity and ω of that motion at a point.
    #[inline]
    pub(super) fn each_relative_motion(
        &self,
        model: &Model,
        placement: &Placement,
        point: &TouchingPoint,
        mut look: impl FnMut(&Dof, Vector3<f64>, Vector3<f64>),
    ) {
        let body = self.shapes[point.shape].body;
        match point.against {
            Against::Ground(_) | Against::Field(_) => placement.each_motion(model, body, point.at, look),
            Against::Pair(pair) => {
                let pair = &self.pairs[pair];
                let other = self.shapes[pair.shapes[1]].body;
                placement.each_motion_on(model, [body, pair.common], point.at, &mut look);
                placement.each_motion_on(model, [other, pair.common], point.at, |dof, velocity, spin| {
                    look(dof, -velocity, -spin);
                });
            }
        }
    }

    /// The bodies that move there, the first shape's with 1 and the other's with −1.
    pub(super) fn sides(&self, point: &TouchingPoint) -> impl Iterator<Item = (usize, f64)> {
        let other = match point.against {
            Against::Ground(_) | Against::Field(_) => WORLD,
            Against::Pair(pair) => self.shapes[self.pairs[pair].shapes[1]].body,
        };
        let sides = [(self.shapes[point.shape].body, 1.0), (other, -1.0)];
        sides.into_iter().filter(|(body, _)| *body != WORLD)
    }

    /// The trees of the two sides of a contact.
    pub(super) fn trees(&self, components: &Components, point: &TouchingPoint) -> [usize; 2] {
        let tree = |shape: usize| self.shapes[shape].tree(components);
        let other = match point.against {
            Against::Ground(_) | Against::Field(_) => NONE,
            Against::Pair(pair) => tree(self.pairs[pair].shapes[1]),
        };
        [tree(point.shape), other]
    }

    /// Adds a contact's force and moment to those of the bodies that it acts on, about the world's origin.
    pub(super) fn add_wrench(&self, point: &TouchingPoint, force: &[f64; MOST_ROWS], wrenches: &mut [Twist]) {
        let (force, moment) = in_world(point, force);
        let moment = moment + point.at.cross(&force);
        for (body, sign) in self.sides(point) {
            wrenches[body][0] += force * sign;
            wrenches[body][1] += moment * sign;
        }
    }

    /// The coordinates that do, rising.
    pub(super) fn coordinates(&self, point: &TouchingPoint) -> &[usize] {
        match point.against {
            Against::Ground(_) | Against::Field(_) => &self.shapes[point.shape].coordinates,
            Against::Pair(pair) => &self.pairs[pair].coordinates,
        }
    }

    /// What is stated of the surface there, if it is; of the coefficient of sliding friction, if it is; and of restitution.
    pub(in crate::contact) fn stated(&self, point: &TouchingPoint) -> (Option<&Surface>, Option<f64>, f64) {
        let on_ground = self.shapes[point.shape].on_grounds.first().map(|(_, surface)| surface);
        match point.against {
            Against::Ground(ground) => {
                let surfaces = self.ground_surfaces[ground].as_ref();
                let ground = &self.grounds[ground].0;
                let stated = surfaces.map_or(on_ground, |surfaces| surfaces[point.shape].as_ref());
                (stated, ground.friction, ground.restitution)
            }
            Against::Field(field) => {
                let field = &self.fields[field];
                let surfaces = field.surfaces.as_ref();
                let stated = surfaces.map_or(on_ground, |surfaces| surfaces[point.shape].as_ref());
                (stated, field.friction, field.restitution)
            }
            Against::Pair(pair) => (Some(&self.pairs[pair].surface), None, self.link_restitution),
        }
    }

    /// The coefficients of restitution of the grounds, the height fields and the links.
    pub(in crate::contact) fn restitutions(&self) -> impl Iterator<Item = f64> + '_ {
        let grounds = self.grounds.iter().map(|(ground, _)| ground.restitution);
        let fields = self.fields.iter().map(|field| field.restitution);
        let links = (!self.pairs.is_empty()).then_some(self.link_restitution);
        grounds.chain(fields).chain(links)
    }

    /// The surface there, a shape's own where none is stated, with the coefficient of sliding friction, and of restitution.
    pub(super) fn surface(&self, point: &TouchingPoint) -> (&Surface, f64, f64) {
        let (stated, friction, restitution) = self.stated(point);
        let surface = stated.unwrap_or(&self.shapes[point.shape].surface);
        (surface, friction.unwrap_or(surface.friction[0]).max(0.0), restitution)
    }
}

impl ContactImpulses {
    /// Normal and tangential velocity of a contact, then its spin about the same axes.
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

    /// λ of the zeros that the tree's matrix has left when links touch each other: a pair's contacts join what moves either of its links.
    pub(super) fn couple(&mut self, carrier: &[usize]) {
        self.carrier.clear();
        self.carrier.extend_from_slice(carrier);
        for active in &self.active {
            if let Against::Pair(pair) = active.point.against
                && let Some(ends) = self.set.pairs[pair].ends
            {
                sparse::couple(&mut self.carrier, ends);
            }
        }
    }
}

/// Normal and tangential parts of a velocity, then those of a spin.
pub(super) fn along_axes(
    point: &TouchingPoint,
    velocity: &Vector3<f64>,
    spin: &Vector3<f64>,
) -> [f64; MOST_ROWS] {
    let [n, s, t] = &point.axes;
    [n.dot(velocity), s.dot(velocity), t.dot(velocity), n.dot(spin), s.dot(spin), t.dot(spin)]
}

/// How many rows a contact has, and their factors: moments count by the ratio of their friction to the sliding one, so that the
/// cone is round.
pub(super) fn directions(surface: &Surface, friction: f64) -> (usize, [f64; MOST_ROWS]) {
    let [_, torsion, rolling] = surface.friction;
    let mut scale = [1.0; MOST_ROWS];
    if friction <= 0.0 {
        return (1, scale);
    }
    let [torsion, rolling] = [torsion, rolling].map(|moment| moment.max(0.0) / friction);
    (scale[3], scale[4], scale[5]) = (torsion, rolling, rolling);
    // Rows whose moment is none are left out at the end; torsion without any stays before rolling, with the factor 0.
    let rows = match rows_of(surface.condim) {
        6 if rolling > 0.0 => 6,
        4 | 6 if torsion > 0.0 => 4,
        1 => 1,
        _ => 3,
    };
    (rows, scale)
}
