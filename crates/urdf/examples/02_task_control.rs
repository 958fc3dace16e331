//! How heavy does the hand feel, and how well does it follow a circle?
//!
//! A seven-joint arm draws a circle of 10 cm in two seconds by operational-space control; the numbers are the
//! inertia Λ its hand has in each direction at the start, and the largest distance from the circle.
//!
//! `cargo run --release --example 02_task_control -p urdf`
#![allow(dead_code)] // the tests use the parts and leave out `main`

use std::error::Error;
use std::f64::consts::{FRAC_PI_2, PI};
use std::ops::ControlFlow;

use dynamics::Integrator;
use multibody::{
    ClosureRow, Model, Simulation, TaskControl, TaskReference, Workspace, frame_pose, operational_space,
};

/// The arm, its ready pose, and its hand.
const ROBOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf");
const READY: [f64; 7] = [0.0, -0.4, 0.0, -2.2, 0.0, 1.9, 0.8];
const HAND: &str = "panda_link8";

/// What the example prints.
pub(crate) struct Numbers {
    /// The diagonal of Λ for x, y, z \[kg\].
    pub(crate) inertia: [f64; 3],
    /// The largest distance from where the hand should be \[m\].
    pub(crate) error: f64,
}

pub(crate) fn numbers() -> Result<Numbers, Box<dyn Error>> {
    let model = Model::new(urdf::load(ROBOT, &urdf::Options::default())?.description)?;
    let frame = model.frame(HAND).ok_or("no hand")?;
    let rest = [0.0; 7];
    let workspace = &mut Workspace::new(&model);
    let rows = [ClosureRow::X, ClosureRow::Y, ClosureRow::Z];
    let space = operational_space(&model, workspace, &READY, &rest, frame, &rows)?;
    let [x, y, z] = frame_pose(&model, workspace, &READY, frame).translation;

    // A circle in the y-z plane, begun and ended at rest: its angle is π (1 − cos πt/2).
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
    let mut control = TaskControl {
        model: &model,
        workspace: Workspace::new(&model),
        frame,
        reference: circle,
        stiffness: 400.0,
        damping: 40.0,
        null_damping: 5.0,
    };
    let simulation = Simulation {
        model: &model,
        integrator: Integrator::RungeKutta4,
        step: 1e-3,
        dissipation: false,
        sample_every: 0,
    };
    let mut error = 0.0f64;
    simulation.run(&READY, &rest, 2000, &mut control, |moment| {
        let hand = frame_pose(&model, workspace, moment.q, frame).translation;
        let wanted = circle(moment.time).position;
        let off = (0..3).map(|k| (hand[k] - wanted[k]).powi(2)).sum::<f64>().sqrt();
        error = error.max(off);
        ControlFlow::Continue(())
    })?;
    Ok(Numbers { inertia: std::array::from_fn(|k| space.inertia[(k, k)]), error })
}

fn main() -> Result<(), Box<dyn Error>> {
    let Numbers { inertia: [x, y, z], error } = numbers()?;
    println!("inertia of the hand along x, y, z   {x:.4}, {y:.4}, {z:.4} kg");
    println!("largest distance from the circle    {:.4} mm", error * 1e3);
    Ok(())
}
