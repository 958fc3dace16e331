//! Register allocation for fused multiply-adds, which overwrite one operand.

use super::{Allocator, Source};
use crate::instruction::{FusedForm, Instruction, Register};
use crate::list::{OperandAccess, Value};

impl Allocator<'_> {
    /// a b + c, or c − a b.
    pub(super) fn fused(&mut self, a: Value, b: Value, c: Value, is_minus: bool) -> Register {
        if self.machine.has_fused_destination {
            let [left, right, addend] = [a, b, c].map(|value| self.load_to_register(value));
            let to = self.result_register(&[a, b, c]);
            self.instructions.push(Instruction::FusedWithDestination {
                is_minus,
                to,
                a: left,
                b: right,
                c: addend,
            });
            return to;
        }
        if self.machine.has_memory_operands {
            self.fused_over_any(a, b, c, is_minus)
        } else {
            self.fused_over_addend(a, b, c, is_minus)
        }
    }

    /// Overwrites the addend, or a copy of it.
    fn fused_over_addend(&mut self, a: Value, b: Value, c: Value, is_minus: bool) -> Register {
        let factors = [self.load_to_register(a), self.load_to_register(b)];
        let addend = self.load_to_register(c);
        // A factor that equals the addend is read before it is overwritten.
        let to = if self.is_dead(c) { addend } else { self.copy_register(addend) };
        self.unbind_if(c, to);
        self.push_fused(FusedForm::Addend, is_minus, to, factors[0], Source::Register(factors[1]));
        for value in [a, b, c] {
            self.release(value);
        }
        to
    }

    /// Copies a register to another one.
    fn copy_register(&mut self, from: Register) -> Register {
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

    /// Overwrites an operand that is dead or also in memory, else a copy.
    fn fused_over_any(&mut self, a: Value, b: Value, c: Value, is_minus: bool) -> Register {
        let Some(over) = self.choose_overwritten(a, b, c) else {
            let [left, right, addend] = [a, b, c].map(|value| self.register[value as usize]);
            let to = self.copy_register(addend);
            self.push_fused(FusedForm::Addend, is_minus, to, left, Source::Register(right));
            return to;
        };
        let to = self.register[over as usize];
        if over == c {
            let exchange = !self.is_in_register(a)
                && (self.is_in_register(b) || self.next[b as usize] < self.next[a as usize]);
            let (a, b) = if exchange { (b, a) } else { (a, b) };
            let factor = self.load_to_register(a);
            let other = self.source(b, OperandAccess::Numbers);
            self.push_fused(FusedForm::Addend, is_minus, to, factor, other);
        } else {
            let factor = if over == a { b } else { a };
            if !self.is_in_register(factor) && !self.is_in_register(c) {
                let sooner = if self.next[factor as usize] < self.next[c as usize] { factor } else { c };
                self.load_to_register(sooner);
            }
            if self.is_in_register(factor) {
                let factor = self.register[factor as usize];
                let addend = self.source(c, OperandAccess::Numbers);
                self.push_fused(FusedForm::FactorAndMemoryAddend, is_minus, to, factor, addend);
            } else {
                let addend = self.register[c as usize];
                let factor = self.source(factor, OperandAccess::Numbers);
                self.push_fused(FusedForm::Factor, is_minus, to, addend, factor);
            }
        }
        // A live value is in memory.
        self.unbind(over);
        for value in [a, b, c] {
            self.release(value);
        }
        to
    }

    /// The operand whose register the result overwrites: it is dead after the operation, or also in memory.
    fn choose_overwritten(&mut self, a: Value, b: Value, c: Value) -> Option<Value> {
        let dies = |value: &Value| self.is_in_register(*value) && self.is_dead(*value);
        if let Some(over) = [c, a, b].into_iter().find(dies) {
            return Some(over);
        }
        let outside = [c, a, b].into_iter().filter(|&value| !self.is_in_register(value));
        if let Some(value) = outside.max_by_key(|&value| self.next[value as usize]) {
            self.load_to_register(value);
            return Some(value);
        }
        if self.free_register().is_some() {
            return None;
        }
        let victim = self.victim(0);
        let is_operand = self.locked >> victim & 1 == 1;
        is_operand.then(|| {
            self.spill(victim);
            self.value_in[usize::from(victim)]
        })
    }

    fn push_fused(&mut self, form: FusedForm, is_minus: bool, to: Register, a: Register, b: Source) {
        self.instructions.push(Instruction::Fused { form, is_minus, to, a, b });
    }
}
