//! Registers for straight-line code: the value whose next use is farthest leaves first (L. A. Belady, *A study of replacement
//! algorithms for a virtual-storage computer*, IBM Systems Journal 5, 1966).
//!
//! An operation's operands are read before its result is written, so that a result may take any register, also one of its operands',
//! once that value is dead or saved. A memory slot that an operation reads for the last time is free after the operation, not within it.

use crate::instruction::{Instruction, Register, Source};
use crate::list::{Address, Base, Binary, Extent, List, NONE, Operation, Reads, Value};
use crate::machine::{Counts, MOST_REGISTERS, Machine};

/// No register.
const NOWHERE: Register = Register::MAX;
/// No further use.
const NEVER: u32 = u32::MAX;
/// No slot.
const NO_SLOT: i32 = -1;

/// A list with registers.
#[derive(Clone, Debug)]
pub(crate) struct Allocation {
    pub(crate) instructions: Vec<Instruction>,
    pub(crate) counts: Counts,
    /// Bytes of scratch memory in use, those before the slots included.
    pub(crate) scratch_end: i32,
}

/// Registers for a list, whose slots begin at a byte of the scratch memory.
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
    counts: Counts,
    /// Where each value is in memory, if it is there, and its slot if that is one.
    home: Vec<Option<Address>>,
    slot: Vec<i32>,
    /// The register of each value, and the value of each register.
    register: Vec<Register>,
    holds: [Value; MOST_REGISTERS],
    /// The steps that read each value in order, beside each other; of each value the first still to come, and the end.
    uses: Vec<u32>,
    cursor: Vec<u32>,
    ends: Vec<u32>,
    /// The next step after this one that reads the value.
    next: Vec<u32>,
    free_slots: Vec<i32>,
    /// Slots that this step reads for the last time.
    freed: Vec<i32>,
    scratch_end: i32,
    /// The pointer in the register for those without one of their own.
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
        let first = |value| if cursor[value] < ends[value] { uses[cursor[value] as usize] } else { NEVER };
        let next = (0..count).map(first).collect();
        Self {
            list,
            machine,
            instructions: Vec::with_capacity(list.steps.len() + list.steps.len() / 4),
            counts: Counts::default(),
            home: list.homes.clone(),
            slot: vec![NO_SLOT; count],
            register: vec![NOWHERE; count],
            holds: [NONE; MOST_REGISTERS],
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
                let from = self.in_register(value);
                self.point_to(to);
                self.instructions.push(Instruction::Store { from, to });
                // Places of one state's results are written once, so that the value can be read there.
                let stays = to.base == Base::Scratch || to.extent == Extent::Number;
                if self.home[value as usize].is_none() && stays {
                    self.home[value as usize] = Some(to);
                }
                self.release(value);
                None
            }
            Operation::Binary(kind, a, b) => Some(self.binary(kind, a, b)),
            Operation::Root(a) => {
                let source = self.source(a, Reads::Numbers);
                let to = self.destination(reads);
                self.instructions.push(Instruction::Root { to, a: source });
                Some(to)
            }
            Operation::Shift(a, by) => {
                let from = self.in_register(a);
                let to = self.destination(reads);
                self.instructions.push(Instruction::Shift { to, a: from, by });
                Some(to)
            }
            Operation::Blend { otherwise, negative, mask } => {
                let mask = self.in_register(mask);
                let otherwise = self.in_register(otherwise);
                let negative = self.source(negative, Reads::Bits);
                let to = self.destination(reads);
                self.instructions.push(Instruction::Blend { to, otherwise, negative, mask });
                Some(to)
            }
            Operation::Fused { a, b, c, is_minus } => Some(self.fused(a, b, c, is_minus)),
        };
        if let Some(to) = to {
            debug_assert!(self.holds[usize::from(to)] == NONE, "a result overwrites a value");
            if self.next[step.result as usize] != NEVER {
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
                    // The one that is read again sooner is loaded.
                    _ => self.next[b as usize] < self.next[a as usize],
                };
            if exchanged {
                core::mem::swap(&mut a, &mut b);
            }
        }
        let left = self.in_register(a);
        let right = self.source(b, extent);
        let to = self.destination(&[a, b]);
        self.instructions.push(Instruction::Binary { kind, to, a: left, b: right });
        to
    }

    /// The next use of a value after this step.
    fn advance(&mut self, value: Value) {
        let value = value as usize;
        let (mut at, end) = (self.cursor[value], self.ends[value]);
        while at < end && self.uses[at as usize] <= self.now {
            at += 1;
        }
        self.cursor[value] = at;
        self.next[value] = if at < end { self.uses[at as usize] } else { NEVER };
    }

    fn lock(&mut self, register: Register) {
        self.locked |= 1 << register;
    }

    pub(super) fn is_in_register(&self, value: Value) -> bool {
        self.register[value as usize] != NOWHERE
    }

    /// Whether the value is not read after this step.
    fn is_dead(&self, value: Value) -> bool {
        self.next[value as usize] == NEVER
    }

    fn registers(&self) -> impl Iterator<Item = Register> + use<> {
        0..self.machine.registers
    }

    fn free_register(&self) -> Option<Register> {
        self.registers().find(|&r| self.holds[usize::from(r)] == NONE && self.locked >> r & 1 == 0)
    }

    /// The register whose value is read again last, of those that may leave; at the same distance one that is in memory anyway.
    fn victim(&self, locked: u32) -> Register {
        let distance = |r: &Register| {
            let value = self.holds[usize::from(*r)] as usize;
            (self.next[value], self.home[value].is_some())
        };
        let candidates = self.registers().filter(|r| locked >> r & 1 == 0);
        candidates.max_by_key(distance).expect("an operation has fewer operands than a machine has registers")
    }

    /// A register that holds nothing.
    fn acquire(&mut self, locked: u32) -> Register {
        if let Some(register) = self.free_register() {
            return register;
        }
        let register = self.victim(locked);
        self.save(register);
        self.unbind(self.holds[usize::from(register)]);
        register
    }

    /// Stores the value of a register where it is read again and not in memory.
    fn save(&mut self, register: Register) {
        let value = self.holds[usize::from(register)] as usize;
        if self.next[value] == NEVER || self.home[value].is_some() {
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
        self.holds[usize::from(register)] = value;
    }

    fn unbind(&mut self, value: Value) {
        let register = core::mem::replace(&mut self.register[value as usize], NOWHERE);
        if register != NOWHERE {
            self.holds[usize::from(register)] = NONE;
        }
    }

    /// Frees what a value holds that is not read again: its register at once, its slot after this step.
    fn release(&mut self, value: Value) {
        if self.is_dead(value) {
            self.unbind(value);
            let slot = core::mem::replace(&mut self.slot[value as usize], NO_SLOT);
            if slot != NO_SLOT {
                self.freed.push(slot);
            }
        }
    }

    /// Makes the base of an address available.
    fn point_to(&mut self, address: Address) {
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
        self.point_to(address);
        address
    }

    /// The register of a value, which is loaded if it is in memory.
    fn in_register(&mut self, value: Value) -> Register {
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

    /// Whether an instruction can read the value where it is.
    fn can_be_source(&self, value: Value, reads: Reads) -> bool {
        if self.is_in_register(value) {
            return true;
        }
        let extent = self.home[value as usize].map(|address| address.extent);
        self.machine.has_memory_operands
            && match extent {
                Some(Extent::Register) => true,
                Some(Extent::Number) => reads == Reads::Numbers,
                Some(Extent::Broadcast) => self.machine.has_broadcast && reads != Reads::Register,
                None => false,
            }
    }

    /// A value as an operand that may be in memory.
    fn source(&mut self, value: Value, reads: Reads) -> Source {
        if self.is_in_register(value) || !self.can_be_source(value, reads) {
            return Source::Register(self.in_register(value));
        }
        Source::Memory(self.home_of(value))
    }

    /// The register of a result: that of an operand which is not read again, or another.
    fn destination(&mut self, reads: &[Value]) -> Register {
        let mut found = None;
        for &read in reads {
            if self.is_dead(read) && self.is_in_register(read) {
                found = found.or(Some(self.register[read as usize]));
            }
            self.release(read);
        }
        // The operands are read before: also their registers may be taken once they are saved.
        found.unwrap_or_else(|| {
            let free = self.registers().find(|&r| self.holds[usize::from(r)] == NONE);
            free.unwrap_or_else(|| self.acquire(0))
        })
    }
}

mod fused;
