//! Splines through configurations with quaternions: waypoints, derivatives, continuity, timing.

use std::error::Error;

use robot_dynamics::control::time_parameterization::ConfigurationSpline;
use robot_dynamics::control::{
    CubicSpline, MotionLimits, TimeOptimal, TreePath, limit_utilization, path_coefficients, time_optimal,
};
use robot_dynamics::description::{Base, JointKinds, RandomRobotOptions, random_robot};
use robot_dynamics::model::{Model, RandomState, Workspace, difference, integrate, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::{max_difference, size};

type Tested = Result<(), Box<dyn Error>>;

/// A floating base and five joints of all kinds, ball joints among them.
fn robot(seed: u64) -> Model {
    let options =
        RandomRobotOptions { kinds: JointKinds::All, joints: 5, base: Base::Floating, ..Default::default() };
    Model::new(random_robot(seed, &options)).expect("a robot")
}

/// Configurations whose joints turn by at most about 1.5 rad from one to the next.
fn waypoints(model: &Model, random: &mut SplitMix64, count: usize) -> Vec<Vec<f64>> {
    let RandomState { q, .. } = random_state(model, random);
    let mut all = vec![q];
    for k in 1..count {
        let step: Vec<f64> = (0..model.nv()).map(|_| random.uniform(-0.9, 0.9)).collect();
        let mut next = vec![0.0; model.nq()];
        integrate(model, &all[k - 1], &step, &mut next);
        all.push(next);
    }
    all
}

/// The body velocity at s by a central difference of configurations, with an error of O(h²).
fn rate(model: &Model, path: &ConfigurationSpline, s: f64, h: f64) -> Vec<f64> {
    let (here, mut after, mut before) = (path.at(s).q, vec![0.0; model.nv()], vec![0.0; model.nv()]);
    difference(model, &here, &path.at(s + h).q, &mut after);
    difference(model, &here, &path.at(s - h).q, &mut before);
    after.iter().zip(before).map(|(after, before)| (after - before) / (2.0 * h)).collect()
}

/// The spline passes through its waypoints. q′ is the rate of q and q″ that of q′, by differences; both are
/// continuous at the knots. Accelerations are zero at both ends.
#[test]
fn derivatives_are_rates_and_continuous() -> Tested {
    for seed in 0..12 {
        let model = robot(seed);
        let random = &mut SplitMix64::new(seed);
        let through = waypoints(&model, random, 6);
        let path = ConfigurationSpline::through(&model, &through)?;
        for (knot, waypoint) in path.knots().iter().zip(&through) {
            let mut away = vec![0.0; model.nv()];
            difference(&model, waypoint, &path.at(*knot).q, &mut away);
            assert!(size(&away) < 1e-12, "seed {seed}: {away:?}");
        }
        for knot in &path.knots()[1..5] {
            let (before, after) = (path.at(knot - 1e-9), path.at(knot + 1e-9));
            let scale = size(&after.ddq);
            // Third derivatives of about 1e2 times q″ times 2e-9.
            assert!(max_difference(&before.dq, &after.dq) < 1e-6 * size(&after.dq), "seed {seed}");
            assert!(max_difference(&before.ddq, &after.ddq) < 1e-5 * scale, "seed {seed}");
        }
        let largest = (0..=100).map(|k| size(&path.at(f64::from(k) / 100.0).ddq)).fold(0.0, f64::max);
        for k in 0..60 {
            let (s, h) = (0.0137 + 0.97 * f64::from(k) / 60.0, 1e-4);
            if path.knots().iter().any(|knot| (knot - s).abs() <= h) {
                continue;
            }
            let here = path.at(s);
            // Central differences: h² times third and fourth derivatives, about 1e2 and 1e3 times q′ and q″.
            assert!(
                max_difference(&rate(&model, &path, s, h), &here.dq) < 1e-5 * size(&here.dq),
                "{seed} {s}"
            );
            let (before, after) = (path.at(s - h), path.at(s + h));
            let second: Vec<f64> =
                after.dq.iter().zip(&before.dq).map(|(after, before)| (after - before) / (2.0 * h)).collect();
            assert!(max_difference(&second, &here.ddq) < 1e-5 * largest, "seed {seed} {s}");
        }
        // For a floating base at rest in its position the acceleration −ω × Rᵀ p′ stays; rotations have none.
        let start = path.at(0.0);
        assert!(size(&start.ddq[3..6]) < 1e-10 * largest, "seed {seed}: {:?}", &start.ddq[3..6]);
        assert!(size(&path.at(1.0).ddq[3..6]) < 1e-10 * largest, "seed {seed}");
    }
    Ok(())
}

/// Without quaternions the spline is the plain one.
#[test]
fn plain_robots_have_the_plain_spline() -> Tested {
    let options = RandomRobotOptions { kinds: JointKinds::Turning, joints: 4, ..Default::default() };
    let model = Model::new(random_robot(8, &options))?;
    let through = waypoints(&model, &mut SplitMix64::new(8), 7);
    let (path, plain) = (ConfigurationSpline::through(&model, &through)?, CubicSpline::through(&through)?);
    for k in 0..=50 {
        let (found, expected) = (path.at(f64::from(k) / 50.0), plain.at(f64::from(k) / 50.0));
        assert!(max_difference(&found.q, &expected.q) < 1e-13);
        assert!(max_difference(&found.ddq, &expected.ddq) < 1e-11 * (1.0 + size(&expected.ddq)));
    }
    Ok(())
}

/// Rotations about one axis follow the natural cubic spline of the angle.
#[test]
fn rotations_about_one_axis_are_plain_splines() -> Tested {
    let options = RandomRobotOptions { joints: 0, base: Base::Floating, ..Default::default() };
    let model = Model::new(random_robot(3, &options))?;
    let angles = [0.0, 1.1, 0.4, -1.5, 0.9];
    let through = angles.map(|angle: f64| {
        let (sine, cosine) = (0.5 * angle).sin_cos();
        vec![0.0, 0.0, 0.0, 0.0, sine, 0.0, cosine]
    });
    let path = ConfigurationSpline::through(&model, &through)?;
    let plain = CubicSpline::through(&angles.map(|angle| vec![angle]))?;
    for k in 0..=50 {
        let (found, expected) = (path.at(f64::from(k) / 50.0), plain.at(f64::from(k) / 50.0));
        assert!((2.0 * found.q[4].atan2(found.q[6]) - expected.q[0]).abs() < 1e-12);
        assert!(
            (found.dq[4] - expected.dq[0]).abs() < 1e-11 && (found.ddq[4] - expected.ddq[0]).abs() < 1e-9
        );
    }
    Ok(())
}

/// The fastest motion of a robot with quaternions obeys its limits and reaches one almost everywhere.
#[test]
fn paths_with_quaternions_are_timed() -> Tested {
    for seed in 0..4 {
        let model = robot(seed);
        let path = ConfigurationSpline::through(&model, &waypoints(&model, &mut SplitMix64::new(seed), 4))?;
        let w = &mut Workspace::new(&model);
        let mut torque = vec![1.0; model.nv()];
        for k in 0..=300 {
            let weight = path_coefficients(&model, w, &path.at(f64::from(k) / 300.0)).c;
            torque
                .iter_mut()
                .zip(weight)
                .for_each(|(limit, c): (&mut f64, f64)| *limit = limit.max(1.5 * c.abs()));
        }
        let limits = MotionLimits::new(torque, vec![2.0; model.nv()]).with_dissipation(false);
        let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), 300))?;
        let used = limit_utilization(&model, &path, &timed, &limits, 5);
        assert!(used.at_grid_points <= 1.0 + 1e-9 && used.in_between <= 1.0 + 2e-3, "seed {seed}: {used:?}");
        assert!(used.saturated > 0.95, "seed {seed}: {used:?}");
    }
    Ok(())
}

/// Equal waypoints and numbers that are no configuration are errors.
#[test]
fn invalid_waypoints_are_errors() {
    let model = robot(1);
    let through = waypoints(&model, &mut SplitMix64::new(1), 3);
    let same = [through[0].clone(), through[0].clone()];
    assert_eq!(ConfigurationSpline::through(&model, &same).unwrap_err().quantity, "waypoints 0 and 1");
    let mut long = through.clone();
    long[1][6] = 2.0;
    assert_eq!(ConfigurationSpline::through(&model, &long).unwrap_err().quantity, "waypoint 1");
}
