//! Time parameterisation of paths: coefficients, splines, and the fastest motion within limits.

use std::error::Error;

use nalgebra::{Matrix3, Vector3};
use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::control::{
    Collocation, CubicSpline, MotionLimits, ParameterizationError, PathCoefficients, TimeOptimal, TimedPath,
    TreePath, TreePathPoint, limit_utilization, path_coefficients, time_optimal,
};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;

use crate::common::{Family, families, size};

type Tested = Result<(), Box<dyn Error>>;

/// a s̈ + b ṡ² + c is the inverse dynamics of v = q′ṡ, a = q′s̈ + q″ṡ², on every kind of tree.
#[test]
fn coefficients_are_inverse_dynamics() {
    for robot in families().iter().flat_map(|family: &Family| family.robots().take(15)) {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let state = &robot.state;
        let point = TreePathPoint { q: state.q.clone(), dq: state.v.clone(), ddq: state.a.clone() };
        let coefficients = path_coefficients(model, w, &point);
        for (speed, acceleration) in [(0.0, 0.0), (1.7, -2.3), (0.4, 5.0)] {
            let v: Vec<f64> = point.dq.iter().map(|dq| dq * speed).collect();
            let a: Vec<f64> = point
                .dq
                .iter()
                .zip(&point.ddq)
                .map(|(dq, ddq)| dq * acceleration + ddq * speed * speed)
                .collect();
            let mut tau = vec![0.0; model.nv()];
            inverse_dynamics(model, w, &state.q, &v, &a, &mut tau);
            let found = coefficients.torque(speed, acceleration);
            let PathCoefficients { a, b, c } = &coefficients;
            let scale = size(a) * 5.0 + size(b) * 3.0 + size(c);
            robot.require("a s̈ + b ṡ² + c", crate::common::max_difference(&found, &tau), 1e-12 * scale);
        }
    }
}

/// The spline passes through its waypoints, its derivatives are those of its values, and q″ is continuous.
#[test]
fn spline_is_twice_differentiable() -> Tested {
    let waypoints = [vec![0.0, 1.0], vec![1.0, 0.2], vec![1.1, -0.5], vec![-0.4, 2.0], vec![0.0, 0.0]];
    let path = CubicSpline::through(&waypoints)?;
    for (s, waypoint) in path.knots().iter().zip(&waypoints) {
        assert!(crate::common::max_difference(&path.at(*s).q, waypoint) < 1e-14);
        let (before, after) = (path.at(s - 1e-9), path.at(s + 1e-9));
        assert!(crate::common::max_difference(&before.ddq, &after.ddq) < 1e-5, "q″ at {s}");
    }
    for i in 0..200 {
        let (s, h) = (0.0123 + 0.975 * f64::from(i) / 200.0, 1e-5);
        let (minus, here, plus) = (path.at(s - h), path.at(s), path.at(s + h));
        for k in 0..2 {
            // Central differences: h² times a third derivative of about 1e3, and ε/h.
            assert!(((plus.q[k] - minus.q[k]) / (2.0 * h) - here.dq[k]).abs() < 1e-6, "q′ at {s}");
            // q″ has corners at the knots.
            if path.knots().iter().all(|knot| (knot - s).abs() > h) {
                assert!(((plus.dq[k] - minus.dq[k]) / (2.0 * h) - here.ddq[k]).abs() < 1e-6, "q″ at {s}");
            }
        }
    }
    assert!(size(&path.at(0.0).ddq) == 0.0 && size(&path.at(1.0).ddq) < 1e-12);
    let error = CubicSpline::through(&[vec![0.0], vec![1.0], vec![1.0]]).unwrap_err();
    assert_eq!(error.quantity, "waypoints 1 and 2");
    Ok(())
}

/// A mass of 2 kg on a rail with at most 6 N.
pub(crate) fn slider() -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("slider");
    let mass = MassProperties::new(2.0, Vector3::zeros(), Matrix3::identity())?;
    robot.links.push(LinkDescription::new("rail", None));
    robot.links.push(LinkDescription::new("mass", mass));
    let along_x = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
    robot.joints.push(JointDescription::new("slide", along_x, "rail", "mass", Pose::IDENTITY));
    Ok(Model::new(robot)?)
}

pub(crate) fn straight() -> (impl Fn(f64) -> TreePathPoint, core::ops::RangeInclusive<f64>) {
    (|s| TreePathPoint { q: vec![s], dq: vec![1.0], ddq: vec![0.0] }, 0.0..=1.5)
}

/// The double integrator: bang-bang in 2 √(L m/F), and the trapezoid L/v + v m/F with a speed limit.
#[test]
fn double_integrator_is_bang_bang() -> Tested {
    let model = slider()?;
    let limits = |velocity| MotionLimits::new(vec![6.0], vec![velocity]);
    for collocation in [Collocation::Start, Collocation::BothEnds] {
        let solve = |velocity| {
            let options =
                TimeOptimal { collocation, ..TimeOptimal::from_rest_to_rest(limits(velocity), 400) };
            time_optimal(&model, &straight(), &options)
        };
        // Switches are on grid points, so the optimum on the grid is the optimum; rounding of 400 sums.
        let free = solve(f64::INFINITY)?.duration();
        assert!((free - 2.0 * f64::sqrt(1.5 * 2.0 / 6.0)).abs() < 1e-11, "{free}");
        let trapezoid = solve(1.5)?.duration();
        assert!((trapezoid - (1.5 / 1.5 + 1.5 * 2.0 / 6.0)).abs() < 1e-11, "{trapezoid}");
    }
    // From 1 m/s to 0.5 m/s: v dv = ±3 ds meets at s with 1 + 6 s = 0.25 + 6 (1.5 − s).
    let options = TimeOptimal {
        start_speed: 1.0,
        end_speed: 0.5,
        ..TimeOptimal::from_rest_to_rest(limits(f64::INFINITY), 1200)
    };
    let timed = time_optimal(&model, &straight(), &options)?;
    let peak = f64::sqrt(1.0 + 6.0 * 0.6875);
    let expected = (peak - 1.0) / 3.0 + (peak - 0.5) / 3.0;
    assert!((timed.duration() - expected).abs() < 1e-11, "{} {expected}", timed.duration());
    let middle = timed.at(timed.times()[550]);
    assert!((middle.speed - peak).abs() < 1e-11 && (middle.s - 0.6875).abs() < 1e-11, "{middle:?}");
    Ok(())
}

/// Two links of 1 m in the vertical plane, 2 kg and 1 kg.
pub(crate) fn arm() -> Result<Model, Box<dyn Error>> {
    let mut robot = RobotDescription::new("arm");
    robot.links.push(LinkDescription::new("base", None));
    for (i, (name, mass)) in [("upper", 2.0), ("fore", 1.0)].into_iter().enumerate() {
        let rod = MassProperties::new(
            mass,
            Vector3::new(0.5, 0.0, 0.0),
            Matrix3::from_diagonal(&Vector3::new(0.0, mass / 12.0, mass / 12.0)),
        )?;
        robot.links.push(LinkDescription::new(name, rod));
        let kind = JointKind::Revolute { axis: [0.0, -1.0, 0.0] };
        let parent = ["base", "upper"][i];
        let at = Pose::from_translation([i as f64, 0.0, 0.0]);
        robot.joints.push(JointDescription::new(["shoulder", "elbow"][i], kind, parent, name, at));
    }
    Ok(Model::new(robot)?)
}

/// A motion from hanging to stretched out and back up, in which gravity, Coriolis forces and both limits
/// matter.
pub(crate) fn reach() -> CubicSpline {
    let waypoints = [vec![-1.5, 0.2], vec![-0.4, 1.3], vec![0.6, 0.4], vec![1.2, -1.0], vec![0.8, -2.0]];
    CubicSpline::through(&waypoints).expect("different waypoints")
}

pub(crate) fn arm_limits() -> MotionLimits {
    MotionLimits::new(vec![45.0, 14.0], vec![4.0, 5.0])
}

#[test]
fn arm_reaches_a_limit_everywhere_and_exceeds_none() -> Tested {
    let (model, path, limits) = (arm()?, reach(), arm_limits());
    let mut beyond = Vec::new();
    for intervals in [200u32, 400, 800] {
        let options = TimeOptimal::from_rest_to_rest(limits.clone(), intervals as usize);
        let timed = time_optimal(&model, &path, &options)?;
        let used = limit_utilization(&model, &path, &timed, &limits, 9);
        println!("{intervals}: {} s, {used:?}", timed.duration());
        assert!(used.at_grid_points <= 1.0 + 1e-6, "{used:?}");
        // All intervals but those in which the active limit changes.
        assert!(used.saturated > 1.0 - 12.0 / f64::from(intervals), "{used:?}");
        beyond.push(used.in_between - 1.0);
    }
    // Between grid points the limits hold up to O(Δs²): the knots, where q″ has corners, are on the grid.
    assert!(beyond[2] < 0.3 * beyond[0] && beyond[0] < 1e-3, "{beyond:?}");

    // Limits that are imposed only at the start of intervals are exceeded at their ends, by O(Δs).
    let start = TimeOptimal {
        collocation: Collocation::Start,
        ..TimeOptimal::from_rest_to_rest(limits.clone(), 400)
    };
    let used = limit_utilization(&model, &path, &time_optimal(&model, &path, &start)?, &limits, 0);
    assert!((1.0 + 1e-6..1.1).contains(&used.at_grid_points), "{used:?}");
    Ok(())
}

/// On a smooth path a limit is exceeded between grid points by O(Δs²). The bound is ⅛ Δs² times the second
/// derivative of τ(s)/τ_max on an interval, about 30 here. The worst interval varies, and with it the factor.
#[test]
fn limits_between_grid_points_hold_to_second_order() -> Tested {
    let (model, limits) = (arm()?, arm_limits());
    let swing = |s: f64| {
        let (sine, cosine) = (3.0 * s).sin_cos();
        TreePathPoint {
            q: vec![2.0 * s - 1.2, 0.9 * sine],
            dq: vec![2.0, 2.7 * cosine],
            ddq: vec![0.0, -8.1 * sine],
        }
    };
    let path = (swing, 0.0..=1.0);
    let mut beyond = Vec::new();
    for intervals in [100, 200, 400, 800, 1600] {
        let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), intervals))?;
        let used = limit_utilization(&model, &path, &timed, &limits, 9);
        assert!(used.at_grid_points <= 1.0 + 1e-6 && used.saturated > 0.9, "{used:?}");
        beyond.push(used.in_between - 1.0);
        let delta = 1.0 / intervals as f64;
        assert!(used.in_between - 1.0 < 4.0 * delta * delta, "{intervals}: {used:?}");
    }
    println!("beyond {beyond:?}");
    Ok(())
}

/// Limits hold on a path that is recorded with noise and has waypoints closer than the requested grid. The
/// test checks points that the computation does not use. Intervals are refined to 1e-3; between the points
/// that the computation uses, twice that is allowed.
#[test]
fn limits_hold_on_a_dense_path() -> Tested {
    let (model, smooth, limits) = (arm()?, reach(), arm_limits());
    let random = &mut SplitMix64::new(9);
    for (waypoints, noise) in [(1000, 1e-3), (400, 3e-3), (40, 0.05)] {
        let mut points: Vec<Vec<f64>> =
            (0..waypoints).map(|k| smooth.at(f64::from(k) / f64::from(waypoints - 1)).q).collect();
        points.iter_mut().flatten().for_each(|q| *q += random.uniform(-noise, noise));
        let path = CubicSpline::through(&points)?;
        if waypoints <= 400 {
            limits_hold_by_default(&model, &path)?;
        }
        for intervals in [100, 500] {
            let options = TimeOptimal::from_rest_to_rest(limits.clone(), intervals);
            let timed = time_optimal(&model, &path, &options)?;
            let used = limit_utilization(&model, &path, &timed, &limits, 16);
            println!("{waypoints} {intervals}: {} pieces, {used:?}", timed.grid().len() - 1);
            assert!(used.at_grid_points <= 1.0 + 1e-6, "{used:?}");
            assert!(used.in_between <= 1.0 + 3e-3, "{waypoints} {intervals}: {used:?}");
            assert!(path.knots().iter().all(|knot| timed.grid().contains(knot)));
            let longest = timed.grid().windows(2).map(|s| s[1] - s[0]).fold(0.0, f64::max);
            assert!(longest <= (1.0 + 1e-9) / intervals as f64, "{longest}");
        }
    }
    Ok(())
}

/// Without a number of intervals, torque, velocity and acceleration pass their limits by less than 1 %, and a
/// finer grid changes the duration by less than 1 %.
fn limits_hold_by_default(model: &Model, path: &CubicSpline) -> Tested {
    let limits = arm_limits().with_acceleration(vec![12.0, 20.0]);
    let timed = time_optimal(model, path, &TimeOptimal::new(limits.clone()))?;
    let used = limit_utilization(model, path, &timed, &limits, 16);
    println!("default: {} pieces, {} s, {used:?}", timed.grid().len() - 1, timed.duration());
    assert!(used.at_grid_points.max(used.in_between) <= 1.01, "{used:?}");
    for (peaks, limits) in [
        (&used.peak_torque, &limits.torque_upper),
        (&used.peak_velocity, &limits.velocity),
        (&used.peak_acceleration, &limits.acceleration),
    ] {
        assert!(peaks.iter().zip(limits).all(|(peak, limit)| *peak <= 1.01 * limit), "{peaks:?}");
    }
    let finer = TimeOptimal::from_rest_to_rest(limits, 2 * timed.grid().len());
    let finer = time_optimal(model, path, &finer)?.duration();
    assert!((timed.duration() / finer - 1.0).abs() < 1e-2, "{} {finer}", timed.duration());
    Ok(())
}

/// The error names the coordinate for a waypoint beyond a limit, a spline that exceeds a limit between two
/// valid waypoints, and a mimic joint that exceeds one.
#[test]
fn path_beyond_position_limits_is_an_error() -> Tested {
    let mut description = arm()?.description().clone();
    for (joint, upper) in description.joints.iter_mut().zip([1.25, 1.6]) {
        joint.limits =
            robot_dynamics::description::Limits::new(-2.1, upper).with_effort(50.0).with_velocity(4.0);
    }
    let model = Model::new(description.clone())?;
    let solve = |model: &Model, waypoints: &[[f64; 2]]| {
        let points: Vec<Vec<f64>> = waypoints.iter().map(|q| q[..model.nq()].to_vec()).collect();
        let path = CubicSpline::through(&points).expect("different waypoints");
        time_optimal(model, &path, &TimeOptimal::from_rest_to_rest(MotionLimits::of(model), 50))
    };
    let named = |error: ParameterizationError| match error {
        ParameterizationError::BeyondPosition { coordinate, value, upper, .. } => (coordinate, value, upper),
        other => panic!("{other}"),
    };
    assert!(solve(&model, &[[-1.5, 0.2], [1.25, 1.6]]).is_ok(), "limits themselves are inside");
    let (coordinate, value, upper) =
        named(solve(&model, &[[-1.0, 0.0], [1.2, 1.7], [0.0, 0.0]]).unwrap_err());
    assert!(coordinate == "elbow" && value > 1.6 && upper == 1.6, "{coordinate} {value}");
    let between = solve(&model, &[[0.0, 0.0], [1.249, 0.5], [1.2495, 0.0]]).unwrap_err();
    let (coordinate, value, upper) = named(between);
    assert!(
        coordinate == "shoulder" && (1.25..1.4).contains(&value) && upper == 1.25,
        "{coordinate} {value}"
    );
    // The elbow mimics the shoulder with ratio 2: the shoulder may go to 0.8.
    description.joints[1].mimic = Some(robot_dynamics::description::Mimic::new("shoulder", 2.0, 0.0));
    let coupled = Model::new(description)?;
    let (coordinate, _, upper) = named(solve(&coupled, &[[0.0, 0.0], [0.9, 0.0]]).unwrap_err());
    assert!(coordinate == "shoulder" && upper == 0.8, "{coordinate} {upper}");
    assert!(solve(&coupled, &[[0.0, 0.0], [0.79, 0.0]]).is_ok());
    Ok(())
}

/// The fastest motion by dynamic programming over (s, ṡ²), a method without reachable sets.
///
/// x is rounded to levels, so it can only be slower; with 2000 levels by less than 2 %.
#[test]
#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // levels from 0 to 2000
fn dynamic_programming_is_not_faster() -> Tested {
    let (model, path, limits) = (arm()?, reach(), arm_limits());
    let levels = 2000;
    let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), 100))?;
    let (grid, n) = (timed.grid(), timed.grid().len() - 1);
    let step = 1.1 * timed.squared_speeds().iter().fold(0.0, |a: f64, b| a.max(*b)) / levels as f64;
    let w = &mut Workspace::new(&model);
    let points: Vec<_> = grid.iter().map(|&s| path.at(s)).collect();
    let at: Vec<_> = points.iter().map(|point| path_coefficients(&model, w, point)).collect();
    let mut rest = vec![f64::INFINITY; levels + 1];
    rest[0] = 0.0;
    for i in (0..n).rev() {
        let mut here = vec![f64::INFINITY; levels + 1];
        let delta = grid[i + 1] - grid[i];
        for (level, time) in here.iter_mut().enumerate() {
            let x = level as f64 * step;
            if (0..2).any(|k| points[i].dq[k].abs() * x.sqrt() > limits.velocity[k]) {
                continue;
            }
            // x₊ in [low, high]: at the start τ = a u + b x + c, at the end a u + b x₊ + c, u = (x₊ − x)/2Δ.
            let (mut low, mut high) = (0.0f64, levels as f64 * step);
            let mut require = |slope: f64, offset: f64, limit: f64| {
                let (p, m) = ((limit - offset) / slope, (-limit - offset) / slope);
                low = low.max(p.min(m));
                high = high.min(p.max(m));
            };
            for k in 0..2 {
                let limit = limits.torque_upper[k];
                let (start, end) = (&at[i], &at[i + 1]);
                let u = 1.0 / (2.0 * delta);
                require(start.a[k] * u, start.b[k] * x + start.c[k] - start.a[k] * x * u, limit);
                require(end.a[k] * u + end.b[k], end.c[k] - end.a[k] * x * u, limit);
            }
            let first = (low / step).ceil() as usize;
            let last = ((high / step).floor() as usize).min(levels);
            for next in first..=last.max(first).min(levels) {
                let x_next = next as f64 * step;
                if x_next > high {
                    break;
                }
                *time = time.min(rest[next] + 2.0 * delta / (x.sqrt() + x_next.sqrt()));
            }
        }
        rest = here;
    }
    println!("reachability {} s, dynamic programming {} s", timed.duration(), rest[0]);
    assert!(rest[0] >= timed.duration() * (1.0 - 1e-12), "{} {}", rest[0], timed.duration());
    assert!(rest[0] <= timed.duration() * 1.02, "{} {}", rest[0], timed.duration());
    Ok(())
}

/// Random robots on random splines: every timing that is found obeys its limits and reaches one almost
/// everywhere.
#[test]
fn random_robots_obey_their_limits() {
    for robot in families().iter().flat_map(|family: &Family| family.robots().take(20)) {
        let model = &robot.model;
        if !model.is_vector_space() {
            continue;
        }
        let random = &mut SplitMix64::new(robot.seed ^ 0x9a7);
        let waypoints: Vec<Vec<f64>> =
            (0..4).map(|_| (0..model.nv()).map(|_| random.uniform(-1.0, 1.0)).collect()).collect();
        let path = CubicSpline::through(&waypoints).expect("different waypoints");
        // The limits are 1.5 times the holding torque everywhere on the path, plus a constant.
        let w = &mut Workspace::new(model);
        let mut torque = vec![1.0; model.nv()];
        for i in 0..=300 {
            let weight = path_coefficients(model, w, &path.at(f64::from(i) / 300.0)).c;
            torque
                .iter_mut()
                .zip(weight)
                .for_each(|(limit, c): (&mut f64, f64)| *limit = limit.max(1.5 * c.abs()));
        }
        let limits = MotionLimits::new(torque, vec![2.0; model.nv()]);
        let options = TimeOptimal::from_rest_to_rest(limits.clone(), 300);
        let timed = time_optimal(model, &path, &options)
            .unwrap_or_else(|error| panic!("{error}; family {}, seed {}", robot.family, robot.seed));
        let used = limit_utilization(model, &path, &timed, &limits, 0);
        robot.require("limits", used.at_grid_points, 1.0 + 1e-9);
        robot.require("a limit is reached", 1.0 - used.saturated, 0.05);
    }
}

/// With k times the speed the velocity part of every torque grows by k²: by inverse dynamics at equal s.
#[test]
fn velocity_part_of_torque_grows_with_square_of_speed() -> Tested {
    let (model, path) = (arm()?, reach());
    let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(arm_limits(), 200))?;
    let w = &mut Workspace::new(&model);
    let mut motion = |timed: &TimedPath, t: f64| {
        let (q, v, a) = timed.state(&path, t);
        let (mut tau, mut weight) = ([0.0; 2], [0.0; 2]);
        inverse_dynamics(&model, w, &q, &v, &a, &mut tau);
        inverse_dynamics(&model, w, &q, &[0.0; 2], &[0.0; 2], &mut weight);
        [tau[0] - weight[0], tau[1] - weight[1]]
    };
    for k in [0.5, 2.0, 3.0] {
        let faster = timed.faster(k);
        assert!((faster.duration() - timed.duration() / k).abs() < 1e-14);
        for i in 1..50 {
            // Times inside intervals, away from the jumps of s̈.
            let t = timed.duration() * (f64::from(i) + 0.0137) / 50.0;
            let (once, fast) = (motion(&timed, t), motion(&faster, t / k));
            for j in 0..2 {
                assert!((fast[j] - k * k * once[j]).abs() < 1e-9 * (1.0 + k * k * 45.0), "k {k}, t {t}");
            }
        }
    }
    Ok(())
}

/// s(t) is the integral of its own speed.
#[test]
fn path_parameter_is_integral_of_speed() -> Tested {
    let (model, path) = (arm()?, reach());
    let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(arm_limits(), 200))?;
    let h = timed.duration() / 20_000.0;
    let mut s = 0.0;
    for i in 0..20_000 {
        // The midpoint rule is exact for ṡ linear in t, except at the 200 corners: h² times a jump of s̈
        // each.
        s += h * timed.at((f64::from(i) + 0.5) * h).speed;
    }
    assert!((s - 1.0).abs() < 1e-6, "{s}");
    assert_eq!(timed.at(-1.0).s, 0.0);
    assert!((timed.at(99.0).s - 1.0).abs() < 1e-12 && timed.at(99.0).speed < 1e-6);
    Ok(())
}

#[test]
fn impossible_paths_are_errors() -> Tested {
    let (model, path) = (arm()?, reach());
    let solve = |torque: [f64; 2], velocity: [f64; 2]| {
        let limits = MotionLimits::new(torque.to_vec(), velocity.to_vec());
        time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits, 100)).unwrap_err()
    };
    let error = solve([15.0, 14.0], [4.0, 5.0]);
    assert!(
        matches!(&error, ParameterizationError::Overloaded { coordinate, .. } if coordinate == "shoulder")
    );
    let error = solve([0.0, 14.0], [4.0, 5.0]);
    let ParameterizationError::Input(input) = &error else { panic!("{error}") };
    assert_eq!(input.quantity, "the torque limit of coordinate `shoulder`");
    let error = solve([f64::INFINITY; 2], [f64::INFINITY; 2]);
    assert!(matches!(error, ParameterizationError::Unbounded { .. }), "{error}");
    let fast = TimeOptimal { start_speed: 50.0, ..TimeOptimal::from_rest_to_rest(arm_limits(), 100) };
    let error = time_optimal(&model, &path, &fast).unwrap_err();
    assert!(matches!(error, ParameterizationError::EndSpeed { place: "start", speed: 50.0, .. }), "{error}");
    Ok(())
}
