//! A linear relation between coordinates: Σ cᵢ vᵢ = 0, with φ = Σ cᵢ qᵢ − offset for plain coordinates.
//!
//! Gears, belts, differentials and locked joints are such rows. A row costs its number of terms. Coordinates
//! of quaternion joints have no φ.

use robot_dynamics_core::Model;
use robot_dynamics_core::configuration::manifold::coordinate_ranges;
use robot_dynamics_core::joint::Chart;
use robot_dynamics_number::{InputProblem, InvalidInput, check_number};

use crate::equality::relation::Relation;

/// Σ cᵢ vᵢ = 0 with constant c: gears, belts, differentials, a locked joint.
///
/// If every coordinate in it is a plain number, φ = Σ cᵢ qᵢ − offset. Unlike a mimic joint of the robot's
/// description, it keeps both coordinates, and its multiplier is the force in the gear.
#[derive(Clone, Debug, PartialEq)]
pub struct Coupling {
    /// Pairs (coordinate of v, cᵢ).
    pub(super) terms: Vec<(usize, f64)>,
    /// The required value of Σ cᵢ qᵢ.
    pub(super) offset: f64,
}

impl Coupling {
    /// A coupling of coordinates, given by name ([`Model::coordinate_names`]), with coefficients.
    ///
    /// # Errors
    /// [`InvalidInput`]: a coordinate does not exist, or a number is not finite.
    pub fn new(model: &Model, terms: &[(&str, f64)], offset: f64) -> Result<Self, InvalidInput> {
        let names = model.coordinate_names();
        let term = |&(name, coefficient): &(&str, f64)| {
            check_number("a coupling's coefficient", coefficient)?;
            let found = names.iter().position(|known| known == name);
            found.map(|index| (index, coefficient)).ok_or_else(|| no_coordinate(model, name))
        };
        check_number("a coupling's offset", offset)?;
        Ok(Self { terms: terms.iter().map(term).collect::<Result<_, _>>()?, offset })
    }

    /// The row of the coordinates.
    pub(super) fn relation(&self, model: &Model) -> Relation {
        let position = |&(coordinate, factor): &(usize, f64)| {
            let plain = coordinate_ranges(model).find(|s| s.chart == Chart::Line && s.v == coordinate)?;
            Some((plain.q, factor))
        };
        Relation::Sum {
            terms: self.terms.clone(),
            positions: self.terms.iter().map(position).collect(),
            offset: self.offset,
        }
    }
}

/// The error of a coordinate that does not exist.
pub(super) fn no_coordinate(model: &Model, name: &str) -> InvalidInput {
    let owner = format!("robot `{}`", model.name());
    let known = "; Model::coordinate_names lists them".to_owned();
    InvalidInput::new("coordinate", InputProblem::UnknownName { name: name.into(), owner, known })
}
