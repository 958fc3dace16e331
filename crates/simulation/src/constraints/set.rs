//! Named constraints, and their rows at a state: A(q), Ȧv and φ(q).
//!
//! Each constraint has rows that are sparse over the coordinates (`equality`). Implicit steps use them as
//! they are. [`ConstraintSet::rows`] writes them to a dense matrix, at a cost of O(n + K nv) for n bodies and
//! K rows. A set belongs to one model: using it with another panics.

use nalgebra::{DMatrix, DVector};
use robot_dynamics_core::model::identity::Identity;
use robot_dynamics_core::{Model, Workspace};
use robot_dynamics_description::{Equality, EqualityDescription, check_length};

use super::rows::ConstraintRows;
use super::{Constraint, ConstraintError, FrameConstraint, LoopClosure, PolynomialCoupling, SpatialAxis};
use crate::equality::rows::EqualityRows;

/// Named constraints of one robot, in order.
///
/// ```
/// use robot_dynamics::constraints::{FrameConstraint, ConstraintSet};
/// use robot_dynamics::description::{RandomRobotOptions, random_robot};
/// use robot_dynamics::model::Model;
/// let model = Model::new(random_robot(3, &RandomRobotOptions::default()))?;
/// let (a, b) = (model.frame("link4").expect("a link"), model.frame("link9").expect("a link"));
/// let set = ConstraintSet::new(&model, [("pin", FrameConstraint::between(a, b, &FrameConstraint::BALL).into())])?;
/// assert_eq!(set.row_names(), ["pin.x", "pin.y", "pin.z"]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct ConstraintSet {
    /// The robot of these constraints; `None` for the empty default set, which constrains no robot.
    robot: Option<Identity>,
    constraints: Vec<Constraint>,
    names: Vec<String>,
    row_names: Vec<String>,
    /// The rows of all constraints; `None` for the empty default set.
    equalities: Option<EqualityRows>,
}

/// Equal constraints of the same robot, with the same names.
impl PartialEq for ConstraintSet {
    fn eq(&self, other: &Self) -> bool {
        (&self.robot, &self.constraints, &self.names) == (&other.robot, &other.constraints, &other.names)
    }
}

impl ConstraintSet {
    /// Checks the constraints against the robot.
    ///
    /// # Errors
    /// [`ConstraintError`]: a duplicate name, missing or repeated rows, an invalid radius, a number that
    /// is not finite, or a frame of another model.
    pub fn new<N: Into<String>>(
        model: &Model,
        constraints: impl IntoIterator<Item = (N, Constraint)>,
    ) -> Result<Self, ConstraintError> {
        let mut set = Self { robot: Some(model.identity.clone()), ..Self::default() };
        for (name, constraint) in constraints {
            set.add(model, name.into(), constraint)?;
        }
        Ok(set.with_rows(model))
    }

    /// The loops given beside a robot file.
    ///
    /// # Errors
    /// As [`ConstraintSet::new`], and [`ConstraintError::Input`] if a frame is missing.
    pub fn from_loops(model: &Model, loops: &[LoopClosure]) -> Result<Self, ConstraintError> {
        let mut set = Self { robot: Some(model.identity.clone()), ..Self::default() };
        for closure in loops {
            set.add(model, closure.name.clone(), closure.resolve(model)?.into())?;
        }
        Ok(set.with_rows(model))
    }

    /// The active equalities of the robot's description. Joints and tendons become [`PolynomialCoupling`]s,
    /// and connections and welds [`FrameConstraint`]s between the frames that the robot has for them
    /// ([`EqualityDescription::frames`]). Relations of locked joints are left out.
    ///
    /// ```
    /// use robot_dynamics::constraints::ConstraintSet;
    /// use robot_dynamics::description::{Equality, EqualityDescription, pendulum};
    /// use robot_dynamics::model::Model;
    /// let mut robot = pendulum(2.0, 0.5);
    /// let pin = Equality::Connect { a: ("rod".into(), [0.5, 0.0, 0.0]), b: ("ceiling".into(), [0.5, 0.0, 0.0]) };
    /// robot.equalities.push(EqualityDescription::new("pin", pin));
    /// let model = Model::new(robot)?;
    /// assert_eq!(ConstraintSet::from_equalities(&model)?.row_names(), ["pin.x", "pin.y", "pin.z"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// As [`ConstraintSet::new`]. The equalities of a compiled robot do not cause errors.
    pub fn from_equalities(model: &Model) -> Result<Self, ConstraintError> {
        let mut set = Self { robot: Some(model.identity.clone()), ..Self::default() };
        for equality in model.description().equalities.iter().filter(|equality| equality.active) {
            let constraint = match &equality.kind {
                Equality::Joints { joint, leader, polynomial } => {
                    let moves = |own: &&robot_dynamics_core::Joint| {
                        own.name == joint.0 && (own.nv > 0 || own.mimic.is_some())
                    };
                    if model.joints().iter().find(moves).is_none() {
                        continue;
                    }
                    let leader = leader.as_ref().map(|(name, reference)| (name.as_str(), *reference));
                    PolynomialCoupling::new(model, (&joint.0, joint.1), leader, *polynomial)?.into()
                }
                Equality::Tendons { tendon, leader, polynomial } => {
                    let leader = leader.as_ref().map(|(name, reference)| (name.as_str(), *reference));
                    let coupling =
                        PolynomialCoupling::of_tendons(model, (&tendon.0, tendon.1), leader, *polynomial)?;
                    if !coupling.is_movable(model) {
                        continue;
                    }
                    coupling.into()
                }
                Equality::Connect { .. } => joined(model, equality, &FrameConstraint::BALL)?,
                Equality::Weld { .. } => joined(model, equality, &FrameConstraint::WELD)?,
            };
            set.add(model, equality.name.clone(), constraint)?;
        }
        Ok(set.with_rows(model))
    }

    /// Prepares the rows of the constraints.
    fn with_rows(mut self, model: &Model) -> Self {
        let relations = self.constraints.iter().map(|constraint| constraint.relation(model));
        self.equalities = Some(EqualityRows::new(model, relations));
        self
    }

    /// The rows, which need a placement before they are read; `None` for the empty default set.
    pub(super) fn equalities(&self) -> Option<&EqualityRows> {
        self.equalities.as_ref()
    }

    fn add(&mut self, model: &Model, name: String, constraint: Constraint) -> Result<(), ConstraintError> {
        if self.names.contains(&name) {
            return Err(ConstraintError::DuplicateName { name });
        }
        let rows = constraint.row_names();
        let bad_rows = |problem| ConstraintError::BadRows { constraint: name.clone(), problem };
        if rows.is_empty() {
            return Err(bad_rows("has no rows"));
        }
        if (1..rows.len()).any(|i| rows[..i].contains(&rows[i])) {
            return Err(bad_rows("has a row twice"));
        }
        constraint.check_numbers()?;
        if constraint.frames().into_iter().any(|frame| !model.has_frame(frame)) {
            return Err(ConstraintError::ForeignFrame { constraint: name, robot: model.name().to_owned() });
        }
        self.row_names.extend(rows.iter().map(|row| format!("{name}.{row}")));
        self.names.push(name);
        self.constraints.push(constraint);
        Ok(())
    }

    /// K: the number of rows.
    pub fn len(&self) -> usize {
        self.row_names.len()
    }

    /// Whether the set has no constraints.
    pub fn is_empty(&self) -> bool {
        self.row_names.is_empty()
    }

    /// The rows' names, `constraint.row`.
    pub fn row_names(&self) -> &[String] {
        &self.row_names
    }

    /// The constraints with their names.
    pub fn constraints(&self) -> impl Iterator<Item = (&str, &Constraint)> {
        self.names.iter().map(String::as_str).zip(&self.constraints)
    }

    #[track_caller]
    pub(super) fn check_robot(&self, model: &Model) {
        if let Some(robot) = &self.robot {
            model.check_identity(robot, "the constraint set");
        }
    }

    /// A(q), Ȧv and φ(q) at a state.
    ///
    /// # Panics
    /// If a slice has the wrong length, or the set or the workspace belongs to another robot.
    #[track_caller]
    pub fn rows(&self, model: &Model, workspace: &mut Workspace, q: &[f64], v: &[f64]) -> ConstraintRows {
        self.check_robot(model);
        check_length("q", q.len(), model.nq());
        check_length("v", v.len(), model.nv());
        let count = self.len();
        let mut rows = ConstraintRows {
            matrix: DMatrix::zeros(count, model.nv()),
            bias: DVector::zeros(count),
            position_error: DVector::zeros(count),
            holonomic: vec![false; count],
        };
        let Some(equalities) = self.placed(model, workspace, q) else { return rows };
        rows.bias = equalities.bias(model, q, v).into();
        for (i, row) in equalities.rows().iter().enumerate() {
            row.terms.iter().for_each(|&(k, factor)| rows.matrix[(i, k)] = factor);
            rows.position_error[i] = row.error.unwrap_or(0.0);
            rows.holonomic[i] = row.error.is_some();
        }
        rows
    }
}

impl ConstraintSet {
    /// The rows at q; `None` for the empty default set.
    pub(super) fn placed(&self, model: &Model, workspace: &mut Workspace, q: &[f64]) -> Option<EqualityRows> {
        let mut equalities = self.equalities.clone()?;
        equalities.place(model, workspace, q);
        Some(equalities)
    }
}

/// The two frames of an equality, joined.
fn joined(
    model: &Model,
    equality: &EqualityDescription,
    rows: &[SpatialAxis],
) -> Result<Constraint, ConstraintError> {
    let [frame_a, frame_b] = ["a", "b"].map(|side| equality.frame_name(side));
    let closure = LoopClosure { name: equality.name.clone(), frame_a, frame_b, rows: rows.to_vec() };
    Ok(closure.resolve(model)?.into())
}
