//! Newton's method, and the repetitions around it.

use number::dispatch::{Call, Hardware, run_here};

use super::entries::{dot, largest, map, sum};
use super::projection::{Place, Slopes};
use super::square::Add;
use super::{ConeProblem, Set};

/// Most solutions with another p̄ and s, and most Newton steps in one of them.
const MOST_OUTER: usize = 60;
const MOST_INNER: usize = 60;

/// R as a part of what an impulse on the block changes: little, so that p̄ is soon found, and more than rounding.
pub(super) const YIELD: f64 = 1e-5;

/// How nearly p̄ and s have to be found, as a part of the speeds in the problem.
const CLOSE: f64 = 1e-11;

/// Where p̄ comes nearer by less than half, and where it has done so for many times, as a part of the speeds that there were at the beginning:
/// multipliers that grow without end do not count.
const STALLED: f64 = 1e-7;
const STALLED_FOR_LONG: f64 = 1e-6;
const LONG: usize = 4;
const CLOSE_SHIFT: f64 = 1e-10;
const CLOSE_SHIFT_BY_IMAGES: f64 = 1e-9;

/// From no further away than this p̄ follows s, as p does: as far as slopes lead.
const NEARBY: f64 = 1e-3;

/// The part of the energy that a step may gain which changes no digit that counts.
const SETTLED: f64 = 1e-22;

/// A step by another round's factor leaves a part of what it was to take: it has to gain that much less.
const STALE: f64 = 1e-3;

/// Where p̄ and s are to be found yet, a step that gains this part of what the first one gained is the last one.
const LOOSE: f64 = 1e-6;
const LOOSEST: f64 = 1e-12;

/// A factor is fresh until a step gains more than this part of the energy: the slopes that Newton's method for s has from it then are off by the root.
const NEAR: f64 = 1e-10;

/// So many solutions may end before their last digit.
const HASTY: usize = 8;

/// Where a step gains less than this part of the last one, the last factor is good for it, too.
const FAST: f64 = 1e-4;

/// What the next step by a fresh factor gains at most, as a part of what this one does; and what that has to be, by any factor, to be believed.
const FRESH: f64 = 1e-5;
const FEW: f64 = 1e-3;

/// How often s is looked for.
const SHIFTS: usize = 30;

impl ConeProblem {
    /// Solves with nothing yielding and Coulomb's law in the cones: x, and p in `multiplier`, of the M that was [taken](Self::take). False where a
    /// number is not finite, or the solution was interrupted.
    ///
    /// Where s is not found, as Coulomb's law with rigid bodies may have no solution **(Painlevé 1895)**, the answer is that for s = 0.
    pub(crate) fn solve_rigid(&mut self) -> bool {
        self.rounds = 0;
        self.choose_softness();
        if self.solve_repeatedly(SHIFTS) {
            return true;
        }
        if self.interrupt.is_set() {
            return false;
        }
        // With very large friction the search for s can leave the numbers that there are.
        self.multiplier.fill(0.0);
        self.blocks.iter_mut().for_each(|block| block.shift = 0.0);
        self.solve_repeatedly(0)
    }

    /// Looks for s in so many of the solutions.
    fn solve_repeatedly(&mut self, shifts: usize) -> bool {
        self.is_coulomb = shifts > 0;
        self.begin();
        let (mut off_before, mut left, mut slow) = (f64::INFINITY, f64::INFINITY, 0);
        let first = self.speed_with(&self.multiplier);
        self.search.clear();
        if shifts > 0 {
            self.predict_shifts();
        }
        for outer in 0..MOST_OUTER {
            let Some(is_settled) = self.minimize(outer == 0, outer < HASTY) else { return false };
            let speed = self.speed();
            let off = self.multipliers_off();
            let off_shift = match outer {
                _ if outer < shifts => self.shifts_off(),
                _ if outer == shifts && shifts > 0 => {
                    self.is_coulomb = false;
                    self.settle_shifts(left);
                    f64::INFINITY
                }
                _ => 0.0,
            };
            left = off_shift;
            // Blocks that say nearly the same leave a little that shrinks only as their multipliers grow without end.
            slow = if off > 0.5 * off_before { slow + 1 } else { 0 };
            let stalled = if slow >= LONG { STALLED_FOR_LONG } else { STALLED };
            let stalls = slow > 0 && off <= stalled * first;
            let close = if self.search.by_newton() { CLOSE_SHIFT } else { CLOSE_SHIFT_BY_IMAGES };
            let is_found = is_settled && (off <= CLOSE * speed || stalls) && off_shift <= close * speed;
            if !is_found
                && outer < shifts
                && self.update_shifts(off_shift, off_before)
                && off_shift <= NEARBY * speed
            {
                // p̄ follows s.
                self.follow_x();
                self.evaluate(0.0);
            }
            off_before = off;
            self.multiplier.copy_from_slice(&self.p);
            if is_found {
                return true;
            }
            // Before roundings add up.
            self.known.is_followed &= outer % 4 != 3;
        }
        true
    }

    /// Solves as it is, each block with the softness that it has: x, and p in `multiplier`, which begins with 0.
    ///
    /// Newton's method starts without forces, or from `x` where that is `warm`.
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

    /// R from what the block's first row moves, by the diagonal of M.
    pub(super) fn choose_softness(&mut self) {
        let Self { blocks, support, entries, paths, mass, .. } = self;
        for block in blocks {
            let support = &support[block.support.clone()];
            let row = &entries[block.entries..block.entries + support.len()];
            let terms = support.iter().zip(row).map(|(&k, a)| a * a / *paths.diagonal_of(k, mass));
            let moved: f64 = terms.sum();
            block.softness = YIELD * if moved > 0.0 { moved } else { 1.0 };
        }
    }

    /// x = M⁻¹(Aᵀp̄ − f): right at once where the last step's multipliers are. Where these act already and nothing else does, x = 0 without a factor.
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
            // So far none acts.
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
            let (inverse, moves) = (1.0 / block.softness, block.softness / YIELD);
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
        self.slopes.clear();
        self.slopes.resize(self.cones.len(), Slopes::ELSEWHERE);
        self.start_energy = sum([&self.start, &self.moved], |[start, moved]| start * start / moved);
        (self.known.is_factored, self.known.is_followed) = (false, false);
    }

    /// The largest speed there is, or that a multiplier gives.
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

    /// How far p̄ is from p, as a speed.
    fn multipliers_off(&self) -> f64 {
        YIELD
            * largest(0.0, [&self.p, &self.multiplier, &self.moved], |[p, before, moved]| {
                (p - before).abs() * moved
            })
    }

    /// c = c₀ + A x and M x + f, unless they are known.
    pub(super) fn follow_x(&mut self) {
        if self.known.is_followed {
            return;
        }
        self.known.is_followed = true;
        if self.x.iter().all(|x| *x == 0.0) {
            self.c.copy_from_slice(&self.start);
            self.drag.copy_from_slice(&self.force);
            return;
        }
        self.rows.multiply(&self.support, &self.x, &mut self.c);
        self.c.iter_mut().zip(&self.start).for_each(|(c, start)| *c += start);
        self.paths.multiply(&self.mass, &self.x, &mut self.drag);
        self.drag.iter_mut().zip(&self.force).for_each(|(drag, force)| *drag += force);
    }

    /// Newton's method from x, with p̄ and s as they are. Whether the last digit that counts is found; with `is_loose`, as p̄ and s are to
    /// change, it ends before that. `None` where a number is not finite, or the solution was interrupted.
    fn minimize(&mut self, first: bool, is_loose: bool) -> Option<bool> {
        let (mut fall_before, mut tolerance, mut is_settled) = (f64::INFINITY, SETTLED, false);
        self.follow_x();
        let mut acts_as_before = self.respond(0.0, first);
        for round in 0..MOST_INNER {
            if self.interrupt.is_set() {
                return None;
            }
            self.rounds += 1;
            let energy = self.find_slope();
            // Where every block acts as it did the last factor shows whether anything is left to do.
            let (mut stale, mut fall) = (STALE, f64::INFINITY);
            if acts_as_before {
                fall = self.find_step();
            }
            // The part of what this step gains that the next one will: by a factor of earlier rounds as much as it left the last time.
            let mut leaves = if self.known.is_fresh { FRESH } else { 1.0 };
            if fall_before.is_finite() {
                leaves = leaves.min(fall / fall_before);
            }
            let is_good = fall <= STALE * tolerance * energy || (is_loose && fall <= FAST * fall_before);
            if !(acts_as_before && is_good) {
                self.assemble();
                fall = self.find_step();
                // Slopes change by what a step changes of p, 1/R times that of c.
                (stale, leaves) = (1.0, fall / (YIELD * energy));
            }
            if !fall.is_finite() {
                return None;
            }
            fall_before = fall;
            self.known.is_fresh &= fall <= NEAR * energy;
            if is_loose && round == 0 {
                tolerance = if first { LOOSEST } else { (LOOSE * fall / energy).clamp(SETTLED, LOOSEST) };
            }
            let bend = self.follow();
            let (is_begun, energy) = (!(first && round == 0), energy + bend);
            // A step that changes no digit that counts.
            let gains_less_than = |part: f64| fall <= stale * part * energy + f64::MIN_POSITIVE;
            is_settled = gains_less_than(SETTLED);
            if is_begun && gains_less_than(tolerance) {
                self.go(1.0);
                self.evaluate(0.0);
                break;
            }
            // Or after which the next one would.
            if is_begun && leaves <= FEW && leaves * fall <= tolerance * energy {
                if self.respond(1.0, false) {
                    self.go(1.0);
                    is_settled = leaves * fall <= SETTLED * energy;
                    break;
                }
                self.known.is_factored = false;
            }
            acts_as_before = self.go_down(bend, fall, is_begun);
            // Where every block acts as in the factor and none slides the value is of second degree, and this its least.
            is_settled = acts_as_before && self.slopes.iter().all(|slopes| slopes.place != Place::Border);
            if is_loose && is_settled {
                break;
            }
        }
        Some(is_settled)
    }

    /// −(M x + f − Aᵀp) to `slope`; about the energy that the multipliers move, and that there is to be moved.
    fn find_slope(&mut self) -> f64 {
        let mut energy = self.start_energy;
        run_here(FindSlope { problem: self, energy: &mut energy });
        self.rows.add_forces(&self.support, &self.missing, &mut self.slope);
        energy
    }

    /// x, c and M x + f that much further along δ.
    pub(super) fn go(&mut self, length: f64) {
        run_here(Go { problem: self, length });
    }

    /// δ = H⁻¹ slope, and how much the value falls along it.
    fn find_step(&mut self) -> f64 {
        self.step.copy_from_slice(&self.slope);
        self.paths.solve(&self.hessian, &mut self.step);
        dot(&self.slope, &self.step)
    }

    /// A δ to `change`, M δ to `slope`; δᵀM δ.
    fn follow(&mut self) -> f64 {
        self.rows.multiply(&self.support, &self.step, &mut self.change);
        self.paths.multiply(&self.mass, &self.step, &mut self.slope);
        dot(&self.slope, &self.step)
    }

    /// H, factored.
    pub(super) fn assemble(&mut self) {
        let Self { blocks, cones, support, rows, mass, hessian, weighted, weights, slopes, paths, .. } = self;
        hessian.clone_from(mass);
        run_here(Add { blocks, cones, slopes, weights, support, rows, paths, matrix: hessian, weighted });
        paths.factor(hessian);
        self.known.is_factored = true;
        self.known.is_fresh = true;
    }
}

/// `ConeProblem::find_slope`, but for Aᵀp.
struct FindSlope<'a> {
    problem: &'a mut ConeProblem,
    energy: &'a mut f64,
}

impl Call for FindSlope<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let ConeProblem { slope, drag, missing, p, counted, moved, .. } = self.problem;
        map(slope, [drag], |_, [drag]| -drag);
        map(missing, [p, counted], |_, [p, counted]| p - counted);
        *self.energy += sum([p, moved], |[p, moved]| p * p * moved);
    }
}

/// [`ConeProblem::go`].
struct Go<'a> {
    problem: &'a mut ConeProblem,
    length: f64,
}

impl Call for Go<'_> {
    #[inline(always)]
    fn call<H: Hardware>(self) {
        let ConeProblem { x, step, c, change, drag, slope, .. } = self.problem;
        for (to, along) in [(x, step), (c, change), (drag, slope)] {
            map(to, [along], |to, [along]| to + self.length * along);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::projection::{norm, project, project_with_slopes};
    use super::*;
    use crate::factor::sparse;
    use crate::oracle::admm;
    use dynamics::SplitMix64;

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
        let carrier: Vec<usize> = (0..n).map(|k| k.checked_sub(1).unwrap_or(sparse::NONE)).collect();
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
        (problem, matrix, carrier)
    }

    fn solve_rigid(problem: &mut ConeProblem, matrix: &[f64], carrier: &[usize]) -> bool {
        problem.take(matrix, carrier);
        problem.solve_rigid()
    }

    fn solve_soft(problem: &mut ConeProblem, matrix: &[f64], carrier: &[usize]) -> bool {
        problem.take(matrix, carrier);
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

    /// Newton's law, Signorini's and Coulomb's: p in its cone, c_n ≥ 0, p_n c_n = 0, and p_t against c_t, as large as it may be.
    #[test]
    fn solutions_fulfil_the_laws_of_contact() {
        let mut found = 0;
        for seed in 0..300 {
            let (mut problem, matrix, carrier) =
                random_problem(seed, 1 + (seed % 3) as usize, (seed % 4) as usize);
            assert!(solve_rigid(&mut problem, &matrix, &carrier));
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
                        // The most power that a force in the disc can take out: −p_t·c_t = μ p_n |c_t|.
                        let power = -dot(&p[1..], &c[1..]);
                        assert!((power - slope * p[0] * slides).abs() < 1e-6, "seed {seed}: {power}");
                    }
                }
            }
        }
        // With friction up to 1.5 and rows that mean nothing, some have no solution.
        assert!(found >= 280, "{found} of 300");
    }

    /// The same laws by another route, in the multipliers alone: p ← Π_K(p − ρ(c + μ|c_t|n)) until p stays. No Newton's method, no
    /// penalty, no extrapolation. x, where it settles.
    fn by_projections(problem: &ConeProblem, matrix: &[f64], carrier: &[usize]) -> Option<Vec<f64>> {
        let (n, rows) = (problem.n, problem.start.len());
        let mut factor = matrix.to_vec();
        sparse::factor(carrier, &mut factor);
        let respond = |p: &[f64]| {
            let mut x: Vec<f64> = problem.force.iter().map(|force| -force).collect();
            problem.add_forces(p, &mut x);
            sparse::solve(carrier, &factor, &mut x);
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
            let (mut problem, matrix, carrier) =
                random_problem(seed, 1 + (seed % 2) as usize, (seed % 3) as usize);
            // With much friction there may be several solutions.
            for block in &mut problem.blocks {
                if let Set::Cone(slope) = &mut block.set {
                    *slope *= 0.2;
                }
            }
            let other = by_projections(&problem, &matrix, &carrier);
            assert!(solve_rigid(&mut problem, &matrix, &carrier));
            let Some(other) = other.filter(|_| problem.is_coulomb) else { continue };
            compared += 1;
            for (x, other) in problem.x.iter().zip(&other) {
                assert!((x - other).abs() < 1e-5, "seed {seed}: {x}, {other}");
            }
        }
        assert!(compared >= 45, "{compared} of 60");
    }

    /// The method of `oracle::admm` on 300 random problems: where both find a solution of Coulomb's law, the same speeds; where these
    /// differ, both are solutions, of which there may be several.
    #[test]
    fn the_alternating_method_finds_the_same() {
        let (mut same, mut two, mut unsolved) = (0, 0, 0);
        for seed in 0..300 {
            let (mut problem, matrix, carrier) =
                random_problem(seed, 1 + (seed % 3) as usize, (seed % 4) as usize);
            assert!(solve_rigid(&mut problem, &matrix, &carrier));
            let dense = problem.dense();
            // G p + g is the c of x.
            let c = &dense.delassus * &dense.impulse + &dense.free_velocity;
            assert!((c - &dense.velocity).amax() < 1e-7, "seed {seed}");
            let other = admm::solve(&dense, &admm::Options::default());
            if !(other.is_settled && problem.is_coulomb) {
                unsolved += 1;
                continue;
            }
            let own = dense.violation(&dense.impulse).worst();
            assert!(own < 1e-5 && other.violation.worst() < 1e-8, "seed {seed}: {own}");
            if (&dense.velocity - &other.velocity).amax() < 1e-5 {
                same += 1;
            } else {
                two += 1;
            }
        }
        assert!(same >= 270, "{same} the same, {two} with two solutions, {unsolved} without one");
        println!("{same} the same, {two} with two solutions, {unsolved} without one");
    }

    /// The steps of Newton's method for s by dx/ds of each sliding cone, and by one factor for all of them.
    #[test]
    fn both_ways_to_the_shifts_agree() {
        let mut compared = 0;
        for seed in 0..60 {
            let (mut problem, matrix, carrier) = random_problem(seed, 3, 1);
            assert!(solve_rigid(&mut problem, &matrix, &carrier));
            // Away from the solution, where there is a step to take.
            problem.blocks.iter_mut().for_each(|block| block.shift = 1.1 * block.shift + 0.01);
            problem.assemble();
            let slides = |cone: &usize| problem.slopes[*cone].place == Place::Border;
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
                // H is conditioned like 1/R, 1e5 times as badly as M.
                assert!((shift - other).abs() < 1e-7 * most, "seed {seed}: {shift} {other}");
            }
        }
        assert!(compared > 20, "{compared}");
    }

    /// A soft block yields by R for each unit of impulse: p is the projection of −c/R.
    #[test]
    fn soft_blocks_yield() {
        for seed in 0..50 {
            let (mut problem, matrix, carrier) = random_problem(seed, 2, 2);
            problem.blocks.iter_mut().for_each(|block| block.softness = 0.3);
            assert!(solve_soft(&mut problem, &matrix, &carrier));
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

    /// The slopes of the projection against differences, in each of its three zones.
    #[test]
    fn slopes_of_the_projection() {
        let mut random = SplitMix64::new(3);
        for _ in 0..100 {
            let slope = random.uniform(0.1, 2.0);
            let at: [f64; 4] = core::array::from_fn(|_| random.uniform(-1.0, 1.0));
            let mut p = at;
            let slopes = project_with_slopes(slope, &mut p);
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
                    // A point within 1e-6 of a zone's border is none of these 100.
                    let slope = match slopes.place {
                        Place::Border => slopes.entry(i, k),
                        Place::Within => f64::from(u8::from(i == k)),
                        Place::Elsewhere => 0.0,
                    };
                    assert!((difference - slope).abs() < 1e-7, "{difference} {slope}");
                }
            }
        }
    }
}
