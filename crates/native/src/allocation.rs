//! Register allocation for straight-line code. The value whose next use is farthest is spilled first (L. A.
//! Belady, *A study of replacement algorithms for a virtual-storage computer*, IBM Systems Journal 5, 1966).
//!
//! An operation reads its operands before it writes its result. The result may therefore take any register,
//! even that of an operand, once that value is dead or stored. A spill slot that an operation reads for the
//! last time is free after the operation, not within it.

use crate::instruction::{Instruction, Register, Source};
use crate::list::{Address, Base, Binary, List, LoadExtent, NONE, OperandAccess, Operation, Value};
use crate::machine::{MAX_REGISTERS, Machine, SpillCounts};

/// Marks a value without a register.
const NO_REGISTER: Register = Register::MAX;
/// Marks a value without a further use.
const NO_USE: u32 = u32::MAX;
/// Marks a value without a spill slot.
const NO_SLOT: i32 = -1;

/// The result of register allocation.
#[derive(Clone, Debug)]
pub(crate) struct Allocation {
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) counts: SpillCounts,
    /// Bytes of scratch memory in use, including those before the slots.
    pub(crate) scratch_end: i32,
}

/// Allocates registers for a list, with spill slots from byte `scratch_begin` of the scratch memory.
pub(crate) fn allocate(list: &List, machine: Machine, scratch_begin: i32) -> Allocation {
    let mut allocator = Allocator::new(list, machine, scratch_begin);
    for number in 0..list.steps.len() {
        allocator.step(number);
    }
    let Allocator { instructions, counts, scratch_end, .. } = allocator;
    Allocation { instructions, counts, scratch_end }
}

struct Allocator<'a> {
    list: &'a List,
    machine: Machine,
    instructions: Vec<Instruction>,
    counts: SpillCounts,
    /// The location of each value in memory, if it is there, and its spill slot, if it has one.
    home: Vec<Option<Address>>,
    slot: Vec<i32>,
    /// The register of each value, and the value of each register.
    register: Vec<Register>,
    value_in: [Value; MAX_REGISTERS],
    /// The steps that read each value, in order, concatenated; the position of each value's next use in that
    /// list, and the end of its uses.
    uses: Vec<u32>,
    cursor: Vec<u32>,
    ends: Vec<u32>,
    /// The next step after this one that reads the value.
    next: Vec<u32>,
    free_slots: Vec<i32>,
    /// Slots that this step reads for the last time.
    freed: Vec<i32>,
    scratch_end: i32,
    /// The pointer in the register that is shared by pointers without their own.
    pointer: Option<u8>,
    /// Registers that this step reads.
    locked: u32,
    now: u32,
}

impl<'a> Allocator<'a> {
    fn new(list: &'a List, machine: Machine, scratch_begin: i32) -> Self {
        let count = list.homes.len();
        let mut cursor = vec![0_u32; count + 1];
        let reads = |number: usize| {
            let (reads, count) = list.steps[number].operation.reads();
            reads.into_iter().take(count).map(|read| read as usize)
        };
        for read in (0..list.steps.len()).flat_map(reads) {
            cursor[read + 1] += 1;
        }
        for value in 0..count {
            cursor[value + 1] += cursor[value];
        }
        let mut at = cursor.clone();
        let mut uses = vec![0; cursor[count] as usize];
        for number in 0..list.steps.len() {
            for read in reads(number) {
                uses[at[read] as usize] = u32::try_from(number).expect("the number of steps was checked");
                at[read] += 1;
            }
        }
        let ends = cursor[1..].to_vec();
        let first = |value| if cursor[value] < ends[value] { uses[cursor[value] as usize] } else { NO_USE };
        let next = (0..count).map(first).collect();
        Self {
            list,
            machine,
            instructions: Vec::with_capacity(list.steps.len() + list.steps.len() / 4),
            counts: SpillCounts::default(),
            home: list.homes.clone(),
            slot: vec![NO_SLOT; count],
            register: vec![NO_REGISTER; count],
            value_in: [NONE; MAX_REGISTERS],
            uses,
            cursor,
            ends,
            next,
            free_slots: Vec::new(),
            freed: Vec::new(),
            scratch_end: scratch_begin,
            pointer: None,
            locked: 0,
            now: 0,
        }
    }

    fn step(&mut self, number: usize) {
        let step = self.list.steps[number];
        self.now = u32::try_from(number).expect("the number of steps was checked");
        let (reads, count) = step.operation.reads();
        let reads = &reads[..count];
        self.locked = 0;
        for &read in reads {
            self.advance(read);
            if self.is_in_register(read) {
                self.lock(self.register[read as usize]);
            }
        }
        let to = match step.operation {
            Operation::Store(value, to) => {
                let from = self.load_to_register(value);
                self.load_base_pointer(to);
                self.instructions.push(Instruction::Store { from, to });
                // Each result of one state is written once, so the value can be read from there.
                let stays = to.base == Base::Scratch || to.extent == LoadExtent::Number;
                if self.home[value as usize].is_none() && stays {
                    self.home[value as usize] = Some(to);
                }
                self.release(value);
                None
            }
            Operation::Binary(kind, a, b) => Some(self.binary(kind, a, b)),
            Operation::Root(a) => {
                let source = self.source(a, OperandAccess::Numbers);
                let to = self.result_register(reads);
                self.instructions.push(Instruction::Root { to, a: source });
                Some(to)
            }
            Operation::Shift(a, by) => {
                let from = self.load_to_register(a);
                let to = self.result_register(reads);
                self.instructions.push(Instruction::Shift { to, a: from, by });
                Some(to)
            }
            Operation::Blend { otherwise, negative, mask } => {
                let mask = self.load_to_register(mask);
                let otherwise = self.load_to_register(otherwise);
                let negative = self.source(negative, OperandAccess::Bits);
                let to = self.result_register(reads);
                self.instructions.push(Instruction::Blend { to, otherwise, negative, mask });
                Some(to)
            }
            Operation::Fused { a, b, c, is_minus } => Some(self.fused(a, b, c, is_minus)),
        };
        if let Some(to) = to {
            debug_assert!(self.value_in[usize::from(to)] == NONE, "a result overwrites a value");
            if self.next[step.result as usize] != NO_USE {
                self.bind(step.result, to);
            }
        }
        self.free_slots.append(&mut self.freed);
    }

    fn binary(&mut self, kind: Binary, mut a: Value, mut b: Value) -> Register {
        let extent = kind.reads();
        if kind.commutes() && !self.is_in_register(a) {
            let exchanged = self.is_in_register(b)
                || match (self.can_be_source(a, extent), self.can_be_source(b, extent)) {
                    (true, false) => true,
                    (false, true) => false,
                    // The value with the sooner next use is loaded.
                    _ => self.next[b as usize] < self.next[a as usize],
                };
            if exchanged {
                core::mem::swap(&mut a, &mut b);
            }
        }
        let left = self.load_to_register(a);
        let right = self.source(b, extent);
        let to = self.result_register(&[a, b]);
        self.instructions.push(Instruction::Binary { kind, to, a: left, b: right });
        to
    }

    /// Advances the next use of a value past this step.
    fn advance(&mut self, value: Value) {
        let value = value as usize;
        let (mut at, end) = (self.cursor[value], self.ends[value]);
        while at < end && self.uses[at as usize] <= self.now {
            at += 1;
        }
        self.cursor[value] = at;
        self.next[value] = if at < end { self.uses[at as usize] } else { NO_USE };
    }

    fn lock(&mut self, register: Register) {
        self.locked |= 1 << register;
    }

    pub(super) fn is_in_register(&self, value: Value) -> bool {
        self.register[value as usize] != NO_REGISTER
    }

    /// Whether the value is dead after this step.
    fn is_dead(&self, value: Value) -> bool {
        self.next[value as usize] == NO_USE
    }

    fn registers(&self) -> impl Iterator<Item = Register> + use<> {
        0..self.machine.registers
    }

    fn free_register(&self) -> Option<Register> {
        self.registers().find(|&r| self.value_in[usize::from(r)] == NONE && self.locked >> r & 1 == 0)
    }

    /// The unlocked register whose value has the farthest next use; among equals, one whose value is in
    /// memory already.
    fn victim(&self, locked: u32) -> Register {
        let distance = |r: &Register| {
            let value = self.value_in[usize::from(*r)] as usize;
            (self.next[value], self.home[value].is_some())
        };
        let candidates = self.registers().filter(|r| locked >> r & 1 == 0);
        candidates.max_by_key(distance).expect("an operation has fewer operands than a machine has registers")
    }

    /// A free register, after a spill if necessary.
    fn acquire(&mut self, locked: u32) -> Register {
        if let Some(register) = self.free_register() {
            return register;
        }
        let register = self.victim(locked);
        self.spill(register);
        self.unbind(self.value_in[usize::from(register)]);
        register
    }

    /// Spills the value of a register if it is live and not in memory.
    fn spill(&mut self, register: Register) {
        let value = self.value_in[usize::from(register)] as usize;
        if self.next[value] == NO_USE || self.home[value].is_some() {
            return;
        }
        let offset = self.free_slots.pop().unwrap_or_else(|| {
            self.scratch_end += self.machine.slot_bytes;
            self.scratch_end - self.machine.slot_bytes
        });
        self.slot[value] = offset;
        let to = Address::new(Base::Scratch, offset, self.machine.slot_extent);
        self.home[value] = Some(to);
        self.instructions.push(Instruction::Store { from: register, to });
        self.counts.spills += 1;
    }

    fn bind(&mut self, value: Value, register: Register) {
        self.register[value as usize] = register;
        self.value_in[usize::from(register)] = value;
    }

    fn unbind(&mut self, value: Value) {
        let register = core::mem::replace(&mut self.register[value as usize], NO_REGISTER);
        if register != NO_REGISTER {
            self.value_in[usize::from(register)] = NONE;
        }
    }

    /// Frees the register of a dead value at once, and its slot after this step.
    fn release(&mut self, value: Value) {
        if self.is_dead(value) {
            self.unbind(value);
            let slot = core::mem::replace(&mut self.slot[value as usize], NO_SLOT);
            if slot != NO_SLOT {
                self.freed.push(slot);
            }
        }
    }

    /// Loads the base pointer of an address if necessary.
    fn load_base_pointer(&mut self, address: Address) {
        if let Base::Table(number) = address.base
            && number >= self.machine.fixed_pointers
            && self.pointer != Some(number)
        {
            self.pointer = Some(number);
            self.instructions.push(Instruction::Pointer(number));
        }
    }

    fn home_of(&mut self, value: Value) -> Address {
        let address = self.home[value as usize].expect("a value is in a register or in memory");
        self.load_base_pointer(address);
        address
    }

    /// The register of a value, which is loaded if necessary.
    fn load_to_register(&mut self, value: Value) -> Register {
        if self.is_in_register(value) {
            return self.register[value as usize];
        }
        let to = self.acquire(self.locked);
        let from = self.home_of(value);
        self.instructions.push(Instruction::Load { to, from });
        self.counts.loads += 1;
        self.bind(value, to);
        self.lock(to);
        to
    }

    /// Whether an instruction can read the value from its current location.
    fn can_be_source(&self, value: Value, reads: OperandAccess) -> bool {
        if self.is_in_register(value) {
            return true;
        }
        let extent = self.home[value as usize].map(|address| address.extent);
        self.machine.has_memory_operands
            && match extent {
                Some(LoadExtent::Register) => true,
                Some(LoadExtent::Number) => reads == OperandAccess::Numbers,
                Some(LoadExtent::Broadcast) => self.machine.has_broadcast && reads != OperandAccess::Register,
                None => false,
            }
    }

    /// A value as an operand that may be in memory.
    fn source(&mut self, value: Value, reads: OperandAccess) -> Source {
        if self.is_in_register(value) || !self.can_be_source(value, reads) {
            return Source::Register(self.load_to_register(value));
        }
        Source::Memory(self.home_of(value))
    }

    /// The register of a result: that of a dead operand, or another one.
    fn result_register(&mut self, reads: &[Value]) -> Register {
        let mut found = None;
        for &read in reads {
            if self.is_dead(read) && self.is_in_register(read) {
                found = found.or(Some(self.register[read as usize]));
            }
            self.release(read);
        }
        // The operands are read first, so their registers can be used too once their values are spilled.
        found.unwrap_or_else(|| {
            let free = self.registers().find(|&r| self.value_in[usize::from(r)] == NONE);
            free.unwrap_or_else(|| self.acquire(0))
        })
    }
}

mod fused_operands;
