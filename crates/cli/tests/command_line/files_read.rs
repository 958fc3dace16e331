//! Outputs never replace files that the run has read, by any path or link. Several outputs are all written,
//! or none.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::symlink;
use std::process::{Command, Stdio};

use crate::command::{Folder, RunOutput};

const MAIN: &str = r#"<mujoco model="arm">
  <asset>
    <model name="child" file="parts/child.xml"/>
    <mesh name="block" file="block.obj"/>
    <hfield name="hills" file="hills.bin" size="2 2 1 0.1"/>
  </asset>
  <worldbody>
    <include file="parts/upper.xml"/>
    <geom type="hfield" hfield="hills" pos="0 0 -5"/>
    <body name="block"><joint name="hinge" axis="0 1 0"/><geom type="mesh" mesh="block"/></body>
    <attach model="child" prefix="child_"/>
  </worldbody>
</mujoco>"#;
const UPPER: &str = r#"<mujocoinclude>
  <body name="upper"><joint name="swing" axis="0 1 0"/><geom size="0.1" pos="0.5 0 0"/></body>
</mujocoinclude>"#;
const CHILD: &str = r#"<mujoco><worldbody>
  <body name="tail"><joint name="wag" axis="0 1 0"/><geom size="0.1" pos="0.3 0 1"/></body>
</worldbody></mujoco>"#;
const BLOCK: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const READ: [&str; 5] = ["main.xml", "parts/upper.xml", "parts/child.xml", "block.obj", "hills.bin"];

/// A model of five files.
fn folder(name: &str) -> Folder {
    let folder = Folder::new(name);
    fs::create_dir(folder.path("parts")).unwrap();
    folder.write("main.xml", MAIN.as_bytes());
    folder.write("parts/upper.xml", UPPER.as_bytes());
    folder.write("parts/child.xml", CHILD.as_bytes());
    folder.write("block.obj", BLOCK.as_bytes());
    let sizes = [2_i32, 2].map(i32::to_le_bytes).concat();
    let heights = [0.0_f32, 1.0, 0.5, 0.25].map(f32::to_le_bytes).concat();
    folder.write("hills.bin", &[sizes, heights].concat());
    folder
}

fn contents(folder: &Folder) -> Vec<Vec<u8>> {
    READ.map(|name| fs::read(folder.path(name)).unwrap()).to_vec()
}

#[track_caller]
fn assert_refused(ran: &RunOutput, role: &str, name: &str, file: &str) {
    assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{name}: {}", ran.err);
    let named =
        ran.err.starts_with(&format!("error: {role} {name} ")) && ran.err.contains(&format!(", {file};"));
    assert!(named && ran.err.lines().count() == 1, "{name}: {}", ran.err);
}

/// The files are the main file, an included one, an attached model, a mesh and a height field. Outputs name
/// them by paths, detours, and links to the file or its folder.
#[test]
fn no_file_that_was_read_is_replaced() {
    let folder = folder("files_read");
    symlink("parts", folder.path("other")).unwrap();
    let before = contents(&folder);
    for file in READ {
        let own = folder.path(file);
        let mut names = vec![file.to_owned(), format!("./parts/../{file}"), own.to_str().unwrap().to_owned()];
        if let Some(inner) = file.strip_prefix("parts/") {
            names.push(format!("other/{inner}"));
        }
        for (link, by) in [("symbolic.xml", true), ("hard.xml", false)] {
            let _ = fs::remove_file(folder.path(link));
            if by { symlink(&own, folder.path(link)) } else { fs::hard_link(&own, folder.path(link)) }
                .unwrap();
            names.push(link.to_owned());
        }
        for name in &names {
            let run = ["simulate", "main.xml", "--duration", "0.01", "--csv", name.as_str()];
            assert_refused(&folder.run(&run, b""), "--csv", name, file);
            let ran = folder.run(&["convert", "main.xml", name, "--to", "urdf"], b"");
            assert_refused(&ran, "the output", name, file);
        }
        // Opened for appending by the shell, under a descriptor's path.
        let script = "exec \"$0\" simulate main.xml --duration 0.01 --csv /dev/fd/7 7>>\"$1\"";
        let mut command = Command::new("bash");
        command.args(["-c", script, env!("CARGO_BIN_EXE_dynamics"), file]).current_dir(folder.path("."));
        let output = command.output().unwrap();
        let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
        assert_refused(&RunOutput { code: output.status.code(), out, err }, "--csv", "/dev/fd/7", file);
    }
    for name in ["plot.svg", "arm.c"] {
        symlink("parts/upper.xml", folder.path(name)).unwrap();
    }
    let ran = folder.run(&["simulate", "main.xml", "--duration", "0.01", "--plot", "plot.svg"], b"");
    assert_refused(&ran, "--plot", "plot.svg", "parts/upper.xml");
    let ran =
        folder.run(&["generate", "main.xml", "--target", "c", "--functions", "gravity", "-o", "."], b"");
    assert_refused(&ran, "the output", "./arm.c", "parts/upper.xml");
    // One of its own files would replace another.
    fs::remove_file(folder.path("arm.c")).unwrap();
    symlink("arm.c", folder.path("arm.h")).unwrap();
    let ran =
        folder.run(&["generate", "main.xml", "--target", "c", "--functions", "gravity", "-o", "."], b"");
    assert_refused(&ran, "the output", "./arm.h", "./arm.c");
    assert_eq!(contents(&folder), before);
    assert!(!folder.names().iter().any(|name| name == "Makefile" || name == "REPORT.md"));
    // A path that was not read is allowed.
    assert_eq!(folder.run(&["convert", "main.xml", "parts/new.urdf"], b"").code, Some(0));
}

/// A URDF file's meshes belong to it, although they are not opened for reading it.
#[test]
fn meshes_of_urdf_are_its_files() {
    let folder = folder("files_read_urdf");
    let text = folder.read("two_r.urdf");
    let visual = "<visual><geometry><mesh filename=\"block.obj\"/></geometry></visual></link>";
    folder.write("arm.urdf", text.replacen("</link>", visual, 1).as_bytes());
    let ran = folder.run(&["convert", "arm.urdf", "block.obj", "--to", "mjcf"], b"");
    assert_refused(&ran, "the output", "block.obj", "block.obj");
    assert_eq!(folder.read("block.obj"), BLOCK);
}

/// The robot comes on standard input from a file that the shell opened.
#[test]
fn a_redirected_robot_is_a_file_that_was_read() {
    let folder = folder("files_read_redirected");
    let robot = folder.read("two_r.urdf");
    let input = fs::File::open(folder.path("two_r.urdf")).unwrap();
    let run = ["simulate", "/dev/stdin", "--duration", "0.01", "--csv", "two_r.urdf"];
    let output = folder.command(&run).stdin(input).spawn().unwrap().wait_with_output().unwrap();
    let err = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(1), "{err}");
    assert!(err.contains("--csv two_r.urdf ") && err.contains(", /dev/stdin;"), "{err}");
    assert_eq!(folder.read("two_r.urdf"), robot);
}

/// If one of several files cannot be written, none is, and no folder remains.
#[test]
fn a_command_writes_all_of_its_files_or_none() {
    let folder = folder("all_or_none");
    let generate = |folder: &Folder, output: &str| {
        let functions = "mass_matrix,gravity";
        let run = ["generate", "two_r.urdf", "--target", "c", "--functions", functions, "-o", output];
        folder.run(&run, b"")
    };
    // One file of an older set cannot be replaced, so the others stay unchanged.
    assert_eq!(generate(&folder, "code").code, Some(0));
    let older = folder.read("code/two_r.c") + "// older\n";
    folder.write("code/two_r.c", older.as_bytes());
    fs::remove_file(folder.path("code/two_r.h")).unwrap();
    fs::create_dir(folder.path("code/two_r.h")).unwrap();
    let ran = generate(&folder, "code");
    assert!(ran.code == Some(1) && ran.err.contains("two_r.h"), "{}", ran.err);
    assert_eq!(folder.read("code/two_r.c"), older);
    // Limits files to four kilobytes, as on an almost full disk.
    for arguments in
        [&["generate", "panda.urdf", "--target", "c", "-o", "new/inner"][..], &["man", "--output", "pages"]]
    {
        let before = folder.names();
        let mut command = Command::new("bash");
        command.args([
            "-c",
            "trap '' XFSZ; ulimit -f 4; exec \"$@\"",
            "bash",
            env!("CARGO_BIN_EXE_dynamics"),
        ]);
        let output = command.args(arguments).current_dir(folder.path(".")).stdin(Stdio::null()).output();
        let ran = output.unwrap();
        let err = String::from_utf8(ran.stderr).unwrap();
        assert!(ran.status.code() == Some(1) && err.contains("File too large"), "{arguments:?}: {err}");
        assert_eq!(folder.names(), before, "{arguments:?}");
    }
    let names: Vec<_> =
        fs::read_dir(folder.path("code")).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert!(names.iter().all(|name| !name.to_string_lossy().starts_with('.')), "{names:?}");
}
