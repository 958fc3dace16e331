//! Limits of the rotation angles of ball joints.
//!
//! With φ = log q, the angle |φ| increases at the rate (φ/|φ|)·ω, where the components of φ are the same in
//! both links. The row depends on q.

use nalgebra::Vector3;

use super::super::joints::{Length, Stop, turned};
use super::Impulses;

/// A joint with a rotation below this has no defined axis \[rad\].
const STRAIGHT: f64 = 1e-12;

impl Impulses {
    /// Evaluates the rows of ball joints at q. The axis of an unrotated joint is that of v.
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
