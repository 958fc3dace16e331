//! `simulate --ground`: a robot falls, lands and stays; and what does not go with ground.

use crate::command::Folder;

/// The number before a word of a text.
fn number_before(text: &str, word: &str) -> f64 {
    let before = text.split(word).next().unwrap();
    before.split_whitespace().next_back().unwrap().parse().unwrap()
}

/// A quadruped let go falls, comes to rest on the ground, which carries its weight, and creeps no more for seconds.
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
    assert!(text.contains("lifted until its lowest point is 0.1 m above the ground"), "{text}");
    assert!(text.contains("ground  level at z = 0 m, friction as the shapes state"), "{text}");
    assert!(text.contains("at rest: no coordinate moves faster than"), "{text}");
    assert!(text.contains("largest violation of the contact laws over the run: "), "{text}");
    // Nothing sinks, not even while it falls over: what a step leaves below is lifted, to rounding.
    assert!(number_before(&text, " m in what it touches") < 1e-9, "{text}");
    let together = text.lines().find(|line| line.contains("together")).unwrap();
    let carried: f64 = together.split_whitespace().next_back().unwrap().parse().unwrap();
    assert!((carried - 19.9 * 9.81).abs() < 0.1, "{together}");
    let svg = folder.read("run.svg");
    assert!(svg.contains("Energy taken out [J]") && svg.contains("force on each link [N]"));
    let table = folder.read("run.csv");
    let rows: Vec<Vec<&str>> = table.lines().map(|line| line.split(',').collect()).collect();
    let column = |name: &str| rows[0].iter().position(|head| *head == name).unwrap();
    let (height, foot) = (column("q floating_base.z [m]"), column("contact front_left_foot.z [N]"));
    let number = |row: usize, column: usize| rows[row][column].parse::<f64>().unwrap();
    let last = rows.len() - 1;
    // What took energy out only grows.
    for cause in ["damping", "friction", "stops", "sliding", "impacts"] {
        let column = column(&format!("{cause} took out [J]"));
        assert!((1..=last).all(|row| row == 1 || number(row, column) >= number(row - 1, column)), "{cause}");
        assert!(number(last, column) > 0.0, "{cause}");
    }
    // Rest: not a digit that is seen in the last second.
    assert!((number(last, height) - number(last - 1000, height)).abs() < 1e-9);
    assert!(number(1, foot) == 0.0 && (1..=last).any(|row| number(row, foot) > 1.0));
}

/// Links touch each other, unless that is switched off.
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
        (text, end.fold(0.0, f64::max))
    };
    let (_, apart) = height(&["--without", "link-contacts"]);
    assert!((apart - 0.1).abs() < 1e-6, "{apart}"); // one in the other
    let (text, on_top) = height(&[]);
    assert!(text.contains("links   one pair of shapes may touch"), "{text}");
    assert!((on_top - 0.3).abs() < 1e-6, "{on_top}");
}

/// Ground that rises, with friction that holds and with friction that does not; a robot set down on it.
#[test]
fn slopes_and_friction() {
    let folder = Folder::new("slope");
    let run = |friction: &str| {
        let run =
            ["simulate", "quadruped.urdf", "--floating-base", "--standing", "--ground", "slope=0.2,z=1"];
        folder.output(&[&run[..], &["--friction", friction, "--duration", "3"]].concat(), "")
    };
    let holds = run("1.5");
    assert!(holds.contains("rises along x by 0.2 rad, at z = 1 m under the origin, friction 1.5"), "{holds}");
    assert!(holds.contains("lowered or lifted until it touches the ground"), "{holds}");
    let slides = run("0.01");
    let end = |text: &str| -> f64 {
        let row = text.lines().find(|line| line.contains("floating_base.x")).unwrap();
        row.split_whitespace().nth(3).unwrap().parse().unwrap()
    };
    // Without friction for 3 s: ½ g sin α cos α t² = 8.6 m downhill.
    assert!(end(&holds) > -0.5 && end(&slides) < -5.0, "{} {}", end(&holds), end(&slides));
    assert!(number_before(&slides, " steps/s") > 0.0);
}

/// What does not go with ground is refused, each with what to do.
#[test]
fn what_does_not_go_with_ground() {
    let folder = Folder::new("no_ground");
    let robot = &["simulate", "quadruped.urdf", "--floating-base"][..];
    for (arguments, code, said) in [
        (&["--friction", "1"][..], 1, "--friction is that of the ground: give --ground, too"),
        (&["--standing"], 1, "--standing stands on the ground: give --ground, too"),
        (
            &["--ground", "--integrator", "rk4"],
            1,
            "method `rk4` knows no contact; `implicit` and `mujoco` do",
        ),
        (&["--ground", "file"], 1, "has no height field and no plane that the world carries"),
        (&["--ground", "x=1"], 2, "the ground has no `x`: it has z [m] and slope [rad]"),
        (&["--ground", "z=high"], 2, "`high` is not a finite number"),
        (&["--ground", "slope=2"], 2, "a slope of 2 rad is no ground"),
        (&["--ground", "--friction", "-1"], 2, "it must be a finite number, 0 or more"),
    ] {
        let ran = folder.run(&[robot, arguments].concat(), b"");
        assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.err);
        assert!(ran.err.contains(said), "{arguments:?}: {}", ran.err);
        assert_eq!(ran.err.lines().count(), 1, "{}", ran.err);
    }
    let ran = folder.run(&["simulate", "panda.urdf", "--ground"], b"");
    assert!(
        ran.err.contains("robot `panda` has no collision shape that can touch the ground"),
        "{}",
        ran.err
    );
    let ran = folder.run(&["simulate", "quadruped.urdf", "--ground", "--standing"], b"");
    assert!(ran.err.contains("--standing: the base of robot `quadruped` is fixed"), "{}", ran.err);
}

/// A ball let go above the height field of its file comes to the bottom of the bowl and is carried there.
#[test]
fn a_ball_rests_in_the_bowl_of_its_file() {
    let folder = Folder::new("bowl");
    let bowl = "<mujoco><asset><hfield name='bowl' size='1 1 0.5 0.1' nrow='3' ncol='3' elevation='1 1 1 1 0 1 1 1 1'/></asset>
        <worldbody><geom type='hfield' hfield='bowl' pos='0 0 -1'/>
        <body pos='0.1 0 0'><freejoint name='base'/><geom size='0.1' mass='1'/></body></worldbody></mujoco>";
    folder.write("bowl.xml", bowl.as_bytes());
    let text = folder.output(&["simulate", "bowl.xml", "--ground", "file", "--duration", "8"], "");
    assert!(text.contains("ground  the height field of the file, friction as the surfaces state"), "{text}");
    // Two of its six faces rise by √½ from the line on which they meet: they carry the ball at R/cos β = R √1.5.
    let end = |name: &str| -> f64 {
        let row = text.lines().find(|line| line.contains(name)).unwrap();
        row.split_whitespace().nth(3).unwrap().parse().unwrap()
    };
    assert!((end("base.z") + 1.0 - 0.1 * 1.5_f64.sqrt()).abs() < 1e-3, "{text}");
    let carried = text.lines().find(|line| line.contains("body_1")).unwrap();
    assert_eq!(carried.split_whitespace().next_back(), Some("9.81"), "{text}");
}

/// MuJoCo's steps under its law: the same weight carried, by constraints that yield.
#[test]
fn mujocos_law_yields() {
    let folder = Folder::new("yields");
    let run = ["simulate", "quadruped.urdf", "--floating-base", "--ground", "--integrator", "mujoco"];
    let text = folder.output(&[&run[..], &["--duration", "3"]].concat(), "");
    assert!(text.contains("method  mujoco, 3000 steps"), "{text}");
    let together = text.lines().find(|line| line.contains("together")).unwrap();
    let carried: f64 = together.split_whitespace().next_back().unwrap().parse().unwrap();
    assert!((carried - 19.9 * 9.81).abs() < 5.0, "{together}");
    let end = text.rsplit("the lowest point is ").next().unwrap();
    let depth = number_before(end, " m below the ground");
    assert!(depth > 1e-5 && depth < 0.01, "{depth}");
    let ran = folder.run(&[&run[..], &["--without", "limits"]].concat(), b"");
    assert!(
        ran.err.contains("holds position limits by its law; `implicit` can leave them out"),
        "{}",
        ran.err
    );
}
