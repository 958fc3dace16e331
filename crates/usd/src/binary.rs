//! Checks the counts in a binary file before it is parsed. The parser allocates as many numbers as a file
//! states, and an allocation that fails would end the program.

use robot_dynamics_xml::{ELEMENT_LIMIT, NUMBER_LIMIT};

use crate::path_table::{PathTable, Tokens, integers};
use crate::paths::check_listed_name;

/// The largest number of entries of a table: each prim has a few properties.
const TABLE_LIMIT: u64 = 4 * ELEMENT_LIMIT as u64;

/// The deepest nesting of dictionaries and samples.
const DEPTH_LIMIT: usize = 64;

/// The largest number of nested values.
const STEP_LIMIT: usize = ELEMENT_LIMIT;

/// The number of bytes of an element of an array, by the number of the type.
const SIZES: [u64; 31] = [
    0, 1, 1, 4, 4, 8, 8, 2, 4, 8, 4, 4, 4, 32, 72, 128, 32, 16, 8, 16, 8, 4, 8, 24, 12, 6, 12, 32, 16, 8, 16,
];

const ARRAY: u64 = 1 << 63;
const INLINED: u64 = 1 << 62;
const COMPRESSED: u64 = 1 << 61;

/// A file, and the number of values that were checked.
struct Check<'c> {
    content: &'c [u8],
    version: [u8; 3],
    steps: usize,
    tokens: Tokens,
}

/// Checks all tables and values.
pub(crate) fn check(content: &[u8]) -> Result<(), String> {
    let version =
        content.get(8..11).and_then(|bytes| bytes.try_into().ok()).ok_or("the file ends too early")?;
    let mut check = Check { content, version, steps: 0, tokens: Tokens::default() };
    let contents = check.long(16)?;
    let count = check.count(contents, 32, 64)?;
    let mut tables = Vec::new();
    for number in 0..count {
        let entry = contents.saturating_add(8 + 32 * number);
        let name = check.bytes(entry, 16)?;
        let start = check.long(entry.saturating_add(16))?;
        tables.push((name.split(|&byte| byte == 0).next().unwrap_or_default(), start));
    }
    // openusd reads the first table of each name.
    let first = |name: &[u8]| tables.iter().find(|(own, _)| *own == name).map(|(_, start)| *start);
    if let Some(start) = first(b"TOKENS") {
        check.tokens(start)?;
    }
    if let Some(start) = first(b"PATHS") {
        check.paths(start)?;
    }
    tables.into_iter().try_for_each(|(name, start)| check.table(name, start))
}

impl<'c> Check<'c> {
    fn bytes(&self, at: u64, length: u64) -> Result<&'c [u8], String> {
        let start = usize::try_from(at).ok();
        let end = at.checked_add(length).and_then(|end| usize::try_from(end).ok());
        let found = start.zip(end).and_then(|(start, end)| self.content.get(start..end));
        found.ok_or_else(|| format!("byte {at} and the next {length} are not in the file"))
    }

    fn long(&self, at: u64) -> Result<u64, String> {
        let bytes = self.bytes(at, 8)?.try_into();
        bytes.map(u64::from_le_bytes).map_err(|_| "the file ends too early".to_owned())
    }

    fn short(&self, at: u64) -> Result<u64, String> {
        let bytes = self.bytes(at, 4)?.try_into();
        bytes
            .map(|bytes| u64::from(u32::from_le_bytes(bytes)))
            .map_err(|_| "the file ends too early".to_owned())
    }

    /// A count of entries of this many bytes, which follow it.
    fn count(&self, at: u64, size: u64, limit: u64) -> Result<u64, String> {
        let count = self.long(at)?;
        self.fits(at.saturating_add(8), count, size, limit)?;
        Ok(count)
    }

    fn fits(&self, at: u64, count: u64, size: u64, limit: u64) -> Result<(), String> {
        let rest = (self.content.len() as u64).saturating_sub(at);
        let fits = count <= limit && count.saturating_mul(size) <= rest;
        fits.then_some(()).ok_or_else(|| format!("byte {at}: {count} entries do not fit in the file"))
    }

    /// The place after a compressed block.
    fn block(&self, at: u64) -> Result<u64, String> {
        let size = self.count(at, 1, u64::MAX)?;
        Ok(at + 8 + size)
    }

    /// The content of a compressed block of this size, and the place after it.
    fn unpacked(&self, at: u64, size: u64, what: &str) -> Result<(Vec<u8>, u64), String> {
        let end = self.block(at)?;
        let damaged = || format!("{what} are damaged");
        let [0, compressed @ ..] = self.bytes(at + 8, end - at - 8)? else { return Err(damaged()) };
        let mut unpacked = vec![0; usize::try_from(size).map_err(|_| damaged())?];
        let length = lz4_flex::decompress_into(compressed, &mut unpacked).map_err(|_| damaged())?;
        unpacked.truncate(length);
        Ok((unpacked, end))
    }

    /// A count of entries in compressed blocks.
    fn limited(&self, at: u64, limit: u64) -> Result<u64, String> {
        let count = self.long(at)?;
        if count > limit {
            Err(format!("byte {at}: {count} entries are more than {limit}"))
        } else {
            Ok(count)
        }
    }

    fn tokens(&mut self, start: u64) -> Result<(), String> {
        let size = self.limited(start.saturating_add(8), 1 << 27)?;
        self.limited(start, size.min(TABLE_LIMIT))?;
        self.tokens = Tokens::new(self.unpacked(start + 16, size, "the tokens")?.0);
        Ok(())
    }

    fn paths(&self, start: u64) -> Result<(), String> {
        let what = "the paths";
        let damaged = || format!("{what} are damaged");
        let count = self.limited(start, TABLE_LIMIT)?;
        let entries = self.limited(start.saturating_add(8), TABLE_LIMIT)?;
        let mut at = start + 16;
        let mut columns = [const { Vec::new() }; 3];
        for column in &mut columns {
            let size = 4 + entries.div_ceil(4) + 4 * entries;
            let (unpacked, end) = self.unpacked(at, size, what)?;
            let entries = usize::try_from(entries).map_err(|_| damaged())?;
            *column = integers(&unpacked, entries).ok_or_else(damaged)?;
            at = end;
        }
        let [paths, elements, jumps] = columns;
        let count = usize::try_from(count).map_err(|_| damaged())?;
        PathTable { count, paths, elements, jumps }.check(&self.tokens)
    }

    /// A list of the names of prims, properties or variants.
    fn names(&self, at: u64) -> Result<(), String> {
        let count = self.count(at, 4, TABLE_LIMIT)?;
        for number in 0..count {
            let token = usize::try_from(self.short(at + 8 + 4 * number)?).unwrap_or(usize::MAX);
            check_listed_name(self.tokens.get(token)?)?;
        }
        Ok(())
    }

    fn table(&mut self, name: &[u8], start: u64) -> Result<(), String> {
        match name {
            b"STRINGS" => {
                self.count(start, 4, TABLE_LIMIT)?;
            }
            b"FIELDSETS" => {
                self.limited(start, TABLE_LIMIT)?;
                self.block(start + 8)?;
            }
            b"SPECS" => {
                self.limited(start, TABLE_LIMIT)?;
                (0..3).try_fold(start + 8, |at, _| self.block(at))?;
            }
            b"FIELDS" => self.fields(start)?,
            _ => {}
        }
        Ok(())
    }

    /// The values of all fields.
    fn fields(&mut self, start: u64) -> Result<(), String> {
        let count = self.limited(start, TABLE_LIMIT)?;
        let values = self.block(start + 8)?;
        let (unpacked, _) = self.unpacked(values, 8 * count, "the values of fields")?;
        for value in unpacked.chunks_exact(8) {
            let value = value.try_into().map_or(0, u64::from_le_bytes);
            self.value(value, 0)?;
        }
        Ok(())
    }

    /// One value, which may be anywhere in the file.
    fn value(&mut self, value: u64, depth: usize) -> Result<(), String> {
        self.steps += 1;
        if self.steps > STEP_LIMIT || depth > DEPTH_LIMIT {
            return Err(format!("more than {STEP_LIMIT} values, or nested deeper than {DEPTH_LIMIT}"));
        }
        let (kind, at) = (value >> 48 & 0xff, value & ((1 << 48) - 1));
        let is_array = value & ARRAY != 0;
        match kind {
            48 | 56 => self.array(value, at, 9),
            10 | 12 | 57 if is_array => self.count(at, 4, TABLE_LIMIT).map(drop),
            0..=30 if is_array => self.array(value, at, kind),
            55 => self.list_edits(kind, at, depth),
            _ if value & INLINED != 0 => Ok(()),
            31 => self.dictionary(at, depth).map(drop),
            32..=39 | 54 => self.list_edits(kind, at, depth),
            41 => self.names(at),
            40 | 50 => self.count(at, 4, TABLE_LIMIT).map(drop),
            45 | 58 => self.count(at, 8, TABLE_LIMIT).map(drop),
            46 => self.samples(at, depth),
            49 => self.count(at, 16, TABLE_LIMIT).map(drop),
            _ => Ok(()),
        }
    }

    fn array(&self, value: u64, at: u64, kind: u64) -> Result<(), String> {
        if at == 0 || (kind == 9 && value & (ARRAY | INLINED) == INLINED) {
            return Ok(());
        }
        let size = usize::try_from(kind).ok().and_then(|kind| SIZES.get(kind)).copied().unwrap_or(8);
        let at = if self.version < [0, 5, 0] { at + 4 } else { at };
        let is_long = self.version >= [0, 7, 0];
        let count = if is_long { self.long(at)? } else { self.short(at)? };
        let data = at + if is_long { 8 } else { 4 };
        let is_compressed = value & COMPRESSED != 0 && (3..=9).contains(&kind);
        if !is_compressed || count < 4 {
            return self.fits(data, count, size, NUMBER_LIMIT as u64);
        }
        if count > NUMBER_LIMIT as u64 {
            return Err(format!("byte {at}: more than {NUMBER_LIMIT} numbers"));
        }
        if !(7..=9).contains(&kind) {
            return self.block(data).map(drop);
        }
        match self.bytes(data, 1)? {
            b"t" => {
                let entries = self.short(data + 1)?;
                self.fits(data + 5, entries, size, NUMBER_LIMIT as u64)?;
                self.block(data + 5 + entries * size).map(drop)
            }
            _ => self.block(data + 1).map(drop),
        }
    }

    /// A dictionary. Returns the place after it.
    fn dictionary(&mut self, at: u64, depth: usize) -> Result<u64, String> {
        let count = self.count(at, 12, TABLE_LIMIT)?;
        let mut at = at + 8;
        for _ in 0..count {
            let place = self.jump(at.saturating_add(4))?;
            let value = self.long(place)?;
            self.value(value, depth + 1)?;
            at = place + 8;
        }
        Ok(at)
    }

    /// The place to which the relative offset here leads.
    fn jump(&self, at: u64) -> Result<u64, String> {
        let offset = i64::from_le_bytes(self.long(at)?.to_le_bytes());
        at.checked_add_signed(offset).ok_or_else(|| format!("byte {at}: a jump out of the file"))
    }

    fn list_edits(&mut self, kind: u64, at: u64, depth: usize) -> Result<(), String> {
        let header = self.bytes(at, 1)?[0];
        let mut at = at + 1;
        for bit in [1, 2, 5, 6, 3, 4] {
            if header & (1 << bit) == 0 {
                continue;
            }
            let size = match kind {
                35 => 32,
                55 if self.version >= [0, 8, 0] => 24,
                37 | 39 | 55 => 8,
                _ => 4,
            };
            let count = self.count(at, size, TABLE_LIMIT)?;
            at += 8;
            if kind == 35 {
                for _ in 0..count {
                    at = self.dictionary(at.saturating_add(24), depth + 1)?;
                    self.steps += 1;
                }
            } else {
                at += count * size;
            }
        }
        Ok(())
    }

    fn samples(&mut self, at: u64, depth: usize) -> Result<(), String> {
        let times = self.jump(at)?;
        self.value(self.long(times)?, depth + 1)?;
        let values = self.jump(times.saturating_add(8))?;
        let count = self.count(values, 8, TABLE_LIMIT)?;
        for number in 0..count {
            self.value(self.long(values + 8 + 8 * number)?, depth + 1)?;
        }
        Ok(())
    }
}
