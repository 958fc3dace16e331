//! How fast can the arm go along this path?
//!
//! A seven-joint arm through five waypoints within the torque and velocity limits of its file, timed by
//! reachability analysis on 1000 intervals and checked by inverse dynamics.
//!
//! `cargo run --release --example 03_fastest_motion -p urdf`
#![allow(dead_code)] // the tests use the parts and leave out `main`

use std::error::Error;

use multibody::{CubicSpline, LimitUse, Model, MotionLimits, TimeOptimal, limit_use, time_optimal};

const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");

/// Where the path goes through \[rad\].
const WAYPOINTS: [[f64; 7]; 5] = [
    [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8],
    [0.8, 0.3, -0.4, -1.4, 0.5, 1.2, 1.4],
    [1.4, 0.9, 0.3, -0.9, -0.6, 2.3, 0.2],
    [0.3, 0.5, 0.9, -1.9, -1.2, 1.5, -0.9],
    [-0.9, -0.2, 0.4, -2.5, 0.1, 2.8, 0.5],
];

/// What the example prints.
pub(crate) struct Numbers {
    /// Seconds from rest to rest.
    pub(crate) duration: f64,
    /// Seconds with half the grid.
    pub(crate) coarse: f64,
    /// How far the limits are used.
    pub(crate) used: LimitUse,
}

pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let model = Model::new(urdf::load(ROBOT, &urdf::Options::default())?.description)?;
    let path = CubicSpline::through(&WAYPOINTS.map(Vec::from))?;
    let limits = MotionLimits::of(&model);
    let solve =
        |intervals| time_optimal(&model, &path, &TimeOptimal::from_rest_to_rest(limits.clone(), intervals));
    let timed = solve(1000)?;
    Ok(Numbers {
        duration: timed.duration(),
        coarse: solve(500)?.duration(),
        used: limit_use(&model, &path, &timed, &limits, 4),
    })
}

fn main() -> Result<(), Box<dyn Error>> {
    let Numbers { duration, coarse, used } = numbers()?;
    println!("fastest motion            {duration:.6} s ({coarse:.6} s on half the grid)");
    println!("a limit is reached        on {:.1} % of the path", 100.0 * used.saturated);
    println!("limits at grid points     exceeded by {:.1e}", (used.at_grid_points - 1.0).max(0.0));
    println!("limits in between         exceeded by {:.1e}", (used.in_between - 1.0).max(0.0));
    let peaks: Vec<String> = used.peak_torque.iter().map(|tau| format!("{tau:.2}")).collect();
    println!("peak torques              {} N·m", peaks.join(", "));
    Ok(())
}
