//! The fastest motion with damping, friction, power, acceleration and asymmetric torques.

use std::error::Error;

use robot_dynamics::control::time_parameterization::LimitedQuantity;
use robot_dynamics::control::{
    MotionLimits, ParameterizationError, TimeOptimal, TreePath, limit_utilization, path_coefficients,
    time_optimal,
};
use robot_dynamics::description::PassiveForces;
use robot_dynamics::model::{Model, Workspace};

use crate::time_optimal::{arm, arm_limits, reach, slider, straight};

type Tested = Result<(), Box<dyn Error>>;

/// The robot with this damping and friction on each joint.
fn dissipative(model: &Model, damping: f64, friction: f64) -> Result<Model, Box<dyn Error>> {
    let mut description = model.description().clone();
    for joint in &mut description.joints {
        joint.passive = PassiveForces::default().with_damping(damping).with_friction(friction);
    }
    Ok(Model::new(description)?)
}

fn duration(model: &Model, limits: &MotionLimits, intervals: usize) -> Result<f64, ParameterizationError> {
    let options = TimeOptimal::from_rest_to_rest(limits.clone(), intervals);
    Ok(time_optimal(model, &straight(), &options)?.duration())
}

/// The root of an increasing function.
fn bisect(mut low: f64, mut high: f64, f: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        *(if f(middle) < 0.0 { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

/// m v̇ = ±F − f − b v: both phases are exponentials, and the time of the switch is the root of a scalar
/// equation. The error of the duration is of first order in the grid.
#[test]
fn damped_slider_is_bang_bang() -> Tested {
    let (m, force, length) = (2.0, 6.0, 1.5);
    for (b, f) in [(3.0, 0.0), (3.0, 1.5), (9.0, 0.5)] {
        let model = dissipative(&slider()?, b, f)?;
        let limits = MotionLimits::new(vec![force], vec![f64::INFINITY]);
        let (coarse, found) = (duration(&model, &limits, 500)?, duration(&model, &limits, 2000)?);
        let rate = b / m;
        let (faster, slower) = ((force - f) / b, (force + f) / b);
        let at_switch = |t: f64| {
            let v = faster * (1.0 - (-rate * t).exp());
            let s = faster * t - v / rate;
            let brake = ((v + slower) / slower).ln() / rate;
            (s + v / rate - slower * brake, t + brake)
        };
        let switch = bisect(0.0, 20.0, |t| at_switch(t).0 - length);
        let expected = at_switch(switch).1;
        let errors = [coarse, found].map(|found| (found / expected - 1.0).abs());
        println!("b {b}, f {f}: {found} {expected} {errors:?}");
        assert!(errors[1] < 2e-3 && errors[1] < 0.35 * errors[0], "b {b}, f {f}: {errors:?}");
    }
    Ok(())
}

/// F until v = P/F, then P = m v̇ v: v³ is linear in s.
#[test]
fn power_bounds_the_slider() -> Tested {
    let (model, m, force, power, length) = (slider()?, 2.0, 6.0, 4.0, 1.5);
    let limits = MotionLimits::new(vec![force], vec![f64::INFINITY]).with_power(vec![power]);
    let corner = power / force;
    let distance = |v: f64| {
        m * corner * corner / (2.0 * force) + m * (v.powi(3) - corner.powi(3)) / (3.0 * power) - 0.5 * length
    };
    let top = bisect(corner, 10.0, distance);
    let expected = 2.0 * (m * corner / force + m * (top * top - corner * corner) / (2.0 * power));
    let mut errors = Vec::new();
    for intervals in [500, 2000] {
        errors.push((duration(&model, &limits, intervals)? / expected - 1.0).abs());
    }
    println!("{expected} {errors:?}");
    assert!(errors[1] < 2e-4 && errors[1] < 0.3 * errors[0], "{errors:?}");
    // Power alone bounds the speed, too: v³ is linear in s from rest.
    let alone = MotionLimits::new(vec![f64::INFINITY], vec![f64::INFINITY]).with_power(vec![power]);
    let top = (1.5 * length * power / m).cbrt();
    let expected = m * top * top / power;
    let found = duration(&model, &alone, 2000)?;
    assert!((found / expected - 1.0).abs() < 1e-2, "{found} {expected}");
    Ok(())
}

/// 3 m/s² forwards and 1 m/s² backwards; then 2 m/s² by a limit of acceleration.
#[test]
fn asymmetric_torque_and_acceleration_bound_the_slider() -> Tested {
    let (model, length) = (slider()?, 1.5);
    let none = vec![f64::INFINITY];
    let limits = MotionLimits::new(none.clone(), none.clone()).with_torque_range(vec![-2.0], vec![6.0]);
    let top = f64::sqrt(2.0 * length / (1.0 / 3.0 + 1.0));
    let found = duration(&model, &limits, 400)?;
    // Switches are on grid points: 1 : 3 divides the path after the 100th of 400 intervals.
    assert!((found - top * (1.0 / 3.0 + 1.0)).abs() < 1e-11, "{found}");
    // Friction of 2 N does the same to a force of ±4 N.
    let limits = MotionLimits::new(vec![4.0], none.clone());
    let found = duration(&dissipative(&model, 0.0, 2.0)?, &limits, 400)?;
    let top = f64::sqrt(2.0 * length / (1.0 + 1.0 / 3.0));
    assert!((found - top * (1.0 + 1.0 / 3.0)).abs() < 1e-11, "{found}");
    let limits = MotionLimits::new(none.clone(), none).with_acceleration(vec![2.0]);
    let found = duration(&model, &limits, 400)?;
    assert!((found - 2.0 * f64::sqrt(length / 2.0)).abs() < 1e-11, "{found}");
    Ok(())
}

/// Each set of limits holds by inverse dynamics and dissipation, and one is reached almost everywhere.
#[test]
fn every_kind_of_limit_holds_on_the_arm() -> Tested {
    let (free, path) = (arm()?, reach());
    let asymmetric = MotionLimits::new(vec![45.0, 14.0], vec![4.0, 5.0])
        .with_torque_range(vec![-30.0, -14.0], vec![45.0, 9.0]);
    let cases = [
        ("friction", dissipative(&free, 0.0, 2.0)?, arm_limits()),
        ("damping", dissipative(&free, 2.0, 0.0)?, arm_limits()),
        ("both", dissipative(&free, 2.0, 1.0)?, arm_limits()),
        ("strong damping", dissipative(&free, 8.0, 1.0)?, arm_limits()),
        ("power", free.clone(), arm_limits().with_power(vec![60.0, 12.0])),
        ("little power", free.clone(), arm_limits().with_power(vec![5.0, 1.0])),
        ("acceleration", free.clone(), arm_limits().with_acceleration(vec![6.0, 9.0])),
        ("asymmetric", free.clone(), asymmetric.clone()),
        (
            "all",
            dissipative(&free, 2.0, 1.0)?,
            asymmetric.with_power(vec![60.0, 12.0]).with_acceleration(vec![9.0, 14.0]),
        ),
    ];
    let unlimited =
        time_optimal(&free, &path, &TimeOptimal::from_rest_to_rest(arm_limits(), 300))?.duration();
    for (name, model, limits) in cases {
        let options = TimeOptimal::from_rest_to_rest(limits.clone(), 300);
        let timed = time_optimal(&model, &path, &options)?;
        let used = limit_utilization(&model, &path, &timed, &limits, 16);
        println!(
            "{name}: {} s, {} intervals, {} {} {} {:?}",
            timed.duration(),
            timed.grid().len() - 1,
            used.at_grid_points,
            used.in_between,
            used.saturated,
            used.tightest
        );
        assert!(used.at_grid_points <= 1.0 + 1e-6, "{name}: {used:?}");
        assert!(used.in_between <= 1.0 + 3e-3, "{name}: {used:?}");
        assert!(used.saturated > 0.9, "{name}: {used:?}");
        assert!(timed.duration() > unlimited - 1e-9 || name == "damping" || name == "friction", "{name}");
    }
    Ok(())
}

/// The utilization names the limit that is tightest.
#[test]
fn utilization_names_quantity_and_coordinate() -> Tested {
    let (model, path, limits) = (arm()?, reach(), arm_limits().with_power(vec![60.0, 12.0]));
    let timed = time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), 200))?;
    let peaks = limit_utilization(&model, &path, &timed, &limits, 5);
    for (quantity, halved) in [
        (
            LimitedQuantity::Velocity,
            MotionLimits { velocity: vec![f64::INFINITY, 0.5 * peaks.peak_velocity[1]], ..limits.clone() },
        ),
        (
            LimitedQuantity::Acceleration,
            limits.clone().with_acceleration(vec![f64::INFINITY, 0.5 * peaks.peak_acceleration[1]]),
        ),
        (LimitedQuantity::Power, limits.clone().with_power(vec![f64::INFINITY, 0.5 * peaks.peak_power[1]])),
        (
            LimitedQuantity::Torque,
            limits.clone().with_torque_range(
                vec![f64::NEG_INFINITY, -0.5 * peaks.peak_torque[1]],
                vec![f64::INFINITY, 0.5 * peaks.peak_torque[1]],
            ),
        ),
    ] {
        let tightest = limit_utilization(&model, &path, &timed, &halved, 5).tightest;
        assert!(tightest.quantity == quantity && tightest.coordinate == 1, "{tightest:?}");
        assert!((tightest.utilization - 2.0).abs() < 1e-9, "{tightest:?}");
    }
    Ok(())
}

/// Dynamic programming over (s, ṡ²) with the exact, nonconvex limits of damping, friction and power at both
/// ends of each interval.
///
/// Its levels are a subset of the feasible motions, so the result of the convex-concave procedure must not be
/// slower than it: it is a global optimum here. The rounding of x to levels costs time, less than 10 %.
#[test]
fn exact_limits_allow_no_faster_motion() -> Tested {
    let model = dissipative(&arm()?, 2.0, 1.0)?;
    let (path, levels, intervals) = (reach(), 500, 60);
    let limits = arm_limits()
        .with_torque_range(vec![-35.0, -14.0], vec![50.0, 12.0])
        .with_power(vec![60.0, 14.0])
        .with_acceleration(vec![25.0, 40.0]);
    let options = TimeOptimal::from_rest_to_rest(limits.clone(), intervals);
    let timed = time_optimal(&model, &path, &options)?;
    let grid = timed.grid();
    let step = 1.1 * timed.squared_speeds().iter().fold(0.0, |a: f64, b| a.max(*b)) / levels as f64;
    let w = &mut Workspace::new(&model);
    let points: Vec<_> = grid.iter().map(|&s| path.at(s)).collect();
    let at: Vec<_> = points.iter().map(|point| path_coefficients(&model, w, point)).collect();
    let allowed = |i: usize, x: f64, u: f64| {
        (0..2).all(|k| {
            let (dq, ddq) = (points[i].dq[k], points[i].ddq[k]);
            let v = dq * x.sqrt();
            let tau = at[i].a[k] * u + at[i].b[k] * x + at[i].c[k] + 2.0 * v + dq.signum();
            (limits.torque_lower[k]..=limits.torque_upper[k]).contains(&tau)
                && v.abs() <= limits.velocity[k]
                && (dq * u + ddq * x).abs() <= limits.acceleration[k]
                && (tau * v).abs() <= limits.power[k]
        })
    };
    let mut rest = vec![f64::INFINITY; levels + 1];
    rest[0] = 0.0;
    for i in (0..grid.len() - 1).rev() {
        let delta = grid[i + 1] - grid[i];
        let mut here = vec![f64::INFINITY; levels + 1];
        for (level, time) in here.iter_mut().enumerate() {
            for (next, after) in rest.iter().enumerate().filter(|(_, after)| after.is_finite()) {
                let (x, x_next) = (level as f64 * step, next as f64 * step);
                let u = (x_next - x) / (2.0 * delta);
                if allowed(i, x, u) && allowed(i + 1, x_next, u) {
                    *time = time.min(after + 2.0 * delta / (x.sqrt() + x_next.sqrt()));
                }
            }
        }
        rest = here;
    }
    println!("dynamic programming {} s, convex-concave procedure {} s", rest[0], timed.duration());
    assert!(rest[0] >= timed.duration() * (1.0 - 1e-9), "{} {}", rest[0], timed.duration());
    assert!(rest[0] <= timed.duration() * 1.1, "{} {}", rest[0], timed.duration());
    Ok(())
}

/// Dry friction that exceeds the torque at rest is named with the coordinate, its torque and the limit.
#[test]
fn friction_beyond_the_torque_is_an_error() -> Tested {
    let model = dissipative(&slider()?, 0.0, 7.0)?;
    let limits = MotionLimits::new(vec![6.0], vec![1.0]);
    let error = duration(&model, &limits, 10).unwrap_err();
    let ParameterizationError::Overloaded { coordinate, needed, limit, .. } = error else {
        panic!("{error}")
    };
    assert!(coordinate == "slide" && needed == 7.0 && limit == 6.0, "{coordinate} {needed} {limit}");
    assert!(duration(&model, &limits.clone().with_dissipation(false), 10).is_ok());
    let nothing = limits.with_torque_range(vec![3.0], vec![3.0]);
    let ParameterizationError::Input(error) = duration(&model, &nothing, 10).unwrap_err() else { panic!() };
    assert_eq!(error.quantity, "the torque limit of coordinate `slide`");
    Ok(())
}
