//! A relation between the positions of two joints, y − y⁰ = p(x − x⁰), p a polynomial of degree 4 at most.
//!
//! φ = y − y⁰ − p(x − x⁰), φ̇ = ẏ − p′ẋ, and its rate at v̇ = 0 is −p″ẋ². A row costs two entries. It is
//! MJCF's equality of joints.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_number::{InvalidInput, check_number};

use super::coupling::no_coordinate;
use crate::equality::relation::Relation;

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
    /// [`InvalidInput`]: a coordinate does not exist, or a number is not finite.
    pub fn new(
        model: &Model,
        joint: (&str, f64),
        leader: Option<(&str, f64)>,
        polynomial: [f64; 5],
    ) -> Result<Self, InvalidInput> {
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
                Err(no_coordinate(model, name))
            }
        };
        let leader = leader.map_or(Ok(JointSum::default()), position)?;
        Ok(Self { joint: position(joint)?, leader, polynomial })
    }

    /// The row of the two joints.
    pub(super) fn relation(&self) -> Relation {
        Relation::Polynomial {
            joint: self.joint.clone(),
            leader: self.leader.clone(),
            polynomial: self.polynomial,
        }
    }
}
