//! The limits that all steps of reading one robot share.

/// The largest number of elements in one robot, with all files and copies: 10⁵ bodies with ten elements each.
pub const ELEMENT_LIMIT: usize = 1_000_000;

/// The largest number of characters \[bytes\] in all files of one robot, and in the names and attributes of
/// copied elements.
pub const CHARACTER_LIMIT: usize = 1 << 27;

/// The largest number of numbers in the height fields, meshes and poses of one robot.
pub const NUMBER_LIMIT: usize = 50_000_000;

/// The largest number of references that attachments and replicates look up.
const STEP_LIMIT: usize = 20_000_000;

/// A quantity with a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resource {
    /// Elements of all files, and of all copies.
    Elements,
    /// Characters of all files, and of the names and attributes of copies.
    Characters,
    /// Numbers in height fields, meshes and poses.
    Numbers,
    /// References that are looked up for copies.
    Steps,
}

/// The quantities that reading one robot has used. All steps of reading charge the same budget, so that
/// memory and time stay bounded however the steps are combined.
///
/// ```
/// use robot_dynamics_xml::{Budget, ELEMENT_LIMIT, Resource};
/// let mut budget = Budget::default();
/// assert!(budget.charge(Resource::Elements, ELEMENT_LIMIT).is_ok());
/// let exceeded = budget.charge(Resource::Elements, 1).unwrap_err();
/// assert_eq!(exceeded.limit, ELEMENT_LIMIT);
/// assert!(budget.is_exceeded());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Budget {
    used: [usize; 4],
    is_exceeded: bool,
}

/// A limit that was exceeded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(alias = "Exceeded")]
pub struct ExceededLimit {
    /// The name of the quantity, in plural.
    pub what: &'static str,
    /// Its limit.
    pub limit: usize,
}

impl Resource {
    /// The name and the limit of the quantity.
    pub fn limit(self) -> ExceededLimit {
        let (what, limit) = match self {
            Self::Elements => ("elements in all files and copies", ELEMENT_LIMIT),
            Self::Characters => ("characters in all files and in the names of copies", CHARACTER_LIMIT),
            Self::Numbers => ("numbers in height fields, meshes and poses", NUMBER_LIMIT),
            Self::Steps => ("references in copies", STEP_LIMIT),
        };
        ExceededLimit { what, limit }
    }
}

impl Budget {
    /// Adds to the use of a quantity.
    ///
    /// # Errors
    /// [`ExceededLimit`] if the use is then above the limit.
    pub fn charge(&mut self, resource: Resource, count: usize) -> Result<(), ExceededLimit> {
        let used = &mut self.used[resource as usize];
        *used = used.saturating_add(count);
        let limit = resource.limit();
        if *used <= limit.limit {
            return Ok(());
        }
        self.is_exceeded = true;
        Err(limit)
    }

    /// Whether a limit was exceeded.
    pub fn is_exceeded(&self) -> bool {
        self.is_exceeded
    }
}
