//! The pairs of shapes with a known contact search.

use super::ContactSet;
use super::contact_shape::ContactShape;
use super::convex::{Convex, KNOWN};

/// Pairs without a known contact search are named one by one up to this number.
const MOST_NOTES: usize = 100_000;

impl ContactSet {
    /// Makes the convex form of every shape, if some shapes need it.
    pub(super) fn find_convex(&mut self) {
        if self.shapes.iter().any(|shape| !shape.form.is_line()) {
            for shape in &mut self.shapes {
                shape.convex = shape.convex.take().or_else(|| Convex::new(&shape.form));
            }
        }
    }

    /// Whether two shapes have a known contact search, once their convex forms are made.
    pub(super) fn can_meet(&self, shapes: [usize; 2]) -> bool {
        let has = |is: fn(&ContactShape) -> bool| shapes.iter().all(|shape| is(&self.shapes[*shape]));
        has(|shape| shape.form.is_line()) || has(|shape| shape.convex.is_some())
    }

    /// Lists the pairs without a known contact search; if there are very many, only their number.
    pub(super) fn note_unknown(&mut self) {
        let is_odd = |index: usize| !self.shapes[index].form.is_line() && self.shapes[index].convex.is_none();
        let odd: Vec<usize> = (0..self.shapes.len()).filter(|index| is_odd(*index)).collect();
        if odd.len() * self.shapes.len() > MOST_NOTES {
            self.left_out_pairs.push(format!("all links with {} of the shapes: {KNOWN}", odd.len()));
            return;
        }
        let mut notes = Vec::new();
        for &one in &odd {
            for two in (0..self.shapes.len()).filter(|two| *two != one) {
                let shapes = [one.min(two), one.max(two)];
                if self.may_touch(shapes) {
                    let [a, b] = shapes.map(|shape| &self.shapes[shape].link);
                    notes.push(format!("links `{a}` and `{b}`: {KNOWN}"));
                }
            }
        }
        self.left_out_pairs.append(&mut notes);
    }

    /// Whether two shapes have a known contact search.
    pub(super) fn is_known(&mut self, shapes: [usize; 2]) -> bool {
        if shapes.iter().all(|shape| self.shapes[*shape].form.is_line()) {
            return true;
        }
        shapes.into_iter().all(|shape| {
            let shape = &mut self.shapes[shape];
            shape.convex = shape.convex.take().or_else(|| Convex::new(&shape.form));
            shape.convex.is_some()
        })
    }
}
