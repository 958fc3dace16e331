//! The shifts s that turn the cones of the convex problem into Coulomb's law.
//!
//! x(s) is the solution for given shifts, and s has to satisfy s = F(s) = μ|c_t(x(s))|. If a contact slides,
//! p is on the border of its cone, and x depends smoothly on s: H dx = −AᵀG n ds/R. Newton's method for s
//! solves this with the known factor once for each sliding contact. If that does not converge, the
//! fixed-point iteration s ← F(s) does, with Anderson's extrapolation over the last three iterates.

use robot_dynamics_core::factorization::paths::WIDTH;

use super::ConeProblem;
use super::block::Block;
use super::entries::dot;
use super::projection::{MultiplierZone, ProjectionDerivative, norm, place_of};
use super::set::Set;
use super::shift_search::ShiftSearch;
use super::tolerances::TOLERANCES;

/// From this number of sliding cones on, one unsymmetric factor of H's size serves all of them.
const LEAST_FOR_COMMON_FACTOR: usize = 64;

impl ConeProblem {
    /// Sets s = μ|c_t| at the x that p̄ causes, where p̄ slides: sliding contacts are expected to continue.
    pub(super) fn predict_shifts(&mut self) {
        self.follow_x();
        let Self { blocks, multiplier, c, .. } = self;
        for block in blocks {
            if let Set::Cone(slope) = block.set
                && place_of(block.set, &multiplier[block.rows.clone()]) == MultiplierZone::Border
            {
                block.shift = slope * norm(&c[block.rows.start + 1..block.rows.end]);
            }
        }
    }

    /// The error of s: its largest distance from μ|c_t|.
    pub(super) fn shifts_off(&self) -> f64 {
        let Self { blocks, cones, derivatives, c, .. } = self;
        let ways = cones
            .iter()
            .zip(derivatives)
            .filter_map(|(b, derivatives)| way_to_image(&blocks[*b], derivatives, c));
        ways.fold(0.0, |most, way| way.abs().max(most))
    }

    /// Updates s, whose error is `off`. Returns whether Newton's method found it; then x is updated as well.
    /// Newton's method has failed if the error is not halved, unless it is below `by_multipliers`, the error
    /// of p̄, which affects c_t.
    pub(super) fn update_shifts(&mut self, off: f64, by_multipliers: f64) -> bool {
        let search = &mut self.search;
        if search.by_images > 0 {
            search.by_images -= 1;
        } else if off >= (0.5 * search.off).max(by_multipliers) {
            // Newton's method does not converge.
            (search.by_images, search.images) = (search.images, 2 * search.images);
        }
        // The next Newton step is not compared with the last fixed-point iterate.
        search.off = if search.by_images > 0 { f64::INFINITY } else { off };
        if off == 0.0 {
            return false;
        }
        let follows = search.by_images == 0 && self.newton_shifts();
        if !follows {
            self.extrapolate_shifts();
        }
        follows
    }

    /// Takes one step of Newton's method for s. Returns false if no contact slides or the result is not
    /// finite.
    fn newton_shifts(&mut self) -> bool {
        if !self.known.is_fresh {
            self.assemble();
        }
        let Self { cones, derivatives, search, .. } = self;
        search.sliding.clear();
        search
            .sliding
            .extend((0..cones.len()).filter(|cone| derivatives[*cone].place == MultiplierZone::Border));
        match search.sliding.len() {
            0 => return false,
            LEAST_FOR_COMMON_FACTOR.. => self.find_many_shifts(),
            _ => self.find_shifts(),
        }
        if !self.search.shifts.iter().all(|shift| shift.is_finite()) {
            return false;
        }
        self.apply_shifts();
        true
    }

    /// Computes ds of the sliding cones into the search's `shifts`, by dx/ds of each.
    pub(super) fn find_shifts(&mut self) {
        let Self { n, blocks, cones, support, entries, derivatives, c, hessian, paths, search, .. } = self;
        let n = *n;
        let ShiftSearch { sliding, ways, derivatives: matrix, shifts, .. } = search;
        let count = sliding.len();
        let rows_of = |block: &Block| {
            let support = &support[block.support.clone()];
            (
                support,
                entries[block.entries..][..support.len() * block.rows.len()].chunks_exact(support.len()),
            )
        };
        ways.clear();
        ways.resize(count.div_ceil(WIDTH) * n, [0.0; WIDTH]);
        for (sliding, ways) in sliding.chunks(WIDTH).zip(ways.chunks_exact_mut(n)) {
            for (lane, &cone) in sliding.iter().enumerate() {
                let block = &blocks[cones[cone]];
                let (support, rows) = rows_of(block);
                for (i, row) in rows.enumerate() {
                    let pull = -derivatives[cone].by_normal(i) / block.softness;
                    support.iter().zip(row).for_each(|(&k, a)| ways[k][lane] += pull * a);
                }
            }
            paths.solve_four(hessian, ways);
        }
        matrix.clear();
        shifts.clear();
        for (i, &cone) in sliding.iter().enumerate() {
            let block = &blocks[cones[cone]];
            let Set::Cone(friction) = block.set else { continue };
            let side = &c[block.rows.start + 1..block.rows.end];
            let speed = norm(side);
            let (support, rows) = rows_of(block);
            for ways in ways.chunks_exact(n) {
                let mut change = [0.0; WIDTH];
                for (row, c) in rows.clone().skip(1).zip(side) {
                    for (&k, a) in support.iter().zip(row) {
                        change = core::array::from_fn(|lane| change[lane] + a * c * ways[k][lane]);
                    }
                }
                matrix.extend(change.map(|change| friction * change / speed));
            }
            matrix.truncate((i + 1) * count);
            matrix[i * count + i] -= 1.0;
            shifts.push(block.shift - friction * speed);
        }
        eliminate(matrix, shifts);
    }

    /// Adds the changes to the shifts, and moves x with them.
    fn apply_shifts(&mut self) {
        let Self { n, blocks, cones, derivatives, c, x, search, .. } = self;
        let ShiftSearch { past, sliding, ways, shifts, .. } = search;
        past.iter_mut().for_each(Vec::clear);
        self.known.is_followed = false;
        let mut next = sliding.iter().zip(&mut *shifts).peekable();
        for (cone, (&b, derivatives)) in cones.iter().zip(&*derivatives).enumerate() {
            let block = &mut blocks[b];
            let Some(way) = way_to_image(block, derivatives, c) else { continue };
            match next.next_if(|(sliding, _)| **sliding == cone) {
                Some((_, shift)) => {
                    *shift = shift.max(-block.shift);
                    block.shift += *shift;
                }
                None => block.shift += way,
            }
        }
        if sliding.len() >= LEAST_FOR_COMMON_FACTOR {
            self.follow_many_shifts();
            return;
        }
        for (shifts, ways) in shifts.chunks(WIDTH).zip(ways.chunks_exact(*n)) {
            for (x, ways) in x.iter_mut().zip(ways) {
                *x += shifts.iter().zip(ways).map(|(shift, way)| shift * way).sum::<f64>();
            }
        }
    }

    /// Takes a fixed-point step s ← μ|c_t|, with Anderson's extrapolation over the last three iterates.
    fn extrapolate_shifts(&mut self) {
        let Self { blocks, cones, derivatives, c, search, .. } = self;
        // This iterate and the two before it: s and F(s) − s.
        search.past.rotate_right(1);
        let [now, before, first] = &mut search.past;
        now.clear();
        let ways = cones.iter().zip(&*derivatives).map(|(b, derivatives)| (&blocks[*b], derivatives));
        now.extend(
            ways.filter_map(|(block, derivatives)| Some((block.shift, way_to_image(block, derivatives, c)?))),
        );
        // The combination of the differences of F(s) − s that is nearest to the last one.
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
            if determinant > TOLERANCES.extrapolation_determinant * square * second {
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
    }

    /// Keeps s if its error is small, and sets it to 0 otherwise.
    pub(super) fn settle_shifts(&mut self, off: f64) {
        if off > TOLERANCES.accepted_shift_error * self.speed() {
            self.blocks.iter_mut().for_each(|block| block.shift = 0.0);
        }
    }
}

/// μ|c_t| − s of a cone. It is −s if the contact sticks, because its c_t is an error of p̄.
fn way_to_image(block: &Block, derivatives: &ProjectionDerivative, c: &[f64]) -> Option<f64> {
    let Set::Cone(slope) = block.set else { return None };
    let sticks = derivatives.place == MultiplierZone::Interior;
    let speed = if sticks { 0.0 } else { norm(&c[block.rows.start + 1..block.rows.end]) };
    Some(slope * speed - block.shift)
}

/// b ← A⁻¹b by Gaussian elimination with partial pivoting. Overwrites the square, row-major A. The result is
/// not finite if A is singular.
fn eliminate(a: &mut [f64], b: &mut [f64]) {
    let n = b.len();
    for k in 0..n {
        let largest = (k..n).max_by(|&i, &j| a[i * n + k].abs().total_cmp(&a[j * n + k].abs())).unwrap_or(k);
        b.swap(k, largest);
        (0..n).for_each(|j| a.swap(k * n + j, largest * n + j));
        for i in k + 1..n {
            let factor = a[i * n + k] / a[k * n + k];
            for j in k..n {
                a[i * n + j] -= factor * a[k * n + j];
            }
            b[i] -= factor * b[k];
        }
    }
    for k in (0..n).rev() {
        let known = dot(&a[k * n + k + 1..(k + 1) * n], &b[k + 1..]);
        b[k] = (b[k] - known) / a[k * n + k];
    }
}
