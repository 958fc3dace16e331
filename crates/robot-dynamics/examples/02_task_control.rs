//! The apparent inertia of a hand, and its tracking error on a circle.
//!
//! A seven-joint arm draws a circle of 10 cm in two seconds by operational-space control. The example prints
//! the inertia Λ of the hand in each direction at the start, and the largest distance from the circle. It
//! also prints how far the joints are from their start after the circle: a position needs three of seven
//! joints, so the others drift unless a posture spring holds them.
//!
//! `cargo run --release --example 02_task_control -p robot-dynamics-urdf`
#![allow(dead_code)] // the tests do not call `main`

#[path = "plot/mod.rs"]
mod plot;

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

use plot::{Axis, Figure, Line, Panel};
use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::constraints::SpatialAxis;
use robot_dynamics::control::{TaskControl, TaskGains, TaskReference, operational_space};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Effect, Integrator, Method, RunOptions, SimulationBuilder};

/// The arm, its ready pose, and its hand.
const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
const READY: [f64; 7] = [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8];
const HAND: &str = "panda_link8";

/// The results that the example prints and draws.
pub(crate) struct Numbers {
    /// The diagonal of Λ for x, y, z \[kg\].
    pub(crate) inertia: [f64; 3],
    /// The largest distance of the hand from the reference \[m\].
    pub(crate) error: f64,
    /// The largest |q − q₀| after the circle, without and with a posture spring \[rad\].
    pub(crate) away: [f64; 2],
    /// Time, the position error of the hand \[m\], and the torques relative to their limits.
    pub(crate) moments: Vec<(f64, [f64; 3], Vec<f64>)>,
}

pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let model = Model::new(
        robot_dynamics::urdf::load(ROBOT, &robot_dynamics::urdf::LoadOptions::default())?.description,
    )?;
    let frame = model.frame(HAND).ok_or("no hand")?;
    let rest = [0.0; 7];
    let workspace = &mut Workspace::new(&model);
    let rows = [SpatialAxis::X, SpatialAxis::Y, SpatialAxis::Z];
    let space = operational_space(&model, workspace, &READY, &rest, frame, &rows)?;
    let [x, y, z] = frame_pose(&model, workspace, &READY, frame).translation;

    // A circle in the y-z plane that starts and ends at rest: its angle is π (1 − cos πt/2).
    let circle = move |t: f64| {
        let (rate, time) = (FRAC_PI_2, t.min(2.0));
        let angle = PI * (1.0 - (rate * time).cos());
        let (speed, acceleration) = (PI * rate * (rate * time).sin(), PI * rate * rate * (rate * time).cos());
        let (s, c) = angle.sin_cos();
        let r = 0.1;
        TaskReference {
            position: [x, y + r * s, z + r * (c - 1.0)],
            velocity: [0.0, r * c * speed, -r * s * speed],
            acceleration: [
                0.0,
                r * (c * acceleration - s * speed * speed),
                -r * (s * acceleration + c * speed * speed),
            ],
        }
    };
    let gains = TaskGains { stiffness: 400.0, damping: 40.0, null_damping: 5.0 };
    let mut control = TaskControl::new(&model, frame, circle, gains)?;
    let mut drawn_home = TaskControl::new(&model, frame, circle, gains)?.with_posture(&READY, 6.25)?;
    let mut simulation = SimulationBuilder::new(&model)
        .method(Method::Fixed(Integrator::RungeKutta4))
        .without(Effect::Dissipation)
        .build()?;
    let limits = model.coordinate_limits();
    let mut moments = Vec::new();
    let run = simulation.run_from(
        &READY,
        &rest,
        2.0,
        RunOptions::new().sample_ends().controller(&mut control).observer(&mut |info| {
            let hand = frame_pose(&model, workspace, info.q, frame).translation;
            let wanted = circle(info.time).position;
            let used = info.tau.iter().zip(&limits).map(|(tau, limit)| tau / limit.effort).collect();
            moments.push((info.time, std::array::from_fn(|k| hand[k] - wanted[k]), used));
            ControlFlow::Continue(())
        }),
    )?;
    let home = simulation.run_from(
        &READY,
        &rest,
        2.0,
        RunOptions::new().sample_ends().controller(&mut drawn_home),
    )?;
    let away =
        [run.q, home.q].map(|q| q.iter().zip(&READY).map(|(q, q0)| (q - q0).abs()).fold(0.0, f64::max));
    let error =
        moments.iter().map(|(_, off, _)| off.iter().map(|x| x * x).sum::<f64>().sqrt()).fold(0.0, f64::max);
    Ok(Numbers { inertia: std::array::from_fn(|k| space.inertia[(k, k)]), error, away, moments })
}

impl Numbers {
    pub(crate) fn figure(&self) -> Figure {
        let off = |k: usize| self.moments.iter().map(|(t, off, _)| (*t, off[k] * 1e3)).collect();
        let used = |i: usize| self.moments.iter().map(|(t, _, used)| (*t, used[i])).collect();
        let panel =
            |name: &str, lines, limits| Panel { name: name.into(), axis: Axis::Linear, lines, limits };
        let offs = ["x", "y", "z"].into_iter().enumerate().map(|(k, name)| Line::new(name, off(k))).collect();
        let torques = (0..7).map(|i| Line::new(format!("joint {}", i + 1), used(i))).collect();
        Figure {
            title: "A circle of 10 cm in two seconds by task-space control".into(),
            across: "t [s]".into(),
            panels: vec![
                panel("Hand less where it should be [mm]", offs, vec![]),
                panel("Torque / limit", torques, vec![-1.0, 1.0]),
            ],
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let numbers = numbers()?;
    let Numbers { inertia: [x, y, z], error, away: [left, drawn], .. } = numbers;
    println!("inertia of the hand along x, y, z   {x:.4}, {y:.4}, {z:.4} kg");
    println!("largest distance from the circle    {:.4} mm", error * 1e3);
    println!("joints away from the start after it {left:.4} rad; with a posture spring {drawn:.4} rad");
    numbers.figure().save("02_task_control")
}
