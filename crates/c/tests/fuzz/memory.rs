//! The arguments of random calls: handles, arrays in one block of memory, and numbers.

use std::ffi::{CStr, c_char};
use std::ptr::{null, null_mut};

use crate::common::Robot;
use robot_dynamics::model::{RandomState, random_state};
use robot_dynamics::number::SplitMix64;

/// The numbers of the block, and of a guard zone between two arrays.
const NUMBERS: usize = 4096;
const GUARD: usize = 4;

/// The kinds of handles; the numbers are those of the kinds' handles.
pub(crate) const MODEL: usize = 1;
pub(crate) const WORKSPACE: usize = 2;
pub(crate) const BATCH: usize = 3;
pub(crate) const CONSTRAINTS: usize = 4;
pub(crate) const SIMULATION: usize = 5;
pub(crate) const SNAPSHOT: usize = 6;
pub(crate) const TORQUE: usize = 7;
pub(crate) const TASK: usize = 8;
pub(crate) const OBSERVER: usize = 9;
pub(crate) const RECORD: usize = 10;
pub(crate) const PROBLEM: usize = 11;
pub(crate) const MPC: usize = 12;
pub(crate) const KINDS: usize = 13;
/// The most objects of a kind.
pub(crate) const MOST: usize = 6;

/// A robot's sizes and some of its states.
struct Sizes {
    nq: usize,
    nv: usize,
    frames: usize,
    joints: usize,
    moving: usize,
    states: Vec<RandomState>,
}

pub(crate) struct Fuzz {
    random: SplitMix64,
    block: Vec<f64>,
    /// The block as it must be outside the outputs.
    expected: Vec<f64>,
    /// Structures of options, and the first free place.
    structures: Vec<u64>,
    next_structure: usize,
    /// The first free number of the block.
    next: usize,
    /// The bytes of the outputs of this call.
    outputs: Vec<(usize, usize)>,
    /// The last array of this call.
    last: usize,
    /// The length of the last argument.
    pub(crate) len: usize,
    /// A number that several arguments of this call share.
    pub(crate) kept: usize,
    robots: Vec<Sizes>,
    /// The robot of this call, and its sizes.
    pub(crate) robot: usize,
    pub(crate) nq: usize,
    pub(crate) nv: usize,
    pub(crate) frames: usize,
    pub(crate) joints: usize,
    /// Handles and their robots, by kind.
    pub(crate) live: [Vec<(u64, usize)>; KINDS],
    pub(crate) freed: Vec<u64>,
}

impl Fuzz {
    pub(crate) fn new(seed: u64, robots: &[Robot]) -> Self {
        let mut random = SplitMix64::new(seed);
        let sizes = |robot: &Robot| Sizes {
            nq: robot.model.nq(),
            nv: robot.model.nv(),
            frames: robot.model.frames().len(),
            joints: robot.model.joints().len(),
            moving: robot.model.moving_links().count(),
            states: (0..8).map(|_| random_state(&robot.model, &mut random)).collect(),
        };
        let sizes: Vec<Sizes> = robots.iter().map(sizes).collect();
        let mut live: [Vec<(u64, usize)>; KINDS] = Default::default();
        live[MODEL] = robots.iter().enumerate().map(|(k, robot)| (robot.handle.id, k)).collect();
        live[WORKSPACE] = robots.iter().enumerate().map(|(k, robot)| (robot.workspace.id, k)).collect();
        let block: Vec<f64> = (0..NUMBERS).map(|k| k as f64).collect();
        let (expected, outputs, freed) = (block.clone(), Vec::new(), Vec::new());
        let (structures, next_structure) = (vec![0; 128], 0);
        let [next, last, len, kept, robot, nq, nv, frames, joints] = [0; 9];
        let mut own = Self {
            random,
            block,
            expected,
            structures,
            next_structure,
            next,
            outputs,
            last,
            len,
            kept,
            robots: sizes,
            robot,
            nq,
            nv,
            frames,
            joints,
            live,
            freed,
        };
        own.start();
        own
    }

    /// Starts a call for a random robot.
    pub(crate) fn start(&mut self) {
        self.robot = self.below(self.robots.len());
        let Sizes { nq, nv, frames, joints, .. } = self.robots[self.robot];
        (self.nq, self.nv, self.frames, self.joints) = (nq, nv, frames, joints);
        (self.next, self.last, self.next_structure) = (GUARD, GUARD, 0);
        self.outputs.clear();
    }

    pub(crate) fn below(&mut self, count: usize) -> usize {
        (self.random.next_u64() % count.max(1) as u64) as usize
    }

    /// Whether a case of this probability in percent occurs.
    pub(crate) fn chance(&mut self, percent: usize) -> bool {
        self.below(100) < percent
    }

    pub(crate) fn bits(&mut self) -> u64 {
        self.random.next_u64()
    }

    /// A number that is usually moderate.
    pub(crate) fn number(&mut self) -> f64 {
        match self.below(40) {
            0 => f64::NAN,
            1 => f64::INFINITY,
            2 => f64::from_bits(self.bits()),
            3 => 1e300,
            4 => 0.0,
            _ => self.random.uniform(-1.0, 1.0),
        }
    }

    /// A number that is usually positive and small.
    pub(crate) fn positive(&mut self) -> f64 {
        if self.chance(90) { self.random.uniform(1e-3, 1e-2) } else { self.number() }
    }

    /// A small number, or rarely a huge one.
    pub(crate) fn count(&mut self, most: usize) -> usize {
        match self.below(60) {
            0 => usize::MAX,
            1 => usize::MAX / 8,
            2 => 1 << 40,
            _ => self.below(most + 1),
        }
    }

    /// The end of a range, 1 or more.
    pub(crate) fn end(&mut self, most: usize) -> usize {
        self.count(most).saturating_add(1)
    }

    pub(crate) fn index(&mut self, count: usize) -> u32 {
        if self.chance(92) { self.below(count) as u32 } else { self.bits() as u32 }
    }

    pub(crate) fn flag(&mut self) -> i32 {
        self.below(2) as i32
    }

    /// A place of this many bytes in the block, of numbers for another array rarely.
    fn place(&mut self, bytes: usize) -> usize {
        let numbers = bytes.div_ceil(8);
        let overlaps = self.chance(2) && self.last + numbers + GUARD < NUMBERS;
        let start = if overlaps { self.last } else { self.next };
        assert!(start + numbers + GUARD < NUMBERS, "the block is too small");
        self.next = self.next.max(start + numbers + GUARD);
        self.last = start;
        start
    }

    /// A length that is rarely another than the right one.
    fn length(&mut self, right: usize) -> usize {
        match self.below(60) {
            0 => self.below(right + 4),
            1 => 0,
            _ => right,
        }
    }

    /// The pointer of an array at a place.
    fn pointer(&mut self, start: usize) -> *mut u8 {
        let pointer = self.block.as_mut_ptr().wrapping_add(start).cast::<u8>();
        match self.below(120) {
            0 => null_mut(),
            1 => pointer.wrapping_add(1),
            2 => {
                // Longer than memory: refused before it is read.
                self.len = usize::MAX - self.below(9);
                pointer
            }
            _ => pointer,
        }
    }

    /// An input of these numbers.
    pub(crate) fn input_of(&mut self, numbers: &[f64]) -> *const f64 {
        let len = self.length(numbers.len());
        let start = self.place(8 * len + 8);
        for k in 0..len {
            let x = numbers.get(k).copied().unwrap_or(0.5);
            (self.block[start + k], self.expected[start + k]) = (x, x);
        }
        self.len = len;
        self.pointer(start).cast()
    }

    /// An input of random numbers.
    pub(crate) fn input(&mut self, len: usize) -> *const f64 {
        let wild = self.chance(10);
        let number = |own: &mut Self| if wild { own.number() } else { own.random.uniform(0.1, 1.0) };
        let numbers: Vec<f64> = (0..len).map(|_| number(self)).collect();
        self.input_of(&numbers)
    }

    /// Rows of a robot's states.
    fn rows(&mut self, rows: usize, of: fn(&RandomState) -> &Vec<f64>) -> *const f64 {
        let mut numbers = Vec::new();
        for _ in 0..rows.min(4) {
            let k = self.below(8);
            numbers.extend_from_slice(of(&self.robots[self.robot].states[k]));
        }
        if self.chance(5) && !numbers.is_empty() {
            let k = self.below(numbers.len());
            numbers[k] = self.number();
        }
        self.input_of(&numbers)
    }

    pub(crate) fn q_rows(&mut self, rows: usize) -> *const f64 {
        self.rows(rows, |state| &state.q)
    }

    pub(crate) fn v_rows(&mut self, rows: usize) -> *const f64 {
        self.rows(rows, |state| &state.v)
    }

    pub(crate) fn q(&mut self) -> *const f64 {
        self.q_rows(1)
    }

    pub(crate) fn v(&mut self) -> *const f64 {
        self.v_rows(1)
    }

    /// A configuration that a call changes in place.
    pub(crate) fn q_in_place(&mut self) -> *mut f64 {
        let pointer = self.q().cast_mut();
        let start = 8 * self.last;
        self.outputs.push((start, start + 8 * self.len.min(self.nq + 4)));
        pointer
    }

    /// A state (q, v).
    pub(crate) fn x(&mut self) -> *const f64 {
        let state = &self.robots[self.robot].states[self.random.next_u64() as usize % 8];
        let x = [&state.q[..], &state.v[..]].concat();
        self.input_of(&x)
    }

    /// The twelve numbers of a pose without rotation.
    pub(crate) fn pose(&mut self) -> *const f64 {
        let mut pose = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.1, 0.2, 0.3];
        if self.chance(10) {
            pose[self.below(12)] = self.number();
        }
        if self.chance(30) { self.input_of(&pose[9..]) } else { self.input_of(&pose) }
    }

    /// Numbers of frames or of reference frames.
    pub(crate) fn frames(&mut self, count: usize, below: usize) -> *const u32 {
        let start = self.place(4 * count + 8);
        for k in 0..count {
            let pair = [self.index(below), self.index(below)].map(u64::from);
            let x = f64::from_bits(pair[0] | pair[1] << 32);
            let at = start + k / 2;
            (self.block[at], self.expected[at]) = (x, x);
        }
        self.len = count;
        self.pointer(start).cast()
    }

    /// An output of values of any type.
    pub(crate) fn out<T>(&mut self, right: usize) -> *mut T {
        let len = self.length(right);
        let bytes = len * size_of::<T>();
        let start = self.place(bytes + 8);
        self.len = len;
        self.outputs.push((8 * start, 8 * start + bytes));
        self.pointer(start).cast()
    }

    /// A single output; it is written only if the pointer is valid.
    pub(crate) fn one<T>(&mut self) -> *mut T {
        let start = self.place(size_of::<T>() + 8);
        self.outputs.push((8 * start, 8 * start + size_of::<T>()));
        self.pointer(start).cast()
    }

    /// An output of this length.
    pub(crate) fn out_of<T>(&mut self, len: usize) -> *mut T {
        let bytes = len.min(NUMBERS / 16) * size_of::<T>();
        let start = self.place(bytes + 8);
        self.outputs.push((8 * start, 8 * start + bytes));
        self.pointer(start).cast()
    }

    /// Four numbers without a length.
    pub(crate) fn matrix(&mut self) -> *const f64 {
        let start = self.place(8 * 4 + 8);
        for k in start..start + 4 {
            let x = self.number();
            (self.block[k], self.expected[k]) = (x, x);
        }
        self.pointer(start).cast_const().cast()
    }

    /// The number of moving links of this call's robot.
    pub(crate) fn moving(&self) -> usize {
        self.robots[self.robot].moving
    }

    /// A structure of options, or null.
    pub(crate) fn options<T: Copy>(&mut self, value: T) -> *const T {
        if self.chance(5) { null() } else { self.always_options(value) }
    }

    /// A structure of options. It is not in the block, because arrays there may overlap.
    pub(crate) fn always_options<T: Copy>(&mut self, value: T) -> *const T {
        let at = self.structures.as_mut_ptr().wrapping_add(self.next_structure).cast::<T>();
        self.next_structure += size_of::<T>().div_ceil(8) + 1;
        assert!(self.next_structure <= self.structures.len(), "there are too many structures");
        // SAFETY: the place has the size of the value, and eight bytes suffice for its alignment.
        unsafe { at.write(value) };
        match self.below(80) {
            0 => null(),
            1 => at.cast::<u8>().wrapping_add(1).cast_const().cast(),
            _ => at.cast_const(),
        }
    }

    /// One of some texts, or null.
    pub(crate) fn text(&mut self, texts: &[&'static CStr]) -> *const c_char {
        if self.chance(3) {
            return null();
        }
        texts[self.below(texts.len())].as_ptr()
    }

    /// Whether the block changed in the outputs only.
    pub(crate) fn outside_is_untouched(&mut self) -> bool {
        // SAFETY: every byte of a number is initialised.
        let (found, expected) =
            unsafe { (self.block.align_to::<u8>().1, self.expected.align_to_mut::<u8>().1) };
        for (start, end) in self.outputs.drain(..) {
            expected[start..end].copy_from_slice(&found[start..end]);
        }
        found == &*expected
    }
}
