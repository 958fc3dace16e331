//! Names in programs.

/// A name as an identifier of any language: letters, digits and underscores.
///
/// ```
/// assert_eq!(robot_dynamics_functions::identifier("left foot"), "left_foot");
/// assert_eq!(robot_dynamics_functions::identifier("2R"), "robot_2r");
/// ```
pub fn identifier(name: &str) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' };
    let text: String = name.chars().map(plain).collect();
    if text.starts_with(|c: char| c.is_ascii_digit()) || text.is_empty() {
        format!("robot_{text}")
    } else {
        text
    }
}
