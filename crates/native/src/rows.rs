//! Transposition between rows of states in memory and values with one state in each lane.
//!
//! A table stores the numbers of one state side by side, as a row. As many rows as a register has lanes are
//! read by tiles: a register's width of each row, transposed into columns. The last tile may overlap the one
//! before. Where a row is shorter than a register, numbers read behind it are ignored. Numbers written behind
//! it are overwritten by the following row, because rows are written in order. Hence a table must extend
//! behind its last row by [`padding`].

use std::collections::HashSet;

use crate::list::{Address, Base, Binary, List, LoadExtent, Operation, Value};
use crate::target::Target;

/// Numbers behind the last row of a table that a kernel accesses.
pub(crate) fn padding(width: usize, lanes: usize) -> usize {
    if width <= 1 { 0 } else { lanes.saturating_sub(width) }
}

/// Rows of results longer than this are written from first to last number at the end of the program. The
/// hardware then prefetches the memory.
const LONG_ROW: usize = 64;

/// The division of rows into registers.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows {
    lanes: usize,
    size: i32,
}

impl Rows {
    pub(crate) fn new(target: Target) -> Self {
        Self { lanes: target.lanes(), size: target.size() }
    }

    /// The address of the part of a row that begins at a column and fills a register.
    fn address(self, table: usize, width: usize, lane: usize, column: usize) -> Address {
        let table = u8::try_from(table).expect("the number of tables was checked");
        let number = i32::try_from(lane * width + column).expect("lengths were checked");
        Address::new(Base::Table(table), number * self.size, LoadExtent::Register)
    }

    /// The first columns of the tiles that cover a row.
    fn groups(self, width: usize) -> impl Iterator<Item = usize> {
        let last = width.saturating_sub(self.lanes);
        (0..width).step_by(self.lanes).map(move |column| column.min(last))
    }

    /// Transposes rows to columns, or columns to rows. Missing ones are not needed.
    fn transpose(self, list: &mut List, rows: &[Option<Value>]) -> Vec<Option<Value>> {
        if let Some(constant) = constant_of_all(list, rows) {
            return vec![Some(constant); rows.len()];
        }
        let in_block = usize::try_from(16 / self.size).expect("2 or 4");
        // By group of rows and column of a block: that column of all blocks.
        let within: Vec<Vec<Option<Value>>> =
            rows.chunks(in_block).map(|group| transpose_blocks(list, group)).collect();
        let mut columns = vec![None; rows.len()];
        for column in 0..in_block {
            let group: Vec<Option<Value>> = within.iter().map(|of_group| of_group[column]).collect();
            let blocks = match group[..] {
                [a, b] => two_blocks(list, a, b),
                [a, b, c, d] => four_blocks(list, [a, b, c, d]),
                _ => unreachable!("registers have two or four blocks of 128 bits"),
            };
            for (block, value) in blocks.into_iter().enumerate() {
                columns[in_block * block + column] = value;
            }
        }
        columns
    }
}

/// The constant that all rows are equal to, the same in each lane.
fn constant_of_all(list: &List, rows: &[Option<Value>]) -> Option<Value> {
    let mut values = rows.iter().flatten().copied();
    let first = values.next()?;
    let is_constant = list.homes[first as usize].is_some_and(|address| address.base == Base::Constants);
    (is_constant && values.all(|value| value == first)).then_some(first)
}

/// An operation of two values, of which one or both may be missing.
fn combine(list: &mut List, kind: Binary, a: Option<Value>, b: Option<Value>) -> Option<Value> {
    let (a, b) = (a.or(b)?, b.or(a)?);
    Some(list.binary(kind, a, b))
}

/// Transposes each block of 128 bits: two rows of doubles, or four rows of singles.
fn transpose_blocks(list: &mut List, rows: &[Option<Value>]) -> Vec<Option<Value>> {
    let mut pair = |bytes, a, b| {
        [
            combine(list, Binary::InterleaveLow(bytes), a, b),
            combine(list, Binary::InterleaveHigh(bytes), a, b),
        ]
    };
    match *rows {
        [a, b] => pair(8, a, b).to_vec(),
        [a, b, c, d] => {
            let ([low_ab, high_ab], [low_cd, high_cd]) = (pair(4, a, b), pair(4, c, d));
            [pair(8, low_ab, low_cd), pair(8, high_ab, high_cd)].concat()
        }
        _ => unreachable!("blocks of 128 bits have two doubles or four singles"),
    }
}

/// Transposes two registers of two blocks.
fn two_blocks(list: &mut List, a: Option<Value>, b: Option<Value>) -> Vec<Option<Value>> {
    [Binary::EvenBlocks, Binary::OddBlocks].map(|kind| combine(list, kind, a, b)).to_vec()
}

/// Transposes four registers of four blocks.
fn four_blocks(list: &mut List, [a, b, c, d]: [Option<Value>; 4]) -> Vec<Option<Value>> {
    let mut pair = |a, b| [combine(list, Binary::EvenBlocks, a, b), combine(list, Binary::OddBlocks, a, b)];
    let ([even_ab, odd_ab], [even_cd, odd_cd]) = (pair(a, b), pair(c, d));
    let ([first, third], [second, fourth]) = (pair(even_ab, even_cd), pair(odd_ab, odd_cd));
    vec![first, second, third, fourth]
}

/// Columns of arguments, read at their first use.
pub(crate) struct Inputs {
    rows: Rows,
    /// By argument and number.
    columns: Vec<Vec<Option<Value>>>,
}

impl Inputs {
    pub(crate) fn new(rows: Rows, lengths: &[usize]) -> Self {
        Self { rows, columns: lengths.iter().map(|&length| vec![None; length]).collect() }
    }

    /// A number of an argument.
    pub(crate) fn column(&mut self, list: &mut List, argument: usize, index: usize) -> Value {
        if let Some(value) = self.columns[argument][index] {
            return value;
        }
        let Rows { lanes, .. } = self.rows;
        let width = self.columns[argument].len();
        if width == 1 {
            let value = list.value(Some(self.rows.address(argument, width, 0, 0)));
            self.columns[argument][index] = Some(value);
            return value;
        }
        let begin = (index - index % lanes).min(width.saturating_sub(lanes));
        let row = |lane| Some(list.value(Some(self.rows.address(argument, width, lane, begin))));
        let rows: Vec<Option<Value>> = (0..lanes).map(row).collect();
        let columns = self.rows.transpose(list, &rows);
        for (number, value) in (begin..width).zip(columns) {
            // The last columns may have been read before.
            let column = &mut self.columns[argument][number];
            *column = column.or(value);
        }
        self.columns[argument][index].expect("the column is among those just read")
    }
}

/// Columns of results, written when a tile of them is complete.
pub(crate) struct Outputs {
    rows: Rows,
    /// The table of the first result.
    first_table: usize,
    /// By result and number.
    columns: Vec<Vec<Option<Value>>>,
    /// By result: the first column of each tile, and the number of its missing columns.
    missing: Vec<Vec<(usize, usize)>>,
}

impl Outputs {
    pub(crate) fn new(rows: Rows, first_table: usize, lengths: impl Iterator<Item = usize> + Clone) -> Self {
        let columns = lengths.clone().map(|length| vec![None; length]).collect();
        let missing =
            lengths.map(|length| rows.groups(length).map(|begin| (begin, rows.lanes.min(length))).collect());
        Self { rows, first_table, columns, missing: missing.collect() }
    }

    /// Records a number of a result.
    pub(crate) fn finish(&mut self, list: &mut List, result: usize, index: usize, value: Value) {
        self.columns[result][index] = Some(value);
        if self.columns[result].len() <= LONG_ROW {
            self.write_finished(list, result, index);
        }
    }

    /// Writes the results with long rows, at the end of the program.
    pub(crate) fn end(&mut self, list: &mut List) {
        for result in 0..self.columns.len() {
            let width = self.columns[result].len();
            if width > LONG_ROW {
                self.rows.groups(width).for_each(|begin| self.write(list, result, begin));
            }
        }
    }

    /// Writes the tiles that a column completes: its own, or the last one, which may begin earlier.
    fn write_finished(&mut self, list: &mut List, result: usize, index: usize) {
        let lanes = self.rows.lanes;
        let last = self.missing[result].len() - 1;
        let own = (index / lanes).min(last);
        for group in [Some(own), (own != last).then_some(last)].into_iter().flatten() {
            let (begin, missing) = &mut self.missing[result][group];
            if (*begin..*begin + lanes).contains(&index) {
                *missing -= 1;
                if *missing == 0 {
                    let begin = *begin;
                    self.write(list, result, begin);
                }
            }
        }
    }

    /// Writes a tile of columns to all rows.
    fn write(&self, list: &mut List, result: usize, begin: usize) {
        let (columns, lanes) = (&self.columns[result], self.rows.lanes);
        let (width, table) = (columns.len(), self.first_table + result);
        if width == 1 {
            let value = columns[0].expect("the column is finished");
            return list.store(value, self.rows.address(table, width, 0, 0));
        }
        let taken = (begin..begin + lanes).map(|column| columns.get(column).copied().flatten());
        let taken: Vec<Option<Value>> = taken.collect();
        let rows = self.rows.transpose(list, &taken);
        for (lane, row) in rows.into_iter().enumerate() {
            let row = row.expect("a row has at least one column");
            list.store(row, self.rows.address(table, width, lane, begin));
        }
    }
}

/// Sums of the results times zero: zero where all results of a state are finite, else NaN.
pub(crate) struct Finiteness {
    zero: Value,
    /// Two sums used alternately, because each addition waits for the one before.
    sums: [Value; 2],
    taken: HashSet<Value>,
}

impl Finiteness {
    pub(crate) fn new(zero: Value) -> Self {
        Self { zero, sums: [zero; 2], taken: HashSet::new() }
    }

    /// Adds a result, each value once; constants are checked at compile time.
    pub(crate) fn take(&mut self, list: &mut List, value: Value) {
        let is_constant = list.homes[value as usize].is_some_and(|address| address.base == Base::Constants);
        if !is_constant && self.taken.insert(value) {
            let [next, other] = self.sums;
            let sum = Operation::Fused { a: value, b: self.zero, c: next, is_minus: false };
            self.sums = [other, list.push(sum)];
        }
    }

    pub(crate) fn sum(&self, list: &mut List) -> Value {
        list.binary(Binary::Add, self.sums[0], self.sums[1])
    }
}
