//! The commands in the guide and in README.md print the output that is shown there.

use std::fs;
use std::path::{Path, PathBuf};

use crate::command::{Folder, robots};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The guide's pages and README.md.
fn pages() -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join("guide/pages")).unwrap();
    let mut pages: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    pages.retain(|path| path.extension().is_some_and(|end| end == "md"));
    pages.sort();
    assert!(pages.len() > 10, "pages are missing");
    pages.push(root().join("README.md"));
    pages
}

/// Each block of shell commands, with the output shown below it.
fn blocks(page: &str) -> Vec<(String, Option<String>)> {
    let mut blocks: Vec<(String, Option<String>)> = Vec::new();
    let (mut lines, mut is_below) = (page.lines(), false);
    while let Some(line) = lines.next() {
        let Some(language) = line.strip_prefix("```") else {
            is_below &= line.is_empty();
            continue;
        };
        let text = lines.by_ref().take_while(|line| *line != "```").collect::<Vec<_>>().join("\n");
        match (language, blocks.last_mut()) {
            ("sh", _) => blocks.push((text.replace("\\\n", " "), None)),
            ("text", Some(last)) if is_below => last.1 = Some(text),
            _ => {}
        }
        is_below = language == "sh";
    }
    blocks
}

/// The words of a command; quotes keep words together, and `#` starts a comment.
fn words(command: &str) -> Vec<String> {
    let (mut words, mut quote, mut word) = (Vec::new(), None, None::<String>);
    for letter in command.chars() {
        match (letter, quote) {
            ('\'' | '"', None) => {
                quote = Some(letter);
                word.get_or_insert_default();
            }
            (_, Some(open)) if letter == open => quote = None,
            ('#', None) if word.is_none() => break,
            (' ', None) => words.extend(word.take()),
            _ => word.get_or_insert_default().push(letter),
        }
    }
    words.extend(word);
    words
}

/// Whether the output is the shown one, in which `...` stands for any text.
fn is_shown(shown: &str, output: &str) -> bool {
    let clean = |text: &str| text.trim_end().lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    let (shown, output) = (clean(shown), clean(output));
    let pieces: Vec<&str> = shown.split("...").collect();
    let Some(mut rest) = output.strip_prefix(pieces[0]) else { return false };
    for piece in &pieces[1..] {
        let Some(at) = rest.find(piece) else { return false };
        rest = &rest[at + piece.len()..];
    }
    rest.is_empty() || pieces.len() > 1 && shown.ends_with("...")
}

#[test]
fn shown_output_may_leave_out_what_differs() {
    assert!(
        is_shown("a\nb", "a\nb\n")
            && is_shown("a\n...\nc", "a\nb\nb\nc")
            && is_shown("a ... s\n...", "a 3 s\nmore")
    );
    assert!(!is_shown("a", "a\nb") && !is_shown("a\n...\nd", "a\nb\nc") && !is_shown("b\n...", "a\nb"));
    assert_eq!(words("x --y '1 2' \"a b\"  # why"), ["x", "--y", "1 2", "a b"]);
}

/// Runs a command. If the output is not shown, `dynamics` only prints its help, and for other programs the
/// files that they name must exist.
fn run(folder: &Folder, command: &str, is_shown: bool) -> Option<String> {
    let (input, command) = match command.split_once(" | ") {
        Some((echo, command)) => {
            (words(echo.strip_prefix("echo ").expect("only echo")).join(" ") + "\n", command)
        }
        None => (String::new(), command),
    };
    let words = words(command);
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    match words.as_slice() {
        ["dynamics", task, ..] if !is_shown => {
            folder.output(&[task, "--help"], "");
            None
        }
        ["dynamics", arguments @ ..] | ["cargo", "run", "--release", "--", arguments @ ..] => {
            let ran = folder.run(arguments, input.as_bytes());
            assert!(ran.code == Some(0) || !ran.err.is_empty(), "{command}: {ran:?}");
            Some(ran.out + &ran.err)
        }
        ["cargo", "xtask", task, ..] => {
            let usage = fs::read_to_string(root().join("xtask/src/main.rs")).unwrap();
            assert!(usage.contains(&format!("\n  {task}")), "{command}: there is no such task");
            None
        }
        ["cargo", "install", "--path", path, ..] => {
            assert!(root().join(path).join("Cargo.toml").exists(), "{command}: no such package");
            None
        }
        ["pip", "install", package, ..] => {
            let (path, extras) = package.split_once('[').unwrap_or((package, ""));
            let project = fs::read_to_string(root().join(path).join("pyproject.toml")).unwrap();
            for extra in extras.trim_end_matches(']').split(',').filter(|extra| !extra.is_empty()) {
                assert!(project.contains(&format!("\n{extra} = [")), "{command}: no such extra");
            }
            None
        }
        ["cmake", "-S", path, ..] => {
            assert!(root().join(path).join("CMakeLists.txt").exists(), "{command}: no such project");
            let files = words.iter().filter_map(|word| word.strip_prefix("-DCMAKE_TOOLCHAIN_FILE="));
            for file in files {
                assert!(root().join(file).exists(), "{command}: no such file");
            }
            None
        }
        // The tests of the C++ library and of the Python package run these.
        ["cmake", "--build" | "--install", ..]
        | ["rustup", "target", "add", ..]
        | ["python", "-m", "robot_dynamics", ..] => None,
        ["python", script, ..] => {
            assert!(root().join(script).exists(), "{command}: no such script");
            None
        }
        ["cargo", "run", "--release", "-p", package, "--example", example, ..] => {
            let folder = package.strip_prefix("robot-dynamics-").unwrap_or(package);
            let examples = root().join("crates").join(folder).join("examples");
            let is_there = [format!("{example}.rs"), format!("{example}/main.rs")];
            assert!(is_there.iter().any(|file| examples.join(file).exists()), "{command}: no such example");
            None
        }
        _ => panic!("no test knows how to try `{command}`"),
    }
}

#[test]
fn commands_of_the_pages_print_what_is_shown() {
    let mut compared = 0;
    for page in pages() {
        let name = page.file_stem().unwrap().to_string_lossy().into_owned();
        let folder = Folder::new(&format!("page-{name}"));
        fs::create_dir(folder.path("robots")).unwrap();
        for robot in robots().iter().chain(&[root().join("robots/arm.xml")]) {
            fs::copy(robot, folder.path("robots").join(robot.file_name().unwrap())).unwrap();
        }
        for (commands, shown) in blocks(&fs::read_to_string(&page).unwrap()) {
            let printed: Vec<String> = commands
                .lines()
                .filter(|line| !line.trim_start().starts_with('#') && !line.trim().is_empty())
                .filter_map(|command| run(&folder, command, shown.is_some()))
                .collect();
            if let (Some(shown), false) = (shown, printed.is_empty()) {
                let printed = printed.concat();
                assert!(
                    is_shown(&shown, &printed),
                    "{name}: `{commands}` printed\n{printed}\nand not\n{shown}"
                );
                compared += 1;
            }
        }
    }
    assert!(compared >= 8, "only {compared} outputs are shown");
}
