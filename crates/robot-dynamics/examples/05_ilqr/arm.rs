//! An arm as a plant: x = (q, v), u = τ. A step is one Runge–Kutta step with constant τ, and A and B are the
//! derivatives of that step.

use std::error::Error;

use nalgebra::{DMatrix, DVector};
use robot_dynamics::derivatives::{LinearizeStepWorkspace, LinearizedStep, RobotState, linearize_step};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{Integrator, StepForces, StepWorkspace, step};

use super::solver::Plant;

/// An arm of revolute and prismatic joints, so that q has no quaternions.
pub(crate) struct Arm<'a> {
    model: &'a Model,
    /// The step size \[s\].
    pub(crate) h: f64,
    stepping: StepWorkspace,
    linearizing: LinearizeStepWorkspace,
}

impl<'a> Arm<'a> {
    pub(crate) fn new(model: &'a Model, h: f64) -> Self {
        assert_eq!(model.nq(), model.nv(), "x = (q, v) needs joints without quaternions");
        Self {
            model,
            h,
            stepping: StepWorkspace::new(model),
            linearizing: LinearizeStepWorkspace::new(model),
        }
    }
}

impl Plant for Arm<'_> {
    fn step(&mut self, x: &DVector<f64>, u: &DVector<f64>) -> Result<DVector<f64>, Box<dyn Error>> {
        let mut next = x.clone();
        let (q, v) = next.as_mut_slice().split_at_mut(self.model.nv());
        let forces = StepForces::new(u.as_slice(), true);
        step(self.model, Integrator::RungeKutta4, &mut self.stepping, &forces, self.h, q, v)?;
        Ok(next)
    }

    fn linearize(
        &mut self,
        x: &DVector<f64>,
        u: &DVector<f64>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), Box<dyn Error>> {
        let n = self.model.nv();
        let (q, v) = x.as_slice().split_at(n);
        let forces = StepForces::new(u.as_slice(), true);
        let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * n]);
        let (integrator, workspace) = (Integrator::RungeKutta4, &mut self.linearizing);
        let out = LinearizedStep { by_state: &mut a, by_force: &mut b };
        linearize_step(self.model, integrator, workspace, &forces, self.h, RobotState { q, v }, out)?;
        Ok((DMatrix::from_row_slice(2 * n, 2 * n, &a), DMatrix::from_row_slice(2 * n, n, &b)))
    }
}
