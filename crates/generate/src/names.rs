//! Names of the files and functions of generated code.

use robot_dynamics_functions::identifier;

use crate::Target;

/// Keywords of Rust in any edition, including reserved ones: neither a module nor a crate can have such a
/// name.
const RUST_KEYWORDS: [&str; 52] = [
    "abstract", "as", "async", "await", "become", "box", "break", "const", "continue", "crate", "do", "dyn",
    "else", "enum", "extern", "false", "final", "fn", "for", "gen", "if", "impl", "in", "let", "loop",
    "macro", "match", "mod", "move", "mut", "override", "priv", "pub", "ref", "return", "self", "static",
    "struct", "super", "trait", "true", "try", "type", "typeof", "unsafe", "unsized", "use", "virtual",
    "where", "while", "yield", "_",
];

/// Crates that a Rust program may have already.
const RUST_CRATES: [&str; 6] = ["alloc", "core", "proc_macro", "robot_dynamics_number", "std", "test"];

/// The C library's headers: a generated header of the same name in an include folder would hide them.
const C_HEADERS: [&str; 32] = [
    "assert",
    "complex",
    "ctype",
    "errno",
    "fenv",
    "float",
    "inttypes",
    "iso646",
    "limits",
    "locale",
    "malloc",
    "math",
    "memory",
    "setjmp",
    "signal",
    "stdalign",
    "stdarg",
    "stdatomic",
    "stdbit",
    "stdbool",
    "stdckdint",
    "stddef",
    "stdint",
    "stdio",
    "stdlib",
    "stdnoreturn",
    "string",
    "tgmath",
    "threads",
    "time",
    "uchar",
    "wchar",
];

/// The name of a robot's files and functions, and the reason if it is not the identifier made of the robot's
/// name.
pub(crate) fn of_robot(target: Target, robot: &str) -> (String, Option<&'static str>) {
    let name = identifier(robot);
    match reason(target, &name) {
        // Leading underscores are merged with the separator.
        Some(why) => (format!("robot_{}", name.trim_start_matches('_')), Some(why)),
        None => (name, None),
    }
}

/// The reason why a name is invalid for the target.
fn reason(target: Target, name: &str) -> Option<&'static str> {
    let is_one_of = |names: &[&str]| names.contains(&name);
    match target {
        Target::Rust if is_one_of(&RUST_KEYWORDS) => return Some("is a keyword of Rust"),
        Target::Rust if is_one_of(&RUST_CRATES) => return Some("is a crate that Rust programs have already"),
        Target::Rust if is_one_of(&["lib", "main"]) => return Some("is a file that Cargo gives a meaning"),
        Target::C | Target::Cuda | Target::Casadi if is_one_of(&C_HEADERS) => {
            return Some("is a header of the C library");
        }
        _ => {}
    }
    if name.starts_with('_') {
        return Some("begins with what is no letter of a to z");
    }
    is_device(name).then_some("is a device of Windows, and no file has its name there")
}

/// Whether a name is that of a Windows device: `aux`, `com1` and similar.
fn is_device(name: &str) -> bool {
    let numbered = name.strip_prefix("com").or_else(|| name.strip_prefix("lpt"));
    matches!(name, "aux" | "con" | "nul" | "prn")
        || numbered.is_some_and(|rest| rest.len() == 1 && rest.starts_with(|c: char| c.is_ascii_digit()))
}

#[cfg(test)]
mod tests {
    use super::{RUST_KEYWORDS, identifier, of_robot};
    use crate::Target;

    #[test]
    fn invalid_names_are_replaced_with_a_reason() {
        for keyword in RUST_KEYWORDS {
            let (name, why) = of_robot(Target::Rust, keyword);
            assert!(name.starts_with("robot_") && why.is_some(), "{keyword}: {name}");
        }
        assert_eq!(of_robot(Target::Rust, "Self").0, "robot_self");
        assert_eq!(of_robot(Target::C, "fn"), ("fn".into(), None));
        assert_eq!(of_robot(Target::C, "Math").0, "robot_math");
        assert_eq!(of_robot(Target::Wgsl, "机械臂").0, "robot_");
        assert_eq!(of_robot(Target::C, "_arm").0, "robot_arm");
        for target in Target::ALL {
            assert_eq!(of_robot(target, "COM1").0, "robot_com1");
            assert_eq!(of_robot(target, "com10"), ("com10".into(), None));
            assert_eq!(of_robot(target, "UR5 left"), ("ur5_left".into(), None));
            assert_eq!(of_robot(target, "2r"), ("robot_2r".into(), None));
        }
        assert_eq!(identifier(""), "robot_");
    }
}
