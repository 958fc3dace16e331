//! `dynamics generate`.

use std::process::Command;

use crate::command::Folder;

/// The folder contains code, test, Makefile and report. The test passes, and the same command gives the same
/// bytes.
#[test]
fn code_for_one_robot_passes_the_test_that_comes_with_it() {
    let folder = Folder::new("generate");
    let arguments = |output| {
        let functions = "inverse_dynamics,mass_matrix,frame_pose:tip";
        ["generate", "two_r.urdf", "--target", "c", "--functions", functions, "-o", output]
    };
    let ran = folder.run(&arguments("code"), b"");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    assert_eq!(std::fs::read_dir(folder.path("code")).unwrap().count(), 5);
    let made = Command::new("make").current_dir(folder.path("code")).output().unwrap();
    assert!(made.status.success(), "{made:?}");
    let header = folder.read("code/two_r.h");
    let command =
        "dynamics generate two_r.urdf --target c --functions inverse_dynamics,mass_matrix,frame_pose:tip\n";
    assert!(header.contains(command), "{header}");
    assert_eq!(folder.run(&arguments("again"), b"").code, Some(0));
    for name in ["two_r.c", "two_r.h", "test_two_r.c", "Makefile", "REPORT.md"] {
        assert_eq!(folder.read(&format!("code/{name}")), folder.read(&format!("again/{name}")), "{name}");
    }
}

/// A function that cannot be generated is named in one line, and no file is written.
#[test]
fn unknown_functions_are_refused_by_name() {
    let folder = Folder::new("generate_refused");
    for (functions, cause) in [
        ("inverse_dynamic", "`inverse_dynamic`"),
        ("frame_pose:hand", "`hand`"),
        ("gravity,gravity", "`gravity`"),
    ] {
        let ran = folder.run(
            &["generate", "two_r.urdf", "--target", "rust", "--functions", functions, "-o", "code"],
            b"",
        );
        assert!(ran.code != Some(0) && ran.err.contains(cause) && ran.err.lines().count() == 1, "{ran:?}");
        assert!(!folder.path("code").exists());
    }
}

/// `--lanes` adds functions for several states, and the files name it in their command. Only Rust supports
/// it.
#[test]
fn lanes_are_for_rust() {
    let folder = Folder::new("generate_lanes");
    let arguments = |target| ["generate", "two_r.urdf", "--target", target, "--lanes", "-o", "code"];
    let ran = folder.run(&arguments("c"), b"");
    assert!(ran.code == Some(1) && ran.err.lines().count() == 1, "{ran:?}");
    assert!(!folder.path("code").exists());
    let ran = folder.run(&arguments("rust"), b"");
    assert_eq!(ran.code, Some(0), "{ran:?}");
    let (code, manifest) = (folder.read("code/src/two_r.rs"), folder.read("code/Cargo.toml"));
    assert!(code.contains("pub mod lanes {") && code.contains(" --lanes\n"), "{code}");
    assert!(manifest.contains("[dependencies]\nrobot-dynamics-number = "), "{manifest}");
}

/// The shader of the lab's map of flips equals a newly generated one.
#[test]
fn the_labs_shader_is_up_to_date() {
    let folder = Folder::new("generate_lab");
    let options = ["--target", "wgsl", "--single", "--functions", "rk4_step", "--name", "arm", "-o", "code"];
    let arguments: Vec<&str> = ["generate", "two_r.urdf"].into_iter().chain(options).collect();
    assert_eq!(folder.run(&arguments, b"").code, Some(0));
    let kept = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lab/src/flips/arm_rk4_step.wgsl");
    let (kept, now) = (std::fs::read_to_string(kept).unwrap(), folder.read("code/arm_rk4_step.wgsl"));
    assert!(kept == now, "copy what this writes to lab/src/flips: dynamics {}", arguments.join(" "));
}

/// Files that were not generated are not replaced.
#[test]
fn no_file_of_another_kind_is_replaced() {
    let folder = Folder::new("generate_foreign");
    folder.write("two_r.c", b"int mine;\n");
    let ran = folder.run(&["generate", "two_r.urdf", "--target", "c", "-o", "."], b"");
    assert_eq!(ran.code, Some(1));
    assert!(ran.err.contains("two_r.c`"), "{ran:?}");
    assert_eq!(folder.read("two_r.c"), "int mine;\n");
    assert!(!folder.path("two_r.h").exists());
}
