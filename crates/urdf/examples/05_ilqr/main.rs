//! Which torques bring the arm to its goal, when no motor may give more than it can?
//!
//! iLQR with box limits on two arms. The two-link arm swings up from hanging and stands: its shoulder has
//! 20 N·m, and holding the arm straight out would take 24.5. The seven-joint arm lifts 3 kg in its hand from
//! stretched out to drawn in. The motions found are replayed with steps ten times shorter and by a method that
//! shares nothing with the one they were found by.
//!
//! `cargo run --release --example 05_ilqr -p urdf`
#![allow(dead_code)] // the tests use the parts and leave out `main`

pub(crate) mod arm;
pub(crate) mod box_qp;
#[path = "../../../multibody/examples/plot/mod.rs"]
mod plot;
pub(crate) mod solver;

use std::error::Error;
use std::f64::consts::FRAC_PI_2;
use std::time::Instant;

use dynamics::{Integrator, MassProperties};
use multibody::{Model, RobotDescription, StepForces, StepWorkspace, Workspace, gravity, step};
use nalgebra::{DVector, Vector3};

use arm::Arm;
use plot::{Axis, Figure, Line, Panel};
use solver::{Plan, Plant, Task};

/// An arm, what it is asked to do, and in which steps \[s\].
pub(crate) struct Problem {
    pub(crate) model: Model,
    pub(crate) task: Task,
    pub(crate) h: f64,
}

fn robot(file: &str) -> Result<RobotDescription, Box<dyn Error>> {
    let path = format!("{}/../../robots/{file}.urdf", env!("CARGO_MANIFEST_DIR"));
    Ok(urdf::load(&path, &urdf::Options::default())?.description)
}

/// From rest at `start` to rest at `goal`, within the torque limits of the file.
///
/// A joint's full torque costs 1 a second, and so does 1 rad/s at `speed_weight` 2; u* holds the goal against
/// gravity.
fn problem(model: Model, h: f64, steps: usize, start: &[f64], goal: &[f64], speed_weight: f64) -> Problem {
    let n = model.nv();
    let at_rest = |q: &[f64]| DVector::from_fn(2 * n, |i, _| if i < n { q[i] } else { 0.0 });
    let limit = DVector::from_iterator(n, model.coordinate_limits().iter().map(|limit| limit.effort));
    let mut rest = DVector::zeros(n);
    gravity(&model, &mut Workspace::new(&model), goal, rest.as_mut_slice());
    let halves = |q: f64, v: f64| DVector::from_fn(2 * n, |i, _| if i < n { q } else { v });
    let task = Task {
        start: at_rest(start),
        goal: at_rest(goal),
        rest,
        state_weight: halves(0.0, h * speed_weight),
        control_weight: limit.map(|limit| h * 2.0 / (limit * limit)),
        end_weight: halves(100.0, 10.0),
        limit,
        steps,
        goal_tolerance: 1e-7,
    };
    Problem { model, task, h }
}

/// The two-link arm, from hanging to standing in 1.2 s.
pub(crate) fn swing_up() -> Result<Problem, Box<dyn Error>> {
    let model = Model::new(robot("two_r")?)?;
    Ok(problem(model, 0.005, 240, &[-FRAC_PI_2, 0.0], &[FRAC_PI_2, 0.0], 0.0))
}

/// The seven-joint arm with 3 kg in its hand, from stretched out to drawn in, in 1.1 s.
pub(crate) fn lift() -> Result<Problem, Box<dyn Error>> {
    let mut arm = robot("panda")?;
    // A block of 10 cm, its centre 6 cm before the flange.
    let block = MassProperties::solid_box(3000.0, Vector3::new(0.1, 0.1, 0.1))?;
    let ahead = Vector3::new(0.0, 0.0, 0.06);
    let load = MassProperties::new(block.mass(), ahead, block.inertia_about_center_of_mass())?;
    arm.attach_payload("panda_link8", &load)?;
    let start = [0.0, 1.2, 0.0, -0.5, 0.0, 1.7, 0.0];
    let goal = [1.0, -0.3, 0.3, -2.2, -0.4, 2.0, 0.8];
    Ok(problem(Model::new(arm)?, 0.0025, 440, &start, &goal, 0.2))
}

/// What the example prints of one arm.
pub(crate) struct Numbers {
    pub(crate) plan: Plan,
    /// The largest |uᵢ| / limitᵢ.
    pub(crate) torque: f64,
    /// The largest |vᵢ| / limitᵢ, which nothing enforces.
    pub(crate) speed: f64,
    /// The largest distance of a joint from the goal \[rad\], and from rest \[rad/s\].
    pub(crate) off: [f64; 2],
    /// The same with Runge–Kutta steps ten times shorter.
    pub(crate) off_finer: [f64; 2],
    /// The same with Yoshida's variational steps ten times shorter.
    pub(crate) off_variational: [f64; 2],
    /// The same from a start 0.01 rad off in every joint, steered by u + K δx within the limits.
    pub(crate) off_steered: [f64; 2],
    /// Seconds for one iteration.
    pub(crate) seconds: f64,
}

impl Problem {
    /// The motion, found from standing still at the start.
    pub(crate) fn numbers(&self) -> Result<Numbers, Box<dyn Error>> {
        let Self { model, task, h } = self;
        let begun = Instant::now();
        let n = model.nv();
        let mut standing = DVector::zeros(n);
        gravity(model, &mut Workspace::new(model), &task.start.as_slice()[..n], standing.as_mut_slice());
        let plan = task.solve(&mut Arm::new(model, *h), vec![standing; task.steps])?;
        let seconds = begun.elapsed().as_secs_f64() / plan.iterations as f64;
        let limits = model.coordinate_limits();
        let ratio = |x: &[f64], limit: fn(&multibody::Limits) -> f64| {
            x.iter().zip(&limits).map(|(x, of)| x.abs() / limit(of)).fold(0.0, f64::max)
        };
        let torque = plan.u.iter().map(|u| ratio(u.as_slice(), |limit| limit.effort)).fold(0.0, f64::max);
        let speed =
            plan.x.iter().map(|x| ratio(&x.as_slice()[n..], |limit| limit.velocity)).fold(0.0, f64::max);
        Ok(Numbers {
            torque,
            speed,
            off: self.off(plan.x[task.steps].as_slice()),
            off_finer: self.off(&self.replay(&plan, Integrator::RungeKutta4, 10)?),
            off_variational: self.off(&self.replay(&plan, Integrator::VariationalYoshida4, 10)?),
            off_steered: self.off(self.steer(&plan, 0.01)?.as_slice()),
            seconds,
            plan,
        })
    }

    /// Where the torques lead, each held over `parts` steps of another integrator.
    pub(crate) fn replay(
        &self,
        plan: &Plan,
        integrator: Integrator,
        parts: u32,
    ) -> Result<Vec<f64>, Box<dyn Error>> {
        let mut x = self.task.start.as_slice().to_vec();
        let (q, v) = x.split_at_mut(self.model.nv());
        let mut workspace = StepWorkspace::new(&self.model);
        for u in &plan.u {
            let forces = StepForces { tau: u.as_slice(), dissipation: true };
            for _ in 0..parts {
                step(&self.model, integrator, &mut workspace, &forces, self.h / f64::from(parts), q, v)?;
            }
        }
        Ok(x)
    }

    /// Where u + K δx, clamped, leads from a start that is `off` in every joint.
    fn steer(&self, plan: &Plan, off: f64) -> Result<DVector<f64>, Box<dyn Error>> {
        let mut arm = Arm::new(&self.model, self.h);
        let mut x = self.task.start.clone();
        x.rows_mut(0, self.model.nv()).add_scalar_mut(off);
        for k in 0..self.task.steps {
            let u = &plan.u[k] + &plan.gains[k] * (&x - &plan.x[k]);
            x = arm.step(&x, &self.task.clamped(&u))?;
        }
        Ok(x)
    }

    fn off(&self, x: &[f64]) -> [f64; 2] {
        let n = self.model.nv();
        let largest = |range: std::ops::Range<usize>| {
            range.map(|i| (x[i] - self.task.goal[i]).abs()).fold(0.0, f64::max)
        };
        [largest(0..n), largest(n..2 * n)]
    }
}

impl Problem {
    /// Angles, and torques over their limits.
    fn panels(&self, name: &str, plan: &Plan) -> [Panel; 2] {
        let (n, h, steps) = (self.model.nv(), self.h, self.task.steps);
        let time = |k: usize| k as f64 * h;
        let angle = |i: usize| (0..=steps).map(|k| (time(k), plan.x[k][i])).collect();
        let share = |i: usize, k: usize| plan.u[k][i] / self.task.limit[i];
        let torque = |i: usize| (0..=steps).map(|k| (time(k), share(i, k.min(steps - 1)))).collect();
        let names: Vec<String> = self.model.joints().iter().map(|joint| joint.name.clone()).collect();
        let lines = |of: &dyn Fn(usize) -> Vec<(f64, f64)>| {
            (0..n).map(|i| Line::new(names[i].trim_start_matches("panda_"), of(i))).collect()
        };
        let panel = |quantity: &str, lines, limits| Panel {
            name: format!("{name}: {quantity}"),
            axis: Axis::Linear,
            lines,
            limits,
        };
        [
            panel("angles [rad]", lines(&angle), vec![]),
            panel("torque / limit", lines(&torque), vec![-1.0, 1.0]),
        ]
    }
}

pub(crate) fn figure(panels: Vec<Panel>) -> Figure {
    Figure { title: "To the goal within the torque limits".into(), across: "t [s]".into(), panels }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut panels = Vec::new();
    for (name, problem) in
        [("two-link arm, swing-up", swing_up()?), ("seven-joint arm, 3 kg lifted", lift()?)]
    {
        let Numbers { plan, torque, speed, off, off_finer, off_variational, off_steered, seconds } =
            problem.numbers()?;
        println!("{name}");
        println!("  iterations           {}, λ renewed {} times", plan.iterations, plan.renewals);
        println!("  one iteration        {:.2} ms", seconds * 1e3);
        println!("  cost                 {:.8}", plan.cost);
        println!("  largest |u|/limit    {torque}");
        println!("  largest |v|/limit    {speed:.3} (not enforced)");
        for (what, [q, v]) in [
            ("from the goal", off),
            ("… in finer steps", off_finer),
            ("… by another method", off_variational),
            ("… steered, start off", off_steered),
        ] {
            println!("  {what:<21}{q:.1e} rad, {v:.1e} rad/s");
        }
        panels.extend(problem.panels(name, &plan));
    }
    figure(panels).save("05_ilqr")
}
