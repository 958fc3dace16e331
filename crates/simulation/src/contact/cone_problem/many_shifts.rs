//! Newton's method for the shifts of many sliding cones at once.
//!
//! Let U = ∂(μ|c_t|)/∂x and V = −AᵀG n/R of the sliding cones. The system (U H⁻¹V − 1) ds = s − μ|c_t| has as
//! many unknowns as there are sliding cones. With dx = H⁻¹V ds it becomes (H − V U) dx = −V (s − μ|c_t|) and
//! ds = U dx − (s − μ|c_t|). This unsymmetric matrix has the zeros of H, and its size does not depend on the
//! number of sliding cones.

use robot_dynamics_number::dispatch::run_here;

use super::ConeProblem;
use super::hessian::Add;
use super::projection::norm;
use super::set::Set;
use super::shift_search::UnsymmetricFactorMemory;

impl ConeProblem {
    /// Computes ds of the sliding cones into the search's `shifts`.
    pub(super) fn find_many_shifts(&mut self) {
        self.assemble_common_matrix();
        self.add_sliding_cones();
        let Self { blocks, cones, support, paths, search, .. } = self;
        let UnsymmetricFactorMemory { lower, upper, turns, way, .. } = &mut search.many;
        paths.factor_unsymmetric(lower, upper);
        paths.solve_unsymmetric(lower, upper, way);
        let mut next = 0;
        for (&cone, shift) in search.sliding.iter().zip(&mut search.shifts) {
            let support = &support[blocks[cones[cone]].support.clone()];
            let turn = &turns[next..next + support.len()];
            *shift = turn.iter().zip(support).map(|(turn, &k)| turn * way[k]).sum::<f64>() - *shift;
            next += support.len();
        }
    }

    /// Computes H into both triangles, and clears the other vectors.
    fn assemble_common_matrix(&mut self) {
        let Self {
            blocks, cones, support, rows, mass, weighted, weights, derivatives, paths, search, ..
        } = self;
        let UnsymmetricFactorMemory { lower, upper, pulls, turns, way } = &mut search.many;
        lower.clone_from(mass);
        run_here(Add { blocks, cones, derivatives, weights, support, rows, paths, matrix: lower, weighted });
        upper.clone_from(lower);
        pulls.clear();
        turns.clear();
        way.clear();
        way.resize(self.n, 0.0);
        search.shifts.clear();
    }

    /// Adds −V U of the sliding cones to the triangles, and computes −V (s − μ|c_t|) into `way`.
    fn add_sliding_cones(&mut self) {
        let Self { blocks, cones, support, entries, derivatives, paths, c, search, .. } = self;
        let UnsymmetricFactorMemory { lower, upper, pulls, turns, way } = &mut search.many;
        for &cone in &search.sliding {
            let (block, derivatives) = (&blocks[cones[cone]], &derivatives[cone]);
            let Set::Cone(friction) = block.set else { continue };
            let (support, c) = (&support[block.support.clone()], &c[block.rows.clone()]);
            let (count, begin) = (support.len(), pulls.len());
            let speed = norm(&c[1..]);
            pulls.resize(begin + count, 0.0);
            turns.resize(begin + count, 0.0);
            let (pull, turn) = (&mut pulls[begin..], &mut turns[begin..]);
            let a = entries[block.entries..][..count * c.len()].chunks_exact(count.max(1));
            for (i, (row, c)) in a.zip(c).enumerate() {
                let by_normal = derivatives.by_normal(i) / block.softness;
                pull.iter_mut().zip(row).for_each(|(pull, a)| *pull += by_normal * a);
                if i > 0 {
                    let part = friction * c / speed;
                    turn.iter_mut().zip(row).for_each(|(turn, a)| *turn += part * a);
                }
            }
            let off = block.shift - friction * speed;
            search.shifts.push(off);
            for (i, &row) in support.iter().enumerate() {
                way[row] += pull[i] * off;
                let own = paths.row_of(row, lower);
                for (turn, &column) in turn[..=i].iter().zip(support) {
                    own[paths.depth(column)] += pull[i] * turn;
                }
                let own = paths.row_of(row, upper);
                for (pull, &column) in pull[..i].iter().zip(support) {
                    own[paths.depth(column)] += pull * turn[i];
                }
            }
        }
    }

    /// Moves x by these changes of the shifts, with the known factor of H.
    pub(super) fn follow_many_shifts(&mut self) {
        let Self { blocks, cones, support, hessian, paths, x, search, .. } = self;
        let UnsymmetricFactorMemory { pulls, way, .. } = &mut search.many;
        way.fill(0.0);
        let mut next = 0;
        for (&cone, shift) in search.sliding.iter().zip(&search.shifts) {
            let support = &support[blocks[cones[cone]].support.clone()];
            let pull = &pulls[next..next + support.len()];
            support.iter().zip(pull).for_each(|(&k, pull)| way[k] -= pull * shift);
            next += support.len();
        }
        paths.solve(hessian, way);
        x.iter_mut().zip(way).for_each(|(x, way)| *x += *way);
    }
}
