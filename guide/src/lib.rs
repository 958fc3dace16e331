//! The Rust code of the guide's pages, compiled and run as doc tests.
//!
//! A crate of its own, unpublished: the pages lie beside it, and it may use all that a user may. Doc tests run in this folder, so that each
//! block begins with a hidden line that goes to the repository's root, where the paths of the pages begin.

/// A module for each page.
macro_rules! pages {
    ($($name:ident)*) => {
        $(
            #[cfg(doctest)]
            #[doc = include_str!(concat!("../pages/", stringify!($name), ".md"))]
            mod $name {}
        )*

        #[cfg(test)]
        const PAGES: &[&str] = &[$(stringify!($name)),*];
    };
}

pages! {
    index start load control invert differentiate constrain identify time simulate batch cluster publish
    conventions verified speed command library examples
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    #[test]
    fn every_page_is_tried() {
        let folder = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/pages")).unwrap();
        let names =
            folder.map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned());
        let tried = super::PAGES.iter().map(ToString::to_string);
        assert_eq!(names.collect::<BTreeSet<_>>(), tried.collect::<BTreeSet<_>>());
    }
}
