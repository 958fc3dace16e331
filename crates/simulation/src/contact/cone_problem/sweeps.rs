//! Nonlinear Gauss-Seidel sweeps over the contacts: the start of the solution in parts with many contacts.
//!
//! Let W = A M⁻¹Aᵀ. If only its own impulse changes, block b has the velocity c_b + W_bb Δp. With this, its
//! law is a problem of a few numbers: the contact separates, sticks, or slides with c_n = 0 and c_t against
//! p_t. A sweep solves one block after the other **(Jean 1999)**. It needs no factor that couples trees,
//! because M⁻¹Aᵀ of a block has entries at its own trees only. A few sweeps come near the solution, but
//! converge slowly from there. Newton's method, which follows, converges fast near the solution.

use robot_dynamics_number::dispatch::{Call, Hardware, run_here};

use super::ConeProblem;
use super::block::Block;
use super::one_block::{factor_dense, solve_block, solve_dense};
use super::projection::{norm, project};
use super::set::{MOST_ROWS, Set};
use super::sweep_memory::{Places, Sweeps};
use super::tolerances::TOLERANCES;

/// The fewest cones for which sweeps run; with fewer, Newton's method starts directly.
const LEAST_CONES: usize = 8;

impl ConeProblem {
    /// Moves p̄ and s near the solution, if there are many cones. They stay unchanged if they are near it
    /// already, or if the sweeps do not converge.
    pub(super) fn begin_by_sweeps(&mut self) {
        let cones = self.blocks.iter().filter(|block| matches!(block.set, Set::Cone(_))).count();
        if cones < LEAST_CONES {
            return;
        }
        self.choose_softness();
        if self.is_near() {
            return;
        }
        let mut sweeps = core::mem::take(&mut self.sweeps);
        if sweeps.prepare(self) {
            sweeps.multiplier.clone_from(&self.multiplier);
            sweeps.shifts.clear();
            sweeps.shifts.extend(self.blocks.iter().map(|block| block.shift));
            let mut off = f64::INFINITY;
            run_here(Sweep { problem: self, sweeps: &sweeps, off: &mut off });
            // In high stacks the sweeps converge too slowly. With very large friction they may diverge.
            if off.is_nan() || off > TOLERANCES.accepted_sweep_change {
                self.multiplier.clone_from(&sweeps.multiplier);
                self.blocks.iter_mut().zip(&sweeps.shifts).for_each(|(block, shift)| block.shift = *shift);
            }
        }
        self.sweeps = sweeps;
    }

    /// Whether the velocities and p̄ nearly satisfy the laws already. Each block's p̄ is then the projection
    /// of p̄ − (c₀ + s n)/w, where w is the velocity per impulse.
    fn is_near(&mut self) -> bool {
        let Self { blocks, start, multiplier, counted, force, paths, mass, .. } = self;
        if multiplier != counted {
            return false;
        }
        let (mut most, mut speed) = (0.0_f64, f64::MIN_POSITIVE);
        for (k, force) in force.iter().enumerate() {
            most = most.max((force / *paths.diagonal_of(k, mass)).abs());
        }
        for block in blocks {
            let (c, p) = (&start[block.rows.clone()], &multiplier[block.rows.clone()]);
            let moved = block.softness / TOLERANCES.relative_softness;
            let mut next = [0.0; MOST_ROWS];
            let next = &mut next[..p.len()];
            next.iter_mut().zip(p).zip(c).for_each(|((next, p), c)| *next = p - c / moved);
            match block.set {
                Set::Interval(lower, upper) => next[0] = next[0].max(lower).min(upper),
                Set::Cone(slope) => {
                    next[0] -= slope * norm(&c[1..]) / moved;
                    project(slope, next);
                }
            }
            for ((next, p), c) in next.iter().zip(p).zip(c) {
                most = most.max((next - p).abs() * moved);
                speed = speed.max(c.abs()).max(p.abs() * moved);
            }
        }
        most <= TOLERANCES.sweep_change * speed
    }

    /// The entries of a block, row by row.
    fn rows_of(&self, block: &Block) -> impl Iterator<Item = &[f64]> {
        self.entries[block.entries..].chunks_exact(block.support.len().max(1)).take(block.rows.len())
    }

    /// Runs the sweeps. Returns the change in the last one, as a fraction of the largest velocity.
    #[inline(always)]
    fn sweep(&mut self, sweeps: &Sweeps) -> f64 {
        let Self { blocks, support, entries, start, multiplier, counted, force, x, interrupt, .. } = self;
        // x = M⁻¹(Aᵀ(p̄ − counted) − f).
        x.iter_mut().zip(&*force).for_each(|(x, force)| *x = -force);
        sweeps.solve_trees(x);
        for (block, places) in blocks.iter().zip(&sweeps.blocks) {
            for (r, row) in block.rows.clone().enumerate() {
                let counted = counted.get(row).copied().unwrap_or(0.0);
                sweeps.push(places, r, multiplier[row] - counted, x);
            }
        }
        let mut off = f64::INFINITY;
        for _ in 0..TOLERANCES.sweeps {
            if interrupt.is_set() {
                break;
            }
            let (mut most, mut speed) = (0.0_f64, f64::MIN_POSITIVE);
            for (block, places) in blocks.iter_mut().zip(&sweeps.blocks) {
                let support = &support[block.support.clone()];
                let rows = block.rows.len();
                let p = &mut multiplier[block.rows.clone()];
                let inertia = &sweeps.inertia[places.inertia..][..rows * rows];
                let (mut c, mut before) = ([0.0; MOST_ROWS], [0.0; MOST_ROWS]);
                before[..rows].copy_from_slice(p);
                let of_rows = entries[block.entries..].chunks_exact(support.len().max(1));
                for ((c, row), start) in c.iter_mut().zip(of_rows).zip(&start[block.rows.clone()]) {
                    *c = start + support.iter().zip(row).map(|(&k, a)| a * x[k]).sum::<f64>();
                }
                let slip = solve_block(block.set, inertia, &c[..rows], p);
                if let Set::Cone(slope) = block.set {
                    block.shift = slope * slip;
                }
                for r in 0..rows {
                    let change = p[r] - before[r];
                    if change != 0.0 {
                        sweeps.push(places, r, change, x);
                        most = most.max((change * inertia[r * rows + r]).abs());
                    }
                    speed = speed.max(c[r].abs()).max((p[r] * inertia[r * rows + r]).abs());
                }
            }
            off = most / speed;
            if off <= TOLERANCES.sweep_change {
                break;
            }
        }
        off
    }
}

/// `ConeProblem::sweep`.
struct Sweep<'a> {
    problem: &'a mut ConeProblem,
    sweeps: &'a Sweeps,
    off: &'a mut f64,
}

impl Call for Sweep<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        *self.off = self.problem.sweep(self.sweeps);
    }
}

impl Sweeps {
    /// Computes the responses of the blocks. Returns false if M is not positive definite, or a number is not
    /// finite.
    fn prepare(&mut self, problem: &ConeProblem) -> bool {
        if !self.factor_trees(problem) {
            return false;
        }
        for list in [&mut self.responses, &mut self.inertia] {
            list.clear();
        }
        self.block_trees.clear();
        self.blocks.clear();
        for block in &problem.blocks {
            let places = self.add_block(problem, block);
            self.find_responses(problem, block, &places);
            self.find_inertia(problem, block, &places);
            self.blocks.push(places);
        }
        true
    }

    /// Factors M tree by tree. Returns false if it is not positive definite, or a number is not finite.
    fn factor_trees(&mut self, problem: &ConeProblem) -> bool {
        let Self { trees, tree_of, factors, begins, .. } = self;
        tree_of.clear();
        tree_of.resize(problem.n, 0);
        factors.clear();
        begins.clear();
        for (number, tree) in trees.iter().enumerate() {
            tree_of[tree.clone()].fill(number);
            let (size, begin) = (tree.len(), factors.len());
            begins.push(begin);
            factors.resize(begin + size * size, 0.0);
            let factor = &mut factors[begin..];
            for row in tree.clone() {
                let (columns, entries) = problem.paths.entries_of(row, &problem.mass);
                for (&column, entry) in
                    columns.iter().zip(entries).filter(|(column, _)| tree.contains(column))
                {
                    factor[(row - tree.start) * size + column - tree.start] = *entry;
                }
            }
            if !factor_dense(factor, size) {
                return false;
            }
        }
        true
    }

    /// Lists the trees of a block, and makes space for its response and W.
    fn add_block(&mut self, problem: &ConeProblem, block: &Block) -> Places {
        let Self { trees, tree_of, block_trees, responses, inertia, .. } = self;
        let first = block_trees.len();
        for &k in &problem.support[block.support.clone()] {
            if block_trees[first..].last() != Some(&tree_of[k]) {
                block_trees.push(tree_of[k]);
            }
        }
        let width = block_trees[first..].iter().map(|tree| trees[*tree].len()).sum();
        let (rows, response, begin) = (block.rows.len(), responses.len(), inertia.len());
        responses.resize(response + rows * width, 0.0);
        inertia.resize(begin + rows * rows, 0.0);
        Places { trees: first..block_trees.len(), response, width, inertia: begin }
    }

    /// Computes M⁻¹Aᵀ of a block, row by row.
    fn find_responses(&mut self, problem: &ConeProblem, block: &Block, places: &Places) {
        let Self { trees, factors, begins, block_trees, responses, column, .. } = self;
        let own = &problem.support[block.support.clone()];
        for (r, row) in problem.rows_of(block).enumerate() {
            let mut at = places.response + r * places.width;
            let mut next = 0;
            for &tree in &block_trees[places.trees.clone()] {
                let range = trees[tree].clone();
                column.clear();
                column.resize(range.len(), 0.0);
                while next < own.len() && range.contains(&own[next]) {
                    column[own[next] - range.start] = row[next];
                    next += 1;
                }
                solve_dense(&factors[begins[tree]..], column);
                responses[at..at + range.len()].copy_from_slice(column);
                at += range.len();
            }
        }
    }

    /// Computes W = A M⁻¹Aᵀ of a block.
    fn find_inertia(&mut self, problem: &ConeProblem, block: &Block, places: &Places) {
        let Self { trees, block_trees, responses, inertia, .. } = self;
        let (own, rows) = (&problem.support[block.support.clone()], block.rows.len());
        for (i, row) in problem.rows_of(block).enumerate() {
            for j in 0..rows {
                let response = &responses[places.response + j * places.width..][..places.width];
                let (mut at, mut tree, mut sum) = (0, places.trees.start, 0.0);
                for (&k, a) in own.iter().zip(row) {
                    while !trees[block_trees[tree]].contains(&k) {
                        at += trees[block_trees[tree]].len();
                        tree += 1;
                    }
                    sum += a * response[at + k - trees[block_trees[tree]].start];
                }
                inertia[places.inertia + i * rows + j] = sum;
            }
        }
    }

    /// x ← M⁻¹x.
    #[inline(always)]
    fn solve_trees(&self, x: &mut [f64]) {
        for (tree, &begin) in self.trees.iter().zip(&self.begins) {
            solve_dense(&self.factors[begin..], &mut x[tree.clone()]);
        }
    }

    /// Adds the change of x by an impulse on the block's row r.
    #[inline(always)]
    fn push(&self, places: &Places, r: usize, impulse: f64, x: &mut [f64]) {
        let mut response = &self.responses[places.response + r * places.width..][..places.width];
        for &tree in &self.block_trees[places.trees.clone()] {
            let range = self.trees[tree].clone();
            let (own, rest) = response.split_at(range.len());
            x[range].iter_mut().zip(own).for_each(|(x, response)| *x += impulse * response);
            response = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::factorization::sparse::NONE;
    use robot_dynamics_number::SplitMix64;

    use super::*;

    /// Trees of three coordinates: each pair of neighbours has a cone, and each tree a bound.
    fn chain(seed: u64, trees: usize) -> ConeProblem {
        let mut random = SplitMix64::new(seed);
        let n = 3 * trees;
        let mut matrix = vec![0.0; n * n];
        for tree in 0..trees {
            let root: Vec<f64> = (0..9).map(|_| random.uniform(-1.0, 1.0)).collect();
            for i in 0..3 {
                for j in 0..3 {
                    let square: f64 = (0..3).map(|k| root[3 * i + k] * root[3 * j + k]).sum();
                    matrix[(3 * tree + i) * n + 3 * tree + j] = square + if i == j { 0.3 } else { 0.0 };
                }
            }
        }
        let mut problem = ConeProblem::new(n);
        for first in 0..trees - 1 {
            let row = problem.push(Set::Cone(random.uniform(0.1, 0.9)), 3, 3 * first..3 * first + 6);
            problem.last().1.iter_mut().for_each(|entry| *entry = random.uniform(-1.0, 1.0));
            problem.start[row] = random.uniform(-1.0, 0.2);
        }
        for tree in 0..trees {
            let row = problem.push(Set::Interval(0.0, f64::INFINITY), 1, core::iter::once(3 * tree));
            problem.last().1[0] = 1.0;
            problem.start[row] = random.uniform(-0.5, 0.5);
        }
        problem.force.iter_mut().for_each(|force| *force = random.uniform(-1.0, 1.0));
        let dof_parent: Vec<usize> = (0..n).map(|k| k.checked_sub(1).unwrap_or(NONE)).collect();
        problem.set_matrix(&matrix, &dof_parent);
        problem.sweeps.trees = (0..trees).map(|tree| 3 * tree..3 * tree + 3).collect();
        problem
    }

    /// Newton's method has the same solution from there as from 0, in less than half of the steps.
    #[test]
    fn sweeps_lead_near_the_solution() {
        let (mut solved, mut by_sweeps, mut cold) = (0, 0, 0);
        for seed in 0..200 {
            let mut without = chain(seed, 12);
            let mut with = without.clone();
            with.begin_by_sweeps();
            assert!(without.solve_rigid() && with.solve_rigid(), "seed {seed}");
            // In some of the problems Coulomb's law has several solutions, or none is found.
            let is_same = without.x.iter().zip(&with.x).all(|(a, b)| (a - b).abs() < 1e-7 * (1.0 + a.abs()));
            if !(without.is_coulomb && with.is_coulomb && is_same) {
                continue;
            }
            solved += 1;
            (by_sweeps, cold) = (by_sweeps + with.rounds, cold + without.rounds);
        }
        assert!(solved > 100, "{solved} of 200");
        assert!(2 * by_sweeps < cold, "{by_sweeps} Newton steps, {cold} without");
    }

    /// Multipliers that are the solution keep their bits.
    #[test]
    fn the_solution_stays_as_it_is() {
        let mut problem = chain(3, 12);
        assert!(problem.solve_rigid());
        let mut x = vec![0.0; problem.n];
        problem.find_impulses(&mut x);
        // With the forces in `counted`, the velocities are the solution already.
        let found = problem.multiplier.clone();
        let velocity = problem.x.clone();
        problem.force.fill(0.0);
        problem.counted.clone_from(&found);
        problem.add_speeds(&velocity);
        problem.begin_by_sweeps();
        assert_eq!(problem.multiplier, found);
    }
}
