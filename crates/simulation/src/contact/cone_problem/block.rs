//! The rows of one contact or of one equality.

use core::ops::Range;

use super::set::Set;

#[derive(Clone, Debug)]
pub(super) struct Block {
    pub(super) set: Set,
    pub(super) rows: Range<usize>,
    /// The range of the block's coordinates in `support`.
    pub(super) support: Range<usize>,
    /// The index of its first entry of A.
    pub(super) entries: usize,
    /// R: velocity per impulse.
    pub(super) softness: f64,
    /// The shift s of Coulomb's law.
    pub(super) shift: f64,
    /// Whether the part that contains this block has to be solved.
    pub(super) is_due: bool,
}
