//! The memory of one step.

use super::explicit::{StageMemory, most_stages};
use super::mass_factor::MassFactor;
use super::newton::Newton;
use crate::joint::Chart;
use crate::space::configuration::stretches;
use crate::{Model, Workspace};

/// Scratch for [`step`](crate::step) on one model; like [`Workspace`], it carries nothing from call to call.
#[derive(Clone, Debug)]
pub struct StepWorkspace {
    pub(crate) dynamics: Workspace,
    pub(crate) force: Vec<f64>,
    /// A middle's q and v, and a displacement.
    pub(crate) q: Vec<f64>,
    pub(crate) v: Vec<f64>,
    pub(crate) displacement: Vec<f64>,
    /// Of the explicit rows, cut by `StageMemory`.
    pub(crate) stages: Vec<f64>,
    /// Of the implicit rows: the start of the inner step, momenta, and what their equation is made of.
    pub(crate) q_start: Vec<f64>,
    pub(crate) p_start: Vec<f64>,
    pub(crate) momentum: Vec<f64>,
    pub(crate) slope: Vec<f64>,
    pub(crate) gravity: Vec<f64>,
    pub(crate) held: Vec<f64>,
    pub(crate) residual: Vec<f64>,
    pub(crate) factor: MassFactor,
    pub(crate) newton: Newton,
    /// Which coordinates have a plain number in q.
    pub(crate) is_plain: Vec<bool>,
}

impl StepWorkspace {
    /// Memory for this model: the only allocation of stepping it.
    pub fn new(model: &Model) -> Self {
        let (nq, nv) = (model.nq(), model.nv());
        let mut is_plain = vec![false; nv];
        for stretch in stretches(model).filter(|stretch| stretch.chart == Chart::Line) {
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

    /// The memory of the recursions.
    pub fn dynamics(&mut self) -> &mut Workspace {
        &mut self.dynamics
    }
}
