//! Simplifications of operations as they are recorded.
//!
//! | operation | becomes |
//! | --- | --- |
//! | an operation on constants | its value, rounded as the operation rounds |
//! | x + 0, x − 0, 1 x, x / 1 | x |
//! | 0 − x, (−1) x, x / (−1) | −x |
//! | 0 x, 0 / x, x − x | 0 |
//! | a + b, a b of the same a and b, in either order | the operation that exists |
//! | b − a, where a − b exists | −(a − b) |
//! | a + (−b), (−a) + b | a − b, b − a |
//! | (−a) + (−b), (−a) b, (−a) / b | −(a + b), −(a b), −(a / b) |
//! | sin(−x), cos(−x) | −sin x, cos x |
//! | a b + c rounded once, with a or b of 0 or ±1, or c of 0 | the remaining product or sum |
//!
//! For finite numbers each is exact except for the sign of a zero: the results of generated code equal (`==`)
//! those of the original operations. Nothing is reassociated or distributed, and no division becomes a
//! product.

use crate::graph::{Graph, Operand, Operation};

const ONE: f64 = 1.0;

impl Graph {
    /// A constant, rounded.
    pub fn constant(&self, x: f64) -> Operand {
        Operand::constant(self.precision.round(x))
    }

    /// a + b.
    pub fn sum(&mut self, a: Operand, b: Operand) -> Operand {
        match (a.known(), b.known()) {
            (Some(x), Some(y)) => return self.constant(x + y),
            (Some(0.0), None) => return b,
            (None, Some(0.0)) => return a,
            _ => {}
        }
        let ((minus_a, a), (minus_b, b)) = (a.split_sign(), b.split_sign());
        match (minus_a, minus_b) {
            (false, false) | (true, true) => {
                self.push(Operation::Sum(a.min(b), a.max(b))).negated_if(minus_a)
            }
            (false, true) => self.unsigned_difference(a, b),
            (true, false) => self.unsigned_difference(b, a),
        }
    }

    /// a − b of operands without signs.
    fn unsigned_difference(&mut self, a: Operand, b: Operand) -> Operand {
        if a == b {
            return Operand::ZERO;
        }
        match self.find(Operation::Difference(b, a)) {
            Some(opposite) => opposite.negated(),
            None => self.push(Operation::Difference(a, b)),
        }
    }

    /// a b.
    pub fn product(&mut self, a: Operand, b: Operand) -> Operand {
        if let (Some(x), Some(y)) = (a.known(), b.known()) {
            return self.constant(x * y);
        }
        let ((minus_a, a), (minus_b, b)) = (a.split_sign(), b.split_sign());
        self.unsigned_product(a, b).negated_if(minus_a != minus_b)
    }

    fn unsigned_product(&mut self, a: Operand, b: Operand) -> Operand {
        match (a.known(), b.known()) {
            (Some(0.0), _) | (_, Some(0.0)) => Operand::ZERO,
            (Some(ONE), _) => b,
            (_, Some(ONE)) => a,
            _ => self.push(Operation::Product(a.min(b), a.max(b))),
        }
    }

    /// a b + c, rounded once.
    pub fn fused(&mut self, a: Operand, b: Operand, c: Operand) -> Operand {
        if let (Some(x), Some(y), Some(z)) = (a.known(), b.known(), c.known()) {
            return Operand::constant(self.precision.multiply_add(x, y, z));
        }
        let exact = |x: Operand| matches!(x.known().map(f64::abs), Some(0.0 | 1.0));
        if exact(a) || exact(b) || c.known() == Some(0.0) {
            let product = self.product(a, b);
            return self.sum(product, c);
        }
        let ((minus_a, a), (minus_b, b), (minus_c, c)) = (a.split_sign(), b.split_sign(), c.split_sign());
        let (a, b) = (a.min(b), a.max(b));
        let operation = if (minus_a != minus_b) == minus_c {
            Operation::Fused(a, b, c)
        } else {
            Operation::FusedMinus(a, b, c)
        };
        self.push(operation).negated_if(minus_c)
    }

    /// a / b.
    pub fn quotient(&mut self, a: Operand, b: Operand) -> Operand {
        if let (Some(x), Some(y)) = (a.known(), b.known()) {
            return self.constant(x / y);
        }
        let ((minus_a, a), (minus_b, b)) = (a.split_sign(), b.split_sign());
        let quotient = match (a.known(), b.known()) {
            (Some(0.0), _) => Operand::ZERO,
            (_, Some(ONE)) => a,
            _ => self.push(Operation::Quotient(a, b)),
        };
        quotient.negated_if(minus_a != minus_b)
    }

    /// √a.
    pub fn root(&mut self, a: Operand) -> Operand {
        match a.known() {
            Some(x) => self.constant(x.sqrt()),
            None => self.push(Operation::Root(a)),
        }
    }

    /// −1, 0 or 1.
    pub fn sign(&mut self, a: Operand) -> Operand {
        if let Some(x) = a.known() {
            return Operand::constant(robot_dynamics_number::Scalar::signum0(x));
        }
        let (minus, a) = a.split_sign();
        self.push(Operation::Sign(a)).negated_if(minus)
    }

    /// sin a and cos a of an operand that is not a constant.
    pub fn sine_cosine(&mut self, a: Operand) -> (Operand, Operand) {
        let (minus, a) = a.split_sign();
        let pair = self.push(Operation::SineCosine(a));
        let sine = self.push(Operation::Sine(pair)).negated_if(minus);
        (sine, self.push(Operation::Cosine(pair)))
    }
}
