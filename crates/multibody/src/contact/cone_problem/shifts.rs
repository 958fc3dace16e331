//! The shifts s that make the convex problem's cones Coulomb's law.
//!
//! With x(s) the solution for given shifts, s is to be F(s) = μ|c_t(x(s))|. A cone whose contact slides has p on its border, and there
//! x depends smoothly on s: H dx = −AᵀG n ds/R, of which Newton's method for s needs one solution with the known factor for each such
//! cone. Where that does not come nearer, Anderson's extrapolation over the last three of the images does.

use super::entries::dot;
use super::many_shifts::Many;
use super::projection::{Place, Slopes, norm, place_of};
use super::{Block, ConeProblem, Set};
use crate::clone_in_place::clone_in_place;
use crate::factor::paths::{Four, WIDTH};

/// How near s must be to be kept where the search for it ends.
const CLOSE_ENOUGH: f64 = 1e-3;

/// How often the images lead on where Newton's method does not come nearer, as some contact begins to slide or to stick; twice as often each time.
const IMAGES: usize = 3;

/// From so many sliding cones on their s are found with a factor of H's size, which does not grow with them.
const MANY: usize = 64;

clone_in_place! {
    /// Memory of the search for s.
    #[derive(Debug)]
    pub(super) struct Search {
        /// For each cone s, and from there the way to μ|c_t|, the last three times.
        past: [Vec<(f64, f64)>; 3],
        /// The cones that slide, by their numbers among the cones.
        pub(super) sliding: Vec<usize>,
        /// dx/ds of each, for four of them side by side.
        ways: Vec<Four>,
        /// ∂F/∂s − 1, and what is to be added to s.
        slopes: Vec<f64>,
        pub(super) shifts: Vec<f64>,
        pub(super) many: Many,
        /// How far s was from its image the last time.
        off: f64,
        /// How many more times the images lead on, before Newton's method is tried again.
        by_images: usize,
        /// And the next time.
        images: usize,
    }
}

impl Search {
    /// With room for n coordinates and 32 cones that slide.
    pub(super) fn new(n: usize) -> Self {
        Self {
            past: core::array::from_fn(|_| Vec::with_capacity(32)),
            sliding: Vec::with_capacity(32),
            ways: Vec::with_capacity(32 / WIDTH * n),
            slopes: Vec::with_capacity(32 * 32 + WIDTH),
            shifts: Vec::with_capacity(32),
            many: Many::default(),
            off: f64::INFINITY,
            by_images: 0,
            images: IMAGES,
        }
    }

    /// Whether Newton's method is at work.
    pub(super) fn by_newton(&self) -> bool {
        self.by_images == 0
    }

    pub(super) fn clear(&mut self) {
        self.past.iter_mut().for_each(Vec::clear);
        (self.off, self.by_images, self.images) = (f64::INFINITY, 0, IMAGES);
    }
}

impl ConeProblem {
    /// s = μ|c_t| of the x that p̄ leads to, where p̄ slides: what slid goes on, a little slower or faster.
    pub(super) fn predict_shifts(&mut self) {
        self.follow_x();
        let Self { blocks, multiplier, c, .. } = self;
        for block in blocks {
            if let Set::Cone(slope) = block.set
                && place_of(block.set, &multiplier[block.rows.clone()]) == Place::Border
            {
                block.shift = slope * norm(&c[block.rows.start + 1..block.rows.end]);
            }
        }
    }

    /// How far s is from μ|c_t|.
    pub(super) fn shifts_off(&self) -> f64 {
        let Self { blocks, cones, slopes, c, .. } = self;
        let ways = cones.iter().zip(slopes).filter_map(|(b, slopes)| way_to_image(&blocks[*b], slopes, c));
        ways.fold(0.0, |most, way| way.abs().max(most))
    }

    /// Other s, nearer to μ|c_t| of its solution, from which they were so far `off`; with Newton's method x that follows, true then. By so much as p̄ was off,
    /// c_t may have changed beside.
    pub(super) fn update_shifts(&mut self, off: f64, by_multipliers: f64) -> bool {
        let search = &mut self.search;
        if search.by_images > 0 {
            search.by_images -= 1;
        } else if off >= (0.5 * search.off).max(by_multipliers) {
            // Newton's method does not come nearer.
            (search.by_images, search.images) = (search.images, 2 * search.images);
        }
        // Where it is tried again it need not be nearer than where the images ended.
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

    /// One step of Newton's method for s; false where none slides, or nothing follows.
    fn newton_shifts(&mut self) -> bool {
        if !self.known.is_fresh {
            self.assemble();
        }
        let Self { cones, slopes, search, .. } = self;
        search.sliding.clear();
        search.sliding.extend((0..cones.len()).filter(|cone| slopes[*cone].place == Place::Border));
        match search.sliding.len() {
            0 => return false,
            MANY.. => self.find_many_shifts(),
            _ => self.find_shifts(),
        }
        if !self.search.shifts.iter().all(|shift| shift.is_finite()) {
            return false;
        }
        self.apply_shifts();
        true
    }

    /// ds of the cones that slide to the search's `shifts`, by dx/ds of each.
    pub(super) fn find_shifts(&mut self) {
        let Self { n, blocks, cones, support, entries, slopes, c, hessian, paths, search, .. } = self;
        let n = *n;
        let Search { sliding, ways, slopes: matrix, shifts, .. } = search;
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
                    let pull = -slopes[cone].by_normal(i) / block.softness;
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

    /// Adds what was found to the shifts, and moves x with them.
    fn apply_shifts(&mut self) {
        let Self { n, blocks, cones, slopes, c, x, search, .. } = self;
        let Search { past, sliding, ways, shifts, .. } = search;
        past.iter_mut().for_each(Vec::clear);
        self.known.is_followed = false;
        let mut next = sliding.iter().zip(&mut *shifts).peekable();
        for (cone, (&b, slopes)) in cones.iter().zip(&*slopes).enumerate() {
            let block = &mut blocks[b];
            let Some(way) = way_to_image(block, slopes, c) else { continue };
            match next.next_if(|(sliding, _)| **sliding == cone) {
                Some((_, shift)) => {
                    *shift = shift.max(-block.shift);
                    block.shift += *shift;
                }
                None => block.shift += way,
            }
        }
        if sliding.len() >= MANY {
            self.follow_many_shifts();
            return;
        }
        for (shifts, ways) in shifts.chunks(WIDTH).zip(ways.chunks_exact(*n)) {
            for (x, ways) in x.iter_mut().zip(ways) {
                *x += shifts.iter().zip(ways).map(|(shift, way)| shift * way).sum::<f64>();
            }
        }
    }

    /// s ← μ|c_t| of the cones, by Anderson's extrapolation over the last three of them.
    fn extrapolate_shifts(&mut self) {
        let Self { blocks, cones, slopes, c, search, .. } = self;
        // This and the two before: s, then the way to its image.
        search.past.rotate_right(1);
        let [now, before, first] = &mut search.past;
        now.clear();
        let ways = cones.iter().zip(&*slopes).map(|(b, slopes)| (&blocks[*b], slopes));
        now.extend(ways.filter_map(|(block, slopes)| Some((block.shift, way_to_image(block, slopes, c)?))));
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
    }

    /// s stays where it nearly is its own image, and else is 0, from now on.
    pub(super) fn settle_shifts(&mut self, off: f64) {
        if off > CLOSE_ENOUGH * self.speed() {
            self.blocks.iter_mut().for_each(|block| block.shift = 0.0);
        }
    }
}

/// μ|c_t| − s of a cone; −s where it sticks, as c_t is what the multipliers have not yet taken out.
fn way_to_image(block: &Block, slopes: &Slopes, c: &[f64]) -> Option<f64> {
    let Set::Cone(slope) = block.set else { return None };
    let sticks = slopes.place == Place::Within;
    let speed = if sticks { 0.0 } else { norm(&c[block.rows.start + 1..block.rows.end]) };
    Some(slope * speed - block.shift)
}

/// b ← A⁻¹b, row by row with the largest pivots; A, square and row-major, is overwritten. Not finite where A is singular.
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
