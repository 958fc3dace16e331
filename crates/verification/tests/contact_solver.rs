//! The contact solver against the alternating direction method of multipliers, which shares no code with it.

use robot_dynamics::number::SplitMix64;
use robot_dynamics::verification::admm;
use robot_dynamics_core::factorization::sparse;
use robot_dynamics_simulation::contact::cone_problem::{ConeProblem, Set};

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

/// The alternating direction method of multipliers on 300 random problems. Where both find a solution of
/// Coulomb's law, the velocities agree, or both are solutions: there may be several.
#[test]
fn alternating_method_finds_same_solution() {
    let (mut same, mut two, mut unsolved) = (0, 0, 0);
    for seed in 0..300 {
        let (mut problem, matrix, dof_parent) =
            random_problem(seed, 1 + (seed % 3) as usize, (seed % 4) as usize);
        problem.set_matrix(&matrix, &dof_parent);
        assert!(problem.solve_rigid());
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
