//! Unique names for elements without a name.

use std::collections::{HashMap, HashSet};

/// The names in use.
#[derive(Default)]
pub(crate) struct Names {
    used: HashSet<String>,
    /// The next number to try for each name, which avoids quadratic work for many equal names.
    next: HashMap<String, usize>,
}

impl Names {
    /// Reserves a name; `false` if it is in use.
    pub(crate) fn reserve(&mut self, name: &str) -> bool {
        self.used.insert(name.to_owned())
    }

    /// Whether a name is in use.
    pub(crate) fn contains(&self, name: &str) -> bool {
        self.used.contains(name)
    }

    /// Reserves this name, or, if it is in use, the first unused one of `name_2`, `name_3` and so on.
    pub(crate) fn unique(&mut self, name: &str) -> String {
        if self.reserve(name) {
            return name.to_owned();
        }
        let mut number = self.next.get(name).copied().unwrap_or(2);
        loop {
            let numbered = format!("{name}_{number}");
            number += 1;
            if self.reserve(&numbered) {
                self.next.insert(name.to_owned(), number);
                return numbered;
            }
        }
    }
}
