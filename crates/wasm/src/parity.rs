//! The format of the values that the native and the WebAssembly builds are compared by.

/// A line `name<TAB>exact|rounded<TAB>numbers`.
pub(crate) fn entry(name: &str, exact: bool, numbers: &[f64]) -> String {
    let kind = if exact { "exact" } else { "rounded" };
    // Rust prints the shortest digits that parse to the same number.
    let digits: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("{name}\t{kind}\t{}", digits.join(" "))
}
