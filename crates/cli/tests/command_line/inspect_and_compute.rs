//! Outputs for other programs: the JSON of `inspect`, the lines of `compute`, and the worked example.

use serde_json::{Value, json};

use crate::command::{Folder, robots};
use crate::messages::Transcript;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn lines(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn numbers_prints_the_worked_example() {
    let folder = Folder::new("numbers");
    let expected = dynamics::WorkedExample::compute().unwrap().to_string();
    assert!(expected.contains("K   = 1.0000 J    V = 17.3418 J    E = 18.3418 J"));
    assert_eq!(folder.output(&["numbers"], ""), expected);
}

/// The same command reads MJCF, which it recognises by the outermost element.
#[test]
fn inspection_and_computation_of_an_mjcf_robot() {
    let folder = Folder::new("mjcf");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/quadruped.xml");
    let object = &lines(&folder.output(&["inspect", file, "--json"], ""))[0];
    assert_eq!(
        [&object["name"], &object["nq"], &object["nv"]],
        [&json!("quadruped"), &json!(19), &json!(18)]
    );
    assert_eq!(object["joints"][0]["name"], "float");
    let trunk = object["links"].as_array().unwrap().iter().find(|link| link["name"] == "trunk").unwrap();
    assert_eq!(trunk["center_of_mass"], json!([0.01, 0.0, 0.005]));
    assert_eq!(trunk["inertia"], json!([0.02, 0.0001, -0.0004, 0.055, 0.00002, 0.065]));
    let mut q = vec![0.0; 19];
    q[6] = 1.0;
    let state = json!({"q": q, "v": vec![0.0; 18]}).to_string();
    let printed = &lines(&folder.output(&["compute", file], &state))[0];
    // At rest, the force along z carries the weight.
    let weight = 9.81 * object["mass"].as_f64().unwrap();
    assert!((numbers(&printed["bias"])[2] - weight).abs() < 1e-12 * weight);
}

/// The environment selects machine code or the recursions.
#[test]
fn inspect_tells_whether_machine_code_computes() {
    let folder = Folder::new("machine_code");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/two_r.urdf");
    let inspect = |arguments: &[&str]| {
        let ran = folder.command(arguments).env("ROBOT_DYNAMICS_NATIVE", "0").output().unwrap();
        String::from_utf8(ran.stdout).unwrap()
    };
    let text = inspect(&["inspect", file]);
    assert!(text.contains("ROBOT_DYNAMICS_NATIVE=0\n"), "{text}");
    let off = &lines(&inspect(&["inspect", file, "--json"]))[0]["machine_code"];
    assert_eq!(off, &json!({"instructions": null, "reason": "ROBOT_DYNAMICS_NATIVE=0"}));
    let on = &lines(&folder.output(&["inspect", file, "--json"], ""))[0]["machine_code"];
    assert_ne!(on["instructions"].is_null(), on["reason"].is_null(), "{on}");
}

/// Sensors, and features that the default simulation leaves out: contact of ellipsoids with each other.
#[test]
fn inspection_tells_sensors_and_what_a_simulation_leaves_out() {
    let folder = Folder::new("left_out");
    let body = |name: &str, x: f64| {
        format!(
            r#"<body name="{name}" pos="{x} 0 1"><freejoint/><site name="{name}_site"/>
               <geom name="{name}" type="ellipsoid" size="0.1 0.2 0.3"/></body>"#
        )
    };
    let text = format!(
        r#"<mujoco><worldbody>{}{}{}</worldbody><sensor><gyro name="turn" site="one_site"/>
           <framepos name="apart" objtype="site" objname="one_site" reftype="site" refname="two_site"/></sensor></mujoco>"#,
        body("one", 0.0),
        body("two", 1.0),
        body("three", 2.0)
    );
    folder.write("eggs.xml", text.as_bytes());
    let object = &lines(&folder.output(&["inspect", "eggs.xml", "--json"], ""))[0];
    let sensors = object["sensors"].as_array().unwrap();
    assert_eq!((sensors.len(), &sensors[0]["name"]), (2, &json!("turn")));
    let left_out = object["simulation"]["left_out"].as_array().unwrap();
    assert_eq!(left_out.len(), 1, "one entry for one reason: {left_out:?}");
    assert_eq!(left_out[0]["features"].as_array().unwrap().len(), 3);
    let text = folder.output(&["inspect", "eggs.xml"], "");
    assert!(text.contains("apart") && text.contains("framepos") && text.contains("two_site"), "{text}");
}

#[test]
fn inspection_of_a_floating_robot() {
    let folder = Folder::new("inspect");
    let object = &lines(&folder.output(&["inspect", "quadruped.urdf", "--json", "--floating-base"], ""))[0];
    assert_eq!(
        [&object["name"], &object["nq"], &object["nv"], &object["floating_base"]],
        [&json!("quadruped"), &json!(19), &json!(18), &json!(true)]
    );
    // The masses in the file: trunk, and four legs of hip, thigh and shank.
    assert!((object["mass"].as_f64().unwrap() - (11.5 + 4.0 * (0.7 + 1.15 + 0.25))).abs() < 1e-12);
    let base = &object["joints"][0];
    for (key, value) in [
        ("name", json!("floating_base")),
        ("kind", json!("floating")),
        ("parent", json!("world")),
        ("child", json!("trunk")),
        ("q_index", json!(0)),
        ("nq", json!(7)),
        ("v_index", json!(0)),
        ("nv", json!(6)),
    ] {
        assert_eq!(base[key], value, "{key}");
    }
    let knee = object["joints"].as_array().unwrap().iter().find(|j| j["name"] == "front_left_knee").unwrap();
    assert_eq!([&knee["q_index"], &knee["v_index"], &knee["nv"]], [&json!(9), &json!(8), &json!(1)]);
    assert_eq!(knee["limits"]["lower"], json!(-2.7));
}

/// nq and nv are the sums over the joints, indices are consecutive, and the text names every joint.
#[test]
fn inspections_of_all_robots_are_consistent() {
    let folder = Folder::new("inspect_all");
    for robot in robots() {
        let file = robot.file_name().unwrap().to_str().unwrap();
        let object = &lines(&folder.output(&["inspect", file, "--json"], ""))[0];
        let text = folder.output(&["inspect", file], "");
        let (mut nq, mut nv) = (0, 0);
        for joint in object["joints"].as_array().unwrap() {
            let size = |key: &str| joint[key].as_u64().unwrap();
            if size("nv") > 0 {
                assert_eq!((size("q_index"), size("v_index")), (nq, nv), "{file}: {joint}");
            }
            (nq, nv) = (nq + size("nq"), nv + size("nv"));
            assert!(text.contains(joint["name"].as_str().unwrap()), "{file}: {joint}");
        }
        assert_eq!([&object["nq"], &object["nv"]], [&json!(nq), &json!(nv)], "{file}");
        assert_eq!(object["report"]["counts"]["ignored_physics"], 0, "{file}");
    }
}

/// Forward dynamics of the inverse dynamics' τ gives the acceleration, with and without dissipation, and τ =
/// M a + C v + g + b.
#[test]
fn forward_of_inverse_is_the_acceleration() {
    let folder = Folder::new("round_trip");
    for (file, n) in [("panda.urdf", 7), ("gripper.urdf", 4), ("ur5.urdf", 6)] {
        let mut random = robot_dynamics_number::SplitMix64::new(7);
        let mut vector = |scale: f64| (0..n).map(|_| random.uniform(-scale, scale)).collect::<Vec<f64>>();
        let states: Vec<[Vec<f64>; 3]> = (0..20).map(|_| [vector(1.0), vector(2.0), vector(5.0)]).collect();
        for extra in [None, Some("--dissipation")] {
            let arguments: Vec<&str> = ["compute", file].into_iter().chain(extra).collect();
            let ask = |states: Vec<Value>| {
                let text: Vec<String> = states.iter().map(Value::to_string).collect();
                lines(&folder.output(&arguments, &text.join("\n")))
            };
            let inverse = ask(states.iter().map(|[q, v, a]| json!({"q": q, "v": v, "a": a})).collect());
            let forward = ask(states
                .iter()
                .zip(&inverse)
                .map(|([q, v, _], answer)| json!({"q": q, "v": v, "tau": answer["inverse_dynamics"]}))
                .collect());
            for (index, [_, v, a]) in states.iter().enumerate() {
                let found = numbers(&forward[index]["forward_dynamics"]);
                // κ(M) of these arms is below 1e5, so κ ε times the terms (below 1e3) is below 2e-8.
                let defect = found.iter().zip(a).map(|(x, a)| (x - a).abs()).fold(0.0, f64::max);
                assert!(defect < 2e-8, "{file} {extra:?}, seed 7, state {index}: {defect:e}");
                let (tau, bias) =
                    (numbers(&inverse[index]["inverse_dynamics"]), numbers(&inverse[index]["bias"]));
                let rows = inverse[index]["mass_matrix"].as_array().unwrap();
                let loss: f64 = (0..n)
                    .map(|i| {
                        let ma: f64 = numbers(&rows[i]).iter().zip(a).map(|(m, a)| m * a).sum();
                        (tau[i] - ma - bias[i]) * v[i]
                    })
                    .sum();
                // The rest is b; its power v·b is zero without dissipation and positive with it.
                match (extra, file) {
                    (None, _) | (_, "panda.urdf" | "ur5.urdf") => {
                        assert!(loss.abs() < 1e-11, "{file}, state {index}: {loss:e}");
                    }
                    _ => assert!(loss > 1e-3, "{file}, state {index}: {loss:e}"),
                }
            }
        }
    }
}

/// One state by hand: the two-link arm of the worked example, in its URDF form.
#[test]
fn compute_gives_the_worked_numbers() {
    let folder = Folder::new("compute_numbers");
    let pi = std::f64::consts::PI;
    let state = json!({"q": [pi / 4.0, pi / 2.0], "v": [1.0, 0.0]}).to_string();
    let answer = &lines(&folder.output(&["compute", "two_r.urdf"], &state))[0];
    for (term, expected) in [
        ("/mass_matrix/0/0", 2.0),
        ("/mass_matrix/0/1", 0.3333),
        ("/mass_matrix/1/1", 0.3333),
        ("/kinetic_energy", 1.0),
        ("/potential_energy", 17.3418),
        ("/gravity/0", 10.4051),
        ("/gravity/1", -3.4684),
        ("/bias/0", 10.4051),
        // C v = (0, 0.5).
        ("/bias/1", -3.4684 + 0.5),
        ("/coriolis_matrix/1/0", 0.5),
    ] {
        let found = answer.pointer(term).and_then(Value::as_f64).unwrap();
        assert!((found - expected).abs() < 1e-4, "{term}: {found}, expected {expected}");
    }
}

/// A program that waits for each answer before the next question gets it.
#[test]
fn answers_come_one_by_one() {
    use std::io::{BufRead, BufReader, Write};
    let folder = Folder::new("one_by_one");
    let mut child = folder.command(&["compute", "two_r.urdf"]).spawn().unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut answers = BufReader::new(child.stdout.take().unwrap());
    for _ in 0..3 {
        stdin.write_all(b"{\"q\":[0,0],\"v\":[0,0]}\n").unwrap();
        stdin.flush().unwrap();
        let mut answer = String::new();
        answers.read_line(&mut answer).unwrap();
        assert!(answer.starts_with("{\"mass_matrix\":"), "{answer}");
    }
    drop(stdin);
    assert!(child.wait().unwrap().success());
}

/// A quaternion of rounded digits is normalised with one note, and gives the numbers of the unit quaternion.
/// A larger deviation is an error.
#[test]
fn quaternions_of_rounded_digits_are_normalised() {
    let folder = Folder::new("rounded_quaternions");
    folder.write("brick.urdf", BRICK.as_bytes());
    let state = |w: f64| format!("{{\"q\":[0,0,1,0.6,0,0,{w}],\"v\":[0,0,0,1,2,3]}}\n");
    let run = ["compute", "brick.urdf", "--floating-base"];
    let exact = folder.run(&run, state(0.8).repeat(2).as_bytes());
    assert_eq!((exact.code, exact.err.as_str()), (Some(0), ""));
    let rounded = folder.run(&run, state(0.8005).repeat(3).as_bytes());
    assert_eq!(rounded.code, Some(0), "{}", rounded.err);
    assert!(rounded.err.starts_with("note: line 1: q[3..7] (joint `floating_base`)"), "{}", rounded.err);
    assert_eq!(rounded.err.lines().count(), 1, "{}", rounded.err);
    // The rotation differs by 0.0005 · 0.6 · 2 rad; M of a body in its own frame does not differ.
    let [exact, rounded] = [exact, rounded].map(|ran| lines(&ran.out)[0].clone());
    let [m, n] = [&exact, &rounded]
        .map(|terms| terms["mass_matrix"].as_array().unwrap().iter().flat_map(numbers).collect::<Vec<f64>>());
    assert!(m.len() == 36 && m.iter().zip(&n).all(|(m, n)| (m - n).abs() < 1e-14), "{m:?} {n:?}");
    let [a, b] = [&exact, &rounded].map(|terms| numbers(&terms["gravity"]));
    let most = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    // |g| = 2 kg · 9.81 m/s² is constant, since the normalised quaternion is a rotation.
    let norm = |x: &[f64]| x[..3].iter().map(|x| x * x).sum::<f64>().sqrt();
    assert!(most > 1e-4 && most < 0.02 && (norm(&b) - 19.62).abs() < 1e-12, "{a:?} {b:?}");

    let ran = folder.run(&run, state(0.81).as_bytes());
    assert_eq!(ran.code, Some(1));
    let error = lines(&ran.out)[0]["error"].as_str().unwrap().to_owned();
    assert!(error.contains("`floating_base`") && error.contains("1.00801"), "{error}");

    let pose = |w: &str| {
        let pose = format!("floating_base=0,0,1,0.6,0,0,{w}");
        folder.run(&["simulate", "brick.urdf", "--floating-base", "--duration", "0.01", "--pose", &pose], b"")
    };
    assert_eq!(pose("0.8").err, "");
    let told = pose("0.8005");
    assert!(told.err.starts_with("note: --pose: joint `floating_base`: "), "{}", told.err);
    assert_eq!((told.code, told.err.lines().count()), (Some(0), 1), "{}", told.err);
}

/// A body of 2 kg.
const BRICK: &str = r#"<robot name="brick"><link name="brick"><inertial><mass value="2"/>
  <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.25"/></inertial></link></robot>"#;

/// 100 000 links on one hub are shown in seconds. A pass over all links for each of them would take minutes.
#[test]
fn a_large_star_is_shown_in_seconds() {
    let folder = Folder::new("star");
    folder.write("star.urdf", star(100_000).as_bytes());
    let text = in_seconds(|| folder.output(&["inspect", "star.urdf"], ""));
    assert!(text.lines().count() > 200_000, "{}", &text[..99]);
    assert!(text.contains("\n    l99999  1 kg  <- j99999 (continuous)\n"));
}

/// The same as JSON.
#[test]
fn a_large_star_is_written_in_seconds() {
    let folder = Folder::new("star_json");
    folder.write("star.urdf", star(100_000).as_bytes());
    let object = in_seconds(|| lines(&folder.output(&["inspect", "star.urdf", "--json"], "")).remove(0));
    assert_eq!(object["joints"].as_array().unwrap().len(), 100_000);
}

/// The result of `run`, which must take seconds on a busy machine.
fn in_seconds<T>(run: impl FnOnce() -> T) -> T {
    let clock = std::time::Instant::now();
    let given = run();
    assert!(clock.elapsed().as_secs() < 30, "{:?}", clock.elapsed());
    given
}

/// A command that needs matrices of 20 000 × 20 000 numbers fails before it allocates them.
#[test]
fn matrices_too_large_are_refused() {
    let folder = Folder::new("star_matrices");
    folder.write("star.urdf", star(20_000).as_bytes());
    let mut transcript = Transcript::default();
    for command in ["compute", "simulate"] {
        let ran = folder.run(&[command, "star.urdf"], b"");
        assert_eq!(ran.code, Some(1), "{command}");
        transcript.add(&[command, "star.urdf"], &ran);
    }
    transcript.compare("too_large");
}

/// A hub with this many joints.
fn star(count: usize) -> String {
    use std::fmt::Write;
    let mut star = String::from("<robot name=\"star\"><link name=\"hub\"/>\n");
    for k in 0..count {
        let _ = writeln!(
            star,
            "<link name=\"l{k}\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" \
             izz=\"1\"/></inertial></link><joint name=\"j{k}\" type=\"continuous\"><parent link=\"hub\"/><child \
             link=\"l{k}\"/><axis xyz=\"0 0 1\"/></joint>"
        );
    }
    star + "</robot>"
}

/// Packages are found in the given folders.
#[test]
fn meshes_of_packages_are_found() {
    let folder = Folder::new("packages");
    std::fs::create_dir_all(folder.path("ws/arm_description/meshes")).unwrap();
    folder.write("ws/arm_description/meshes/link.stl", b"");
    let text = r#"<robot name="r"><link name="a"><visual><geometry>
        <mesh filename="package://arm_description/meshes/link.stl"/></geometry></visual></link></robot>"#;
    folder.write("robot.urdf", text.as_bytes());
    let missing = "package://arm_description/meshes/link.stl";
    assert!(folder.output(&["inspect", "robot.urdf"], "").contains(missing));
    for given in ["ws", "ws/arm_description"] {
        let told =
            folder.output(&["inspect", "robot.urdf", "--package-path", ".", "--package-path", given], "");
        assert!(!told.contains(missing), "{given}: {told}");
    }
    let ran = folder.run(&["inspect", "robot.urdf", "--package-path", "nowhere"], b"");
    assert_eq!((ran.code, ran.err.lines().count()), (Some(1), 1), "{}", ran.err);
}
