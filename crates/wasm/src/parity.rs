//! How the numbers are written that the native and the WebAssembly builds are compared on.

/// A line `name<TAB>exact|rounded<TAB>numbers`.
pub(crate) fn entry(name: &str, exact: bool, numbers: &[f64]) -> String {
    let kind = if exact { "exact" } else { "rounded" };
    // Rust prints the shortest digits that read back as the same number.
    let digits: Vec<String> = numbers.iter().map(f64::to_string).collect();
    format!("{name}\t{kind}\t{}", digits.join(" "))
}
