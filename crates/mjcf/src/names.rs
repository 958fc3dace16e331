//! Names for what the file leaves without one, each used once.

use std::collections::HashSet;

/// Names that are taken.
#[derive(Default)]
pub(crate) struct Names {
    taken: HashSet<String>,
}

impl Names {
    /// Takes this name; `false` if it is taken already.
    pub(crate) fn take(&mut self, name: &str) -> bool {
        self.taken.insert(name.to_owned())
    }

    /// This name, or, where it is taken, the first free one of `name_2`, `name_3` and so on.
    pub(crate) fn free(&mut self, name: &str) -> String {
        if self.take(name) {
            return name.to_owned();
        }
        let numbered = (2..).map(|number| format!("{name}_{number}"));
        numbered.into_iter().find(|name| self.take(name)).unwrap_or_default()
    }
}
