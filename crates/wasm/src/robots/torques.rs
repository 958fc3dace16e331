//! The terms of the equation of motion, M q̈ + C q̇ + g = τ + the rest, coordinate by coordinate.

use multibody::{difference, gravity, integrate, inverse_dynamics};
use wasm_bindgen::prelude::wasm_bindgen;

use super::robot::Robot;

/// A step as it was taken.
#[derive(Clone, Debug)]
pub(crate) struct Step {
    /// q and v before it.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    /// What motors and hand gave, the same all through it.
    pub(crate) tau: Vec<f64>,
    /// How long it was \[s\].
    pub(crate) h: f64,
}

/// What each coordinate's equation is made of, nv numbers a term \[N·m or N\]: averaged over the last step, which is what a
/// method of second order knows of them; at rest, before the first step, of the pose alone.
#[wasm_bindgen(getter_with_clone)]
#[derive(Clone, Debug)]
pub struct RobotTorques {
    /// M q̈; empty before the first step.
    #[wasm_bindgen(readonly)]
    pub inertial: Vec<f64>,
    /// C q̇.
    #[wasm_bindgen(readonly)]
    pub coriolis: Vec<f64>,
    /// g(q): what motors must give to hold the pose.
    #[wasm_bindgen(readonly)]
    pub gravity: Vec<f64>,
    /// What motors and hand gave; empty before the first step.
    #[wasm_bindgen(readonly)]
    pub applied: Vec<f64>,
    /// What is left of the equation, which damping, friction, stops, the ground and loops gave; empty before the first step.
    #[wasm_bindgen(readonly)]
    pub rest: Vec<f64>,
}

#[wasm_bindgen]
impl Robot {
    /// The terms of the equation of motion over the last step: M and C and g at the middle of the way it took, with the
    /// mean velocity, and q̈ = Δv/h.
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
