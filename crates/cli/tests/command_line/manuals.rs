//! Shell completions and manual pages contain every subcommand and option.

use std::process::{Command, Stdio};

use crate::command::Folder;

pub(crate) const SUBCOMMANDS: [&str; 11] = [
    "numbers",
    "inspect",
    "compute",
    "simulate",
    "audit",
    "bench",
    "certify",
    "convert",
    "generate",
    "completions",
    "man",
];

/// Each shell's script names the subcommands and an option, and Bash accepts its script.
#[test]
fn completions_are_scripts() {
    let folder = Folder::new("completions");
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = folder.output(&["completions", shell], "");
        for word in SUBCOMMANDS.iter().chain(&["stop-at-limits"]) {
            assert!(script.contains(word), "{shell}: no {word}");
        }
    }
    folder.write("dynamics.bash", folder.output(&["completions", "bash"], "").as_bytes());
    // Bash's completions of `dynamics simulate --to`.
    let ask = "source ./dynamics.bash; COMP_WORDS=(dynamics simulate --to); COMP_CWORD=2; \
               _dynamics dynamics --to simulate; echo \"${COMPREPLY[@]}\"";
    let output = Command::new("bash").args(["-c", ask]).current_dir(folder.path(".")).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&output.stdout), "--tolerance\n", "{output:?}");
    let ran = folder.run(&["completions", "csh"], b"");
    assert_eq!(ran.code, Some(2), "{}", ran.err);
}

/// A page for the command and each subcommand, with options; a single page on standard output.
#[test]
fn manual_pages_hold_the_options() {
    let folder = Folder::new("manuals");
    let before = folder.names().len();
    folder.output(&["man", "--output", "pages/man1"], "");
    assert_eq!(std::fs::read_dir(folder.path("pages/man1")).unwrap().count(), SUBCOMMANDS.len() + 1);
    for subcommand in SUBCOMMANDS {
        let page = folder.read(&format!("pages/man1/dynamics-{subcommand}.1"));
        assert!(page.contains(&format!(".TH dynamics-{subcommand} 1")), "{page}");
        assert_eq!(folder.output(&["man", subcommand], ""), page);
    }
    let page = folder.read("pages/man1/dynamics-simulate.1");
    for option in ["\\-\\-integrator", "\\-\\-csv", "\\-\\-floating\\-base"] {
        assert!(page.contains(option), "no {option} in\n{page}");
    }
    let page = folder.output(&["man"], "");
    assert_eq!(folder.read("pages/man1/dynamics.1"), page);
    assert!(
        SUBCOMMANDS.iter().all(|subcommand| page.contains(&format!("dynamics\\-{subcommand}(1)"))),
        "{page}"
    );
    // The pages are replaced the second time.
    folder.output(&["man", "--output", "pages/man1"], "");
    assert_eq!(folder.names().len(), before + 1);

    for arguments in [&["man", "juggle"][..], &["man", "--output", "two_r.urdf"]] {
        assert_eq!(folder.run(arguments, b"").code, Some(1), "{arguments:?}");
    }
    let mut child = folder.command(&["man"]).stdout(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success(), "a closed pipe is no failure");
}
