//! How often each file may still break a rule: `xtask/allowances.txt`, in which counts only shrink.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::fs;

use crate::root::root;

/// The file.
const FILE: &str = "xtask/allowances.txt";

const HEAD: &str = "\
# How often each file breaks a rule of `cargo xtask tidy`: rule, path, count. Counts only shrink:
# `cargo xtask tidy --write-allowances` lowers them; with `--force` it raises them too, after files were moved.
";

/// Counts by rule and path.
pub(crate) type Counts = BTreeMap<(String, String), usize>;

/// Reads the allowances; none if there is no file.
pub(crate) fn read() -> Result<Counts, String> {
    match fs::read_to_string(root().join(FILE)) {
        Ok(text) => parse(&text),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Counts::new()),
        Err(error) => Err(format!("{FILE}: {error}")),
    }
}

fn parse(text: &str) -> Result<Counts, String> {
    let mut counts = Counts::new();
    for (index, line) in
        text.lines().enumerate().filter(|(_, line)| !line.starts_with('#') && !line.is_empty())
    {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [rule, path, count] = words.as_slice() else {
            return Err(format!("{FILE}:{}: not `rule path count`", index + 1));
        };
        let count = count.parse().map_err(|error| format!("{FILE}:{}: {error}", index + 1))?;
        counts.insert(((*rule).to_owned(), (*path).to_owned()), count);
    }
    Ok(counts)
}

/// The differences: counts above their allowance, explained by `show`, and allowances above their count.
pub(crate) fn compare(found: &Counts, allowed: &Counts, show: impl Fn(&str, &str) -> String) -> Vec<String> {
    let mut broken = Vec::new();
    for ((rule, path), &count) in found {
        let most = allowed.get(&(rule.clone(), path.clone())).copied().unwrap_or(0);
        if count > most {
            broken.push(format!("{path}: {rule}: {count}, at most {most}:{}", show(rule, path)));
        }
    }
    let mut spare = 0;
    for (key, &most) in allowed {
        if most > found.get(key).copied().unwrap_or(0) {
            spare += 1;
        }
    }
    if spare > 0 {
        broken.push(format!(
            "{FILE}: {spare} allowances are larger than their counts: `cargo xtask tidy --write-allowances` lowers them"
        ));
    }
    broken
}

/// Writes the counts as allowances. Without `is_forced` a count is never raised.
pub(crate) fn write(found: &Counts, allowed: &Counts, is_forced: bool) -> Result<(), String> {
    let text = text(&lowered(found, allowed, is_forced));
    fs::write(root().join(FILE), text).map_err(|error| format!("{FILE}: {error}"))
}

fn lowered(found: &Counts, allowed: &Counts, is_forced: bool) -> Counts {
    let mut counts = found.clone();
    if !is_forced {
        for (key, count) in &mut counts {
            *count = (*count).min(allowed.get(key).copied().unwrap_or(0));
        }
    }
    counts.retain(|_, count| *count > 0);
    counts
}

fn text(counts: &Counts) -> String {
    let mut text = HEAD.to_owned();
    for ((rule, path), count) in counts {
        let _ = writeln!(text, "{rule} {path} {count}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::{Counts, compare, lowered, parse, text};

    fn counts(lines: &[(&str, &str, usize)]) -> Counts {
        lines.iter().map(|(rule, path, count)| (((*rule).into(), (*path).into()), *count)).collect()
    }

    #[test]
    fn counts_survive_the_file() {
        let some = counts(&[("width", "a/b.rs", 3), ("opening", "c.md", 1)]);
        assert_eq!(parse(&text(&some)).expect("reads"), some);
        assert!(parse("width a.rs\n").is_err());
    }

    #[test]
    fn growth_and_spare_allowances_are_reported() {
        let (found, allowed) =
            (counts(&[("w", "a", 2), ("w", "b", 1)]), counts(&[("w", "a", 1), ("w", "c", 1)]));
        let broken = compare(&found, &allowed, |_, _| String::new());
        assert_eq!(broken.len(), 3);
        assert!(compare(&found, &found, |_, _| String::new()).is_empty());
    }

    #[test]
    fn counts_rise_only_by_force() {
        let (found, allowed) =
            (counts(&[("w", "a", 2), ("w", "b", 1)]), counts(&[("w", "a", 1), ("w", "c", 1)]));
        assert_eq!(lowered(&found, &allowed, false), counts(&[("w", "a", 1)]));
        assert_eq!(lowered(&found, &allowed, true), found);
    }
}
