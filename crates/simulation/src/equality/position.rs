//! A position that a polynomial relation couples: a sum of joint positions, or the length of a spatial
//! tendon.

use std::collections::BTreeSet;

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_core::kinematics::tendon_path::{LengthDerivatives, LengthEntry, TendonPath};

use crate::placement::{BodyMotion, Placement};

/// A position minus its reference, x − x⁰.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum CoupledPosition {
    /// A sum of joint positions; the offset of the sum includes −x⁰.
    Joints(JointSum),
    /// The length of a spatial tendon.
    Path {
        path: TendonPath,
        /// x⁰.
        reference: f64,
    },
}

impl Default for CoupledPosition {
    /// The constant 0.
    fn default() -> Self {
        Self::Joints(JointSum::default())
    }
}

impl CoupledPosition {
    /// The length of a tendon by its name; `None` without such a tendon.
    pub(crate) fn of_tendon(model: &Model, name: &str, reference: f64) -> Option<Self> {
        let robot = model.description();
        if let Some(tendon) = robot.tendons.iter().find(|own| own.name == name) {
            return Some(Self::Joints(JointSum::of_tendon(model, tendon).minus(reference)));
        }
        let number = robot.spatial_tendons.iter().position(|own| own.name == name)?;
        let path = TendonPath::all(model).swap_remove(number);
        Some(Self::Path { path, reference })
    }

    /// Whether it depends on the placement of the bodies.
    pub(crate) fn needs_placement(&self) -> bool {
        matches!(self, Self::Path { .. })
    }

    /// The coordinates that may change it.
    pub(crate) fn coordinates(&self, model: &Model) -> BTreeSet<usize> {
        match self {
            Self::Joints(sum) => sum.terms().map(|(k, _)| k).collect(),
            Self::Path { path, .. } => path.coordinates(model).into_iter().collect(),
        }
    }

    /// Its value at q. `placement` is that at q, if the position needs it.
    pub(crate) fn at(&self, placement: &Placement, q: &[f64]) -> f64 {
        match self {
            Self::Joints(sum) => sum.at(q),
            Self::Path { path, reference, .. } => path.length(placement) - reference,
        }
    }

    /// Calls `visit` with each coordinate and the derivative by it. `row` has nv entries.
    pub(crate) fn each_derivative(
        &self,
        model: &Model,
        placement: &Placement,
        row: &mut [f64],
        mut visit: impl FnMut(usize, f64),
    ) {
        match self {
            Self::Joints(sum) => sum.terms().for_each(|(k, c)| visit(k, c)),
            Self::Path { path, .. } => {
                path.length_and_row(model, placement, row);
                row.iter().enumerate().for_each(|(k, entry)| visit(k, *entry));
            }
        }
    }

    /// Its first derivative by time, and its second one at v̇ = 0. `motions` are those of the bodies, if it
    /// needs their placement.
    pub(crate) fn motion(
        &self,
        model: &Model,
        placement: &Placement,
        v: &[f64],
        motions: &[BodyMotion],
    ) -> [f64; 2] {
        match self {
            Self::Joints(sum) => [sum.rate(v), 0.0],
            Self::Path { path, .. } => {
                let mut row = vec![0.0; model.nv()];
                path.length_and_row(model, placement, &mut row);
                let rate = row.iter().zip(v).map(|(entry, v)| entry * v).sum();
                [rate, path.bias_acceleration(placement, motions)]
            }
        }
    }

    /// Its first two derivatives by time, and their derivatives by q and v, in a motion with the state q, v
    /// and the acceleration a. `motions` are those of the bodies, if it needs their placement.
    pub(crate) fn derivatives(
        &self,
        model: &Model,
        (placement, motions): (&Placement, &[BodyMotion]),
        [_, v, a]: [&[f64]; 3],
    ) -> LengthDerivatives {
        match self {
            Self::Joints(sum) => {
                let entry = |(coordinate, slope)| LengthEntry { coordinate, slope, ..LengthEntry::default() };
                let entries = sum.terms().map(entry).collect();
                LengthDerivatives { rate: sum.rate(v), second: sum.rate(a), entries }
            }
            Self::Path { path, .. } => path.derivatives(model, placement, motions),
        }
    }

    /// Calls `add` with the entries (i, j) of the derivative of its row by q.
    pub(crate) fn row_derivative(
        &self,
        model: &Model,
        (placement, motions): (&Placement, &[BodyMotion]),
        add: impl FnMut(usize, usize, f64),
    ) {
        match self {
            Self::Joints(_) => {}
            Self::Path { path, .. } => path.row_derivative(model, placement, motions, add),
        }
    }
}
