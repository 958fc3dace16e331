//! Indices that are affine functions of a loop's iteration.

use core::fmt;

/// An index that is an affine function of the iteration: first + step · k.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct AffineIndex {
    pub(crate) first: usize,
    pub(crate) step: isize,
}

impl AffineIndex {
    /// A constant index.
    pub(crate) fn at(first: usize) -> Self {
        Self { first, step: 0 }
    }

    /// The affine index through these values, if there is one.
    pub(crate) fn through(mut indices: impl Iterator<Item = usize>) -> Option<Self> {
        let first = indices.next()?;
        let mut before = first;
        let mut step = None;
        for index in indices {
            let here = difference(index, before);
            if *step.get_or_insert(here) != here {
                return None;
            }
            before = index;
        }
        Some(Self { first, step: step.unwrap_or(0) })
    }

    /// The index in an iteration, counted from zero.
    #[cfg(test)]
    pub(crate) fn at_iteration(self, iteration: usize) -> usize {
        self.first.checked_add_signed(self.step * iteration.cast_signed()).expect("an index is not negative")
    }
}

/// a − b.
pub(crate) fn difference(a: usize, b: usize) -> isize {
    a.cast_signed() - b.cast_signed()
}

/// The index in iteration `k`, as an expression.
impl fmt::Display for AffineIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { first, step } = *self;
        match (first, step) {
            (_, 0) => write!(f, "{first}"),
            (0, 1) => f.write_str("k"),
            (0, _) => write!(f, "{step} * k"),
            (_, 1) => write!(f, "{first} + k"),
            (_, -1) => write!(f, "{first} - k"),
            _ if step < 0 => write!(f, "{first} - {} * k", step.unsigned_abs()),
            _ => write!(f, "{first} + {step} * k"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::AffineIndex;

    #[test]
    fn indices_are_written_in_their_shortest_form() {
        let through = |indices: &[usize]| AffineIndex::through(indices.iter().copied());
        for (indices, text) in [
            (&[7, 7, 7][..], "7"),
            (&[0, 1, 2], "k"),
            (&[0, 3, 6], "3 * k"),
            (&[4, 5, 6], "4 + k"),
            (&[4, 3, 2], "4 - k"),
            (&[9, 11, 13], "9 + 2 * k"),
            (&[9, 7, 5], "9 - 2 * k"),
        ] {
            let index = through(indices).unwrap();
            assert_eq!(index.to_string(), text);
            assert!((0..3).all(|iteration| index.at_iteration(iteration) == indices[iteration]), "{text}");
        }
        assert_eq!(through(&[1, 2, 4]), None);
    }
}
