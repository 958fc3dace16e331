//! The time-optimal motion of an arm along a path.
//!
//! A seven-joint arm moves through five waypoints within the torque and velocity limits of its file. The
//! timing is computed by reachability analysis on 1000 intervals and checked by inverse dynamics.
//!
//! `cargo run --release --example 03_fastest_motion -p robot-dynamics-urdf`
#![allow(dead_code)] // the tests do not call `main`

#[path = "plot/mod.rs"]
mod plot;

use std::error::Error;

use plot::{Axis, Figure, Line, Panel};
use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::control::{
    CubicSpline, LimitUtilization, MotionLimits, TimeOptimal, TimedPath, TreePath, TreePathPoint,
    limit_utilization, time_optimal,
};
use robot_dynamics::model::{Model, Workspace};

const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");

/// The waypoints of the path \[rad\].
const WAYPOINTS: [[f64; 7]; 5] = [
    [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8],
    [0.8, 0.3, -0.4, -1.4, 0.5, 1.2, 1.4],
    [1.4, 0.9, 0.3, -0.9, -0.6, 2.3, 0.2],
    [0.3, 0.5, 0.9, -1.9, -1.2, 1.5, -0.9],
    [-0.9, -0.2, 0.4, -2.5, 0.1, 2.8, 0.5],
];

/// The results that the example prints and draws.
pub(crate) struct Numbers {
    /// The duration from rest to rest \[s\].
    pub(crate) duration: f64,
    /// The duration with half the grid \[s\].
    pub(crate) coarse: f64,
    /// The utilization of the limits.
    pub(crate) used: LimitUtilization,
    /// Time, and torques and velocities relative to their limits, at both ends of every interval.
    pub(crate) moments: Vec<(f64, [Vec<f64>; 2])>,
}

pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let model = Model::new(
        robot_dynamics::urdf::load(ROBOT, &robot_dynamics::urdf::LoadOptions::default())?.description,
    )?;
    let path = CubicSpline::through(&WAYPOINTS.map(Vec::from))?;
    let limits = MotionLimits::of(&model);
    let solve =
        |intervals| time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), intervals));
    let timed = solve(1000)?;
    Ok(Numbers {
        duration: timed.duration(),
        coarse: solve(500)?.duration(),
        used: limit_utilization(&model, &path, &timed, &limits, 4),
        moments: moments(&model, &path, &timed, &limits),
    })
}

/// Computes inverse dynamics along the motion. The acceleration of the path is discontinuous between
/// intervals.
fn moments(
    model: &Model,
    path: &impl TreePath,
    timed: &TimedPath,
    limits: &MotionLimits,
) -> Vec<(f64, [Vec<f64>; 2])> {
    let (workspace, mut tau) = (&mut Workspace::new(model), vec![0.0; model.nv()]);
    let shares = |x: &[f64], limits: &[f64]| -> Vec<f64> {
        x.iter().zip(limits).map(|(x, limit)| x / limit).collect()
    };
    let mut moments = Vec::new();
    for i in 0..timed.grid().len() - 1 {
        for end in [i, i + 1] {
            let (square, acceleration) = (timed.squared_speeds()[end], timed.acceleration(i));
            let TreePathPoint { q, dq, ddq } = path.at(timed.grid()[end]);
            let v: Vec<f64> = dq.iter().map(|dq| dq * square.sqrt()).collect();
            let a: Vec<f64> = dq.iter().zip(&ddq).map(|(dq, ddq)| dq * acceleration + ddq * square).collect();
            inverse_dynamics(model, workspace, &q, &v, &a, &mut tau);
            moments.push((
                timed.times()[end],
                [shares(&tau, &limits.torque_upper), shares(&v, &limits.velocity)],
            ));
        }
    }
    moments
}

impl Numbers {
    pub(crate) fn figure(&self) -> Figure {
        let panel = |name: &str, which: usize| {
            let points =
                |joint: usize| self.moments.iter().map(|(t, used)| (*t, used[which][joint])).collect();
            let lines =
                (0..7).map(|joint| Line::new(format!("joint {}", joint + 1), points(joint))).collect();
            Panel { name: name.into(), axis: Axis::Linear, lines, limits: vec![-1.0, 1.0] }
        };
        Figure {
            title: "The fastest motion through five waypoints: some limit is always reached".into(),
            across: "t [s]".into(),
            panels: vec![panel("Torque / limit", 0), panel("Velocity / limit", 1)],
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let numbers = numbers()?;
    let Numbers { duration, coarse, used, .. } = &numbers;
    println!("fastest motion            {duration:.6} s ({coarse:.6} s on half the grid)");
    println!("a limit is reached        on {:.1} % of the path", 100.0 * used.saturated);
    println!("limits at grid points     exceeded by {:.1e}", (used.at_grid_points - 1.0).max(0.0));
    println!("limits in between         exceeded by {:.1e}", (used.in_between - 1.0).max(0.0));
    let peaks: Vec<String> = used.peak_torque.iter().map(|tau| format!("{tau:.2}")).collect();
    println!("peak torques              {} N·m", peaks.join(", "));
    numbers.figure().save("03_fastest_motion")
}
