//! Tests reading, writing and evaluating sensors against MuJoCo's `sensordata`
//! (`testdata/mjcf/sensors/golden.json`).
//!
//! Tolerance: 1e-10 of the largest value of the sensor. The accelerations and forces are MuJoCo's on both
//! sides, so only the rounding of sums over a dozen bodies differs.

use robot_dynamics::conventions::{acceleration_from_mujoco, force_from_mujoco};
use robot_dynamics::description::{
    LinkDescription, RobotDescription, SensorDescription, SensorKind, SensorObject, Shape,
};
use robot_dynamics::model::Model;
use robot_dynamics::simulation::{
    Method, PointForce, SensorInputs, SensorSet, Simulation, SimulationBuilder,
};
use robot_dynamics_mjcf::{Disposition, FileSet, Finding, LoadOptions, load, load_from_files, parse};
use serde_json::Value;

use crate::golden::{Golden, numbers, root};

const COMPUTED: f64 = 1e-10;

fn golden() -> Value {
    let text = std::fs::read_to_string(root().join("testdata/mjcf/sensors/golden.json"));
    serde_json::from_str(&text.expect("the golden file")).expect("JSON")
}

fn three(value: &Value) -> [f64; 3] {
    numbers(value).try_into().expect("three numbers")
}

/// Converts MuJoCo's quaternion, w x y z, to x y z w, with w not negative for a frame.
fn ours(kind: SensorKind, value: &[f64]) -> Vec<f64> {
    let &[w, x, y, z] = value else { return value.to_vec() };
    let sign = if kind == SensorKind::FrameQuaternion && w < 0.0 { -1.0 } else { 1.0 };
    [x, y, z, w].map(|x| sign * x).to_vec()
}

/// The robot of a file; if `again`, after writing it and reading the text back.
fn robot(file: &str, again: bool) -> RobotDescription {
    let robot = load(root().join(file), &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.report.counts.ignored, 0, "{}", robot.report);
    if !again {
        return robot.description;
    }
    let written = robot_dynamics_mjcf::write(&robot.description, None).expect("a file");
    let lost: Vec<_> = written.left_out.iter().filter(|lost| lost.place.contains("sensor")).collect();
    assert!(lost.is_empty(), "{lost:?}");
    parse(&written.text, &LoadOptions::default()).expect("its own file").description
}

fn compare(again: bool) {
    let mut pressed = 0;
    for (file, record) in golden()["files"].as_object().expect("files") {
        let model = Model::new(robot(file, again)).expect("a model");
        let sensors = SensorSet::new(&model).expect("sensors");
        let kinds: Vec<SensorKind> = sensors.kinds().collect();
        assert_eq!(sensors.value_count() as f64, numbers(&record["sizes"]).iter().sum::<f64>());
        let (mut memory, mut values) = (sensors.memory(&model), vec![0.0; sensors.value_count()]);
        for (at, state) in record["states"].as_array().expect("states").iter().enumerate() {
            let (q, v) = Golden::state(&model, state);
            let (mut a, mut limits) = (vec![0.0; model.nv()], vec![0.0; model.nv()]);
            acceleration_from_mujoco(&model, &q, &v, &numbers(&state["qacc"]), &mut a);
            force_from_mujoco(&model, &q, &numbers(&state["joint_limit_force"]), &mut limits);
            let contacts = state["contacts"].as_array().expect("contacts").iter().map(|contact| PointForce {
                link: model.frame(contact["body"].as_str().expect("a name")).expect("a link"),
                point: three(&contact["point"]),
                force: three(&contact["force"]),
                moment: three(&contact["moment"]),
                normal: three(&contact["normal"]),
            });
            let wrenches: Vec<PointForce> = contacts.collect();
            let (forces, tendons) =
                (numbers(&state["actuator_force"]), numbers(&state["tendon_limit_force"]));
            let mut inputs = SensorInputs::new(&q, &v, &a);
            inputs.time = state["time"].as_f64().expect("a number");
            inputs.actuator_forces = &forces;
            inputs.joint_limit_forces = &limits;
            inputs.tendon_limit_forces = &tendons;
            inputs.wrenches = &wrenches;
            sensors.evaluate(&model, &mut memory, &inputs, &mut values);
            let expected = numbers(&state["sensordata"]);
            for (index, (name, &kind)) in sensors.names().zip(&kinds).enumerate() {
                let range = sensors.range(index);
                let expected = ours(kind, &expected[range.clone()]);
                let found = &values[range];
                let scale = expected.iter().fold(1.0_f64, |most, x| most.max(x.abs()));
                for (found, expected) in found.iter().zip(&expected) {
                    let off = (found - expected).abs();
                    assert!(
                        off <= COMPUTED * scale,
                        "{file} {at} {name}: {found} for {expected}, off {off:e}"
                    );
                }
                pressed += usize::from(kind == SensorKind::Touch && found[0] > 0.0);
            }
        }
    }
    assert!(pressed > 5, "{pressed} touch sensors pressed");
}

#[test]
fn values_are_mujocos() {
    compare(false);
}

#[test]
fn written_sensors_give_the_same_values() {
    compare(true);
}

/// Without contact and motors the values follow from Newton's laws, here computed by hand.
#[test]
fn a_resting_body_shows_its_weight() {
    let text = "<mujoco><worldbody><body name='b'>
        <inertial pos='0.2 0 0' mass='2' diaginertia='1 1 1'/> <site name='s' euler='90 0 0'/>
      </body></worldbody>
      <sensor><accelerometer site='s'/><force site='s'/><torque site='s'/></sensor></mujoco>";
    let robot = parse(text, &LoadOptions::default()).expect("a robot").description;
    assert_eq!(
        robot.sensors.iter().map(|sensor| sensor.name.as_str()).collect::<Vec<_>>(),
        ["sensor_0", "sensor_1", "sensor_2"]
    );
    let model = Model::new(robot).expect("a model");
    let sensors = SensorSet::new(&model).expect("sensors");
    let mut values = [0.0; 9];
    let inputs = SensorInputs::new(&[], &[], &[]);
    sensors.evaluate(&model, &mut sensors.memory(&model), &inputs, &mut values);
    // The y axis of the site points up. The weight of 2 kg acts at 0.2 m, so the joint carries −0.2·2·g about
    // the y axis of the world.
    let weight = 2.0 * 9.81;
    let expected = [0.0, 9.81, 0.0, 0.0, weight, 0.0, 0.0, 0.0, 0.2 * weight];
    for (found, expected) in values.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-14, "{values:?}");
    }
}

/// A sensor that is supported, and four that are not.
pub(crate) const UNANSWERED: &str =
    "<mujoco><worldbody><body name='b'><joint name='j' type='ball'/><geom name='g' size='0.1'/>
        <site name='s'/></body></worldbody>
      <actuator><general name='m' joint='j' dyntype='user'/></actuator>
      <sensor>
      <rangefinder site='s'/>
      <actuatorpos actuator='m'/>
      <jointlimitpos joint='j'/>
      <framequat objtype='body' objname='b'/>
      <gyro site='s'/>
      </sensor></mujoco>";

#[test]
fn unsupported_sensors_are_reported() {
    let robot = parse(UNANSWERED, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.description.sensors.len(), 1);
    let is_ignored = |finding: &&Finding| finding.disposition() == Disposition::Ignored { physics: false };
    let lines: Vec<usize> = robot
        .report
        .findings
        .iter()
        .filter(is_ignored)
        .map(robot_dynamics::description::Finding::line)
        .collect();
    assert_eq!(lines, [5, 6, 7, 8], "{}", robot.report);
}

#[test]
fn an_unknown_object_is_an_error_of_its_line() {
    let body = "<mujoco><worldbody><body name='b'><geom size='0.1'/></body></worldbody><sensor>";
    for sensor in [
        "<gyro site='nowhere'/>",
        "<gyro/>",
        "<jointpos joint='nowhere'/>",
        "<actuatorfrc actuator='nowhere'/>",
        "<framepos objtype='xbody' objname='nowhere'/>",
        "<subtreecom body='nowhere'/>",
    ] {
        let error = parse(&format!("{body}\n{sensor}</sensor></mujoco>"), &LoadOptions::default());
        let refused = error.expect_err("refused");
        assert!(refused.errors().iter().all(|error| error.line() == Some(2)), "{sensor}: {refused}");
    }
}

/// Sensors of an attached part get its prefix, and those of replicates are copied for each replica.
#[test]
fn sensors_are_attached_and_replicated() {
    let hand =
        "<mujoco><worldbody><body name='hand'><joint name='turn'/><geom size='0.1'/><site name='tip'/></body>
      </worldbody><actuator><motor name='m' joint='turn'/></actuator>
      <sensor><gyro name='spin' site='tip'/><actuatorfrc name='pull' actuator='m'/>
        <framepos name='where' objtype='site' objname='tip'/></sensor></mujoco>";
    let main = "<mujoco><asset><model name='hand' file='hand.xml'/></asset><worldbody>
      <body name='arm'><joint name='base'/><geom size='0.1'/><attach model='hand' body='hand' prefix='left_'/></body>
      <replicate count='2'><body name='ball'><freejoint/><geom size='0.1'/><site name='mark'/></body></replicate>
      </worldbody><sensor><gyro name='g' site='mark'/></sensor></mujoco>";
    let files = FileSet::new([("main.xml", main), ("hand.xml", hand)]);
    let robot = load_from_files(&files, "main.xml", &LoadOptions::default()).expect("a robot").description;
    let named = |sensor: &SensorDescription| match &sensor.object {
        SensorObject::Named(object) => format!("{}: {object}", sensor.name),
        object => format!("{}: {object:?}", sensor.name),
    };
    let mut found: Vec<String> = robot.sensors.iter().map(named).collect();
    found.sort();
    assert_eq!(
        found,
        ["g0: mark0", "g1: mark1", "left_pull: left_m", "left_spin: left_tip", "left_where: left_tip"]
    );
    Model::new(robot).expect("a model");
}

/// Sensors on a link, sensors with a zone, and sensors that MJCF cannot represent.
#[test]
fn sensors_of_a_description_are_written() {
    let mut robot = robot_dynamics::description::pendulum(2.0, 0.5);
    robot.links.push(LinkDescription::new("hook", None));
    let hook = robot_dynamics::description::JointDescription::new(
        "weld",
        robot_dynamics::description::JointKind::Fixed,
        "rod",
        "hook",
        robot_dynamics::description::Pose::IDENTITY,
    );
    robot.joints.push(hook);
    let pad = Shape::Box { size: [0.1, 0.2, 0.3] };
    robot.sensors.push(SensorDescription::new("load", SensorKind::Force, "rod").with_cutoff(50.0));
    robot.sensors.push(SensorDescription::new("pad", SensorKind::Touch, "tip").within(pad.clone()));
    robot.sensors.push(SensorDescription::new("all", SensorKind::Touch, "tip"));
    robot.sensors.push(SensorDescription::new("reach", SensorKind::FramePosition, "hook").relative_to("rod"));
    let written = robot_dynamics_mjcf::write(&robot, None).expect("a file");
    let left_out: Vec<&str> = written.left_out.iter().map(|lost| lost.place.as_str()).collect();
    assert!(left_out.contains(&"sensor \"all\""), "{left_out:?}");
    let back = parse(&written.text, &LoadOptions::default()).expect("a robot").description;
    let kinds: Vec<_> = back.sensors.iter().map(|sensor| (sensor.name.as_str(), sensor.kind)).collect();
    assert_eq!(
        kinds,
        [("load", SensorKind::Force), ("pad", SensorKind::Touch), ("reach", SensorKind::FramePosition)]
    );
    assert_eq!((back.sensors[0].cutoff, &back.sensors[1].zone), (50.0, &Some(pad)));
    assert_eq!(back.sensors[2].reference, Some("rod".into()));
}

/// Two links fall to their upper limits, and a tendon between the second one and a slide becomes taut.
const LIMITED: &str = r#"<mujoco><compiler angle="radian"/><option timestep="0.002"/>
  <worldbody>
    <body name="a" pos="0 0 1"><joint name="shoulder" axis="0 1 0" range="-0.5 0.3" damping="0.1" solreflimit="0.03 0.9"/>
      <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03" mass="1.2" contype="0"/>
      <body name="b" pos="0.4 0 0"><joint name="elbow" axis="0 1 0" range="-1 0.2" margin="0.01" damping="0.05"/>
        <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" mass="0.7" contype="0"/></body></body>
    <body name="c" pos="0 1 0"><joint name="slide" type="slide" axis="0 0 1" damping="2"/>
      <geom size="0.05" mass="0.4" contype="0"/></body>
  </worldbody>
  <tendon><fixed name="rope" range="-0.05 1"><joint joint="slide" coef="1"/><joint joint="elbow" coef="0.1"/></fixed></tendon>
  <sensor>
    <jointlimitpos joint="shoulder"/><jointlimitvel joint="shoulder"/><jointlimitfrc joint="shoulder"/>
    <jointlimitpos joint="elbow"/><jointlimitvel joint="elbow"/><jointlimitfrc joint="elbow"/>
    <tendonlimitpos tendon="rope"/><tendonlimitvel tendon="rope"/><tendonlimitfrc tendon="rope"/>
  </sensor></mujoco>"#;

fn limited(method: Method) -> Simulation {
    let robot = parse(LIMITED, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.report.counts.ignored, 0, "{}", robot.report);
    let model = Model::new(robot.description).expect("a model");
    SimulationBuilder::new(&model).method(method).dt(2e-3).build().expect("a simulation")
}

fn sensed(simulation: &Simulation) -> Vec<f64> {
    simulation.sensors().into_iter().flat_map(|(_, values)| values).collect()
}

/// `sensordata` of MuJoCo 4.0.0 (`tolerance="0"`, 200 iterations): positions and velocities after the given
/// steps, and the forces of the last step.
#[test]
fn limits_of_a_simulation_show_mujocos_forces() {
    let mut simulation = limited(Method::Mujoco);
    let after_120 = [
        -0.018149807085349245,
        0.35679598186696304,
        5.324415219373206,
        -0.06361626939879748,
        1.651610221699752,
        0.8094565545540264,
        0.0,
        0.0,
        0.0,
    ];
    let after_200 = [
        -0.001984784069168466,
        -0.0024160401538515348,
        5.7631817613747796,
        -0.003314478967763093,
        -4.4706952695820984e-05,
        1.2924958128483912,
        -0.0004699251502153362,
        -0.00022541506781961778,
        3.902655937818828,
    ];
    for (steps, expected) in [(120, after_120), (80, after_200)] {
        for _ in 0..steps {
            simulation.step().expect("a step");
        }
        for (k, (found, expected)) in sensed(&simulation).iter().zip(expected).enumerate() {
            assert!(
                (found - expected).abs() < 1e-10 * expected.abs().max(1.0),
                "{k}: {found} for {expected}"
            );
        }
    }
}

/// At rest under the rigid law, the forces of the limits balance gravity, and the joints are at the limits to
/// rounding.
#[test]
fn rigid_limits_show_the_forces_that_carry_the_weight() {
    let mut simulation = limited(Method::Implicit);
    simulation.run_for(5.0).expect("a run");
    let found = sensed(&simulation);
    let (model, q) = (simulation.model().clone(), simulation.q().to_vec());
    assert!((q[0] - 0.3).abs() < 1e-9 && (q[1] - 0.2).abs() < 1e-9 && (q[2] + 0.07).abs() < 1e-9, "{q:?}");
    let held = model.inverse_dynamics(&q, &[0.0; 3], &[0.0; 3]).expect("a state");
    let tension = 0.4 * 9.81;
    assert!((held[2] - tension).abs() < 1e-12);
    // Both upper limits push back, and the tendon pulls the elbow.
    for (sensor, expected) in [(2, -held[0]), (5, -(held[1] - 0.1 * tension)), (8, tension)] {
        assert!((found[sensor] - expected).abs() < 1e-6, "{sensor}: {} for {expected}", found[sensor]);
    }
}
