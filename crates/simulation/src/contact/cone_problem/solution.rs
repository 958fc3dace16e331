//! The outer iterations: the method of multipliers, and the search for s.

use super::ConeProblem;
use super::entries::{largest, map, sum};
use super::projection::ProjectionDerivative;
use super::set::Set;
use super::tolerances::TOLERANCES;

/// The convergence of the outer iterations.
#[derive(Clone, Copy, Debug)]
struct Convergence {
    /// The largest speed at the beginning.
    first_speed: f64,
    /// The error of p̄ and of s in the last iteration.
    multiplier_error: f64,
    shift_error: f64,
    /// Consecutive iterations that reduced the error of p̄ by less than half.
    slow: usize,
}

impl Convergence {
    fn new(first_speed: f64) -> Self {
        Self { first_speed, multiplier_error: f64::INFINITY, shift_error: f64::INFINITY, slow: 0 }
    }

    /// Whether this error of p̄ is small enough. Nearly redundant blocks leave an error that decreases only
    /// while their multipliers grow without bound: a larger error is accepted if it decreases slowly.
    fn accepts_multipliers(&mut self, error: f64, speed: f64) -> bool {
        self.slow = if error > 0.5 * self.multiplier_error { self.slow + 1 } else { 0 };
        let stalled = if self.slow >= TOLERANCES.slow_iterations {
            TOLERANCES.slow_multiplier_error
        } else {
            TOLERANCES.stalled_multiplier_error
        };
        let stalls = self.slow > 0 && error <= stalled * self.first_speed;
        error <= TOLERANCES.multiplier_error * speed || stalls
    }
}

impl ConeProblem {
    /// Solves for rigid blocks with Coulomb's law in the cones, with the M that was [set](Self::take). The
    /// result is in `x`, and p in `multiplier`. Returns false if a number is not finite or the solution was
    /// interrupted.
    ///
    /// Rigid bodies with Coulomb's law may have no solution **(Painlevé 1895)**. If s is not found, the
    /// result is that for s = 0.
    pub fn solve_rigid(&mut self) -> bool {
        self.rounds = 0;
        self.choose_softness();
        if self.solve_repeatedly(TOLERANCES.shift_iterations) {
            return true;
        }
        if self.interrupt.is_set() {
            return false;
        }
        // With very large friction, the search for s can overflow.
        self.multiplier.fill(0.0);
        self.blocks.iter_mut().for_each(|block| block.shift = 0.0);
        self.solve_repeatedly(0)
    }

    /// Solves for p̄ by the method of multipliers, and for s in the first `shifts` outer iterations.
    fn solve_repeatedly(&mut self, shifts: usize) -> bool {
        self.is_coulomb = shifts > 0;
        self.begin();
        let mut convergence = Convergence::new(self.speed_with(&self.multiplier));
        self.search.clear();
        if shifts > 0 {
            self.predict_shifts();
        }
        for outer in 0..TOLERANCES.outer_iterations {
            let is_inexact = outer < TOLERANCES.inexact_iterations;
            let Some(is_exact) = self.minimize(outer == 0, is_inexact) else { return false };
            let (speed, error) = (self.speed(), self.multipliers_off());
            let shift_error = self.shift_error(outer, shifts, convergence.shift_error);
            convergence.shift_error = shift_error;
            let is_found = convergence.accepts_multipliers(error, speed) && is_exact;
            let is_found = is_found && shift_error <= self.search.largest_error() * speed;
            if !is_found && outer < shifts {
                self.improve_shifts(shift_error, convergence.multiplier_error, speed);
            }
            convergence.multiplier_error = error;
            self.multiplier.copy_from_slice(&self.p);
            if is_found {
                return true;
            }
            // Recompute c and M x + f before rounding errors accumulate.
            let period = TOLERANCES.recompute_period;
            self.known.is_followed &= outer % period != period - 1;
        }
        true
    }

    /// The error of s after an outer iteration; `last` is the previous error. After the iterations for s, it
    /// is kept or set to 0, and is not compared again.
    fn shift_error(&mut self, outer: usize, shifts: usize, last: f64) -> f64 {
        match outer {
            _ if outer < shifts => self.shifts_off(),
            _ if outer == shifts && shifts > 0 => {
                self.is_coulomb = false;
                self.settle_shifts(last);
                f64::INFINITY
            }
            _ => 0.0,
        }
    }

    /// Updates s, and near the solution also p̄ to the new s.
    fn improve_shifts(&mut self, shift_error: f64, multiplier_error: f64, speed: f64) {
        let by_newton = self.update_shifts(shift_error, multiplier_error);
        if by_newton && shift_error <= TOLERANCES.prediction_range * speed {
            self.follow_x();
            self.evaluate(0.0);
        }
    }

    /// Solves with the softness of each block. The result is in `x`, and p in `multiplier`, which must be 0
    /// at the start.
    ///
    /// Newton's method starts without forces, or from `x` if `warm`.
    pub(crate) fn solve_soft(&mut self, warm: bool) -> bool {
        self.rounds = 0;
        if warm {
            self.make_room();
        } else {
            self.begin();
        }
        let is_settled = self.minimize(false, false);
        self.multiplier.copy_from_slice(&self.p);
        is_settled.is_some()
    }

    /// Sets R from the velocity that a unit impulse on the block's first row causes, by the diagonal of M.
    pub(super) fn choose_softness(&mut self) {
        let Self { blocks, support, entries, paths, mass, .. } = self;
        for block in blocks {
            let support = &support[block.support.clone()];
            let row = &entries[block.entries..block.entries + support.len()];
            let terms = support.iter().zip(row).map(|(&k, a)| a * a / *paths.diagonal_of(k, mass));
            let moved: f64 = terms.sum();
            block.softness = TOLERANCES.relative_softness * if moved > 0.0 { moved } else { 1.0 };
        }
    }

    /// Sets x = M⁻¹(Aᵀ(p̄ − counted) − f), which is the solution if p̄ is. If this is 0, M is not factored.
    fn begin(&mut self) {
        self.make_room();
        let Self { rows, support, multiplier, counted, missing, x, force, .. } = self;
        for (x, force) in x.iter_mut().zip(&*force) {
            *x = -force;
        }
        if multiplier != counted {
            map(missing, [multiplier, counted], |_, [p, counted]| p - counted);
            rows.add_forces(support, missing, x);
        }
        if x.iter().any(|x| *x != 0.0) {
            self.hessian.clone_from(&self.mass);
            self.paths.factor(&mut self.hessian);
            self.paths.solve(&self.hessian, &mut self.x);
            // No block acts yet, so H = M.
            self.known.is_factored = true;
        }
    }

    fn make_room(&mut self) {
        self.arrange();
        let Self { blocks, cones, start, p, c, change, counted, missing, .. } = self;
        let Self { inverses, moved, lower, upper, weights, next, .. } = self;
        for vector in [&mut *p, c, change, counted, missing, inverses, moved, lower, upper, weights, next] {
            vector.resize(start.len(), 0.0);
        }
        for vector in [p, c, change] {
            vector.fill(0.0);
        }
        cones.clear();
        for (index, block) in blocks.iter().enumerate() {
            let (inverse, moves) = (1.0 / block.softness, block.softness / TOLERANCES.relative_softness);
            let (least, most, weight) = match block.set {
                Set::Interval(least, most) => (least, most, 0.0),
                Set::Cone(_) => {
                    cones.push(index);
                    (f64::NEG_INFINITY, f64::INFINITY, inverse)
                }
            };
            for row in block.rows.clone() {
                (inverses[row], moved[row], weights[row]) = (inverse, moves, weight);
                (lower[row], upper[row]) = (least, most);
            }
        }
        self.derivatives.clear();
        self.derivatives.resize(self.cones.len(), ProjectionDerivative::ELSEWHERE);
        self.start_energy = sum([&self.start, &self.moved], |[start, moved]| start * start / moved);
        (self.known.is_factored, self.known.is_followed) = (false, false);
    }

    /// The largest speed in the problem: of the rows, or caused by a multiplier.
    pub(super) fn speed(&self) -> f64 {
        self.speed_with(&self.p)
    }

    fn speed_with(&self, p: &[f64]) -> f64 {
        largest(f64::MIN_POSITIVE, [&self.start, &self.c, p, &self.moved], |[start, c, p, moved]| {
            let of_rows = if c.abs() > start.abs() { c.abs() } else { start.abs() };
            let of_p = p.abs() * moved;
            if of_p > of_rows { of_p } else { of_rows }
        })
    }

    /// The error of p̄, as a speed.
    fn multipliers_off(&self) -> f64 {
        TOLERANCES.relative_softness
            * largest(0.0, [&self.p, &self.multiplier, &self.moved], |[p, before, moved]| {
                (p - before).abs() * moved
            })
    }

    /// Computes c = c₀ + A x and M x + f, unless they are those of x already.
    pub(super) fn follow_x(&mut self) {
        if self.known.is_followed {
            return;
        }
        self.known.is_followed = true;
        if self.x.iter().all(|x| *x == 0.0) {
            self.c.copy_from_slice(&self.start);
            self.residual.copy_from_slice(&self.force);
            return;
        }
        self.rows.multiply(&self.support, &self.x, &mut self.c);
        self.c.iter_mut().zip(&self.start).for_each(|(c, start)| *c += start);
        self.paths.multiply(&self.mass, &self.x, &mut self.residual);
        self.residual.iter_mut().zip(&self.force).for_each(|(residual, force)| *residual += force);
    }
}

#[cfg(test)]
mod tests {
    use robot_dynamics_core::factorization::sparse;
    use robot_dynamics_number::SplitMix64;

    use super::super::entries::dot;
    use super::super::projection::{MultiplierZone, norm, project, project_with_derivative};
    use super::*;

    /// A random M with a few blocks over some of its coordinates.
    fn random_problem(seed: u64, cones: usize, bounds: usize) -> (ConeProblem, Vec<f64>, Vec<usize>) {
        let mut random = SplitMix64::new(seed);
        let n = 3 + (seed % 9) as usize;
        let root: Vec<f64> = (0..n * n).map(|_| random.uniform(-1.0, 1.0)).collect();
        let mut matrix = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                let square: f64 = (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum();
                matrix[i * n + j] = square + if i == j { 0.1 } else { 0.0 };
            }
        }
        let dof_parent: Vec<usize> = (0..n).map(|k| k.checked_sub(1).unwrap_or(sparse::NONE)).collect();
        let mut problem = ConeProblem::new(n);
        for block in 0..cones + bounds {
            let (set, rows) = if block < cones {
                (Set::Cone(random.uniform(0.0, 1.5)), 3)
            } else {
                (Set::Interval(-random.uniform(0.0, 1.0), random.uniform(0.0, 1.0)), 1)
            };
            let first = problem.push(set, rows, 0..n);
            problem.last().1.iter_mut().for_each(|entry| *entry = random.uniform(-1.0, 1.0));
            for row in first..first + rows {
                problem.start[row] = random.uniform(-1.0, 1.0);
            }
        }
        problem.force.iter_mut().for_each(|force| *force = random.uniform(-1.0, 1.0));
        (problem, matrix, dof_parent)
    }

    fn solve_rigid(problem: &mut ConeProblem, matrix: &[f64], dof_parent: &[usize]) -> bool {
        problem.set_matrix(matrix, dof_parent);
        problem.solve_rigid()
    }

    fn solve_soft(problem: &mut ConeProblem, matrix: &[f64], dof_parent: &[usize]) -> bool {
        problem.set_matrix(matrix, dof_parent);
        problem.solve_soft(false)
    }

    /// |M x + f − Aᵀp|, the largest of them.
    fn imbalance(problem: &ConeProblem, matrix: &[f64]) -> f64 {
        let n = problem.n;
        let mut forces = vec![0.0; n];
        problem.add_forces(&problem.multiplier, &mut forces);
        let left = |k: usize| dot(&matrix[k * n..(k + 1) * n], &problem.x) + problem.force[k] - forces[k];
        (0..n).map(|k| left(k).abs()).fold(0.0, f64::max)
    }

    /// Newton's, Signorini's and Coulomb's laws: p in its cone, c_n ≥ 0, p_n c_n = 0, and p_t opposes c_t
    /// with the largest possible magnitude.
    #[test]
    fn solutions_fulfil_the_laws_of_contact() {
        let mut found = 0;
        for seed in 0..300 {
            let (mut problem, matrix, dof_parent) =
                random_problem(seed, 1 + (seed % 3) as usize, (seed % 4) as usize);
            assert!(solve_rigid(&mut problem, &matrix, &dof_parent));
            assert!(imbalance(&problem, &matrix) < 1e-8, "seed {seed}");
            found += usize::from(problem.is_coulomb);
            for block in &problem.blocks {
                let rows = block.rows.clone();
                let (p, c) = (&problem.multiplier[rows.clone()], &problem.c[rows]);
                match block.set {
                    Set::Interval(lower, upper) => {
                        assert!(p[0] >= lower && p[0] <= upper, "seed {seed}");
                        // Stalled blocks leave up to 1e-7 of the speeds, which are about 1.
                        let holds = c[0].abs() < 1e-6
                            || (c[0] > 0.0 && p[0] == lower)
                            || (c[0] < 0.0 && p[0] == upper);
                        assert!(holds, "seed {seed}: c {} p {} of {lower} to {upper}", c[0], p[0]);
                    }
                    Set::Cone(slope) => {
                        let (side, slides) = (norm(&p[1..]), norm(&c[1..]));
                        assert!(p[0] >= 0.0 && side <= slope * p[0] * (1.0 + 1e-12), "seed {seed}");
                        if !problem.is_coulomb {
                            continue;
                        }
                        assert!(
                            c[0] > -1e-6 && p[0] * c[0] < 1e-6,
                            "seed {seed}: p_n {}, c_n {}",
                            p[0],
                            c[0]
                        );
                        // The largest power that a force in the disc can dissipate: −p_t·c_t = μ p_n |c_t|.
                        let power = -dot(&p[1..], &c[1..]);
                        assert!((power - slope * p[0] * slides).abs() < 1e-6, "seed {seed}: {power}");
                    }
                }
            }
        }
        // With friction up to 1.5 and random rows, some problems have no solution.
        assert!(found >= 280, "{found} of 300");
    }

    /// The same laws by an independent route, in the multipliers alone: p ← Π_K(p − ρ(c + μ|c_t|n)) until p
    /// converges. It has no Newton's method, penalty or extrapolation. Returns x if it converges.
    fn by_projections(problem: &ConeProblem, matrix: &[f64], dof_parent: &[usize]) -> Option<Vec<f64>> {
        let (n, rows) = (problem.n, problem.start.len());
        let mut factor = matrix.to_vec();
        sparse::factor(dof_parent, &mut factor);
        let respond = |p: &[f64]| {
            let mut x: Vec<f64> = problem.force.iter().map(|force| -force).collect();
            problem.add_forces(p, &mut x);
            sparse::solve(dof_parent, &factor, &mut x);
            let mut c = Vec::new();
            problem.multiply(&x, &mut c);
            c.iter_mut().zip(&problem.start).for_each(|(c, start)| *c += start);
            (x, c)
        };
        let still = respond(&vec![0.0; rows]).1;
        // |A M⁻¹ Aᵀ| ≤ its trace.
        let trace: f64 = (0..rows)
            .map(|row| {
                let mut unit = vec![0.0; rows];
                unit[row] = 1.0;
                respond(&unit).1[row] - still[row]
            })
            .sum();
        let mut p = vec![0.0; rows];
        for _ in 0..100_000 {
            let (x, c) = respond(&p);
            let mut moved = 0.0_f64;
            for block in &problem.blocks {
                let (rows, mut next) = (block.rows.clone(), Vec::new());
                next.extend(rows.clone().map(|row| p[row] - c[row] / trace));
                match block.set {
                    Set::Interval(lower, upper) => next[0] = next[0].max(lower).min(upper),
                    Set::Cone(slope) => {
                        next[0] -= slope * norm(&c[rows.start + 1..rows.end]) / trace;
                        project(slope, &mut next);
                    }
                }
                for (row, next) in rows.zip(next) {
                    moved = moved.max((next - p[row]).abs());
                    p[row] = next;
                }
            }
            if moved < 1e-13 {
                return Some(x);
            }
        }
        assert!(n > 0);
        None
    }

    #[test]
    fn another_route_finds_the_same() {
        let mut compared = 0;
        for seed in 0..60 {
            let (mut problem, matrix, dof_parent) =
                random_problem(seed, 1 + (seed % 2) as usize, (seed % 3) as usize);
            // With large friction there may be several solutions.
            for block in &mut problem.blocks {
                if let Set::Cone(slope) = &mut block.set {
                    *slope *= 0.2;
                }
            }
            let other = by_projections(&problem, &matrix, &dof_parent);
            assert!(solve_rigid(&mut problem, &matrix, &dof_parent));
            let Some(other) = other.filter(|_| problem.is_coulomb) else { continue };
            compared += 1;
            for (x, other) in problem.x.iter().zip(&other) {
                assert!((x - other).abs() < 1e-5, "seed {seed}: {x}, {other}");
            }
        }
        assert!(compared >= 45, "{compared} of 60");
    }

    /// Newton's step for s is the same by dx/ds of each sliding cone and by one factor for all.
    #[test]
    fn both_ways_to_the_shifts_agree() {
        let mut compared = 0;
        for seed in 0..60 {
            let (mut problem, matrix, dof_parent) = random_problem(seed, 3, 1);
            assert!(solve_rigid(&mut problem, &matrix, &dof_parent));
            // Away from the solution, so that the step is not zero.
            problem.blocks.iter_mut().for_each(|block| block.shift = 1.1 * block.shift + 0.01);
            problem.assemble();
            let slides = |cone: &usize| problem.derivatives[*cone].place == MultiplierZone::Border;
            problem.search.sliding = (0..problem.cones.len()).filter(slides).collect();
            if problem.search.sliding.is_empty() {
                continue;
            }
            problem.find_shifts();
            let one_by_one = problem.search.shifts.clone();
            problem.find_many_shifts();
            compared += 1;
            let most = one_by_one.iter().fold(0.0_f64, |most, shift| most.max(shift.abs()));
            for (shift, other) in one_by_one.iter().zip(&problem.search.shifts) {
                // The condition number of H is about 1/R = 1e5 times that of M.
                assert!((shift - other).abs() < 1e-7 * most, "seed {seed}: {shift} {other}");
            }
        }
        assert!(compared > 20, "{compared}");
    }

    /// A soft block yields by R for each unit of impulse: p is the projection of −c/R.
    #[test]
    fn soft_blocks_yield() {
        for seed in 0..50 {
            let (mut problem, matrix, dof_parent) = random_problem(seed, 2, 2);
            problem.blocks.iter_mut().for_each(|block| block.softness = 0.3);
            assert!(solve_soft(&mut problem, &matrix, &dof_parent));
            assert!(imbalance(&problem, &matrix) < 1e-9, "seed {seed}");
            for block in &problem.blocks {
                let mut p: Vec<f64> = problem.c[block.rows.clone()].iter().map(|c| -c / 0.3).collect();
                match block.set {
                    Set::Interval(lower, upper) => p[0] = p[0].clamp(lower, upper),
                    Set::Cone(slope) => project(slope, &mut p),
                }
                for (p, found) in p.iter().zip(&problem.multiplier[block.rows.clone()]) {
                    assert!((p - found).abs() < 1e-12, "seed {seed}");
                }
            }
        }
    }

    /// The derivative of the projection agrees with differences, in each of its three zones.
    #[test]
    fn derivative_of_the_projection() {
        let mut random = SplitMix64::new(3);
        for _ in 0..100 {
            let slope = random.uniform(0.1, 2.0);
            let at: [f64; 4] = core::array::from_fn(|_| random.uniform(-1.0, 1.0));
            let mut p = at;
            let derivatives = project_with_derivative(slope, &mut p);
            for k in 0..4 {
                let moved = |by: f64| {
                    let mut to = at;
                    to[k] += by;
                    project(slope, &mut to);
                    to
                };
                let (plus, minus) = (moved(1e-6), moved(-1e-6));
                for i in 0..4 {
                    let difference = (plus[i] - minus[i]) / 2e-6;
                    // None of these 100 points is within 1e-6 of the border of a zone.
                    let slope = match derivatives.place {
                        MultiplierZone::Border => derivatives.entry(i, k),
                        MultiplierZone::Interior => f64::from(u8::from(i == k)),
                        MultiplierZone::Elsewhere => 0.0,
                    };
                    assert!((difference - slope).abs() < 1e-7, "{difference} {slope}");
                }
            }
        }
    }
}
