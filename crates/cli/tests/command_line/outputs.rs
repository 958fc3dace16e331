//! Outputs replace no inputs, are complete or partial by name, and keep results.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::process::Stdio;

use crate::command::{Folder, RunOutput};
use crate::labels::{DRIFT, DRIFT_OF_KINETIC, FAILED_TO_WRITE, number_after};
use crate::messages::Transcript;

/// A short run with these additional arguments.
fn simulate(folder: &Folder, robot: &str, arguments: &[&str]) -> RunOutput {
    folder.run(&[&["simulate", robot, "--duration", "0.05"], arguments].concat(), b"")
}

#[track_caller]
fn assert_refused(folder: &Folder, robot: &str, arguments: &[&str], transcript: &mut Transcript) {
    let before = folder.names();
    let ran = simulate(folder, robot, arguments);
    assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{arguments:?}: {}", ran.err);
    assert!(ran.err.starts_with("error: ") && ran.err.lines().count() == 1, "{arguments:?}: {}", ran.err);
    let here = folder.path("").to_str().unwrap().to_owned();
    let arguments = arguments.iter().map(|argument| argument.replace(&here, "HERE/")).collect::<Vec<_>>();
    transcript.add_text(&format!("$ dynamics simulate {robot} {}", arguments.join(" ")));
    transcript.add_text(&ran.err.replace(&here, "HERE/"));
    assert_eq!(folder.names(), before, "{arguments:?}");
}

/// The output is the robot's path, a detour, a link to the file or its folder, or has the robot's path as its
/// partial file.
#[test]
fn no_output_replaces_the_robot() {
    let folder = Folder::new("over_the_robot");
    let mut transcript = Transcript::default();
    let robot = folder.read("two_r.urdf");
    fs::create_dir(folder.path("inner")).unwrap();
    symlink("two_r.urdf", folder.path("link.csv")).unwrap();
    symlink("link.csv", folder.path("link.svg")).unwrap();
    symlink(".", folder.path("here")).unwrap();
    fs::hard_link(folder.path("two_r.urdf"), folder.path("hard.csv")).unwrap();
    let whole = folder.path("two_r.urdf");
    let whole = whole.to_str().unwrap();
    for name in [
        "two_r.urdf",
        "./two_r.urdf",
        "inner/../two_r.urdf",
        whole,
        "link.csv",
        "here/two_r.urdf",
        "hard.csv",
    ] {
        assert_refused(&folder, "two_r.urdf", &["--csv", name], &mut transcript);
    }
    // The robot by its link, the output by its own name, and a plot.
    assert_refused(&folder, "link.csv", &["--csv", "two_r.urdf"], &mut transcript);
    assert_refused(&folder, "two_r.urdf", &["--plot", "link.svg"], &mut transcript);
    fs::copy(folder.path("two_r.urdf"), folder.path("arm.partial.csv")).unwrap();
    assert_refused(&folder, "arm.partial.csv", &["--csv", "arm.csv"], &mut transcript);
    transcript.compare("over_the_robot");
    assert_eq!(folder.read("two_r.urdf"), robot);
    assert_eq!(folder.read("arm.partial.csv"), robot);
}

/// Two outputs must differ, including new files: through a dangling link, and on file systems that ignore
/// case.
#[test]
fn no_output_replaces_another() {
    let folder = Folder::new("over_another");
    let mut transcript = Transcript::default();
    symlink("to_come.svg", folder.path("ahead.csv")).unwrap();
    for (csv, plot) in [
        ("run.svg", "run.svg"),
        ("./run.svg", "run.svg"),
        ("ahead.csv", "to_come.svg"),
        ("RUN.svg", "run.svg"),
    ] {
        assert_refused(&folder, "two_r.urdf", &["--csv", csv, "--plot", plot], &mut transcript);
    }
    let partial = ["--csv", "run.partial.svg", "--plot", "run.svg"];
    assert_refused(&folder, "two_r.urdf", &partial, &mut transcript);
    assert_refused(&folder, "two_r.urdf", &["--csv", "inner/"], &mut transcript);
    assert_refused(&folder, "two_r.urdf", &["--csv", "none/run.csv"], &mut transcript);
    symlink("round.csv", folder.path("round.csv")).unwrap();
    assert_refused(&folder, "two_r.urdf", &["--csv", "round.csv"], &mut transcript);
    transcript.compare("over_another_output");
}

/// A replaced file keeps its permissions, and a link to it stays a link.
#[test]
fn a_replaced_file_keeps_its_mode() {
    let folder = Folder::new("mode");
    for mode in [0o600, 0o640, 0o666] {
        folder.write("run.csv", b"older\n");
        fs::set_permissions(folder.path("run.csv"), fs::Permissions::from_mode(mode)).unwrap();
        let _ = fs::remove_file(folder.path("link.csv"));
        symlink("run.csv", folder.path("link.csv")).unwrap();
        let ran = simulate(&folder, "two_r.urdf", &["--csv", "link.csv"]);
        assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.out);
        assert!(folder.read("run.csv").starts_with("t [s],"), "{mode:o}");
        assert_eq!(fs::metadata(folder.path("run.csv")).unwrap().mode() & 0o7777, mode);
        assert!(fs::symlink_metadata(folder.path("link.csv")).unwrap().is_symlink());
    }
}

/// With the table on standard output, the summary goes to standard error. Devices accept two outputs.
#[test]
fn streams_are_written_as_they_are() {
    let folder = Folder::new("streams");
    let before = folder.names();
    for name in ["-", "/dev/stdout"] {
        let ran = simulate(&folder, "two_r.urdf", &["--csv", name]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        assert!(ran.out.starts_with("t [s],") && ran.out.lines().count() == 52, "{}", ran.out);
        assert!(ran.err.starts_with("two_r (two_r.urdf): ") && ran.err.contains(" (51 "), "{}", ran.err);
    }
    symlink("/dev/null", folder.path("null.svg")).unwrap();
    let ran = simulate(&folder, "two_r.urdf", &["--csv", "/dev/null", "--plot", "null.svg"]);
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.out);
    assert!(ran.out.contains("/dev/null (51 "), "{}", ran.out);
    // The robot from a stream, and the table to one.
    let robot = folder.read("two_r.urdf");
    let run = ["simulate", "/dev/stdin", "--duration", "0.05", "--csv", "/dev/stdout"];
    let ran = folder.run(&run, robot.as_bytes());
    assert!(ran.code == Some(0) && ran.out.lines().count() == 52, "{}", ran.err);
    // A closed pipe ends the run without an error.
    let run = ["simulate", "two_r.urdf", "--duration", "100000", "--csv", "-"];
    let mut child = folder.command(&run).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
    fs::remove_file(folder.path("null.svg")).unwrap();
    assert_eq!(folder.names(), before);
}

/// Runs it with a limit on the size of files, as on an almost full disk.
fn with_little_room(folder: &Folder, kilobytes: u32, arguments: &[&str]) -> RunOutput {
    // With the signal ignored the write fails, as on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f {kilobytes}; exec \"$@\"");
    let mut command = std::process::Command::new("bash");
    command.args(["-c", &script, "bash", env!("CARGO_BIN_EXE_dynamics")]).args(arguments);
    command.current_dir(folder.path(".")).stdin(Stdio::null());
    let output = command.output().unwrap();
    RunOutput {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// On a full disk, complete rows stay in a partial file beside the older file; the summary and the cause are
/// printed.
#[test]
fn a_full_disk_keeps_what_fits() {
    let folder = Folder::new("full_disk");
    folder.write("run.csv", b"older\n");
    let run = ["simulate", "panda.urdf", "--conservative", "--duration", "100", "--csv", "run.csv"];
    let ran = with_little_room(&folder, 64, &run);
    assert_eq!(ran.code, Some(1), "{}", ran.out);
    assert!(number_after(&ran.err, FAILED_TO_WRITE) > 0.0, "{}", ran.err);
    assert!(ran.err.contains("(os error 27)") && ran.err.contains(" run.partial.csv"), "{}", ran.err);
    assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    assert!(ran.out.contains(DRIFT), "{}", ran.out);
    assert_eq!(folder.read("run.csv"), "older\n");
    let kept = folder.read("run.partial.csv");
    assert!(kept.ends_with('\n') && kept.len() <= 64 * 1024, "{} bytes", kept.len());
    let cells: Vec<usize> = kept.lines().map(|line| line.split(',').count()).collect();
    assert!(cells.iter().all(|&cells| cells == 26), "every row is whole");
    let longest = kept.lines().map(str::len).max().unwrap();
    assert!(kept.len() + longest >= 64 * 1024, "the next row would not have fitted: {} bytes", kept.len());
    assert!(ran.out.contains(&format!("run.partial.csv ({} ", cells.len() - 1)), "{}", ran.out);
    assert!(folder.names().iter().all(|name| !name.contains("unfinished")), "{:?}", folder.names());
    let mut transcript = Transcript::default();
    transcript.add_without_numbers(&run, &RunOutput { out: String::new(), ..ran });
    transcript.compare("full_disk");
}

/// The last rows can fail at the end. A plot that does not fit leaves nothing, no file is completed, and the
/// table stays as a partial file.
#[test]
fn a_full_disk_at_the_end_is_an_error() {
    let folder = Folder::new("full_disk_at_the_end");
    let run = ["simulate", "two_r.urdf", "--duration", "0.03", "--csv", "run.csv"];
    let ran = with_little_room(&folder, 2, &run);
    assert!(ran.err.contains(" run.csv ") && ran.err.contains("(os error 27)"), "{}", ran.err);
    assert!(ran.code == Some(1) && ran.out.contains(DRIFT_OF_KINETIC), "{}", ran.out);
    assert!(folder.read("run.partial.csv").lines().count() > 5);
    assert!(!folder.names().contains(&"run.csv".to_owned()), "{:?}", folder.names());
    fs::remove_file(folder.path("run.partial.csv")).unwrap();

    let before = folder.names();
    let run = ["simulate", "two_r.urdf", "--duration", "0.01", "--csv", "run.csv"];
    for plot in ["run.svg", "run.png"] {
        let ran = with_little_room(&folder, 4, &[&run[..], &["--plot", plot]].concat());
        assert!(ran.err.contains(plot) && ran.err.contains(" run.partial.csv"), "{}", ran.err);
        assert!(ran.code == Some(1) && ran.out.contains("run.partial.csv (11 "), "{}", ran.out);
        assert_eq!(folder.read("run.partial.csv").lines().count(), 12);
        fs::remove_file(folder.path("run.partial.csv")).unwrap();
        assert_eq!(folder.names(), before, "{plot}");
    }
}

/// A full standard output is an error, and the files are complete.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_an_error() {
    let folder = Folder::new("full_standard_output");
    for csv in ["run.csv", "-"] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let run = ["simulate", "two_r.urdf", "--duration", "0.05", "--csv", csv];
        let output = folder.command(&run).stdout(full).spawn().unwrap().wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert!(err.contains("No space left on device") && output.status.code() == Some(1), "{csv}: {err}");
    }
    assert_eq!(folder.read("run.csv").lines().count(), 52);
}
