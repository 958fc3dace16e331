//! The modules of a crate: its files, their items and imports, and the uses between files.

mod cycles;
mod parse;
mod resolve;
mod structure;

use crate::files::SourceFile;
use crate::tokens::code;

pub(crate) use cycles::components;
pub(crate) use resolve::{Target, resolve_name};
pub(crate) use structure::{Crate, Use, Visibility};

use structure::ModuleFile;

impl Crate {
    /// Reads the crate in that folder of `crates/`; nothing if it has no sources.
    pub(crate) fn read(folder: &str, files: &[SourceFile]) -> Option<Self> {
        let prefix = format!("crates/{folder}/src/");
        let sources = files.iter().filter(|file| file.path.starts_with(&prefix));
        let sources: Vec<(String, String)> = sources
            .filter(|file| std::path::Path::new(&file.path).extension().is_some_and(|end| end == "rs"))
            .map(|file| (file.path.clone(), file.text.clone()))
            .collect();
        Self::of(folder, sources)
    }

    /// The crate of these files, paths and texts.
    fn of(folder: &str, sources: Vec<(String, String)>) -> Option<Self> {
        let prefix = format!("crates/{folder}/src/");
        let file = |(path, text): (String, String)| ModuleFile { path, code: code(&text).1, text };
        let files = sources.into_iter().map(file).collect();
        let mut this = Self { folder: folder.to_owned(), files, modules: Vec::new(), roots: Vec::new() };
        for index in 0..this.files.len() {
            let below = this.files[index].path.strip_prefix(&prefix).unwrap_or_default();
            if below == "lib.rs" || below == "main.rs" || is_program(below) {
                this.roots.push(this.modules.len());
                parse::module(&mut this, String::new(), None, index, true);
            }
        }
        (!this.roots.is_empty()).then_some(this)
    }

    /// The root of the library, if there is one.
    pub(crate) fn library(&self) -> Option<usize> {
        self.roots.iter().copied().find(|&root| {
            self.files[self.modules[root].file].path == format!("crates/{}/src/lib.rs", self.folder)
        })
    }

    /// The uses between files: one for each pair.
    pub(crate) fn uses(&self) -> Vec<Use> {
        resolve::uses(self)
    }

    /// A child of a module.
    pub(crate) fn child(&self, module: usize, name: &str) -> Option<usize> {
        self.modules[module].children.iter().copied().find(|&child| self.modules[child].name == name)
    }
}

/// Whether a file below `src` is a program of its own.
fn is_program(below: &str) -> bool {
    below.strip_prefix("bin/").is_some_and(|name| !name.contains('/'))
}

#[cfg(test)]
mod tests {
    use super::{Crate, components};

    /// Uses between files, as `from > to`, of files `path: code`.
    fn uses(files: &[(&str, &str)]) -> (Crate, Vec<String>) {
        let sources =
            files.iter().map(|(path, code)| (format!("crates/x/src/{path}"), (*code).to_owned())).collect();
        let this = Crate::of("x", sources).expect("has a root");
        let short = |file: usize| this.files[file].path["crates/x/src/".len()..].to_owned();
        let mut shown: Vec<String> =
            this.uses().iter().map(|one| format!("{} > {}", short(one.from), short(one.to))).collect();
        shown.sort();
        (this, shown)
    }

    fn cycles(this: &Crate) -> Vec<usize> {
        let edges: Vec<(usize, usize)> = this.uses().iter().map(|one| (one.from, one.to)).collect();
        components(this.files.len(), &edges).iter().map(Vec::len).collect()
    }

    #[test]
    fn re_exports_lead_to_the_file_that_defines() {
        let (this, shown) = uses(&[
            ("lib.rs", "mod a; mod b; pub use a::One;"),
            ("a.rs", "mod part; pub use part::{One, Two as Three};"),
            ("a/part.rs", "pub struct One; pub struct Two;"),
            ("b.rs", "use crate::One; fn f(x: crate::a::Three) {}"),
        ]);
        assert_eq!(shown, ["b.rs > a/part.rs"]);
        assert!(cycles(&this).is_empty());
    }

    #[test]
    fn a_child_that_imports_what_its_parent_defines_is_in_a_cycle() {
        let files = [
            ("lib.rs", "mod a;"),
            ("a.rs", "mod part; pub struct One; fn f() { part::g(One) }"),
            ("a/part.rs", "use super::One; pub fn g(_: One) {}"),
        ];
        let (this, shown) = uses(&files);
        assert_eq!(shown, ["a.rs > a/part.rs", "a/part.rs > a.rs"]);
        assert_eq!(cycles(&this), [2]);
    }

    #[test]
    fn siblings_through_their_parent_are_not() {
        let (this, shown) = uses(&[
            ("lib.rs", "mod a;"),
            ("a.rs", "mod one; mod two; use one::One; pub fn f(_: One) { two::g() }"),
            ("a/one.rs", "pub struct One;"),
            ("a/two.rs", "use super::One; pub fn g() { let _: One; }"),
        ]);
        assert_eq!(shown, ["a.rs > a/one.rs", "a.rs > a/two.rs", "a/two.rs > a/one.rs"]);
        assert!(cycles(&this).is_empty());
    }

    #[test]
    fn globs_modules_and_macros_are_followed() {
        let (_, shown) = uses(&[
            ("lib.rs", "#[macro_use] mod m; mod a; mod b; mod c;"),
            ("m.rs", "macro_rules! make { () => { $crate::a::One } }"),
            ("a.rs", "pub struct One; pub fn run() {} made!();"),
            ("b.rs", "use crate::a::*; fn f() { run(); let x = self.one; }"),
            ("c.rs", "use crate::{a, b as d}; fn f() { make!(); a::Made::new(); d::f() }"),
        ]);
        assert_eq!(shown, ["b.rs > a.rs", "c.rs > a.rs", "c.rs > b.rs", "c.rs > m.rs", "m.rs > a.rs"]);
    }

    #[test]
    fn a_re_export_counts_where_its_file_uses_the_name() {
        let (_, shown) = uses(&[
            ("lib.rs", "mod a; mod b; pub use a::One; pub use b::two;"),
            ("a.rs", "pub struct One;"),
            ("b.rs", "pub fn two() {}"),
        ]);
        assert!(shown.is_empty());
        let (_, shown) = uses(&[
            ("lib.rs", "mod a; mod b; pub use a::One; pub use b::two; fn f() -> One { two() }"),
            ("a.rs", "pub struct One;"),
            ("b.rs", "pub fn two() {}"),
        ]);
        assert_eq!(shown, ["lib.rs > a.rs", "lib.rs > b.rs"]);
    }

    #[test]
    fn inline_modules_share_their_file() {
        let (_, shown) = uses(&[
            ("lib.rs", "mod a; mod b;"),
            ("a.rs", "mod inner { use super::One; pub(in crate::a) struct Two; } pub struct One;"),
            ("b.rs", "fn f(_: super::a::inner::Two) {}"),
        ]);
        assert_eq!(shown, ["b.rs > a.rs"]);
    }

    #[test]
    fn items_that_a_macro_takes_are_the_files() {
        let (this, shown) = uses(&[
            (
                "lib.rs",
                "mod a; mod b; copied! { /// A.
 #[derive(Debug)] pub struct One<T> { x: T } }",
            ),
            ("a.rs", "copied! { pub enum Two { A } }"),
            ("b.rs", "use crate::{One, a::Two};"),
        ]);
        assert_eq!(shown, ["b.rs > a.rs", "b.rs > lib.rs"]);
        assert_eq!(this.modules[0].items[0].name, "One");
    }

    #[test]
    fn other_crates_are_not_modules() {
        let (_, shown) = uses(&[
            ("lib.rs", "mod number;"),
            ("number.rs", "use std::fmt; use ::number::One; fn f() { fmt::run(); Self::new() }"),
        ]);
        assert!(shown.is_empty());
    }

    #[test]
    fn items_have_their_visibility_and_kind() {
        let (this, _) = uses(&[(
            "lib.rs",
            "#[derive(Debug, thiserror::Error)] pub enum E { A } pub(crate) const fn f<T>() -> [u8; 3] where T: X {} impl E { pub fn g() {} } pub unsafe trait T {} static S: u8 = 1;",
        )]);
        let items: Vec<(&str, &str, bool, bool)> = this.modules[0]
            .items
            .iter()
            .map(|item| (item.keyword, item.name.as_str(), item.is_public, item.derives_error))
            .collect();
        assert_eq!(
            items,
            [
                ("enum", "E", true, true),
                ("fn", "f", false, false),
                ("trait", "T", true, false),
                ("static", "S", false, false)
            ]
        );
    }
}
