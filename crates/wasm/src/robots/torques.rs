//! The terms of the equation of motion M q̈ + C q̇ + g = τ + others, for each coordinate.

use robot_dynamics::algorithms::{gravity, inverse_dynamics};
use robot_dynamics::model::{difference, integrate};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// The terms of each coordinate's equation, nv numbers for each term \[N·m or N\], averaged over the last
/// step, to second order. Before the first step they are those of the pose at rest.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct RobotTorques {
    /// M q̈; empty before the first step.
    #[wasm_bindgen(readonly)]
    pub inertial: Vec<f64>,
    /// C q̇.
    #[wasm_bindgen(readonly)]
    pub coriolis: Vec<f64>,
    /// g(q): the torque of motors that hold the pose.
    #[wasm_bindgen(readonly)]
    pub gravity: Vec<f64>,
    /// Torque of motors and hand; empty before the first step.
    #[wasm_bindgen(readonly)]
    pub applied: Vec<f64>,
    /// The rest of the equation, which damping, friction, stops, the ground and loops contribute; empty
    /// before the first step.
    #[wasm_bindgen(readonly)]
    pub rest: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// The terms of the equation of motion over the last step: M, C and g at the midpoint with the mean
    /// velocity, and q̈ = Δv/h.
    pub fn torques(&mut self) -> RobotTorques {
        let (model, workspace, nv) = (&*self.model, &mut self.workspace, self.model.nv());
        let (mut q, mut v) = (self.simulation.q().to_vec(), self.simulation.v().to_vec());
        let mut acceleration = vec![0.0; nv];
        if let Some(step) = &self.last {
            let mut way = vec![0.0; nv];
            difference(model, &step.q, self.simulation.q(), &mut way);
            let half: Vec<f64> = way.iter().map(|x| 0.5 * x).collect();
            integrate(model, &step.q, &half, &mut q);
            for (k, mean) in v.iter_mut().enumerate() {
                acceleration[k] = (*mean - step.v[k]) / step.h;
                *mean = f64::midpoint(*mean, step.v[k]);
            }
        }
        let still = vec![0.0; nv];
        let (mut sum, mut bias, mut weight) = (still.clone(), still.clone(), still.clone());
        inverse_dynamics(model, workspace, &q, &v, &acceleration, &mut sum);
        inverse_dynamics(model, workspace, &q, &v, &still, &mut bias);
        gravity(model, workspace, &q, &mut weight);
        let less = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
        let (inertial, applied, rest) = match &self.last {
            Some(step) => (less(&sum, &bias), step.tau.clone(), less(&sum, &step.tau)),
            None => (Vec::new(), Vec::new(), Vec::new()),
        };
        RobotTorques { inertial, coriolis: less(&bias, &weight), gravity: weight, applied, rest }
    }
}
