//! Checks the table of paths of a binary file.
//!
//! The table is a tree in the order of its entries, each with a jump j. The child of an entry is the next
//! one if j > 0 or j = −1. Its sibling is the next one if j = 0, and j entries on if j > 0. In a valid table
//! each entry has one place in the tree. If a child and a sibling coincide, the number of paths doubles with
//! each entry.

use robot_dynamics_xml::CHARACTER_LIMIT;

use crate::paths::{check_element, check_property_name};

/// The tokens of a file, which end with a zero byte each.
#[derive(Debug, Default)]
pub(crate) struct Tokens {
    content: Vec<u8>,
    /// The place after each token.
    ends: Vec<usize>,
}

impl Tokens {
    pub(crate) fn new(content: Vec<u8>) -> Self {
        let ends = content.iter().enumerate().filter(|(_, byte)| **byte == 0).map(|(at, _)| at).collect();
        Self { content, ends }
    }

    pub(crate) fn get(&self, number: usize) -> Result<&[u8], String> {
        let end = self.ends.get(number).ok_or_else(|| format!("it has no token {number}"))?;
        let start = number.checked_sub(1).map_or(0, |before| self.ends[before] + 1);
        Ok(&self.content[start..*end])
    }
}

/// The entries of the table, with the number of paths.
pub(crate) struct PathTable {
    pub(crate) count: usize,
    /// The number of the path of each entry.
    pub(crate) paths: Vec<i32>,
    /// The token of each entry; −1 times that of a property.
    pub(crate) elements: Vec<i32>,
    pub(crate) jumps: Vec<i32>,
}

impl PathTable {
    /// Refuses a table whose entries have no or several places, and paths that are invalid or too long.
    pub(crate) fn check(&self, tokens: &Tokens) -> Result<(), String> {
        let mut has_place = vec![false; self.jumps.len()];
        let mut characters = 0_usize;
        let mut pending = if self.jumps.is_empty() { Vec::new() } else { vec![(0, None)] };
        while let Some((mut entry, mut parent)) = pending.pop() {
            loop {
                let length = self.length(entry, parent, tokens)?;
                if core::mem::replace(&mut has_place[entry], true) {
                    return Err(format!("entry {entry} of its paths has two places"));
                }
                characters = characters.saturating_add(length);
                if characters > CHARACTER_LIMIT {
                    return Err(format!("its paths have more than {CHARACTER_LIMIT} characters"));
                }
                let jump = self.jumps[entry];
                let (has_child, has_sibling) = (jump > 0 || jump == -1, jump >= 0);
                if has_child {
                    if has_sibling {
                        let sibling = entry.saturating_add(usize::try_from(jump).unwrap_or_default());
                        pending.push((sibling, parent));
                    }
                    parent = Some(length);
                }
                if !has_child && !has_sibling {
                    break;
                }
                entry += 1;
            }
        }
        Ok(())
    }

    /// The length of the path of an entry; that of its parent is missing for the root.
    fn length(&self, entry: usize, parent: Option<usize>, tokens: &Tokens) -> Result<usize, String> {
        let Some(&path) = self.paths.get(entry) else {
            return Err(format!("its paths end before entry {entry}"));
        };
        if usize::try_from(path).map_or(true, |path| path >= self.count) {
            return Err(format!("it has {} paths, and none with the number {path}", self.count));
        }
        let Some(parent) = parent else { return Ok(1) };
        let element = self.elements[entry];
        let token = tokens.get(usize::try_from(element.unsigned_abs()).unwrap_or(usize::MAX))?;
        if element < 0 {
            check_property_name(token)?;
        } else {
            check_element(token)?;
        }
        Ok(parent + 1 + token.len())
    }
}

/// Decodes integers that are stored as differences: the usual difference, two bits for each integer that
/// tell its form, and the differences of one, two or four bytes. `None` if bytes are missing.
pub(crate) fn integers(data: &[u8], count: usize) -> Option<Vec<i32>> {
    if count == 0 {
        return Some(Vec::new());
    }
    let (usual, rest) = data.split_at_checked(4)?;
    let usual = i32::from_le_bytes(usual.try_into().ok()?);
    let (forms, mut rest) = rest.split_at_checked(count.div_ceil(4))?;
    let mut value = 0_i32;
    let mut values = Vec::with_capacity(count);
    for number in 0..count {
        let form = forms[number / 4] >> (2 * (number % 4)) & 3;
        let mut bytes = |length: usize| {
            let (bytes, others) = rest.split_at_checked(length)?;
            rest = others;
            Some(bytes)
        };
        let difference = match form {
            0 => usual,
            1 => i32::from(i8::from_le_bytes(bytes(1)?.try_into().ok()?)),
            2 => i32::from(i16::from_le_bytes(bytes(2)?.try_into().ok()?)),
            _ => i32::from_le_bytes(bytes(4)?.try_into().ok()?),
        };
        value = value.wrapping_add(difference);
        values.push(value);
    }
    Some(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(elements: &[i32], jumps: &[i32]) -> Result<(), String> {
        let tokens = Tokens::new(b"\0a\0x}\0b.c\0{v=x}\0".to_vec());
        let paths = (0..).take(jumps.len()).collect();
        let table =
            PathTable { count: jumps.len(), paths, elements: elements.to_vec(), jumps: jumps.to_vec() };
        table.check(&tokens)
    }

    #[test]
    fn each_entry_has_one_place() {
        // The root with a, which has a property a and a variant.
        check(&[0, 1, -1, 4], &[-1, -1, 0, -2]).unwrap();
        // Two siblings, the first with a child.
        check(&[0, 1, 1, 1], &[-1, 2, -2, -2]).unwrap();
        // Child and sibling coincide: 2⁴⁰ paths.
        let mut jumps = vec![1; 40];
        jumps.push(-2);
        assert!(check(&[1; 41], &jumps).is_err());
        assert!(check(&[0, 1], &[-1, 5]).is_err());
        assert!(check(&[0, 1], &[-1, -1]).is_err());
        assert!(check(&[0, 1], &[-1, i32::MAX]).is_err());
    }

    #[test]
    fn invalid_elements_are_refused() {
        for element in [0, 2, 3, -2, 5, i32::MIN] {
            assert!(check(&[0, element], &[-1, -2]).is_err(), "{element}");
        }
    }

    #[test]
    fn integers_are_sums_of_differences() {
        // The usual difference 1, then −1 in one byte, 300 in two, and 70,000 in four.
        let data = [1, 0, 0, 0, 0b11_10_01_00, 0, 0xff, 0x2c, 0x01, 0x70, 0x11, 0x01, 0x00];
        assert_eq!(integers(&data, 5), Some(vec![1, 0, 300, 70_300, 70_301]));
        assert_eq!(integers(&data[..10], 5), None);
    }
}
