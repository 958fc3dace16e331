//! Derivatives and pullbacks of any function, by the chain rule through its graph.

mod expected_values;

use robot_dynamics_core::{
    InstructionSet, Model, Workspace, cotangent_from_coordinates, cotangent_to_coordinates,
};
use robot_dynamics_expression::{
    Arithmetic, Graph, Operand, Traced, as_traced, chain, continue_trace, trace,
};
use robot_dynamics_number::Scalar;

use crate::Function;
use crate::function::{ArgumentRow, DerivativeKind, Size};

pub(crate) use self::expected_values::derivatives_by_dual_numbers;

/// A traced function with its arguments: the input of differentiation.
struct DifferentiationInput<'a> {
    function: &'a Function,
    model: &'a Model,
    arithmetic: Arithmetic,
    graph: &'a Graph,
    results: &'a [Vec<Operand>],
    /// The arguments, as operands of the graph.
    arguments: Vec<Vec<Operand>>,
}

/// A graph and the results in it.
pub(crate) type Trace = (Graph, Vec<Vec<Operand>>);

/// Differentiates a traced function by the method with the fewest operations.
pub(crate) fn differentiate(
    (function, kind): (&Function, DerivativeKind),
    model: &Model,
    arithmetic: Arithmetic,
    (graph, results): &Trace,
) -> Trace {
    let mut graph = graph.clone();
    let mut arguments: Vec<Vec<Operand>> = Vec::new();
    let mut inputs = |argument: usize, count: usize| -> Vec<Operand> {
        (0..count).map(|index| graph.input(argument, index)).collect()
    };
    for (argument, (_, size, _)) in function.rows_of_arguments().iter().enumerate() {
        arguments.push(inputs(argument, size.of(model)));
    }
    let of_results = match kind {
        DerivativeKind::Derivatives => 0,
        DerivativeKind::Pullback => Size::of_all_changes(&function.matrices()).of(model),
    };
    let cotangent = inputs(arguments.len(), of_results);
    let input = DifferentiationInput { function, model, arithmetic, graph: &graph, results, arguments };
    let methods = match kind {
        DerivativeKind::Pullback => vec![input.pullback(&cotangent)],
        DerivativeKind::Derivatives => {
            let mut methods = vec![input.forward()];
            if input.rows() <= input.arguments.iter().map(Vec::len).sum() {
                methods.push(input.backward());
            }
            methods.extend(input.by_recursions());
            methods
        }
    };
    methods
        .into_iter()
        .min_by_key(|(graph, results)| as_traced(graph, results).len())
        .expect("there is at least one method")
}

impl DifferentiationInput<'_> {
    /// The index of the configuration among the arguments.
    fn q(&self) -> Option<usize> {
        self.function.rows_of_arguments().iter().position(|&(name, ..)| name == "q")
    }

    /// The index of the configuration among the results.
    fn q_next(&self) -> Option<usize> {
        self.function.matrices().iter().position(|&(name, ..)| name == "q_next")
    }

    /// The number of directions of an argument: displacements for q, numbers otherwise.
    fn directions(&self, argument: usize) -> usize {
        if Some(argument) == self.q() { self.model.nv() } else { self.arguments[argument].len() }
    }

    /// N(q), the derivative of the numbers of q along displacements, with a row for each number.
    fn displacement_map(&self, graph: &mut Graph) -> Vec<Vec<Operand>> {
        let Some(q) = self.q() else { return Vec::new() };
        let q = traced(&self.arguments[q]);
        continue_trace(self.arithmetic, graph, || {
            let row = |i: usize| {
                let (mut unit, mut row) = (zeros(q.len()), zeros(self.model.nv()));
                unit[i] = Traced::one();
                cotangent_from_coordinates(self.model, &q, &unit, &mut row);
                operands(&row)
            };
            (0..q.len()).map(row).collect()
        })
    }

    /// Forward mode: a tangent for each displacement, or number, of each argument.
    fn forward(&self) -> Trace {
        let mut graph = self.graph.clone();
        let steps = chain::steps(&graph, self.results);
        let turning = self.displacement_map(&mut graph);
        let back = self.inverse_displacement_map(&mut graph);
        let mut blocks = Vec::new();
        for (argument, _) in self.function.varied_arguments() {
            let column = |direction: usize| {
                let seed = |a: usize, i: usize| {
                    if a != argument {
                        Operand::ZERO
                    } else if Some(a) == self.q() {
                        turning[i][direction]
                    } else {
                        Operand::constant(if i == direction { 1.0 } else { 0.0 })
                    }
                };
                let tangents = chain::push_forward(&mut graph, &steps, seed, self.arithmetic);
                let mut column = Vec::new();
                for (result, entries) in self.results.iter().enumerate() {
                    let change: Vec<Operand> =
                        entries.iter().map(|&entry| chain::tangent_of(&tangents, entry)).collect();
                    column.extend(match &back {
                        Some(back) if self.q_next() == Some(result) => {
                            self.displacement(&mut graph, back, &change)
                        }
                        _ => change,
                    });
                }
                column
            };
            let columns: Vec<Vec<Operand>> = (0..self.directions(argument)).map(column).collect();
            let rows = columns.first().map_or(0, Vec::len);
            blocks.push((0..rows).flat_map(|row| columns.iter().map(move |column| column[row])).collect());
        }
        (graph, blocks)
    }

    /// The left inverse of N at a resulting configuration, N (NᵀN)⁻¹ by columns: for each displacement, the
    /// weights of the numbers' tangents.
    fn inverse_displacement_map(&self, graph: &mut Graph) -> Option<Vec<Vec<Operand>>> {
        let q = traced(&self.results[self.q_next()?]);
        Some(continue_trace(self.arithmetic, graph, || {
            let column = |k: usize| {
                let (mut unit, mut column) = (zeros(self.model.nv()), zeros(q.len()));
                unit[k] = Traced::one();
                cotangent_to_coordinates(self.model, &q, &unit, &mut column);
                operands(&column)
            };
            (0..self.model.nv()).map(column).collect()
        }))
    }

    /// Converts a change of numbers to a displacement.
    fn displacement(&self, graph: &mut Graph, back: &[Vec<Operand>], change: &[Operand]) -> Vec<Operand> {
        let change = traced(change);
        continue_trace(self.arithmetic, graph, || {
            let one = |column: &Vec<Operand>| {
                let pairs = traced(column).into_iter().zip(&change);
                pairs.fold(Traced::zero(), |sum, (x, &change)| x.mul_add(change, sum)).0
            };
            back.iter().map(one).collect()
        })
    }

    /// The adjoints of the arguments for these weights of the results' numbers; those of q are along
    /// displacements.
    fn adjoints(&self, graph: &mut Graph, steps: &[usize], weights: &[Operand]) -> Vec<Vec<Operand>> {
        let pairs = self.results.iter().flatten().copied().zip(weights.iter().copied());
        let adjoints = chain::pull_back(graph, steps, pairs, self.arithmetic);
        let of = |(argument, _): (usize, ArgumentRow)| -> Vec<Operand> {
            let numbers = self.arguments[argument].iter();
            numbers.map(|&number| adjoints[number.node().expect("an input")]).collect()
        };
        let mut gradients: Vec<Vec<Operand>> = self.function.varied_arguments().map(of).collect();
        if let Some(at) = self.q() {
            let (q, coordinates) = (traced(&self.arguments[at]), traced(&gradients[at]));
            gradients[at] = continue_trace(self.arithmetic, graph, || {
                let mut gradient = zeros(self.model.nv());
                cotangent_from_coordinates(self.model, &q, &coordinates, &mut gradient);
                operands(&gradient)
            });
        }
        gradients
    }

    /// Backward mode: one adjoint for each row.
    fn backward(&self) -> Trace {
        let mut graph = self.graph.clone();
        let steps = chain::steps(&graph, self.results);
        let rows = self.rows();
        let mut blocks: Vec<Vec<Operand>> = self.function.varied_arguments().map(|_| Vec::new()).collect();
        for row in 0..rows {
            let unit: Vec<Operand> =
                (0..rows).map(|i| Operand::constant(if i == row { 1.0 } else { 0.0 })).collect();
            let weights = self.weights(&mut graph, &unit);
            let gradients = self.adjoints(&mut graph, &steps, &weights);
            blocks.iter_mut().zip(gradients).for_each(|(block, row)| block.extend(row));
        }
        (graph, blocks)
    }

    /// The gradients of the weighted sum of all results.
    fn pullback(&self, cotangent: &[Operand]) -> Trace {
        let mut graph = self.graph.clone();
        let steps = chain::steps(&graph, self.results);
        let weights = self.weights(&mut graph, cotangent);
        let gradients = self.adjoints(&mut graph, &steps, &weights);
        (graph, gradients)
    }

    /// The number of rows: numbers of the results, or displacements for a configuration.
    fn rows(&self) -> usize {
        let numbers = |(k, result): (usize, &Vec<Operand>)| {
            if self.q_next() == Some(k) { self.model.nv() } else { result.len() }
        };
        self.results.iter().enumerate().map(numbers).sum()
    }

    /// The weights of the results' numbers, from those of the rows. They differ for a configuration, which
    /// comes first.
    fn weights(&self, graph: &mut Graph, rows: &[Operand]) -> Vec<Operand> {
        let Some(at) = self.q_next() else { return rows.to_vec() };
        let (displacement, others) = rows.split_at(self.model.nv());
        let (q, displacement) = (traced(&self.results[at]), traced(displacement));
        let mut weights = continue_trace(self.arithmetic, graph, || {
            let mut coordinates = zeros(q.len());
            cotangent_to_coordinates(self.model, &q, &displacement, &mut coordinates);
            operands(&coordinates)
        });
        weights.extend(others);
        weights
    }

    /// The library's own recursions for the derivatives, where it has them. Those of C v + g and g are those
    /// of M a + C v + g with zeros.
    fn by_recursions(&self) -> Option<Trace> {
        let takes_v = match self.function {
            Function::Bias => true,
            Function::Gravity => false,
            _ => return None,
        };
        let lengths: Vec<usize> = self.arguments.iter().map(Vec::len).collect();
        let nv = self.model.nv();
        Some(trace(self.arithmetic, &lengths, |arguments| {
            let w = &mut Workspace::<Traced>::limited(self.model, InstructionSet::Portable);
            let (rest, mut by_q, mut by_v) = (zeros(nv), zeros(nv * nv), zeros(nv * nv));
            let v = if takes_v { &arguments[1] } else { &rest };
            let out = robot_dynamics_core::InverseDynamicsDerivativesMut {
                by_position: &mut by_q,
                by_velocity: &mut by_v,
            };
            robot_dynamics_core::inverse_dynamics_derivatives(self.model, w, &arguments[0], v, &rest, out);
            if takes_v { vec![by_q, by_v] } else { vec![by_q] }
        }))
    }
}

fn zeros(count: usize) -> Vec<Traced> {
    vec![Traced::zero(); count]
}

fn traced(operands: &[Operand]) -> Vec<Traced> {
    operands.iter().map(|&x| Traced(x)).collect()
}

fn operands(numbers: &[Traced]) -> Vec<Operand> {
    numbers.iter().map(|x| x.0).collect()
}

#[cfg(test)]
mod tests;
