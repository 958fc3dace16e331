//! The command `dynamics`.
fn main() {}
