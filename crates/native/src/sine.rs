//! The library's own sine as a part of the list of operations.

use std::sync::OnceLock;

use robot_dynamics_expression::{Arithmetic, Graph, Operand, Precision, as_traced, trace_sine};

use crate::list::{Binary, Operation, Value};
use crate::lowering::Lowering;

/// The graph of sine and cosine of one input, without the rotation by quarter turns.
pub(crate) struct SineGraph {
    graph: Graph,
    /// The shifted number of quarter turns, and the sine and cosine of the reduced angle.
    results: [Operand; 3],
    order: Vec<usize>,
}

impl SineGraph {
    /// The graph in an arithmetic, traced once per process.
    pub(crate) fn of(arithmetic: Arithmetic) -> &'static Self {
        static GRAPHS: [OnceLock<SineGraph>; 4] = [const { OnceLock::new() }; 4];
        let number =
            2 * usize::from(arithmetic.precision == Precision::Single) + usize::from(arithmetic.fused);
        GRAPHS[number].get_or_init(|| {
            let (graph, results) = trace_sine(arithmetic);
            let order = as_traced(&graph, &results);
            Self { graph, results: [results[0][0], results[0][1], results[0][2]], order }
        })
    }
}

impl Lowering<'_> {
    /// The sine and cosine of an angle. The largest magnitude of all angles is recorded.
    pub(crate) fn sine_and_cosine(&mut self, angle: Value, magnitude: Value) -> (Value, Value) {
        let size = self.list.binary(Binary::And, angle, magnitude);
        // A NaN is ignored: the maximum is the second operand then.
        let largest = self.largest_angle.unwrap_or_else(|| self.constant(0.0));
        self.largest_angle = Some(self.list.binary(Binary::Maximum, size, largest));
        let sine = SineGraph::of(self.target.arithmetic);
        let mut values = vec![angle; sine.graph.nodes.len()];
        for &node in &sine.order {
            values[node] = self.operation(&values, sine.graph.nodes[node]);
        }
        let [shifted, sine, cosine] = sine.results.map(|operand| self.operand(&values, operand));
        self.rotate_by_quadrant(shifted, sine, cosine)
    }

    /// Sine and cosine of r + n π/2 from those of r. The lowest bit of n exchanges them, and the next bit of
    /// n (of n + 1) is the sign of the sine (cosine).
    fn rotate_by_quadrant(&mut self, shifted: Value, sine: Value, cosine: Value) -> (Value, Value) {
        let sign = self.bits(self.sign_bit());
        let last_bit = self.number_bits() - 1;
        let odd = self.list.push(Operation::Shift(shifted, last_bit));
        let half_turn = self.list.push(Operation::Shift(shifted, last_bit - 1));
        let half_turn = self.list.binary(Binary::And, half_turn, sign);
        let turned = Operation::Blend { otherwise: sine, negative: cosine, mask: odd };
        let turned_sine = self.list.push(turned);
        let turned_sine = self.list.binary(Binary::Xor, turned_sine, half_turn);
        let turned = Operation::Blend { otherwise: cosine, negative: sine, mask: odd };
        let turned_cosine = self.list.push(turned);
        let next = self.list.binary(Binary::Xor, half_turn, odd);
        // The other bits of `odd` are zero.
        let turned_cosine = self.list.binary(Binary::Xor, turned_cosine, next);
        (turned_sine, turned_cosine)
    }
}
