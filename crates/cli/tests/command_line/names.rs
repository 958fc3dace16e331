//! Names in a robot's file are data: in every output they are escaped, so that terminals, tables, pictures
//! and JSON readers show them as text.

use crate::command::Folder;

/// Two moving links whose names contain line breaks, control characters, direction marks, separators and
/// markup.
const HOSTILE: &str = "<robot name=\"a&#10;rm&#x9b;2J&#x202e;\">
  <link name=\"base&#10;note: all is well\"/>
  <link name=\"li,nk&#x2028;&quot;&lt;b>\"><inertial><origin xyz=\"1 0 0\"/><mass value=\"1\"/></inertial></link>
  <link name=\"tip&#x7f;&#13;\"><inertial><origin xyz=\"1 0 0\"/><mass value=\"1\"/></inertial></link>
  <joint name=\"hin&#10;ge&#x2066;,&quot;q&quot;\" type=\"revolute\"><parent link=\"base&#10;note: all is well\"/>
    <child link=\"li,nk&#x2028;&quot;&lt;b>\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"1\" effort=\"9\" velocity=\"0.1\"/></joint>
  <joint name=\"wri&#9;st&#x85;&lt;/text>\" type=\"continuous\"><parent link=\"li,nk&#x2028;&quot;&lt;b>\"/>
    <child link=\"tip&#x7f;&#13;\"/><origin xyz=\"1 0 0\"/><axis xyz=\"0 1 0\"/>
    <dynamics damping=\"0.1\" springStiffness=\"3\"/></joint>
</robot>";

/// Only visible characters and line ends.
#[track_caller]
fn assert_plain(what: &str, text: &str) {
    let is_odd = |letter: &char| {
        letter.is_control() && *letter != '\n'
            || matches!(letter, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}' | '\u{feff}')
    };
    assert_eq!(text.chars().find(is_odd), None, "{what}: {text:?}");
    let broken = text.lines().find(|line| {
        line.starts_with("note: all is well") || line.starts_with("rm") || line.starts_with("ge")
    });
    assert_eq!(broken, None, "a name breaks a line of {what}");
}

#[test]
fn every_command_prints_names_as_text() {
    let folder = Folder::new("names");
    folder.write("robot.urdf", HOSTILE.as_bytes());
    let state = "{\"q\":[0.1,0.2],\"v\":[0,0],\"a\":[0,0],\"tau\":[0,0]}\n";
    for (arguments, code) in [
        (&["inspect", "robot.urdf"][..], 0),
        (&["inspect", "robot.urdf", "--all"], 0),
        (&["inspect", "robot.urdf", "--json"], 0),
        (&["inspect", "robot.urdf", "--strict"], 1),
        (&["audit", "robot.urdf", "--states", "2"], 1),
        (&["audit", "robot.urdf", "--states", "2", "--json"], 1),
        (&["compute", "robot.urdf"], 0),
        (&["compute", "robot.urdf", "--terms", "frame_poses"], 0),
        (&["simulate", "robot.urdf", "--duration", "0.1"], 0),
        (&["simulate", "robot.urdf", "--duration", "0.1", "--hold"], 0),
        (&["simulate", "robot.urdf", "--duration", "0.1", "--pose", "el\u{9b}\nbow=1"], 1),
        (&["simulate", "robot.urdf", "--duration", "0.1", "--ground"], 1),
        (&["simulate", "robot.urdf", "--\u{1b}[2J\u{202e}"], 2),
        (&["convert", "robot.urdf", "there.xml"], 1),
        (&["inspect", "no\u{202e}\nbody.urdf"], 1),
        (&["bench", "robot.urdf", "--quick", "--states", "1024", "--threads", "1"], 0),
        (&["generate", "robot.urdf", "--target", "c", "--functions", "gravity", "-o", "code"], 0),
    ] {
        let ran = folder.run(arguments, state.as_bytes());
        assert_eq!(ran.code, Some(code), "{arguments:?}: {}{}", ran.out, ran.err);
        let what = format!("{arguments:?}");
        assert_plain(&what, &ran.out);
        assert_plain(&what, &ran.err);
        if code != 0 {
            assert!(ran.err.lines().count() <= 5, "{what}: {}", ran.err);
        }
    }
    for name in ["Makefile", "REPORT.md", "a_rm_2j_.c", "a_rm_2j_.h", "test_a_rm_2j_.c"] {
        let text = folder.read(&format!("code/{name}")).replace('\t', " ");
        assert_plain(name, &text);
    }
}

/// JSON contains the exact names, and so does a converted file, except for control characters.
#[test]
fn names_are_the_same_in_json_and_in_a_converted_file() {
    let folder = Folder::new("names_json");
    folder.write("robot.urdf", HOSTILE.as_bytes());
    let names = |file: &str| {
        let ran = folder.run(&["inspect", file, "--json"], b"");
        let inspected: serde_json::Value = serde_json::from_str(&ran.out).unwrap();
        let joints = inspected["joints"].as_array().unwrap().iter();
        joints.map(|joint| joint["name"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    let own = names("robot.urdf");
    assert_eq!(own, ["hin\nge\u{2066},\"q\"", "wri\tst\u{85}</text>"]);
    let controls = ["&#10;", "&#x7f;", "&#13;", "&#9;", "&#x85;", "&#x9b;"];
    let plain = controls.iter().fold(HOSTILE.to_owned(), |text, control| text.replace(control, "&#x200f;"));
    folder.write("plain.urdf", plain.as_bytes());
    let ran = folder.run(&["convert", "plain.urdf", "there.xml"], b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    // MJCF has one more fixed joint, between the world and the base.
    assert_eq!(names("there.xml")[1..], names("plain.urdf"));
    // The command line accepts the exact names.
    let pose = format!("{}=0.5", own[1]);
    let run = ["simulate", "robot.urdf", "--duration", "0.01", "--pose", pose.as_str()];
    assert_eq!(folder.run(&run, b"").code, Some(0));
}

/// Each row of the table is one line, and the picture is well-formed.
#[test]
fn tables_and_pictures_hold_names() {
    let folder = Folder::new("names_files");
    folder.write("robot.urdf", HOSTILE.as_bytes());
    let run = ["simulate", "robot.urdf", "--duration", "0.01", "--csv", "run.csv", "--plot", "run.svg"];
    let ran = folder.run(&run, b"");
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    let table = folder.read("run.csv");
    assert_plain("the table", &table);
    assert_eq!(table.lines().count(), 12);
    let head = table.lines().next().unwrap();
    assert!(head.contains(r#","q hin\nge\u{2066},""q"" [rad]","#), "{head}");
    let unquoted: String = head.split('"').step_by(2).collect();
    assert_eq!(unquoted.matches(',').count(), table.lines().last().unwrap().matches(',').count());
    let picture = folder.read("run.svg");
    assert_plain("the picture", &picture);
    let document = robot_dynamics_xml::roxmltree::Document::parse(&picture).unwrap();
    let texts: Vec<&str> = document.descendants().filter_map(|node| node.text()).map(str::trim).collect();
    assert!(texts.iter().any(|text| text.contains(r"wri\tst\u{85}</text>")), "{texts:?}");
}
