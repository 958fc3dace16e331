//! Every public function of the libraries has an example that runs in its documentation.

/// The names of the public functions at the top level of a file whose documentation has no example. Functions
/// that a macro makes are not looked for.
pub(crate) fn without_example(source: &str) -> Vec<&str> {
    let (mut missing, mut has_example, mut in_fence) = (Vec::new(), false, false);
    for line in source.lines().take_while(|line| line.trim() != "#[cfg(test)]") {
        if line == "#[doc(hidden)]" {
            // Another crate of this library calls it.
            has_example = true;
        } else if let Some(language) = line.strip_prefix("/// ```") {
            has_example |= !in_fence && language.is_empty();
            in_fence = !in_fence;
        } else if let Some(function) =
            line.strip_prefix("pub fn ").or_else(|| line.strip_prefix("pub const fn "))
        {
            if !has_example {
                missing.extend(function.split(['(', '<']).next());
            }
            has_example = false;
        } else if !line.starts_with(['/', '#', ' ', ')']) {
            // Neither documentation nor an attribute, of one line or several: another item, or none.
            has_example = false;
        }
    }
    missing
}

/// Whether users see a function of `module`, a top-level module of the crate with this `lib.rs`: a hidden
/// module shows only what `lib.rs` re-exports.
pub(crate) fn is_shown(library: &str, module: &str, function: &str) -> bool {
    let hidden = format!("#[doc(hidden)]\npub mod {module};");
    let statements = library.split(';').filter(|statement| !statement.contains("#[doc(hidden)]"));
    let mut exported = statements.filter_map(|statement| Some(statement.split_once("pub use ")?.1));
    let is_word = |letter: char| letter.is_alphanumeric() || letter == '_';
    !library.contains(&hidden)
        || exported.any(|names| names.split(|letter| !is_word(letter)).any(|name| name == function))
}

#[cfg(test)]
mod tests {
    use super::{is_shown, without_example};

    #[test]
    fn a_hidden_module_shows_what_is_exported() {
        let library = "#[doc(hidden)]\npub mod inner;\npub mod outer;\n\npub use inner::{shown, told};\n";
        assert!(is_shown(library, "inner", "told") && !is_shown(library, "inner", "kept"));
        assert!(is_shown(library, "outer", "kept"));
    }

    #[test]
    fn a_function_needs_an_example_that_runs() {
        assert!(without_example("/// ```\n/// shown();\n/// ```\n#[inline]\npub fn shown() {}\n").is_empty());
        assert_eq!(without_example("/// Words.\npub fn told<T>() {}\n"), ["told"]);
        assert_eq!(without_example("/// ```text\n/// a drawing\n/// ```\npub fn drawn() {}\n"), ["drawn"]);
        assert_eq!(
            without_example("/// ```\n/// ```\npub struct Shown;\n\npub const fn next() {}\n"),
            ["next"]
        );
    }
}
