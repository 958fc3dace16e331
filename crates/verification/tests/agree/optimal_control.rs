//! iLQR within torque limits. The minimum in a box is checked against enumeration, and linear systems against
//! their exact solution. Both arms are checked against differences of the cost and against finer and other
//! integrators.

use std::error::Error;

use nalgebra::{DMatrix, DVector};
use robot_dynamics::algorithms::gravity;
use robot_dynamics::model::Workspace;
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::Integrator;

use crate::ilqr::arm::Arm;
use crate::ilqr::box_qp::{BoxError, box_minimum};
use crate::ilqr::problem::{Problem, lift, swing_up};
use crate::ilqr::solver::{Plan, Plant, Task};

/// Entries between −1 and 1.
fn matrix(random: &mut SplitMix64, rows: usize, columns: usize) -> DMatrix<f64> {
    DMatrix::from_fn(rows, columns, |_, _| random.uniform(-1.0, 1.0))
}

/// The least value over all 3ⁿ ways to hold coordinates at a bound, without a start or an iteration.
fn enumerated(
    h: &DMatrix<f64>,
    g: &DVector<f64>,
    lower: &DVector<f64>,
    upper: &DVector<f64>,
) -> DVector<f64> {
    let n = g.len();
    let mut best = (f64::INFINITY, DVector::zeros(n));
    for code in 0..3usize.pow(u32::try_from(n).expect("small")) {
        let state = |i: usize| code / 3usize.pow(u32::try_from(i).expect("small")) % 3;
        let mut x = DVector::from_fn(n, |i, _| [0.0, lower[i], upper[i]][state(i)]);
        let free: Vec<usize> = (0..n).filter(|&i| state(i) == 0).collect();
        if !free.is_empty() {
            let slope = (h * &x + g).select_rows(&free);
            let own = h.select_rows(&free).select_columns(&free);
            let inner = own.lu().solve(&-slope).expect("positive definite");
            free.iter().zip(inner.iter()).for_each(|(&i, value)| x[i] = *value);
        }
        if (0..n).all(|i| x[i] >= lower[i] && x[i] <= upper[i]) {
            let value = 0.5 * x.dot(&(h * &x)) + g.dot(&x);
            if value < best.0 {
                best = (value, x);
            }
        }
    }
    best.1
}

#[test]
fn box_minimum_is_best_of_all_active_sets() {
    let mut held = 0;
    for seed in 0..300 {
        let mut random = SplitMix64::new(seed);
        let n = 1 + usize::try_from(seed % 6).expect("small");
        // Condition numbers up to about 1e6.
        let root = matrix(&mut random, n, n);
        let h = &root * root.transpose() + DMatrix::identity(n, n) * 10f64.powf(random.uniform(-5.0, 1.0));
        let g = matrix(&mut random, n, 1).column(0).into_owned();
        let lower = DVector::from_fn(n, |_, _| random.uniform(-1.0, 0.0));
        let upper = DVector::from_fn(n, |i, _| lower[i] + random.uniform(0.05, 1.5));
        let far = DVector::from_fn(n, |_, _| random.uniform(-2.0, 2.0));
        let expected = enumerated(&h, &g, &lower, &upper);
        // Both solve a system with H: κ ε of the box, which is below 2.5.
        let eigenvalues = h.symmetric_eigenvalues();
        let tolerance = 1e-14 * eigenvalues.max() / eigenvalues.min() + 1e-14;
        // A start that equals the solution up to rounding must still give the correct held set.
        for start in [far, expected.add_scalar(-4e-16)] {
            let found = box_minimum(&h, &g, (&lower, &upper), &start)
                .unwrap_or_else(|error| panic!("seed {seed}: {error:?}"));
            let defect = (&found.x - &expected).amax();
            assert!(
                defect <= tolerance,
                "seed {seed}: {defect:e} > {tolerance:e}, {:?} {expected:?}",
                found.x
            );
            let inside: Vec<usize> =
                (0..n).filter(|&i| expected[i] > lower[i] && expected[i] < upper[i]).collect();
            assert_eq!(found.free, inside, "seed {seed}");
            held += n - inside.len();
        }
    }
    assert!(held > 200, "only {held} coordinates at a bound");
    let (zero, one) = (DVector::zeros(1), DVector::from_element(1, 1.0));
    let refused = box_minimum(&DMatrix::from_element(1, 1, -1.0), &zero, (&-&one, &one), &zero);
    assert_eq!(refused.err(), Some(BoxError::Indefinite));
}

/// x ← A x + B u.
struct Linear {
    a: DMatrix<f64>,
    b: DMatrix<f64>,
}

impl Plant for Linear {
    fn step(&mut self, x: &DVector<f64>, u: &DVector<f64>) -> Result<DVector<f64>, Box<dyn Error>> {
        Ok(&self.a * x + &self.b * u)
    }

    fn linearize(
        &mut self,
        _: &DVector<f64>,
        _: &DVector<f64>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), Box<dyn Error>> {
        Ok((self.a.clone(), self.b.clone()))
    }
}

/// Two masses joined by a spring, each with a force, and their cost.
fn masses(limit: f64, goal_tolerance: f64) -> (Linear, Task) {
    let h = 0.1;
    #[rustfmt::skip]
    let a = DMatrix::from_row_slice(4, 4, &[
        1.0, 0.0, h, 0.0,
        0.0, 1.0, 0.0, h,
        -2.0 * h, 2.0 * h, 1.0, 0.0,
        2.0 * h, -2.0 * h, 0.0, 1.0,
    ]);
    #[rustfmt::skip]
    let b = DMatrix::from_row_slice(4, 2, &[
        0.0, 0.0,
        0.0, 0.0,
        h, 0.0,
        0.0, h,
    ]);
    let task = Task {
        start: DVector::from_column_slice(&[-1.0, 0.5, 0.0, 0.3]),
        goal: DVector::from_column_slice(&[0.2, 0.4, 0.0, 0.0]),
        rest: DVector::from_column_slice(&[0.1, -0.1]),
        limit: DVector::from_element(2, limit),
        state_weight: DVector::from_column_slice(&[0.1, 0.2, 0.05, 0.05]),
        control_weight: DVector::from_column_slice(&[0.05, 0.1]),
        end_weight: DVector::from_element(4, 1e3),
        steps: 30,
        goal_tolerance,
    };
    (Linear { a, b }, task)
}

/// All x and u at once: the stationarity of the cost with x₊ = A x + B u as constraints, one linear system.
fn stationary(plant: &Linear, task: &Task) -> (Vec<DVector<f64>>, Vec<DVector<f64>>) {
    let (n, m, steps) = (task.goal.len(), task.rest.len(), task.steps);
    let (us, rows) = (n * (steps + 1), n * (steps + 1) + m * steps);
    let mut k = DMatrix::zeros(rows + n * (steps + 1), rows + n * (steps + 1));
    let mut right = DVector::zeros(k.nrows());
    let mut weigh = |at: usize, weight: &DVector<f64>, wanted: &DVector<f64>| {
        for i in 0..weight.len() {
            k[(at + i, at + i)] = weight[i];
            right[at + i] = weight[i] * wanted[i];
        }
    };
    for step in 0..steps {
        weigh(n * step, &task.state_weight, &task.goal);
        weigh(us + m * step, &task.control_weight, &task.rest);
    }
    weigh(n * steps, &task.end_weight, &task.goal);
    for step in 0..=steps {
        let row = rows + n * step;
        k.view_mut((row, n * step), (n, n)).fill_with_identity();
        if step == 0 {
            right.rows_mut(row, n).copy_from(&task.start);
        } else {
            k.view_mut((row, n * (step - 1)), (n, n)).copy_from(&-&plant.a);
            k.view_mut((row, us + m * (step - 1)), (n, m)).copy_from(&-&plant.b);
        }
    }
    let lower = k.view((rows, 0), (n * (steps + 1), rows)).transpose();
    k.view_mut((0, rows), lower.shape()).copy_from(&lower);
    let z = k.lu().solve(&right).expect("a convex problem");
    let x = (0..=steps).map(|step| z.rows(n * step, n).into_owned()).collect();
    (x, (0..steps).map(|step| z.rows(us + m * step, m).into_owned()).collect())
}

/// Without limits one pass solves a linear plant, and the gains are those of the exact solution.
#[test]
fn one_pass_solves_a_linear_plant() -> Result<(), Box<dyn Error>> {
    let (mut plant, task) = masses(1e3, f64::INFINITY);
    let plan = task.solve(&mut plant, vec![DVector::from_element(2, 0.7); task.steps])?;
    // One pass to move, and one to find that nothing is left to gain.
    assert_eq!((plan.iterations, plan.renewals), (2, 0));
    let (x, u) = stationary(&plant, &task);
    let apart = |a: &[DVector<f64>], b: &[DVector<f64>]| {
        a.iter().zip(b).map(|(a, b)| (a - b).amax()).fold(0.0, f64::max)
    };
    // Rounding of 30 steps and of a system whose condition is the ratio of the weights, about 400, times N².
    let (x_defect, u_defect) = (apart(&plan.x, &x), apart(&plan.u, &u));
    assert!(x_defect < 1e-11 && u_defect < 1e-11, "{x_defect:e}, {u_defect:e}");

    // The solution is linear in x₀: a unit change of x₀ changes u₀ by a column of K₀.
    for i in 0..4 {
        let mut moved = task.clone();
        moved.start[i] += 1.0;
        let (_, other) = stationary(&plant, &moved);
        let defect = (&other[0] - &u[0] - plan.gains[0].column(i)).amax();
        assert!(defect < 1e-11, "column {i}: {defect:e}");
    }
    Ok(())
}

/// ∂J/∂u of `entries` (step, joint) by central differences of whole motions, without A and B; δ in units of
/// the limits.
fn slope(
    task: &Task,
    plant: &mut dyn Plant,
    plan: &Plan,
    entry: (usize, usize),
    delta: f64,
) -> Result<f64, Box<dyn Error>> {
    let mut change = |delta: f64| -> Result<f64, Box<dyn Error>> {
        let mut u = plan.u.clone();
        u[entry.0][entry.1] += delta * task.limit[entry.1];
        let mut x = plan.x[..=entry.0].to_vec();
        for k in entry.0..task.steps {
            x.push(plant.step(&x[k], &u[k])?);
        }
        Ok(task.total(&x, &u, &plan.multipliers))
    };
    let mut difference = |delta: f64| Ok::<_, Box<dyn Error>>(change(delta)? - change(-delta)?);
    Ok((8.0 * difference(delta)? - difference(2.0 * delta)?) / (12.0 * delta))
}

/// No change within the limits lowers the cost: derivatives are zero inside and point outwards at a limit.
/// Returns the number of the tested torques that are at a limit.
fn require_stationary(
    task: &Task,
    plant: &mut dyn Plant,
    plan: &Plan,
    every: usize,
    (delta, tolerance): (f64, f64),
) -> Result<usize, Box<dyn Error>> {
    let mut at_limit = 0;
    let mut worst = 0.0f64;
    for step in (0..task.steps).step_by(every) {
        for joint in 0..task.limit.len() {
            let slope = slope(task, plant, plan, (step, joint), delta)?;
            let share = plan.u[step][joint] / task.limit[joint];
            let excess = if share.abs() == 1.0 {
                at_limit += 1;
                (slope * share).max(0.0)
            } else {
                slope.abs()
            };
            worst = worst.max(excess);
            assert!(excess <= tolerance, "step {step}, joint {joint} at {share} limits: slope {slope:e}");
        }
    }
    println!("worst slope {worst:e}, {at_limit} at a limit");
    Ok(at_limit)
}

#[test]
fn limited_torques_are_stationary() -> Result<(), Box<dyn Error>> {
    let (mut plant, task) = masses(1.4, 1e-8);
    let plan = task.solve(&mut plant, vec![DVector::zeros(2); task.steps])?;
    assert!(plan.u.iter().all(|u| u.amax() <= 1.4));
    assert!((plan.x[task.steps].clone() - &task.goal).amax() <= 1e-8);
    // J is quadratic: differences are exact except for rounding, 1e-16 J/δ. The remaining gain is below 1e-12
    // J, so a derivative is below its root times twice the curvature, both of order 1.
    let at_limit = require_stationary(&task, &mut plant, &plan, 1, (0.01, 3e-6))?;
    assert!(at_limit >= 5, "{at_limit}");
    Ok(())
}

/// Requires that the goal is reached within the limits, and checks the derivatives of each motion.
fn require_goal(problem: &Problem, every: usize) -> Result<(), Box<dyn Error>> {
    let numbers = problem.numbers()?;
    let Problem { model, task, h } = problem;
    let plan = &numbers.plan;
    // The limits hold exactly, and they are active.
    assert_eq!(numbers.torque, 1.0);
    // The limits of the joints are not enforced, but the motion satisfies those of the arm's file.
    assert!(numbers.speed < 1.0, "{}", numbers.speed);
    let limits = model.coordinate_limits();
    for x in &plan.x {
        let inside = (0..limits.len()).all(|i| x[i] >= limits[i].lower && x[i] <= limits[i].upper);
        assert!(inside, "a joint leaves its range: {x:?}");
    }
    let [q, v] = numbers.off;
    assert!(q.max(v) <= task.goal_tolerance, "{q:e}, {v:e}");

    // From other initial torques the search takes another path and ends at the same motion. The goal may be
    // missed by e within its tolerance, which is worth λᵀe; otherwise the cost is flat.
    let other = problem.solve_from(0.01)?;
    let worth = plan.multipliers.abs().sum() * task.goal_tolerance;
    assert!((other.cost - plan.cost).abs() < worth, "{} and {}, {worth:e}", other.cost, plan.cost);

    // The error of the steps relative to the continuous motion: with order 4, steps ten times shorter have
    // 1/10⁴ of it. The finer simulation is therefore the reference and must reach the goal, and another
    // method of order 4 must reach the same end.
    let ([q, v], [other_q, other_v]) = (numbers.off_finer, numbers.off_variational);
    println!("replayed {q:e} rad, {v:e} rad/s; {other_q:e}, {other_v:e}");
    assert!(q < 1e-4 && v < 1e-3, "{q:e}, {v:e}");
    let finer = problem.replay(plan, Integrator::RungeKutta4, 10)?;
    let variational = problem.replay(plan, Integrator::VariationalYoshida4, 10)?;
    let apart = finer.iter().zip(&variational).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("two methods end {apart:e} apart");
    // The error constant of Yoshida's composition is some tens of times that of Runge–Kutta: a hundredth of
    // v.
    assert!(apart < 0.01 * v, "{apart:e} of {v:e}");

    // An offset of 0.01 rad at the start has nearly vanished at the end, although torques at a limit cannot
    // correct it.
    let [q, v] = numbers.off_steered;
    println!("steered {q:e} rad, {v:e} rad/s");
    assert!(q < 1e-3 && v < 1e-3, "{q:e}, {v:e}");

    // δ = 3e-7 of the limits: fourth-order differences of motions that amplify an early torque about a
    // thousandfold. Their rounding is 1e-9. The remaining gain is below 1e-12 J, a derivative of about 1e-6
    // by the curvature (a derivative s gains s²/2J″). A full torque alone has the derivative 2 h, 5e-3 or
    // more; the tolerance is a share of it.
    let at_limit = require_stationary(task, &mut Arm::new(model, *h), plan, every, (3e-7, 2e-6))?;
    assert!(at_limit > 0);
    Ok(())
}

#[test]
fn two_link_arm_swings_up() -> Result<(), Box<dyn Error>> {
    let problem = swing_up()?;
    // The shoulder cannot carry the stretched arm: it must swing or fold.
    let mut held = [0.0; 2];
    gravity(&problem.model, &mut Workspace::new(&problem.model), &[0.0, 0.0], &mut held);
    assert!(held[0] > 1.2 * problem.task.limit[0], "{held:?}");
    require_goal(&problem, 4)
}

/// The picture shows the computed poses: 13 chains of three points, drawn to scale.
#[test]
fn poses_are_drawn_to_scale() -> Result<(), Box<dyn Error>> {
    let problem = swing_up()?;
    let plan = problem.solve()?;
    let svg = crate::ilqr::figure(problem.panels("arm", &plan)).svg();
    let curve = svg.lines().find(|line| line.contains("stroke-width=\"1.8\"")).ok_or("no curve")?;
    let path = curve.split('"').nth(1).ok_or("no path")?;
    let mut chains = 0;
    for chain in path.split('M').filter(|chain| !chain.is_empty()) {
        let points: Vec<Vec<f64>> = chain
            .split(' ')
            .map(|point| point.split(',').map(|x| x.parse().expect("a number")).collect())
            .collect();
        assert_eq!(points.len(), 3);
        // Both links are 1 m, and 4 m are 220/1.12 pixels; coordinates are rounded to a tenth.
        for link in points.windows(2) {
            let length = (link[1][0] - link[0][0]).hypot(link[1][1] - link[0][1]);
            assert!((length - 220.0 / 1.12 / 4.0).abs() < 0.2, "{length} in {chain}");
        }
        chains += 1;
    }
    assert_eq!(chains, 13);
    Ok(())
}

#[test]
fn seven_joint_arm_lifts_its_load() -> Result<(), Box<dyn Error>> {
    require_goal(&lift()?, 20)
}
