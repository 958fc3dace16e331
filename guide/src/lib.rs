//! The Rust code of the guide's pages, compiled and run as doc tests.
//!
//! The crate is unpublished and uses the facade as a user does. Doc tests run in this folder, so each
//! block begins with a hidden line that changes to the repository's root, where the paths start.

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
    index start concepts load scene control touch motors optimal invert differentiate constrain identify time simulate push sensors batch
    cluster publish conventions verified certify speed glossary command library cpp examples
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::fs;

    /// A block without an assertion could not fail.
    #[test]
    fn every_block_of_rust_asserts_something() {
        for name in super::PAGES {
            let page = fs::read_to_string(format!("{}/pages/{name}.md", env!("CARGO_MANIFEST_DIR"))).unwrap();
            for block in page.split("\n```rust\n").skip(1) {
                let code = block.split("\n```").next().unwrap();
                assert!(code.contains("assert"), "{name}: a block without an assertion:\n{code}");
            }
        }
    }

    /// Each experiment that a page embeds or links to has a file in the lab.
    #[test]
    fn every_linked_experiment_exists() {
        let guide = env!("CARGO_MANIFEST_DIR");
        let mut shown = 0;
        for page in ["pages", "reference"]
            .iter()
            .flat_map(|folder| fs::read_dir(format!("{guide}/{folder}")).unwrap())
        {
            let page = fs::read_to_string(page.unwrap().path()).unwrap();
            for link in page.split("lab/index.html").skip(1) {
                let Some(name) = link.strip_prefix("?only=").or_else(|| link.strip_prefix('#')) else {
                    continue;
                };
                let name = name.split(['"', ')']).next().unwrap();
                assert!(
                    fs::exists(format!("{guide}/../lab/src/widgets/{name}.ts")).unwrap(),
                    "no experiment `{name}`"
                );
                shown += 1;
            }
        }
        assert!(shown > 10, "only {shown} experiments are shown");
    }

    #[test]
    fn every_page_is_tested() {
        let folder = fs::read_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/pages")).unwrap();
        let names =
            folder.map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned());
        let tried = super::PAGES.iter().map(ToString::to_string);
        assert_eq!(names.collect::<BTreeSet<_>>(), tried.collect::<BTreeSet<_>>());
    }
}
