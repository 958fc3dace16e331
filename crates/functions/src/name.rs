//! Names in programs.

/// Letters, digits and underscores: a name as an identifier of any language.
///
/// ```
/// assert_eq!(functions::identifier("left foot"), "left_foot");
/// assert_eq!(functions::identifier("2R"), "robot_2r");
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
