//! SIGINT, SIGTERM and SIGHUP end a command in the same way: results are kept, and no temporary file remains.
#![cfg(unix)]

use std::fs;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use crate::command::Folder;
use crate::labels::INTERRUPTED;

const SIGNALS: [(&str, i32); 3] = [("INT", 130), ("TERM", 143), ("HUP", 129)];

#[track_caller]
fn wait_until(is_so: impl Fn() -> bool) {
    let clock = Instant::now();
    while !is_so() {
        assert!(clock.elapsed() < Duration::from_secs(120), "the condition is not met in time");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn send(signal: &str, child: &Child) {
    let id = child.id().to_string();
    assert!(Command::new("kill").args([&format!("-{signal}"), id.as_str()]).status().unwrap().success());
}

/// Only the partial table and the partial plot remain.
#[test]
fn a_run_is_kept_up_to_the_signal() {
    let folder = Folder::new("signals");
    let before = folder.names();
    let run = ["simulate", "two_r.urdf", "--duration", "100000", "--csv", "run.csv", "--plot", "run.svg"];
    for (signal, code) in SIGNALS {
        let child = folder.command(&run).spawn().unwrap();
        // The header is written when the buffer is full of rows.
        let grows = |name: &String| {
            name.ends_with("run.csv") && fs::metadata(folder.path(name)).is_ok_and(|file| file.len() > 0)
        };
        wait_until(|| folder.names().iter().any(grows));
        send(signal, &child);
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{signal}: {err}");
        assert!(err.starts_with(INTERRUPTED), "{signal}: {err}");
        for name in ["run.partial.csv", "run.partial.svg"] {
            assert!(fs::metadata(folder.path(name)).is_ok_and(|file| file.len() > 0), "{signal}: {name}");
            fs::remove_file(folder.path(name)).unwrap();
        }
        assert_eq!(folder.names(), before, "{signal}");
    }
}

/// A command without steps ends at once, and its temporary folder is removed.
#[test]
fn a_measurement_leaves_no_folder() {
    let folder = Folder::new("signals_measure");
    let temporary = folder.path("temporary");
    fs::create_dir(&temporary).unwrap();
    let run = ["generate", "humanoid.urdf", "--target", "c", "--measure", "-o", "code"];
    for (signal, code) in SIGNALS {
        // The compiler has its own files there.
        let is_there = || {
            let mut entries = fs::read_dir(&temporary).unwrap().map(|entry| entry.unwrap().file_name());
            entries.any(|name| name.to_string_lossy().starts_with("dynamics-measure-"))
        };
        let child = folder.command(&run).env("TMPDIR", &temporary).spawn().unwrap();
        wait_until(is_there);
        send(signal, &child);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(code), "{signal}: {}", String::from_utf8_lossy(&output.stderr));
        assert!(!is_there(), "{signal}");
        assert!(!folder.path("code").exists(), "{signal}");
    }
}

/// With `nohup` a run outlives its terminal.
#[cfg(target_os = "linux")]
#[test]
fn a_run_that_ignores_hangups_goes_on() {
    let folder = Folder::new("signals_nohup");
    let mut command = Command::new("bash");
    let script = "trap '' HUP; exec \"$0\" simulate two_r.urdf --duration 100000 --csv run.csv";
    command.args(["-c", script, env!("CARGO_BIN_EXE_dynamics")]).current_dir(folder.path("."));
    let mut child = command.stdout(std::process::Stdio::null()).spawn().unwrap();
    let grows = |name: &String| {
        name.starts_with(".unfinished") && fs::metadata(folder.path(name)).is_ok_and(|file| file.len() > 0)
    };
    wait_until(|| folder.names().iter().any(grows));
    send("HUP", &child);
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(child.try_wait().unwrap(), None);
    send("TERM", &child);
    assert_eq!(child.wait().unwrap().code(), Some(143));
}
