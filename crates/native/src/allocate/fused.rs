//! Fused multiply-adds, of whose operands one is overwritten.

use super::{Allocator, Source};
use crate::instruction::{Form, Instruction, Register};
use crate::list::{Reads, Value};

impl Allocator<'_> {
    /// a b + c, or c − a b.
    pub(super) fn fused(&mut self, a: Value, b: Value, c: Value, is_minus: bool) -> Register {
        if self.machine.has_fused_apart {
            let [left, right, addend] = [a, b, c].map(|value| self.in_register(value));
            let to = self.destination(&[a, b, c]);
            self.instructions.push(Instruction::FusedApart { is_minus, to, a: left, b: right, c: addend });
            return to;
        }
        if self.machine.has_memory_operands {
            self.fused_over_any(a, b, c, is_minus)
        } else {
            self.fused_over_addend(a, b, c, is_minus)
        }
    }

    /// Over the addend, or a copy of it.
    fn fused_over_addend(&mut self, a: Value, b: Value, c: Value, is_minus: bool) -> Register {
        let factors = [self.in_register(a), self.in_register(b)];
        let addend = self.in_register(c);
        // A factor that is the addend, too, is read before it is overwritten.
        let to = if self.is_dead(c) { addend } else { self.copied(addend) };
        self.unbind_if(c, to);
        self.push_fused(Form::Addend, is_minus, to, factors[0], Source::Register(factors[1]));
        for value in [a, b, c] {
            self.release(value);
        }
        to
    }

    /// A copy of a register in another one.
    fn copied(&mut self, from: Register) -> Register {
        let to = self.acquire(self.locked);
        self.instructions.push(Instruction::Copy { to, from });
        self.counts.copies += 1;
        to
    }

    fn unbind_if(&mut self, value: Value, register: Register) {
        if self.register[value as usize] == register {
            self.unbind(value);
        }
    }

    /// Over the operand that is not read again or that is in memory, too; else over a copy.
    fn fused_over_any(&mut self, a: Value, b: Value, c: Value, is_minus: bool) -> Register {
        let Some(over) = self.overwritten(a, b, c) else {
            let [left, right, addend] = [a, b, c].map(|value| self.register[value as usize]);
            let to = self.copied(addend);
            self.push_fused(Form::Addend, is_minus, to, left, Source::Register(right));
            return to;
        };
        let to = self.register[over as usize];
        if over == c {
            let exchange = !self.is_in_register(a)
                && (self.is_in_register(b) || self.next[b as usize] < self.next[a as usize]);
            let (a, b) = if exchange { (b, a) } else { (a, b) };
            let factor = self.in_register(a);
            let other = self.source(b, Reads::Numbers);
            self.push_fused(Form::Addend, is_minus, to, factor, other);
        } else {
            let factor = if over == a { b } else { a };
            if !self.is_in_register(factor) && !self.is_in_register(c) {
                let sooner = if self.next[factor as usize] < self.next[c as usize] { factor } else { c };
                self.in_register(sooner);
            }
            if self.is_in_register(factor) {
                let factor = self.register[factor as usize];
                let addend = self.source(c, Reads::Numbers);
                self.push_fused(Form::FactorAndMemoryAddend, is_minus, to, factor, addend);
            } else {
                let addend = self.register[c as usize];
                let factor = self.source(factor, Reads::Numbers);
                self.push_fused(Form::Factor, is_minus, to, addend, factor);
            }
        }
        // A value that is read again is in memory.
        self.unbind(over);
        for value in [a, b, c] {
            self.release(value);
        }
        to
    }

    /// The operand whose register the result takes, which is not needed any more after the operation or is in memory, too.
    fn overwritten(&mut self, a: Value, b: Value, c: Value) -> Option<Value> {
        let dies = |value: &Value| self.is_in_register(*value) && self.is_dead(*value);
        if let Some(over) = [c, a, b].into_iter().find(dies) {
            return Some(over);
        }
        let outside = [c, a, b].into_iter().filter(|&value| !self.is_in_register(value));
        if let Some(value) = outside.max_by_key(|&value| self.next[value as usize]) {
            self.in_register(value);
            return Some(value);
        }
        if self.free_register().is_some() {
            return None;
        }
        let victim = self.victim(0);
        let is_operand = self.locked >> victim & 1 == 1;
        is_operand.then(|| {
            self.save(victim);
            self.holds[usize::from(victim)]
        })
    }

    fn push_fused(&mut self, form: Form, is_minus: bool, to: Register, a: Register, b: Source) {
        self.instructions.push(Instruction::Fused { form, is_minus, to, a, b });
    }
}
