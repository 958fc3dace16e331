//! Trajectory optimization of arms within their torque limits.
//!
//! iLQR with box limits on two arms. The two-link arm swings up from hanging to standing. Its shoulder has 20
//! N·m, and a horizontal straight arm would need 24.5 N·m. The seven-joint arm lifts 3 kg in its hand from a
//! stretched to a retracted pose. The motions are replayed with steps ten times shorter, and with a
//! variational method that steps momenta instead of velocities.
//!
//! `cargo run --release --example 05_ilqr -p robot-dynamics-urdf`
#![allow(dead_code)] // the tests do not call `main`

pub(crate) mod arm;
pub(crate) mod box_qp;
#[path = "../plot/mod.rs"]
mod plot;
pub(crate) mod problem;
pub(crate) mod solver;

use std::error::Error;
use std::time::Instant;

use plot::{Axis, Figure, Line, Panel};
use problem::{Problem, lift, swing_up};
use robot_dynamics::algorithms::frame_pose;
use robot_dynamics::model::Workspace;
use robot_dynamics::simulation::Integrator;
use solver::Plan;

/// The results that the example prints for one arm.
pub(crate) struct Numbers {
    pub(crate) plan: Plan,
    /// The largest |uᵢ| / limitᵢ.
    pub(crate) torque: f64,
    /// The largest |vᵢ| / limitᵢ, which is not enforced.
    pub(crate) speed: f64,
    /// The largest distance of a joint from the goal \[rad\], and of its velocity from rest \[rad/s\].
    pub(crate) off: [f64; 2],
    /// The same with Runge–Kutta steps ten times shorter.
    pub(crate) off_finer: [f64; 2],
    /// The same with Yoshida's variational steps ten times shorter.
    pub(crate) off_variational: [f64; 2],
    /// The same from a start with an error of 0.01 rad in every joint, controlled by u + K δx within the
    /// limits.
    pub(crate) off_steered: [f64; 2],
    /// The duration of one iteration \[s\].
    pub(crate) seconds: f64,
}

/// The number of intervals between drawn poses.
const POSES: usize = 12;

impl Problem {
    /// Computes the motion and its results.
    pub(crate) fn numbers(&self) -> Result<Numbers, Box<dyn Error>> {
        let begun = Instant::now();
        let plan = self.solve()?;
        let seconds = begun.elapsed().as_secs_f64() / plan.iterations as f64;
        let Self { model, task, .. } = self;
        let n = model.nv();
        let limits = model.coordinate_limits();
        let ratio = |x: &[f64], limit: fn(&robot_dynamics::description::Limits) -> f64| {
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

    /// Panels of angles, and of torques relative to their limits. For a planar arm a panel of its poses in
    /// the x-z plane comes first.
    pub(crate) fn panels(&self, name: &str, plan: &Plan) -> Vec<Panel> {
        let (n, h, steps) = (self.model.nv(), self.h, self.task.steps);
        let time = |k: usize| k as f64 * h;
        let angle = |i: usize| (0..=steps).map(|k| (time(k), plan.x[k][i])).collect();
        let share = |i: usize, k: usize| plan.u[k][i] / self.task.limit[i];
        let torque = |i: usize| (0..=steps).map(|k| (time(k), share(i, k.min(steps - 1)))).collect();
        let names = self.model.coordinate_names();
        let lines = |of: &dyn Fn(usize) -> Vec<(f64, f64)>| {
            (0..n).map(|i| Line::new(names[i].trim_start_matches("panda_"), of(i))).collect()
        };
        let panel = |quantity: &str, lines, limits| Panel {
            name: format!("{name}: {quantity}"),
            axis: Axis::Linear,
            lines,
            limits,
        };
        let mut panels = vec![
            panel("angles [rad]", lines(&angle), vec![]),
            panel("torque / limit", lines(&torque), vec![-1.0, 1.0]),
        ];
        if n == 2 {
            let poses = Line::new(format!("every {} s", time(steps / POSES)), self.poses(plan));
            panels.insert(0, panel("from the side, z [m]", vec![poses], vec![]));
        }
        panels
    }

    /// x and z of the joints and the last frame, with the base at its time on the axis.
    fn poses(&self, plan: &Plan) -> Vec<(f64, f64)> {
        let Self { model, task, h } = self;
        let workspace = &mut Workspace::new(model);
        let moving = model.joints().iter().filter(|joint| joint.nv > 0);
        let mut frames: Vec<&str> = moving.map(|joint| joint.child_link.as_str()).collect();
        frames.extend(model.frames().last().map(|frame| frame.name.as_str()));
        let mut chains = Vec::new();
        for k in (0..=task.steps).step_by(task.steps / POSES) {
            let q = &plan.x[k].as_slice()[..model.nv()];
            let chain: Vec<[f64; 3]> = frames
                .iter()
                .filter_map(|name| model.frame(name))
                .map(|frame| frame_pose(model, workspace, q, frame).translation)
                .collect();
            chains.push((k as f64 * h, chain));
        }
        let heights = || chains.iter().flat_map(|(_, chain)| chain).map(|point| point[2]);
        let up = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
        let seconds_per_metre = 1.0 / Figure::aspect(task.steps as f64 * h, up);
        let mut points = Vec::new();
        for (t, chain) in chains {
            points.extend(chain.iter().map(|[x, _, z]| (t + x * seconds_per_metre, *z)));
            points.push((f64::NAN, f64::NAN));
        }
        points
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
