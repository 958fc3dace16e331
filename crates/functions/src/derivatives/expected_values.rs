//! Derivatives by the library's recursions over dual numbers: a route independent of the graph.

use robot_dynamics_core::{Model, cotangent_from_coordinates, cotangent_to_coordinates};
use robot_dynamics_number::Dual;

use crate::call::call;
use crate::function::DerivativeKind;
use crate::{Function, FunctionError, FunctionResult};

/// The derivatives of a function in one state. For a pullback the last argument is the cotangent.
///
/// # Errors
/// [`FunctionError::Input`].
pub(crate) fn derivatives_by_dual_numbers(
    (function, kind): (&Function, DerivativeKind),
    model: &Model,
    arguments: &[Vec<f64>],
) -> Result<Vec<Vec<f64>>, FunctionError> {
    let compute = call::<Dual<f64, 1>>(function, model)?;
    let results = function.results(model);
    let (arguments, cotangent) = arguments.split_at(function.rows_of_arguments().len());
    let mut found = Vec::new();
    for (at, (name, ..)) in function.varied_arguments() {
        let directions = if name == "q" { model.nv() } else { arguments[at].len() };
        let column = |direction: usize| -> Vec<f64> {
            let mut given: Vec<Vec<Dual<f64, 1>>> =
                arguments.iter().map(|x| x.iter().map(|&x| Dual::constant(x)).collect()).collect();
            let change = if name == "q" {
                along(model, &arguments[at], direction)
            } else {
                (0..directions).map(|i| f64::from(u8::from(i == direction))).collect()
            };
            given[at].iter_mut().zip(change).for_each(|(x, change)| x.gradient = [change]);
            let of_result = |(found, outcome): (&Vec<Dual<f64, 1>>, &FunctionResult)| {
                let change: Vec<f64> = found.iter().map(|x| x.gradient[0]).collect();
                let value: Vec<f64> = found.iter().map(|x| x.value).collect();
                if outcome.name == "q_next" { displacement(model, &value, &change) } else { change }
            };
            compute(&given).iter().zip(&results).flat_map(of_result).collect()
        };
        let columns: Vec<Vec<f64>> = (0..directions).map(column).collect();
        found.push(match kind {
            DerivativeKind::Derivatives => by_rows(&columns),
            DerivativeKind::Pullback => columns.iter().map(|column| dot(column, &cotangent[0])).collect(),
        });
    }
    Ok(found)
}

fn by_rows(columns: &[Vec<f64>]) -> Vec<f64> {
    let rows = columns.first().map_or(0, Vec::len);
    (0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect()
}

fn dot(x: &[f64], y: &[f64]) -> f64 {
    x.iter().zip(y).map(|(x, y)| x * y).sum()
}

/// The rates of q's numbers along one displacement: a column of N(q).
fn along(model: &Model, q: &[f64], direction: usize) -> Vec<f64> {
    let entry = |i: usize| {
        let (mut unit, mut row) = (vec![0.0; model.nq()], vec![0.0; model.nv()]);
        unit[i] = 1.0;
        cotangent_from_coordinates(model, q, &unit, &mut row);
        row[direction]
    };
    (0..model.nq()).map(entry).collect()
}

/// The displacement for a change of the numbers of q.
fn displacement(model: &Model, q: &[f64], change: &[f64]) -> Vec<f64> {
    let one = |k: usize| {
        let (mut unit, mut column) = (vec![0.0; model.nv()], vec![0.0; model.nq()]);
        unit[k] = 1.0;
        cotangent_to_coordinates(model, q, &unit, &mut column);
        dot(&column, change)
    };
    (0..model.nv()).map(one).collect()
}
