//! Limits of the angles that ball joints are turned by.
//!
//! With φ = log q, the angle |φ| grows with (φ/|φ|)·ω, in the frames of both links alike. The row turns with the joint.

use nalgebra::Vector3;

use super::super::joints::{Length, Stop, turned};
use super::Impulses;

/// A joint turned by less than this has no axis of its own \[rad\].
const STRAIGHT: f64 = 1e-12;

impl Impulses {
    /// Takes the rows of ball joints at q. One that is not turned at all would turn along v.
    pub(in super::super) fn turn(&mut self, stops: &[Stop], q: &[f64], v: &[f64]) {
        for stop in stops {
            let Length::Turn(at) = stop.length else { continue };
            let way = turned(at, q);
            let row = &mut self.terms[stop.row];
            let axis = if way.norm() > STRAIGHT {
                way.normalize()
            } else {
                let spin = Vector3::from_fn(|k, _| v[row[k].0]);
                spin.try_normalize(0.0).unwrap_or_else(Vector3::z)
            };
            row.iter_mut().zip(&axis).for_each(|((_, factor), axis)| *factor = *axis);
        }
    }

    /// Adds the forces of these stops in the last step, along their axes at q.
    pub(in super::super) fn add_turned(&self, stops: &[Stop], q: &[f64], forces: &mut [f64]) {
        for stop in stops {
            let (Length::Turn(at), force) = (&stop.length, self.memory.carried[stop.row]) else { continue };
            let way = turned(*at, q);
            if force != 0.0 && way.norm() > STRAIGHT {
                let axis = way.normalize();
                self.terms[stop.row].iter().zip(&axis).for_each(|((k, _), axis)| forces[*k] += force * axis);
            }
        }
    }
}
