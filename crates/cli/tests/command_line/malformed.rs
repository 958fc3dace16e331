//! Wrong files and wrong states: each gives one line on standard error and an exit code of 1.

use crate::command::Folder;
use crate::messages::Transcript;

/// A pendulum, in which tests replace a text by a mistake.
pub(crate) const PENDULUM: &str = r#"<robot name="pendulum">
  <link name="ceiling"/>
  <link name="bob">
    <inertial>
      <mass value="2"/>
      <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>
    </inertial>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="ceiling"/>
    <child link="bob"/>
    <dynamics damping="0.1"/>
  </joint>
</robot>"#;

/// Texts of the pendulum with a mistake in their place; an empty text stands for the whole file.
const MISTAKES: &[(&str, &str)] = &[
    ("", ""),
    ("", "robot"),
    ("", "<sdf version=\"1.6\"/>"),
    ("value=\"2\"", "value=\"NaN\""),
    ("damping=\"0.1\"", "damping=\"low\""),
    ("type=\"continuous\"", "type=\"hinge\""),
    ("child link=\"bob\"", "child link=\"rod\""),
    ("child link=\"bob\"", "child link=\"ceiling\""),
];

/// All commands reject a malformed file with the same line.
#[test]
fn malformed_files() {
    let folder = Folder::new("malformed_files");
    let mut transcript = Transcript::default();
    for (index, (wanted, mistake)) in MISTAKES.iter().enumerate() {
        let text = if wanted.is_empty() { (*mistake).to_owned() } else { PENDULUM.replace(wanted, mistake) };
        assert!(text != PENDULUM, "case {index} changes nothing");
        folder.write("bad.urdf", text.as_bytes());
        let [first, others @ ..] = ["inspect", "compute", "simulate", "audit"]
            .map(|command| folder.run(&[command, "bad.urdf"], b""));
        assert_eq!((first.code, first.out.as_str()), (Some(1), ""), "case {index}");
        assert_eq!(first.err.lines().count(), 1, "case {index}: {}", first.err);
        for other in others {
            assert_eq!((other.code, other.out, other.err), (Some(1), String::new(), first.err.clone()));
        }
        transcript.add_text(&format!("# {wanted} -> {mistake}"));
        transcript.add_text(&first.err);
    }
    transcript.compare("malformed_files");
}

/// All errors of a file at once, one per line.
#[test]
fn all_errors_at_once() {
    let folder = Folder::new("all_errors_at_once");
    let text = PENDULUM.replace("value=\"2\"", "value=\"2,5\"").replace("link=\"bob\"", "link=\"rod\"");
    folder.write("bad.urdf", text.as_bytes());
    let mut transcript = Transcript::default();
    for command in ["inspect", "compute", "simulate", "audit"] {
        let ran = folder.run(&[command, "bad.urdf"], b"");
        assert_eq!((ran.code, ran.err.lines().count(), ran.out.as_str()), (Some(1), 3, ""), "{command}");
        let lines: Vec<&str> = ran.err.lines().collect();
        assert!(lines[1].starts_with("  line 5: ") && lines[2].starts_with("  line 9: "), "{}", ran.err);
        transcript.add(&[command, "bad.urdf"], &ran);
    }
    transcript.compare("several_errors");
}

/// Suspicious values are used as written, with a warning by every command.
#[test]
fn warnings_are_shown_by_every_command() {
    let folder = Folder::new("warnings_are_shown");
    let text = PENDULUM.replace("izz=\"1\"", "izz=\"5\"").replace(" name=\"pendulum\"", "");
    folder.write("odd.urdf", text.as_bytes());
    let state = b"{\"q\":[0.1],\"v\":[0],\"tau\":[0]}";
    let mut transcript = Transcript::default();
    for command in ["compute", "simulate", "audit"] {
        let ran = folder.run(&[command, "odd.urdf"], state);
        let lines: Vec<&str> =
            ran.err.lines().filter(|line| line.starts_with("warning: odd.urdf: line ")).collect();
        assert_eq!(lines.len(), 2, "{command}: {}", ran.err);
        transcript.add_text(&lines.join("\n"));
    }
    let listed = folder.run(&["inspect", "odd.urdf"], b"");
    assert_eq!((listed.code, listed.err.as_str()), (Some(0), ""));
    assert_eq!(listed.out.matches("  warning: line ").count(), 2, "{}", listed.out);
    // The repair shows the old and the new moments.
    let repaired = folder.run(&["inspect", "odd.urdf", "--repair-inertia"], b"");
    assert!(repaired.out.contains("1, 1, 5 → 1, 1, 2 kg·m²"), "{}", repaired.out);
    let strict = folder.run(&["inspect", "odd.urdf", "--strict"], b"");
    assert_eq!((strict.code, strict.err.lines().count()), (Some(1), 3), "{}", strict.err);
    transcript.add(&["inspect", "odd.urdf", "--strict"], &strict);
    transcript.compare("warnings");
}

/// Six joints with two unknown attributes each are two warnings, and `inspect` lists all twelve.
#[test]
fn warnings_of_one_kind_are_one_line() {
    let folder = Folder::new("grouped_warnings");
    let joint = |k: usize| {
        format!(
            "<link name=\"l{k}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" \
             iyz=\"0\"/></inertial></link><joint name=\"j{k}\" type=\"continuous\"><parent link=\"l{}\"/><child \
             link=\"l{k}\"/><axis xyz=\"1 0 0\"/><dynamics bound{k}=\"0\" stiff=\"{k}.5\"/></joint>\n",
            k - 1
        )
    };
    let text = format!(
        "<robot name=\"chain\"><link name=\"l0\"/>\n{}",
        (1..=6).map(joint).collect::<Vec<_>>().concat()
    );
    folder.write("chain.urdf", (text + "</robot>").as_bytes());
    let ran = folder.run(&["compute", "chain.urdf"], b"{\"q\":[0,0,0,0,0,0]}");
    let lines: Vec<&str> = ran.err.lines().filter(|line| line.contains("stiff")).collect();
    assert_eq!(lines.len(), 1, "{}", ran.err);
    let mut transcript = Transcript::default();
    transcript.add_text(lines[0]);
    transcript.compare("grouped_warnings");
    // A digit within a name makes another kind.
    assert_eq!(ran.err.lines().filter(|line| line.contains(" bound")).count(), 6, "{}", ran.err);
    let listed = folder.run(&["inspect", "chain.urdf"], b"");
    assert_eq!(listed.out.matches(" stiff=").count(), 6, "{}", listed.out);
}

/// --floating-base has no effect on a robot with a floating root, and gives a note.
#[test]
fn a_floating_root_gets_no_second_floating_joint() {
    let folder = Folder::new("a_floating_root");
    let text = PENDULUM.replace("\"continuous\"", "\"floating\"");
    folder.write("free.urdf", text.as_bytes());
    let plain = folder.run(&["inspect", "free.urdf"], b"");
    let freed = folder.run(&["inspect", "free.urdf", "--floating-base"], b"");
    assert_eq!((plain.code, freed.code), (Some(0), Some(0)));
    assert_eq!(plain.out.lines().next(), freed.out.lines().next());
    assert!(freed.err.starts_with("note: ") && freed.err.lines().count() == 1, "{}", freed.err);
}

/// Invalid lines for `compute`.
const STATES: [&str; 14] = [
    "hello",
    "[[0,0],[0,0]]",
    "{\"q\":[0,0],\"v\":[0,0]",
    "{\"q\":[0,0]}",
    "{\"q\":[0,null],\"v\":[0,0]}",
    "{\"q\":[0,NaN],\"v\":[0,0]}",
    "{\"q\":[0,1e999],\"v\":[0,0]}",
    "{\"q\":[0,0],\"v\":[0,0],\"u\":[0,0]}",
    "{\"q\":[0],\"v\":[0,0]}",
    "{\"q\":[0,0],\"v\":[0,0,0]}",
    "{\"q\":[0,0],\"v\":[0,0],\"a\":[]}",
    "{\"q\":[0,0],\"v\":[0,0],\"tau\":[1]}",
    "{\"q\":[0,1],\"v\":[1e200,0]}",
    "{\"q\":[0,1],\"v\":[0,0],\"a\":[0,1e309]}",
];

/// Each gives an error object, and later lines are read.
#[test]
fn malformed_states() {
    let folder = Folder::new("malformed_states");
    let mut transcript = Transcript::default();
    let mut summary = None;
    for line in STATES {
        // The lines before and after it are valid, and an empty line counts.
        let good = "{\"q\":[0,0],\"v\":[0,0]}";
        let ran = folder.run(&["compute", "two_r.urdf"], format!("{good}\n\n{line}\n{good}\n").as_bytes());
        let answers: Vec<serde_json::Value> =
            ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!(answers.len(), 3, "{line}");
        assert_eq!((answers[1]["error"].is_string(), &answers[1]["line"]), (true, &3.into()), "{line}");
        assert!(answers[0]["gravity"].is_array() && answers[0] == answers[2], "{line}");
        assert_eq!(ran.code, Some(1), "{line}");
        transcript.add_text(&format!("{line}\n  {}", answers[1]["error"].as_str().unwrap()));
        assert_eq!(summary.get_or_insert_with(|| ran.err.clone()), &ran.err, "{line}");
    }
    transcript.add_text(&summary.unwrap());
    transcript.compare("malformed_states");
}

/// A quaternion far from unit length is an error.
#[test]
fn quaternions_of_compute_have_unit_length() {
    let folder = Folder::new("quaternions");
    folder.write("stone.urdf", PENDULUM.replace("continuous", "fixed").as_bytes());
    let state = "{\"q\":[0,0,0,0,0,0,0],\"v\":[0,0,0,0,0,0]}\n";
    let ran = folder.run(&["compute", "stone.urdf", "--floating-base"], state.as_bytes());
    assert_eq!(ran.code, Some(1));
    let answer: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
    let mut transcript = Transcript::default();
    transcript.add_text(answer["error"].as_str().unwrap());
    transcript.compare("quaternion");
}

/// Input without states is not an error, and no input causes a panic.
#[test]
fn empty_and_hostile_input() {
    let folder = Folder::new("hostile_input");
    assert_eq!(folder.output(&["compute", "two_r.urdf"], ""), "");
    assert_eq!(folder.output(&["compute", "two_r.urdf"], "\n  \n"), "");
    let deep = "[".repeat(100_000);
    let long = format!("{{\"q\":[{}0]}}", "0,".repeat(100_000));
    for bytes in [&b"\xff\xfe{\x00}"[..], b"\0\0\0", deep.as_bytes(), long.as_bytes()] {
        let ran = folder.run(&["compute", "two_r.urdf"], bytes);
        assert_eq!(ran.code, Some(1));
        assert!(ran.out.starts_with("{\"error\":") && ran.out.lines().count() == 1, "{}", ran.out);
    }
}
