//! The structure of a crate: files, modules, items, imports and uses.

use std::collections::HashMap;

/// A file of a crate with its code.
pub(crate) struct ModuleFile {
    /// Its path below the root of the repository.
    pub(crate) path: String,
    /// Its text.
    pub(crate) text: String,
    /// Its code without comments and unit tests; bytes are where they are in the text.
    pub(crate) code: String,
}

/// An item that other files can name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Item {
    /// Its name.
    pub(crate) name: String,
    /// Its keyword: `fn`, `struct`, `enum`, `trait`, `type`, `const`, `static`, `union` or `macro_rules`.
    pub(crate) keyword: &'static str,
    /// Whether it is `pub` without a restriction.
    pub(crate) is_public: bool,
    /// Whether an attribute derives `Error` for it.
    pub(crate) derives_error: bool,
    /// Its first byte.
    pub(crate) at: usize,
}

/// The visibility of an import.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Visibility {
    /// Names for this file.
    Private,
    /// Names for other modules of the crate.
    Restricted,
    /// Names for everyone.
    Public,
}

/// One name, or one glob, of a `use`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Import {
    /// The path.
    pub(crate) path: Vec<String>,
    /// The name here; none for a glob.
    pub(crate) name: Option<String>,
    /// Its visibility.
    pub(crate) visibility: Visibility,
    /// Its first byte.
    pub(crate) at: usize,
}

/// A module, in a file of its own or inside another's.
#[derive(Debug, Default)]
pub(crate) struct Module {
    /// Its name; empty for the root.
    pub(crate) name: String,
    /// Its parent.
    pub(crate) parent: Option<usize>,
    /// Its file.
    pub(crate) file: usize,
    /// Whether it is `pub` without a restriction.
    pub(crate) is_public: bool,
    /// Its child modules, in order.
    pub(crate) children: Vec<usize>,
    /// Its items.
    pub(crate) items: Vec<Item>,
    /// Its imports and re-exports.
    pub(crate) imports: Vec<Import>,
    /// The paths in its code, with their first bytes.
    pub(crate) paths: Vec<(Vec<String>, usize)>,
    /// Names in its code that may be imported, with their first bytes.
    pub(crate) names: HashMap<String, usize>,
    /// Types for which it implements `Error`.
    pub(crate) errors: Vec<String>,
    /// Macros called by name alone.
    pub(crate) macros: HashMap<String, usize>,
}

/// A crate's modules. The first is the root.
pub(crate) struct Crate {
    /// Its folder below `crates/`.
    pub(crate) folder: String,
    /// Its files.
    pub(crate) files: Vec<ModuleFile>,
    /// Its modules.
    pub(crate) modules: Vec<Module>,
    /// The modules that are roots: of the library, of programs.
    pub(crate) roots: Vec<usize>,
}

/// One file uses another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Use {
    /// The file that uses.
    pub(crate) from: usize,
    /// The file that is used.
    pub(crate) to: usize,
    /// The paths or names, the first one first.
    pub(crate) paths: Vec<String>,
    /// The first byte of the first path.
    pub(crate) at: usize,
}
