//! The shifts s that make the convex problem's cones Coulomb's law.

use super::projection::norm;
use super::{ConeProblem, Set};

/// How near s must be to be kept where the search for it ends.
const CLOSE_ENOUGH: f64 = 1e-3;

impl ConeProblem {
    /// s ← μ|c_t| of the cones, by Anderson's extrapolation over the last three of them; the largest distance that was left.
    pub(super) fn update_shifts(&mut self) -> f64 {
        let Self { blocks, c, past, .. } = self;
        let mut off = 0.0_f64;
        // This and the two before: s, then the way to its image.
        past.rotate_right(1);
        let [now, before, first] = past;
        now.clear();
        for block in &*blocks {
            if let Set::Cone(slope) = block.set {
                let left = slope * norm(&c[block.rows.start + 1..block.rows.end]) - block.shift;
                off = off.max(left.abs());
                now.push((block.shift, left));
            }
        }
        // The combination of the ways' differences that is nearest to the last way.
        let mut weights = [0.0; 2];
        if before.len() == now.len() {
            let has_first = first.len() == now.len();
            let (mut square, mut cross, mut second, mut with) = (0.0, 0.0, 0.0, [0.0; 2]);
            for k in 0..now.len() {
                let one = now[k].1 - before[k].1;
                let two = if has_first { before[k].1 - first[k].1 } else { 0.0 };
                square += one * one;
                cross += one * two;
                second += two * two;
                with[0] += one * now[k].1;
                with[1] += two * now[k].1;
            }
            let determinant = square * second - cross * cross;
            if determinant > 1e-8 * square * second {
                weights[0] = (second * with[0] - cross * with[1]) / determinant;
                weights[1] = (square * with[1] - cross * with[0]) / determinant;
            } else if square > 0.0 {
                weights[0] = with[0] / square;
            }
        }
        let cones = blocks.iter_mut().filter(|block| matches!(block.set, Set::Cone(_)));
        for (k, block) in cones.enumerate() {
            let mut next = now[k].0 + now[k].1;
            if weights != [0.0; 2] {
                next -= weights[0] * (now[k].0 + now[k].1 - before[k].0 - before[k].1);
                if weights[1] != 0.0 {
                    next -= weights[1] * (before[k].0 + before[k].1 - first[k].0 - first[k].1);
                }
            }
            block.shift = next.max(0.0);
        }
        off
    }

    /// s stays where it nearly is its own image, and else is 0, from now on.
    pub(super) fn settle_shifts(&mut self, off: f64) {
        if off > CLOSE_ENOUGH * self.speed() {
            self.blocks.iter_mut().for_each(|block| block.shift = 0.0);
        }
    }
}
