//! A relation between the positions of two joints, y − y⁰ = p(x − x⁰), p a polynomial of degree 4 at most.
//!
//! φ = y − y⁰ − p(x − x⁰), φ̇ = ẏ − p′ẋ, and its rate at v̇ = 0 is −p″ẋ². A row costs two entries. It is
//! MJCF's equality of joints.

use nalgebra::RowDVector;
use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_number::check_number;

use super::ConstraintError;
use super::rows::RowsAt;

/// y − y⁰ = p(x − x⁰), p a polynomial of degree 4 at most: MJCF's equality of joints.
///
/// φ = y − y⁰ − p(x − x⁰), φ̇ = ẏ − p′ẋ, and its rate at v̇ = 0 is −p″ẋ².
///
/// ```
/// use robot_dynamics::constraints::{ConstraintSet, PolynomialCoupling};
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::{Model, Workspace};
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let joint = model.joints().iter().find(|joint| joint.nv == 1).expect("a hinge");
/// let held = PolynomialCoupling::new(&model, (&joint.name, 0.0), None, [0.5, 0.0, 0.0, 0.0, 0.0])?;
/// let set = ConstraintSet::new(&model, [("held", held.into())])?;
/// let (q, v) = (robot_dynamics::model::neutral(&model), vec![0.0; model.nv()]);
/// let rows = set.rows(&model, &mut Workspace::new(&model), &q, &v);
/// assert_eq!(rows.position_error[0], -0.5);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PolynomialCoupling {
    /// y − y⁰ and x − x⁰; the latter empty without a leader.
    pub(super) joint: JointSum,
    pub(super) leader: JointSum,
    pub(super) polynomial: [f64; 5],
}

impl PolynomialCoupling {
    /// A coupling of joints of one degree of freedom, given by name, each with its reference position.
    ///
    /// # Errors
    /// [`ConstraintError::UnknownCoordinate`], [`ConstraintError::Input`].
    pub fn new(
        model: &Model,
        joint: (&str, f64),
        leader: Option<(&str, f64)>,
        polynomial: [f64; 5],
    ) -> Result<Self, ConstraintError> {
        let numbers = polynomial.into_iter().chain([joint.1]).chain(leader.map(|leader| leader.1));
        for value in numbers {
            check_number("a number of a polynomial coupling", value)?;
        }
        let position = |(name, reference): (&str, f64)| {
            let own = model.joints().iter().find(|own| own.name == name);
            let is_single = own.is_some_and(|own| own.nv == 1 || own.mimic.is_some());
            if is_single {
                Ok(JointSum::new(model, -reference, [(name, 1.0)]))
            } else {
                Err(ConstraintError::UnknownCoordinate { name: name.into(), robot: model.name().into() })
            }
        };
        let leader = leader.map_or(Ok(JointSum::default()), position)?;
        Ok(Self { joint: position(joint)?, leader, polynomial })
    }

    pub(super) fn write(&self, model: &Model, q: &[f64], v: &[f64], rows: &mut RowsAt<'_>) {
        let x = self.leader.at(q);
        // p, p′ and ½p″ by Horner's rule.
        let (mut p, mut slope, mut half_curvature) = (0.0, 0.0, 0.0);
        for c in self.polynomial.iter().rev() {
            half_curvature = half_curvature * x + slope;
            slope = slope * x + p;
            p = p * x + c;
        }
        let mut row = RowDVector::zeros(model.nv());
        self.joint.spread(1.0, row.as_mut_slice());
        self.leader.spread(-slope, row.as_mut_slice());
        let bias = -2.0 * half_curvature * self.leader.rate(v).powi(2);
        rows.push(&row, bias, Some(self.joint.at(q) - p));
    }
}
