//! The memory of a step.

use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_core::{Model, Workspace};

use super::mass_factor::MassFactor;
use super::newton_memory::Newton;
use super::stage_memory::{StageMemory, most_stages};

/// Scratch for [`step`](crate::step) on one model; like [`Workspace`], it holds no state between calls.
#[derive(Clone, Debug)]
pub struct StepWorkspace {
    pub dynamics: Workspace,
    pub force: Vec<f64>,
    /// q and v of a middle, and a displacement.
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub displacement: Vec<f64>,
    /// Memory of the explicit rows, cut by `StageMemory`.
    pub stages: Vec<f64>,
    /// Memory of the implicit rows: the start of the inner step, momenta, and the terms of their equation.
    pub(crate) q_start: Vec<f64>,
    pub(crate) p_start: Vec<f64>,
    pub momentum: Vec<f64>,
    pub slope: Vec<f64>,
    pub gravity: Vec<f64>,
    pub held: Vec<f64>,
    pub residual: Vec<f64>,
    pub factor: MassFactor,
    pub(crate) newton: Newton,
    /// Whether each coordinate of v has a plain coordinate in q.
    pub is_plain: Vec<bool>,
}

impl StepWorkspace {
    /// Allocates the memory for this model; steps do not allocate.
    pub fn new(model: &Model) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        let mut is_plain = vec![false; nv];
        for stretch in coordinate_ranges(model).filter(|stretch| stretch.chart == Chart::Line) {
            is_plain[stretch.v] = true;
        }
        Self {
            dynamics: Workspace::new(model),
            force: vec![0.0; nv],
            q: vec![0.0; nq],
            v: vec![0.0; nv],
            displacement: vec![0.0; nv],
            stages: vec![0.0; StageMemory::<f64>::size(model, most_stages())],
            q_start: vec![0.0; nq],
            p_start: vec![0.0; nv],
            momentum: vec![0.0; nv],
            slope: vec![0.0; nv],
            gravity: vec![0.0; nv],
            held: vec![0.0; nv],
            residual: vec![0.0; nv],
            factor: MassFactor::new(model),
            newton: Newton::new(nv),
            is_plain,
        }
    }

    /// The workspace of the recursions.
    pub fn dynamics(&mut self) -> &mut Workspace {
        &mut self.dynamics
    }
}
