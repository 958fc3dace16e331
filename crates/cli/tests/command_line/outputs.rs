//! What is written where: nothing over an input, nothing half, nothing lost.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::process::Stdio;

use crate::command::{Folder, Ran};

/// A short run with these further arguments.
fn simulate(folder: &Folder, robot: &str, arguments: &[&str]) -> Ran {
    folder.run(&[&["simulate", robot, "--duration", "0.05"], arguments].concat(), b"")
}

#[track_caller]
fn assert_refused(folder: &Folder, robot: &str, arguments: &[&str], message: &str) {
    let before = folder.names();
    let ran = simulate(folder, robot, arguments);
    assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{arguments:?}: {}", ran.err);
    assert_eq!(ran.err, format!("error: {message}\n"), "{arguments:?}");
    assert_eq!(folder.names(), before, "{arguments:?}");
}

/// By whatever name: the path itself, a way round, a symbolic or a hard link, a link to the folder, a file that only a
/// run that ends early would leave.
#[test]
fn no_output_replaces_the_robot() {
    let folder = Folder::new("over_the_robot");
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
        let message =
            format!("--csv {name} is the same file as the robot's file, two_r.urdf; name another file");
        assert_refused(&folder, "two_r.urdf", &["--csv", name], &message);
    }
    // The robot by its link, the output by its own name, and a picture.
    let message = "--csv two_r.urdf is the same file as the robot's file, link.csv; name another file";
    assert_refused(&folder, "link.csv", &["--csv", "two_r.urdf"], message);
    let message = "--plot link.svg is the same file as the robot's file, two_r.urdf; name another file";
    assert_refused(&folder, "two_r.urdf", &["--plot", "link.svg"], message);
    fs::copy(folder.path("two_r.urdf"), folder.path("arm.partial.csv")).unwrap();
    let message = "--csv arm.csv would be kept as arm.partial.csv if the run ended early, and that is the robot's \
                   file, arm.partial.csv; name another file";
    assert_refused(&folder, "arm.partial.csv", &["--csv", "arm.csv"], message);
    assert_eq!(folder.read("two_r.urdf"), robot);
    assert_eq!(folder.read("arm.partial.csv"), robot);
}

/// Two outputs are two files, also those to come: through a link that leads nowhere yet, and where capitals make no
/// difference.
#[test]
fn no_output_replaces_another() {
    let folder = Folder::new("over_another");
    symlink("to_come.svg", folder.path("ahead.csv")).unwrap();
    for (csv, plot) in [
        ("run.svg", "run.svg"),
        ("./run.svg", "run.svg"),
        ("ahead.csv", "to_come.svg"),
        ("RUN.svg", "run.svg"),
    ] {
        let message = format!("--plot {plot} is the same file as --csv, {csv}; name another file");
        assert_refused(&folder, "two_r.urdf", &["--csv", csv, "--plot", plot], &message);
    }
    let message = "--plot run.svg would be kept as run.partial.svg if the run ended early, and that is --csv, \
                   run.partial.svg; name another file";
    assert_refused(&folder, "two_r.urdf", &["--csv", "run.partial.svg", "--plot", "run.svg"], message);
    let message = "cannot write inner/: it has no file name";
    assert_refused(&folder, "two_r.urdf", &["--csv", "inner/"], message);
    let message = "cannot write none/run.csv: No such file or directory (os error 2)";
    assert_refused(&folder, "two_r.urdf", &["--csv", "none/run.csv"], message);
    symlink("round.csv", folder.path("round.csv")).unwrap();
    let message = "cannot write round.csv: too many links, one leading to the other";
    assert_refused(&folder, "two_r.urdf", &["--csv", "round.csv"], message);
}

/// A file that is replaced keeps who may read it; a link to it stays a link.
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

/// The table on standard output, the summary out of its way; devices take what they are given, twice if need be.
#[test]
fn streams_are_written_as_they_are() {
    let folder = Folder::new("streams");
    let before = folder.names();
    for name in ["-", "/dev/stdout"] {
        let ran = simulate(&folder, "two_r.urdf", &["--csv", name]);
        assert_eq!(ran.code, Some(0), "{}", ran.err);
        assert!(ran.out.starts_with("t [s],") && ran.out.lines().count() == 52, "{}", ran.out);
        assert!(
            ran.err.starts_with("two_r (two_r.urdf): ") && ran.err.contains("standard output (51 samples)")
        );
    }
    symlink("/dev/null", folder.path("null.svg")).unwrap();
    let ran = simulate(&folder, "two_r.urdf", &["--csv", "/dev/null", "--plot", "null.svg"]);
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""), "{}", ran.out);
    assert!(ran.out.contains("wrote /dev/null (51 samples)"), "{}", ran.out);
    // The robot from a stream: the table may go to one as well.
    let robot = folder.read("two_r.urdf");
    let run = ["simulate", "/dev/stdin", "--duration", "0.05", "--csv", "/dev/stdout"];
    let ran = folder.run(&run, robot.as_bytes());
    assert!(ran.code == Some(0) && ran.out.lines().count() == 52, "{}", ran.err);
    // A reader that has seen enough ends the run, and is no failure.
    let run = ["simulate", "two_r.urdf", "--duration", "100000", "--csv", "-"];
    let mut child = folder.command(&run).spawn().unwrap();
    drop(child.stdout.take());
    let output = child.wait_with_output().unwrap();
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
    fs::remove_file(folder.path("null.svg")).unwrap();
    assert_eq!(folder.names(), before);
}

/// Runs it where no file may grow beyond so many kilobytes, as on a disk that is nearly full.
fn with_little_room(folder: &Folder, kilobytes: u32, arguments: &[&str]) -> Ran {
    // The signal is ignored, so that the write fails, as it does when a disk is full.
    let script = format!("trap '' XFSZ; ulimit -f {kilobytes}; exec \"$@\"");
    let mut command = std::process::Command::new("bash");
    command.args(["-c", &script, "bash", env!("CARGO_BIN_EXE_dynamics")]).args(arguments);
    command.current_dir(folder.path(".")).stdin(Stdio::null());
    let output = command.output().unwrap();
    Ran {
        code: output.status.code(),
        out: String::from_utf8(output.stdout).unwrap(),
        err: String::from_utf8(output.stderr).unwrap(),
    }
}

/// Whole rows up to where the disk was full, beside the older file, which stays; the summary; and the cause.
#[test]
fn a_full_disk_keeps_what_fits() {
    let folder = Folder::new("full_disk");
    folder.write("run.csv", b"older\n");
    let run = ["simulate", "panda.urdf", "--conservative", "--duration", "100", "--csv", "run.csv"];
    let ran = with_little_room(&folder, 64, &run);
    assert_eq!(ran.code, Some(1), "{}", ran.out);
    assert!(ran.err.starts_with("error: cannot write run.csv from t = 0."), "{}", ran.err);
    assert!(ran.err.contains(" s on: File too large (os error 27); kept up to there: "), "{}", ran.err);
    assert!(ran.err.ends_with(" run.partial.csv\n") && ran.err.lines().count() == 1, "{}", ran.err);
    assert!(ran.out.contains("energy drift, max |E − E0| / |E0|: "), "{}", ran.out);
    assert_eq!(folder.read("run.csv"), "older\n");
    let kept = folder.read("run.partial.csv");
    assert!(kept.ends_with('\n') && kept.len() <= 64 * 1024, "{} bytes", kept.len());
    let cells: Vec<usize> = kept.lines().map(|line| line.split(',').count()).collect();
    assert!(cells.iter().all(|&cells| cells == 26), "every row is whole");
    let longest = kept.lines().map(str::len).max().unwrap();
    assert!(kept.len() + longest >= 64 * 1024, "the next row would not have fitted: {} bytes", kept.len());
    assert!(ran.out.contains(&format!("wrote run.partial.csv ({} samples)", cells.len() - 1)), "{}", ran.out);
    assert!(folder.names().iter().all(|name| !name.contains("unfinished")), "{:?}", folder.names());
}

/// The last rows may fail as well, when the file is closed. A picture that does not fit leaves nothing; then no file is in its
/// place, and the complete table is kept beside it.
#[test]
fn a_full_disk_at_the_end_is_seen() {
    let folder = Folder::new("full_disk_at_the_end");
    let run = ["simulate", "two_r.urdf", "--duration", "0.03", "--csv", "run.csv"];
    let ran = with_little_room(&folder, 2, &run);
    assert!(ran.err.starts_with("error: cannot write run.csv to its end: File too large"), "{}", ran.err);
    assert!(ran.code == Some(1) && ran.out.contains("energy drift"), "{}", ran.out);
    assert!(folder.read("run.partial.csv").lines().count() > 5);
    assert!(!folder.names().contains(&"run.csv".to_owned()), "{:?}", folder.names());
    fs::remove_file(folder.path("run.partial.csv")).unwrap();

    let before = folder.names();
    let run = ["simulate", "two_r.urdf", "--duration", "0.01", "--csv", "run.csv"];
    for plot in ["run.svg", "run.png"] {
        let ran = with_little_room(&folder, 4, &[&run[..], &["--plot", plot]].concat());
        let cause = "File too large (os error 27); kept up to there: run.partial.csv";
        assert_eq!(ran.err, format!("error: cannot draw {plot}: {cause}\n"));
        assert!(ran.code == Some(1) && ran.out.contains("run.partial.csv (11 samples)"), "{}", ran.out);
        assert_eq!(folder.read("run.partial.csv").lines().count(), 12);
        fs::remove_file(folder.path("run.partial.csv")).unwrap();
        assert_eq!(folder.names(), before, "{plot}");
    }
}

/// Standard output on a full disk is a failure, too, and the files are in their places.
#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_said() {
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
