//! The sizes of arguments and results.

use robot_dynamics_core::Model;
use robot_dynamics_simulation::ContactStep;

/// A result: its name, its rows and columns (row-major), its meaning.
pub(crate) type Matrix = (&'static str, Size, Size, &'static str);

/// The size of an argument or of a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Size {
    Nq,
    Nv,
    One,
    Fixed(usize),
    /// Ten numbers for each moving link.
    Parameters,
    /// The entries of M on and above the diagonal that are not always zero.
    Related,
    /// 2 nv.
    TwoNv,
    /// nv².
    Square,
    /// 6 nv.
    Jacobian,
    /// 3 nv.
    CenterJacobian,
    /// Twelve numbers for each frame.
    Poses,
    /// Ten numbers for each moving link and degree of freedom.
    Regressor,
    /// The multipliers of a step with contact.
    Impulses,
    /// The table of a step with contact.
    Problem,
    /// The sum of these.
    Sum(&'static [Self]),
}

impl Size {
    pub(crate) fn of(self, model: &Model) -> usize {
        match self {
            Self::Nq => model.nq(),
            Self::Nv => model.nv(),
            Self::One => 1,
            Self::Fixed(count) => count,
            Self::Parameters => robot_dynamics_core::inertial_parameters(model).len(),
            Self::Related => robot_dynamics_core::mass_matrix_related_entries(model).len(),
            Self::TwoNv => 2 * model.nv(),
            Self::Square => model.nv() * model.nv(),
            Self::Jacobian => 6 * model.nv(),
            Self::CenterJacobian => 3 * model.nv(),
            Self::Poses => 12 * model.frames().len(),
            Self::Regressor => model.nv() * Self::Parameters.of(model),
            // A robot without a step with contact is rejected when the function is traced.
            Self::Impulses => ContactStep::new(model, 1).map_or(0, |step| step.impulse_count()),
            Self::Sum(sizes) => sizes.iter().map(|size| size.of(model)).sum(),
            Self::Problem => ContactStep::new(model, 1).map_or(0, |step| step.problem_count()),
        }
    }

    /// The size of a change: a configuration changes along displacements.
    pub(super) fn of_changes(self) -> Self {
        if self == Self::Nq { Self::Nv } else { self }
    }

    /// The size of the changes of all results, one result after the other, matrices by rows.
    pub(crate) fn of_all_changes(results: &[Matrix]) -> Self {
        let flat = |&(_, rows, columns, _): &Matrix| match (rows, columns) {
            (rows, Self::One) => rows.of_changes(),
            (Self::Nv, Self::Nv) => Self::Square,
            (Self::Fixed(6), Self::Nv) => Self::Jacobian,
            (Self::Fixed(3), Self::Nv) => Self::CenterJacobian,
            (Self::Nv, Self::Parameters) => Self::Regressor,
            (Self::Fixed(rows), Self::Fixed(columns)) => Self::Fixed(rows * columns),
            (rows, columns) => unreachable!("no result has {rows:?} rows and {columns:?} columns"),
        };
        match results.iter().map(flat).collect::<Vec<_>>()[..] {
            [one] => one,
            // The multipliers that a step returns have no weights.
            [Self::Nv, Self::Nv] | [Self::Nv, Self::Nv, Self::Impulses] => Self::TwoNv,
            [Self::Problem, Self::Nv] => Self::Sum(&[Self::Problem, Self::Nv]),
            [Self::Nv, Self::Impulses] => Self::Sum(&[Self::Nv, Self::Impulses]),
            [Self::Fixed(one), Self::Fixed(other)] => Self::Fixed(one + other),
            ref sizes => unreachable!("no differentiable function has results of {sizes:?}"),
        }
    }
}
