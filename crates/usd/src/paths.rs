//! Checks of the names of prims and of paths.
//!
//! openusd takes a path apart from its end until it reaches the root. It never does for a path with a brace
//! that closes nothing, an empty name, or a name `.`, and continues until the stack or the time is exhausted.

use robot_dynamics_xml::excerpt;

/// Whether each `}` belongs to a `{` before it.
fn is_balanced(text: &[u8]) -> bool {
    let mut open = 0_usize;
    text.iter().all(|byte| match byte {
        b'{' => {
            open += 1;
            true
        }
        b'}' => {
            let is_open = open > 0;
            open = open.saturating_sub(1);
            is_open
        }
        _ => true,
    })
}

fn shown(text: &[u8]) -> String {
    excerpt(&String::from_utf8_lossy(text))
}

/// Refuses the name of a prim that is empty or has a character of paths.
pub(crate) fn check_prim_name(name: &[u8]) -> Result<(), String> {
    if name.is_empty() || name.iter().any(|byte| b"/.{}[]<>".contains(byte)) {
        let shown = shown(name);
        return Err(format!("the name of a prim {shown:?} is invalid; use letters, digits and underscores"));
    }
    Ok(())
}

/// Refuses the path of a prim or of a property with an empty name or a brace that closes nothing.
pub(crate) fn check_path(path: &[u8]) -> Result<(), String> {
    if path.windows(2).any(|pair| pair == b"//") || !is_balanced(path) {
        return Err(format!("the path <{}> is invalid; correct it", shown(path)));
    }
    Ok(())
}

/// Refuses a name in a list of the prims, properties or variants of a prim.
pub(crate) fn check_listed_name(name: &[u8]) -> Result<(), String> {
    if matches!(name, b"" | b".") || !is_balanced(name) {
        let shown = shown(name);
        return Err(format!("the name of a prim or property {shown:?} is invalid; correct it"));
    }
    Ok(())
}

/// Refuses the name of a property in a path.
pub(crate) fn check_property_name(name: &[u8]) -> Result<(), String> {
    check_listed_name(name)?;
    check_path(name)
}

/// Refuses an element of a path after a prim: a name, or a variant as `{set=variant}`.
pub(crate) fn check_element(element: &[u8]) -> Result<(), String> {
    if element.starts_with(b"{") { check_path(element) } else { check_prim_name(element) }
}
