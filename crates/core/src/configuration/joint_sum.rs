//! Weighted sums of joint positions: lengths of tendons, positions of joints by name.

use std::collections::BTreeMap;

use robot_dynamics_description::TendonDescription;

use crate::Model;

/// ℓ = offset + Σ cᵢ q\[i\] over joints with one DoF.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct JointSum {
    offset: f64,
    terms: Vec<Term>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Term {
    /// Indices in q and in v.
    q: usize,
    v: usize,
    factor: f64,
}

impl JointSum {
    /// From joint names and factors. A mimic joint counts with its leader's position; a locked joint does not
    /// count.
    pub fn new<'a>(model: &Model, offset: f64, joints: impl IntoIterator<Item = (&'a str, f64)>) -> Self {
        let mut sum = Self { offset, terms: Vec::new() };
        for (name, factor) in joints {
            let joint = model.joints.iter().position(|joint| joint.name == name);
            let dof = model.dofs.iter().find(|dof| Some(dof.joint) == joint);
            if let Some(dof) = dof {
                sum.offset += factor * dof.offset;
                sum.terms.push(Term {
                    q: model.bodies[dof.body].q_index,
                    v: dof.coordinate,
                    factor: factor * dof.ratio,
                });
            }
        }
        sum
    }

    /// The length of a tendon over joints.
    pub fn of_tendon(model: &Model, tendon: &TendonDescription) -> Self {
        let terms = tendon.terms.iter().map(|(joint, factor)| (joint.as_str(), *factor));
        Self::new(model, tendon.offset, terms)
    }

    /// ℓ − a constant.
    #[must_use]
    pub fn minus(self, constant: f64) -> Self {
        Self { offset: self.offset - constant, ..self }
    }

    /// ℓ(q).
    pub fn at(&self, q: &[f64]) -> f64 {
        self.terms.iter().fold(self.offset, |sum, term| term.factor.mul_add(q[term.q], sum))
    }

    /// ℓ̇.
    pub fn rate(&self, v: &[f64]) -> f64 {
        self.terms.iter().map(|term| term.factor * v[term.v]).sum()
    }

    /// The coordinates and their c.
    pub fn terms(&self) -> impl ExactSizeIterator<Item = (usize, f64)> {
        self.terms.iter().map(|term| (term.v, term.factor))
    }

    /// The coordinates in ascending order, each once, with the sum of its c.
    pub fn row(&self) -> Vec<(usize, f64)> {
        let mut sums = BTreeMap::new();
        self.terms().for_each(|(v, factor)| *sums.entry(v).or_insert(0.0) += factor);
        sums.into_iter().filter(|(_, factor)| *factor != 0.0).collect()
    }

    /// τ += c f.
    pub fn spread(&self, force: f64, tau: &mut [f64]) {
        for term in &self.terms {
            tau[term.v] += term.factor * force;
        }
    }
}
