//! The tasks of the arms, and replays of their torques.

use std::error::Error;
use std::f64::consts::FRAC_PI_2;

use nalgebra::{DVector, Vector3};
use robot_dynamics::algorithms::gravity;
use robot_dynamics::description::{MassProperties, RobotDescription};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};

use super::arm::Arm;
use super::solver::{Plan, Plant, Task};

/// An arm, its task, and the step size \[s\].
pub(crate) struct Problem {
    pub(crate) model: Model,
    pub(crate) task: Task,
    pub(crate) h: f64,
}

fn robot(file: &str) -> Result<RobotDescription, Box<dyn Error>> {
    let path = format!("{}/../../robots/{file}.urdf", env!("CARGO_MANIFEST_DIR"));
    Ok(robot_dynamics::urdf::load(&path, &robot_dynamics::urdf::LoadOptions::default())?.description)
}

/// A task from rest at `start` to rest at `goal`, within the torque limits of the file.
///
/// The full torque of a joint costs 1 per second, as does 1 rad/s with a `speed_weight` of 2. u* holds the
/// goal against gravity.
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

/// The seven-joint arm with 3 kg in its hand, from a stretched to a retracted pose in 1.1 s.
pub(crate) fn lift() -> Result<Problem, Box<dyn Error>> {
    let mut arm = robot("panda")?;
    // A block of 10 cm whose centre is 6 cm in front of the flange.
    let block = MassProperties::solid_box(3000.0, Vector3::new(0.1, 0.1, 0.1))?;
    let ahead = Vector3::new(0.0, 0.0, 0.06);
    let load = MassProperties::new(block.mass(), ahead, block.inertia_about_center_of_mass())?;
    arm.attach_payload("panda_link8", &load)?;
    let start = [0.0, 1.2, 0.0, -0.5, 0.0, 1.7, 0.0];
    let goal = [1.0, -0.3, 0.3, -2.2, -0.4, 2.0, 0.8];
    Ok(problem(Model::new(arm)?, 0.0025, 440, &start, &goal, 0.2))
}

impl Problem {
    /// Solves with the torques that hold the start as initial controls.
    pub(crate) fn solve(&self) -> Result<Plan, Box<dyn Error>> {
        self.solve_from(0.0)
    }

    /// Solves with initial controls that differ from the holding torques by `off` \[N·m\].
    pub(crate) fn solve_from(&self, off: f64) -> Result<Plan, Box<dyn Error>> {
        let n = self.model.nv();
        let mut standing = DVector::zeros(n);
        let q = &self.task.start.as_slice()[..n];
        gravity(&self.model, &mut Workspace::new(&self.model), q, standing.as_mut_slice());
        standing.add_scalar_mut(off);
        self.task.solve(&mut Arm::new(&self.model, self.h), vec![standing; self.task.steps])
    }

    /// Replays the torques with another integrator, each held over `parts` steps.
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
            let forces = StepForces::new(u.as_slice(), true);
            for _ in 0..parts {
                step(&self.model, integrator, &mut workspace, &forces, self.h / f64::from(parts), q, v)?;
            }
        }
        Ok(x)
    }

    /// The end under u + K δx, clamped, from a start with an error of `off` in every joint.
    pub(crate) fn steer(&self, plan: &Plan, off: f64) -> Result<DVector<f64>, Box<dyn Error>> {
        let mut arm = Arm::new(&self.model, self.h);
        let mut x = self.task.start.clone();
        x.rows_mut(0, self.model.nv()).add_scalar_mut(off);
        for k in 0..self.task.steps {
            let u = &plan.u[k] + &plan.gains[k] * (&x - &plan.x[k]);
            x = arm.step(&x, &self.task.clamped(&u))?;
        }
        Ok(x)
    }

    /// The largest distance of a joint from the goal \[rad\], and of its velocity from rest \[rad/s\].
    pub(crate) fn off(&self, x: &[f64]) -> [f64; 2] {
        let n = self.model.nv();
        let largest = |range: std::ops::Range<usize>| {
            range.map(|i| (x[i] - self.task.goal[i]).abs()).fold(0.0, f64::max)
        };
        [largest(0..n), largest(n..2 * n)]
    }
}
