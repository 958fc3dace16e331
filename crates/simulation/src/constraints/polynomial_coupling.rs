//! A relation between the positions of two joints or the lengths of two tendons, y − y⁰ = p(x − x⁰), p a
//! polynomial of degree 4 at most.
//!
//! φ = y − y⁰ − p(x − x⁰), φ̇ = ẏ − p′ẋ, and its rate at v̇ = 0 is ÿ − p′ẍ − p″ẋ², where ÿ and ẍ are 0 except
//! for spatial tendons. These are MJCF's equalities of joints and of tendons.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::joint_sum::JointSum;
use robot_dynamics_number::{InputProblem, InvalidInput, check_number};

use super::coupling::no_coordinate;
use crate::equality::polynomial::PolynomialRelation;
use crate::equality::position::CoupledPosition;
use crate::equality::relation::Relation;

/// y − y⁰ = p(x − x⁰), p a polynomial of degree 4 at most: MJCF's equality of joints or of tendons.
///
/// φ = y − y⁰ − p(x − x⁰), φ̇ = ẏ − p′ẋ, and its rate at v̇ = 0 is ÿ − p′ẍ − p″ẋ².
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
    /// The relation of y − y⁰ and x − x⁰; the latter is 0 without a leader.
    relation: PolynomialRelation,
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
        let position = |(name, reference): (&str, f64)| {
            let own = model.joints().iter().find(|own| own.name == name);
            let is_single = own.is_some_and(|own| own.nv == 1 || own.mimic.is_some());
            if is_single {
                Ok(CoupledPosition::Joints(JointSum::new(model, -reference, [(name, 1.0)])))
            } else {
                Err(no_coordinate(model, name))
            }
        };
        Self::of_positions(joint, leader, polynomial, position)
    }

    /// A coupling of the lengths of tendons, given by name, each with its reference length \[m, or the unit
    /// of its joints\].
    ///
    /// ```
    /// use robot_dynamics::constraints::{ConstraintSet, PolynomialCoupling};
    /// use robot_dynamics::description::{TendonDescription, pendulum};
    /// use robot_dynamics::model::{Model, Workspace};
    /// let mut robot = pendulum(2.0, 0.5);
    /// robot.tendons.push(TendonDescription::new("belt", [("hinge".to_owned(), 0.5)]));
    /// let model = Model::new(robot)?;
    /// let held = PolynomialCoupling::of_tendons(&model, ("belt", 0.0), None, [0.2, 0.0, 0.0, 0.0, 0.0])?;
    /// let set = ConstraintSet::new(&model, [("held", held.into())])?;
    /// let rows = set.rows(&model, &mut Workspace::new(&model), &[0.4], &[0.0]);
    /// assert_eq!((rows.matrix[(0, 0)], rows.position_error[0]), (0.5, 0.0));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`InvalidInput`]: a tendon does not exist, or a number is not finite.
    pub fn of_tendons(
        model: &Model,
        tendon: (&str, f64),
        leader: Option<(&str, f64)>,
        polynomial: [f64; 5],
    ) -> Result<Self, InvalidInput> {
        let position = |(name, reference): (&str, f64)| {
            CoupledPosition::of_tendon(model, name, reference).ok_or_else(|| {
                let owner = format!("robot `{}`", model.name());
                let known = "; its description lists them as tendons and spatial_tendons".to_owned();
                InvalidInput::new("tendon", InputProblem::UnknownName { name: name.into(), owner, known })
            })
        };
        Self::of_positions(tendon, leader, polynomial, position)
    }

    fn of_positions(
        own: (&str, f64),
        leader: Option<(&str, f64)>,
        polynomial: [f64; 5],
        position: impl Fn((&str, f64)) -> Result<CoupledPosition, InvalidInput>,
    ) -> Result<Self, InvalidInput> {
        let numbers = polynomial.into_iter().chain([own.1]).chain(leader.map(|leader| leader.1));
        for value in numbers {
            check_number("a number of a polynomial coupling", value)?;
        }
        let leader = leader.map_or(Ok(CoupledPosition::default()), &position)?;
        Ok(Self { relation: PolynomialRelation { position: position(own)?, leader, polynomial } })
    }

    /// Whether a coordinate changes one of the two positions.
    pub(super) fn is_movable(&self, model: &Model) -> bool {
        !self.relation.coordinates(model).is_empty()
    }

    /// The row of the two positions.
    pub(super) fn relation(&self) -> Relation {
        Relation::Polynomial(self.relation.clone())
    }
}
