//! The statements of a function's parts.

use core::cell::Cell;

use robot_dynamics_expression::{Graph, Operand, Operation};

use crate::affine_index::AffineIndex;
use crate::layout::{Layout, Loop, LoopOperand, LoopStep, Region};
use crate::syntax::Syntax;

/// The statements of a program's parts.
pub(crate) struct Body<'a, I, O, F> {
    pub(crate) syntax: Syntax<'a>,
    pub(crate) graph: &'a Graph,
    pub(crate) layout: &'a Layout,
    pub(crate) results: &'a [Vec<Operand>],
    /// The place in a result at which a number is stored, if it is.
    pub(crate) place: &'a dyn Fn(usize, usize) -> Option<usize>,
    /// Writes a number of an argument.
    pub(crate) input: I,
    /// Writes the statement that stores an expression in a place of a result.
    pub(crate) store: O,
    /// Writes the statement that sets all of a result to zero.
    pub(crate) clear: F,
}

/// The number of zeros from which on a result is cleared as a whole: compilers take long for thousands of
/// stores.
const MANY_ZEROS: usize = 8;

/// Stores each number at its own index.
#[allow(clippy::unnecessary_wraps)] // other functions leave out some numbers
pub(crate) fn every_number(_: usize, index: usize) -> Option<usize> {
    Some(index)
}

/// Indented lines.
struct Lines<'a> {
    text: String,
    indent: &'a str,
}

impl Lines<'_> {
    fn add(&mut self, line: &str) {
        self.text.push_str(self.indent);
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// Adds a line within a loop.
    fn add_inside(&mut self, line: &str) {
        self.text.push_str("    ");
        self.add(line);
    }
}

impl<I, O, F> Body<'_, I, O, F>
where
    I: Fn(usize, AffineIndex) -> String,
    O: Fn(usize, AffineIndex, &str) -> String,
    F: Fn(usize) -> String,
{
    /// The statements of a part, one a line.
    pub(crate) fn part(&self, number: usize, indent: &str) -> String {
        let mut lines = Lines { text: String::new(), indent };
        if number == 0 {
            self.store_constants(&mut lines);
        }
        let stored = self.stored_entries(number);
        let mut at = 0;
        let tables = Cell::new(0);
        for piece in &self.layout.parts[number] {
            let nodes = match piece {
                Region::Straight(nodes) => nodes,
                Region::Loop(repeated) => {
                    self.write_loop(repeated, number, &tables, &mut lines);
                    continue;
                }
            };
            for &node in nodes {
                lines.add(&self.statement(node, &mut |_, operand| self.operand(operand, number)));
                if let Some(place) = self.layout.stored_at[node] {
                    lines.add(&format!("w[{place}] = {};", self.name(node)));
                }
                while let Some(&(_, result, place, operand)) =
                    stored.get(at).filter(|entry| entry.0 == self.step(node))
                {
                    lines.add(&(self.store)(result, AffineIndex::at(place), &self.operand(operand, number)));
                    at += 1;
                }
            }
        }
        lines.text
    }

    /// Stores results that are constants or inputs.
    fn store_constants(&self, lines: &mut Lines<'_>) {
        // Excludes −0, which has other bits.
        let is_zero = |operand: &Operand| *operand == Operand::ZERO;
        let zeros = |entries: &[Operand]| entries.iter().filter(|entry| is_zero(entry)).count();
        let cleared: Vec<bool> = self.results.iter().map(|entries| zeros(entries) >= MANY_ZEROS).collect();
        for result in (0..cleared.len()).filter(|&result| cleared[result]) {
            lines.add(&(self.clear)(result));
        }
        for (result, index, operand) in self.entries() {
            let is_plain = operand.node().is_none_or(|node| self.graph.nodes[node].is_input());
            let is_done = cleared[result] && is_zero(&operand);
            if is_plain
                && !is_done
                && let Some(place) = (self.place)(result, index)
            {
                lines.add(&(self.store)(result, AffineIndex::at(place), &self.operand(operand, 0)));
            }
        }
    }

    /// Writes a loop, with the statements before its first iteration.
    fn write_loop(&self, repeated: &Loop, part: usize, tables: &Cell<usize>, lines: &mut Lines<'_>) {
        for &(place, node) in &repeated.copies {
            lines.add(&format!("w[{place}] = {};", self.value(node, part)));
        }
        let carried: Vec<String> = repeated.carried.iter().map(|one| format!("c{}", one.number)).collect();
        for (one, name) in repeated.carried.iter().zip(&carried) {
            lines.add(&self.syntax.declare_carried(name, &self.value(one.first, part)));
        }
        let mut body_lines = Vec::new();
        for step in &repeated.steps {
            let operation = self.graph.nodes[step.node];
            let mut read = |number: usize, operand: Operand| {
                let read = &step.reads[number];
                // Constants contain their sign, unless the operation changes it.
                let is_minus = match operand {
                    Operand::Constant(_) => operation.operands().nth(number) != Some(operand),
                    Operand::Plus(_) | Operand::Minus(_) => matches!(operand, Operand::Minus(_)),
                };
                match read {
                    LoopOperand::Invariant(Operand::Constant(_)) => self.operand(operand, part),
                    _ if is_minus => format!("-{}", self.read(read, part, &carried, tables, lines)),
                    _ => self.read(read, part, &carried, tables, lines),
                }
            };
            body_lines.push(self.statement(step.node, &mut read));
            let name = self.name(step.node);
            body_lines.extend(step.stored_at.map(|index| format!("w[{index}] = {name};")));
            for store in &step.stores {
                let text = if store.is_minus { format!("-{name}") } else { name.clone() };
                body_lines.push((self.store)(store.result, store.index, &text));
            }
        }
        for (one, name) in repeated.carried.iter().zip(&carried) {
            body_lines.push(format!("{name} = {};", self.name(one.next)));
        }
        lines.add(
            &self.syntax.loop_head(repeated.iterations, repeated.steps.iter().any(LoopStep::uses_iteration)),
        );
        for line in &body_lines {
            lines.add_inside(line);
        }
        lines.add("}");
    }

    /// Writes an operand of an operation in a loop, without its sign. A table of constants is written before
    /// the loop.
    fn read(
        &self,
        read: &LoopOperand,
        part: usize,
        carried: &[String],
        tables: &Cell<usize>,
        lines: &mut Lines<'_>,
    ) -> String {
        match read {
            LoopOperand::Invariant(operand) => self.operand(*operand, part),
            LoopOperand::ConstantTable(bits) => {
                let values: Vec<f64> = bits.iter().map(|&bits| f64::from_bits(bits)).collect();
                let (table, text) = self.syntax.constants(tables.replace(tables.get() + 1), &values);
                lines.add(&table);
                text
            }
            LoopOperand::Input { argument, index } => (self.input)(*argument, *index),
            LoopOperand::SameIteration(node) => self.name(*node),
            LoopOperand::Carried(number) => carried[*number].clone(),
            LoopOperand::Array(index) => format!("w[{index}]"),
        }
    }

    /// All entries of all results.
    fn entries(&self) -> impl Iterator<Item = (usize, usize, Operand)> {
        self.results.iter().enumerate().flat_map(|(result, entries)| {
            entries.iter().enumerate().map(move |(index, &operand)| (result, index, operand))
        })
    }

    /// The entries of results that a part computes outside its loops, in the order of its operations.
    fn stored_entries(&self, number: usize) -> Vec<(usize, usize, usize, Operand)> {
        let mut stored: Vec<_> = self
            .entries()
            .filter_map(|(result, index, operand)| {
                let node = operand.node()?;
                let is_computed = !self.graph.nodes[node].is_input() && !self.layout.in_loop[node];
                let is_here = is_computed && self.layout.part_of[node] == number;
                let place = (self.place)(result, index).filter(|_| is_here)?;
                Some((self.step(node), result, index, place, operand))
            })
            .collect();
        stored.sort_by_key(|&(step, result, index, ..)| (step, result, index));
        stored.into_iter().map(|(step, result, _, place, operand)| (step, result, place, operand)).collect()
    }

    /// The position of an operation in the order.
    fn step(&self, node: usize) -> usize {
        self.layout.step_of[node]
    }

    fn name(&self, node: usize) -> String {
        format!("t{}", self.step(node))
    }

    fn operand(&self, operand: Operand, part: usize) -> String {
        match operand {
            Operand::Constant(bits) => self.syntax.literal(f64::from_bits(bits)),
            Operand::Plus(node) => self.value(node as usize, part),
            Operand::Minus(node) => format!("-{}", self.value(node as usize, part)),
        }
    }

    /// A value as it is read outside the loop that computes it.
    fn value(&self, node: usize, part: usize) -> String {
        if let Operation::Input { argument, index } = self.graph.nodes[node] {
            return (self.input)(argument as usize, AffineIndex::at(index as usize));
        }
        match self.layout.stored_at[node] {
            Some(place) if self.layout.part_of[node] != part || self.layout.in_loop[node] => {
                format!("w[{place}]")
            }
            _ => self.name(node),
        }
    }

    /// The statement of an operation. `text` writes an operand, given its number among the operands.
    fn statement(&self, node: usize, text: &mut dyn FnMut(usize, Operand) -> String) -> String {
        let name = self.name(node);
        let operation = self.graph.nodes[node];
        if let Operation::FusedMinus(a, b, c) = operation {
            let operands = [text(0, a.negated()), text(1, b), text(2, c)];
            return self.syntax.declare(&name, &self.syntax.fused(operands));
        }
        let operands: Vec<String> =
            operation.operands().enumerate().map(|(number, operand)| text(number, operand)).collect();
        let expression = match (operation, &operands[..]) {
            (Operation::SineCosine(_), [a]) => return self.syntax.declare_pair(&name, a),
            (Operation::Sum(..), [a, b]) => format!("{a} + {b}"),
            (Operation::Difference(..), [a, b]) => format!("{a} - {b}"),
            (Operation::Product(..), [a, b]) => format!("{a} * {b}"),
            (Operation::Quotient(..), [a, b]) => format!("{a} / {b}"),
            (Operation::Fused(..), [a, b, c]) => self.syntax.fused([a.clone(), b.clone(), c.clone()]),
            (Operation::Root(_), [a]) => self.syntax.root(a),
            (Operation::Sign(_), [a]) => self.syntax.sign(a),
            (Operation::Sine(_), [a]) => self.syntax.half(a, true),
            (Operation::Cosine(_), [a]) => self.syntax.half(a, false),
            _ => unreachable!("inputs are not steps"),
        };
        self.syntax.declare(&name, &expression)
    }
}
