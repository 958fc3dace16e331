//! `simulate --ground`: a robot falls, lands and stays; and options that need ground.

use crate::command::Folder;
use crate::labels::{BELOW_GROUND, DEEPEST, TOTAL_FORCE, number_after, number_before};

/// A quadruped falls and comes to rest on the ground, which carries its weight, without creep for seconds.
#[test]
fn a_quadruped_falls_and_stays() {
    let folder = Folder::new("falls");
    let run = [
        "simulate",
        "quadruped.urdf",
        "--floating-base",
        "--ground",
        "--duration",
        "4",
        "--csv",
        "run.csv",
        "--plot",
        "run.svg",
    ];
    let text = folder.output(&run, "");
    // Nothing sinks, even during the fall: penetration after a step is corrected up to rounding.
    assert!(number_after(&text, DEEPEST) < 1e-9, "{text}");
    let together = text.lines().find(|line| line.contains(TOTAL_FORCE)).unwrap();
    let carried: f64 = together.split_whitespace().next_back().unwrap().parse().unwrap();
    assert!((carried - 19.9 * 9.81).abs() < 0.1, "{together}");
    let svg = folder.read("run.svg");
    assert!(svg.contains("front_left_foot"), "a line for the ground's force");
    let table = folder.read("run.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
    let (height, foot) = (column("q floating_base.z [m]"), column("contact front_left_foot.z [N]"));
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    let last = rows.len() - 1;
    // Losses only grow.
    for cause in ["damping", "friction", "stops", "sliding", "impacts"] {
        let column = column(&format!("{cause} took out [J]"));
        assert!((1..=last).all(|row| row == 1 || number(row, column) >= number(row - 1, column)), "{cause}");
        assert!(number(last, column) > 0.0, "{cause}");
    }
    // The robot starts 0.1 m above the ground, and in the last second it does not move visibly.
    assert!(number(1, height) - number(last, height) > 0.1);
    assert!((number(last, height) - number(last - 1000, height)).abs() < 1e-9);
    assert!(number(1, foot) == 0.0 && (1..=last).any(|row| number(row, foot) > 1.0));
}

/// Links make contact with each other, unless that is switched off.
#[test]
fn links_touch_each_other() {
    let folder = Folder::new("links");
    let balls = r#"<mujoco><worldbody>
        <body name="low" pos="0 0 0.1"><freejoint/><geom type="sphere" size="0.1" mass="1"/></body>
        <body name="high" pos="0 0 0.35"><freejoint/><geom type="sphere" size="0.1" mass="1"/></body>
        </worldbody>
        <keyframe><key name="apart" qpos="0 0 0.1 1 0 0 0 0 0 0.35 1 0 0 0"/></keyframe></mujoco>"#;
    folder.write("balls.xml", balls.as_bytes());
    let height = |flag: &[&str]| {
        let run =
            ["simulate", "balls.xml", "--ground", "--pose", "apart", "--duration", "1", "--csv", "run.csv"];
        let text = folder.output(&[&run[..], flag].concat(), "");
        let table = folder.read("run.csv");
        let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
        let heights =
            (0..rows[0].len()).filter(|k| rows[0][*k].ends_with(".z [m]") && rows[0][*k].starts_with("q "));
        let end = heights.map(|k| rows[rows.len() - 1][k].parse::<f64>().unwrap());
        (text.contains("\n  links "), end.fold(0.0, f64::max))
    };
    let (lists_pairs, apart) = height(&["--without", "link-contacts"]);
    assert!((apart - 0.1).abs() < 1e-6 && !lists_pairs, "{apart}"); // one inside the other
    let (lists_pairs, on_top) = height(&[]);
    assert!(lists_pairs && (on_top - 0.3).abs() < 1e-6, "{on_top}");
}

/// A slope with sufficient and with insufficient friction; a robot placed on it.
#[test]
fn slopes_and_friction() {
    let folder = Folder::new("slope");
    let run = |friction: &str| {
        let run =
            ["simulate", "quadruped.urdf", "--floating-base", "--standing", "--ground", "slope=0.2,z=1"];
        folder.output(&[&run[..], &["--friction", friction, "--duration", "3"]].concat(), "")
    };
    let holds = run("1.5");
    let slides = run("0.01");
    let end = |text: &str| -> f64 {
        let row = text.lines().find(|line| line.contains("floating_base.x")).unwrap();
        row.split_whitespace().nth(3).unwrap().parse().unwrap()
    };
    // Without friction for 3 s: ½ g sin α cos α t² = 8.6 m downhill.
    assert!(end(&holds) > -0.5 && end(&slides) < -5.0, "{} {}", end(&holds), end(&slides));
    assert!(number_before(&slides, " steps/s") > 0.0);
}

/// Options without their ground are rejected with one line.
#[test]
fn options_that_need_ground_are_rejected() {
    let folder = Folder::new("no_ground");
    let robot = &["simulate", "quadruped.urdf", "--floating-base"][..];
    for (arguments, code) in [
        (&["--friction", "1"][..], 1),
        (&["--standing"], 1),
        (&["--ground", "--integrator", "rk4"], 1),
        (&["--ground", "file"], 1),
        (&["--ground", "x=1"], 2),
        (&["--ground", "z=high"], 2),
        (&["--ground", "slope=2"], 2),
        (&["--ground", "--friction", "-1"], 2),
    ] {
        let ran = folder.run(&[robot, arguments].concat(), b"");
        assert_eq!((ran.code, ran.err.lines().count()), (Some(code), 1), "{arguments:?}: {}", ran.err);
    }
    for arguments in [&["panda.urdf", "--ground"][..], &["quadruped.urdf", "--ground", "--standing"]] {
        let ran = folder.run(&[&["simulate"], arguments].concat(), b"");
        assert_eq!((ran.code, ran.err.lines().count()), (Some(1), 1), "{arguments:?}: {}", ran.err);
    }
}

/// A ball above the height field of its file comes to rest at the bottom of the bowl.
#[test]
fn a_ball_rests_in_the_bowl_of_its_file() {
    let folder = Folder::new("bowl");
    let bowl = "<mujoco><asset><hfield name='bowl' size='1 1 0.5 0.1' nrow='3' ncol='3' elevation='1 1 1 1 0 1 1 1 1'/></asset>
        <worldbody><geom type='hfield' hfield='bowl' pos='0 0 -1'/>
        <body pos='0.1 0 0'><freejoint name='base'/><geom size='0.1' mass='1'/></body></worldbody></mujoco>";
    folder.write("bowl.xml", bowl.as_bytes());
    let text = folder.output(&["simulate", "bowl.xml", "--ground", "file", "--duration", "8"], "");
    // Two of its six faces rise by √½ from the line on which they meet: they carry the ball at R/cos β = R
    // √1.5.
    let end = |name: &str| -> f64 {
        let row = text.lines().find(|line| line.contains(name)).unwrap();
        row.split_whitespace().nth(3).unwrap().parse().unwrap()
    };
    assert!((end("base.z") + 1.0 - 0.1 * 1.5_f64.sqrt()).abs() < 1e-3, "{text}");
    let carried = text.lines().find(|line| line.contains("body_1")).unwrap();
    assert_eq!(carried.split_whitespace().next_back(), Some("9.81"), "{text}");
}

/// MuJoCo's method carries the same weight with soft constraints.
#[test]
fn mujoco_contacts_are_soft() {
    let folder = Folder::new("yields");
    let run = ["simulate", "quadruped.urdf", "--floating-base", "--ground", "--integrator", "mujoco"];
    let text = folder.output(&[&run[..], &["--duration", "3"]].concat(), "");
    assert!(text.contains("method  mujoco, 3000 steps"), "{text}");
    let together = text.lines().find(|line| line.contains(TOTAL_FORCE)).unwrap();
    let carried: f64 = together.split_whitespace().next_back().unwrap().parse().unwrap();
    assert!((carried - 19.9 * 9.81).abs() < 5.0, "{together}");
    let depth = number_before(&text, BELOW_GROUND);
    assert!(depth > 1e-5 && depth < 0.01, "{depth}");
    let ran = folder.run(&[&run[..], &["--without", "limits"]].concat(), b"");
    assert_eq!((ran.code, ran.out.as_str()), (Some(1), ""), "{}", ran.err);
}
