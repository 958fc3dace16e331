//! Every public function of the libraries shows itself at work: its documentation has an example that runs.

/// The crates whose functions strangers call.
pub(crate) const LIBRARIES: [&str; 13] = [
    "dynamics",
    "expression",
    "functions",
    "generate",
    "gpu",
    "mesh",
    "mjcf",
    "multibody",
    "native",
    "number",
    "robot-dynamics",
    "urdf",
    "xml",
];

/// The names of the public functions at the top level of a file whose documentation has no example. Functions that a
/// macro makes are not looked for.
pub(crate) fn without_example(source: &str) -> Vec<&str> {
    let (mut missing, mut has_example, mut in_fence) = (Vec::new(), false, false);
    for line in source.lines().take_while(|line| line.trim() != "#[cfg(test)]") {
        if let Some(language) = line.strip_prefix("/// ```") {
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

#[cfg(test)]
mod tests {
    use super::without_example;

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
