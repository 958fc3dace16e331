//! Names for what the file leaves without one, each used once.

use std::collections::{HashMap, HashSet};

/// Names that are taken.
#[derive(Default)]
pub(crate) struct Names {
    taken: HashSet<String>,
    /// The number behind each name that is tried next, so that many of one name take no quadratic work.
    next: HashMap<String, usize>,
}

impl Names {
    /// Takes this name; `false` if it is taken already.
    pub(crate) fn take(&mut self, name: &str) -> bool {
        self.taken.insert(name.to_owned())
    }

    /// Whether it is taken.
    pub(crate) fn has(&self, name: &str) -> bool {
        self.taken.contains(name)
    }

    /// This name, or, where it is taken, the first free one of `name_2`, `name_3` and so on.
    pub(crate) fn free(&mut self, name: &str) -> String {
        if self.take(name) {
            return name.to_owned();
        }
        let mut number = self.next.get(name).copied().unwrap_or(2);
        loop {
            let numbered = format!("{name}_{number}");
            number += 1;
            if self.take(&numbered) {
                self.next.insert(name.to_owned(), number);
                return numbered;
            }
        }
    }
}
