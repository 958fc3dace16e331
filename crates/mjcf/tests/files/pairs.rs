//! Explicit contact pairs (`<pair>`) are independent of the other contact settings of geoms.

use robot_dynamics::contact::{ContactSet, Ground, SoftConstraints, SoftDynamicsInputs};
use robot_dynamics::description::{RobotDescription, ShapeRole};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::simulation::{Method, RunOptions, SimulationBuilder};
use robot_dynamics_mjcf::{Disposition, LoadOptions, parse, write};

fn read(text: &str) -> RobotDescription {
    let robot = parse(text, &LoadOptions::default()).expect("a robot");
    assert_eq!(robot.report.counts.ignored_physics, 0, "{}", robot.report);
    robot.description
}

/// All geoms have zero collision bits, so only the pairs can collide. The ball and its child `finger` are
/// also excluded.
fn balls(pairs: &str) -> String {
    format!(
        r#"<mujoco>
          <default>
            <geom contype="0" conaffinity="0"/>
            <pair condim="4" friction="0.2 0.2"/>
            <default class="grip"><pair friction="0.7 0.7 0.01" margin="0.002"/></default>
          </default>
          <worldbody>
            <geom name="floor" type="plane" size="1 1 1"/>
            <geom name="post" size="0.1" pos="0 0 -1"/>
            <body name="ball"><freejoint/><geom name="ball" size="0.1" mass="1"/>
              <body name="finger" pos="0 0 0.3"><joint type="slide" axis="0 0 1"/><geom name="tip" size="0.05" mass="0.1"/></body>
            </body>
          </worldbody>
          <contact><exclude body1="ball" body2="finger"/>{pairs}</contact></mujoco>"#
    )
}

#[test]
fn a_pair_is_read_with_its_defaults_and_written() {
    let text = balls(
        r#"<pair name="own" geom1="ball" geom2="floor" friction="0.3" solref="-900 -40" solreffriction="0.03" gap="0.001"/>
           <pair class="grip" geom1="tip" geom2="ball" condim="6" solimp="0.8"/>"#,
    );
    let robot = read(&text);
    let [floor, grip] = &robot.contact_pairs[..] else { panic!("{:?}", robot.contact_pairs) };
    assert_eq!((floor.name.as_str(), &floor.shapes), ("own", &["ball".to_owned(), "floor".to_owned()]));
    // Numbers of the pair replace those of its defaults, and these replace MJCF's. The geoms have no effect.
    assert_eq!((floor.condim, floor.friction), (4, [0.3, 0.2, 0.005, 1e-4, 1e-4]));
    assert_eq!((floor.solref, floor.margin, floor.gap), ([-900.0, -40.0], 0.0, 0.001));
    assert_eq!((floor.solreffriction, grip.solreffriction), (Some([0.03, 0.0]), None));
    assert_eq!((grip.condim, grip.friction, grip.margin), (6, [0.7, 0.7, 0.01, 1e-4, 1e-4], 0.002));
    assert_eq!((grip.solref, grip.solimp), ([0.02, 1.0], [0.8, 0.95, 0.001, 0.5, 2.0]));
    // A geom in a pair is a collision shape; the post is a visual shape.
    let roles = robot.shapes.iter().map(|shape| (shape.name.as_str(), shape.role == ShapeRole::Collision));
    assert_eq!(roles.collect::<Vec<_>>(), [("floor", true), ("post", false), ("ball", true), ("tip", true)]);

    let written = write(&robot, None).expect("a robot");
    assert_eq!(written.left_out, []);
    let back = read(&written.text);
    assert_eq!(back.contact_pairs, robot.contact_pairs);
    assert_eq!(back.contact_exclusions, robot.contact_exclusions);
    let mut bare = robot.clone();
    bare.shapes.retain(|shape| shape.name != "tip");
    let written = write(&bare, None).expect("a robot");
    assert_eq!(written.left_out.len(), 1, "{:?}", written.left_out);
    assert_eq!(read(&written.text).contact_pairs, robot.contact_pairs[..1]);
}

#[test]
fn anisotropic_friction_is_reported() {
    let text = balls(r#"<pair geom1="ball" geom2="floor" friction="0.3 0.4"/>"#);
    let robot = parse(&text, &LoadOptions::default()).expect("a robot");
    let is_ignored =
        |one: &&robot_dynamics_mjcf::Finding| one.disposition() == Disposition::Ignored { physics: false };
    let findings: Vec<_> = robot.report.findings.iter().filter(is_ignored).collect();
    assert_eq!(findings.len(), 1, "{}", robot.report);
    assert_eq!(findings[0].line(), 14);
}

/// Pairs of attached models get the prefix, and those of replicates are copied for each replica.
#[test]
fn pairs_of_replicated_geoms_are_replicated() {
    let text = r#"<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
        <replicate count="3" offset="1 0 0"><body name="b"><freejoint/><geom name="foot" size="0.1"/></body></replicate>
        </worldbody><contact><pair geom1="foot" geom2="floor" friction="0.4 0.4"/></contact></mujoco>"#;
    let robot = read(text);
    let names: Vec<&str> = robot.contact_pairs.iter().map(|pair| pair.shapes[0].as_str()).collect();
    assert_eq!(names, ["foot0", "foot1", "foot2"]);
    assert!(robot.contact_pairs.iter().all(|pair| pair.shapes[1] == "floor" && pair.friction[0] == 0.4));
}

fn run(text: &str, links: bool, v: &[f64], steps: usize) -> (Vec<f64>, Vec<f64>) {
    let model = Model::new(read(text)).expect("a model");
    let contacts = ContactSet::new(&model, &[Ground::level(-0.1)]).expect("a ground");
    let contacts = if links { contacts.with_links(&model) } else { contacts };
    let q = robot_dynamics::model::neutral(&model);
    let run = SimulationBuilder::new(&model)
        .method(Method::Implicit)
        .contacts(contacts)
        .dt(1e-3)
        .build()
        .unwrap()
        .run_steps_from(&q, v, steps, RunOptions::new().sample_ends())
        .expect("a run");
    (run.q, run.v)
}

/// A ball without collision bits falls. With a pair it slides on the ground with the friction of the pair, x
/// = v₀t − ½μgt².
#[test]
fn a_pair_with_a_plane_is_a_ground_contact() {
    let ball = |pair: &str| {
        format!(
            r#"<mujoco><default><geom contype="0" conaffinity="0"/></default>
              <worldbody><geom name="floor" type="plane" size="1 1 1"/>
                <body><freejoint/><geom name="ball" size="0.1"/></body></worldbody>
              <contact>{pair}</contact></mujoco>"#
        )
    };
    let v = [2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let (q, _) = run(&ball(""), false, &v, 100);
    assert!((q[2] + 0.5 * 9.81 * 0.01).abs() < 1e-12, "{q:?}");
    let (q, _) = run(&ball(r#"<pair geom1="floor" geom2="ball" friction="0.3"/>"#), false, &v, 100);
    let expected = 0.2 - 0.5 * 0.3 * 9.81 * 0.01;
    // A sliding ball rises by less than 1e-5 m, and has no friction while it is above the ground.
    assert!(q[2].abs() < 1e-5 && (q[0] - expected).abs() < 1e-5, "{q:?} for {expected}");
}

/// The finger comes to rest on its parent `ball`, although bits, the exclusion and the joint between them
/// rule out contact.
#[test]
fn a_pair_overrides_bits_exclusions_and_joints() {
    let floor = r#"<pair geom1="floor" geom2="ball"/>"#;
    let (q, _) = run(&balls(floor), true, &[0.0; 7], 1000);
    assert!(q[7] < -4.0, "it falls through: {q:?}");
    let both = format!(r#"{floor}<pair geom1="tip" geom2="ball" friction="0 0"/>"#);
    let (q, v) = run(&balls(&both), true, &[0.0; 7], 4000);
    // The distance is 0.3 m and the radii are 0.1 and 0.05 m. A displacement by the impact decays as
    // exp(−t/0.1 s), to zero here.
    assert!((q[7] + 0.15).abs() < 1e-9 && v[6].abs() < 1e-9, "{q:?} {v:?}");
}

/// MuJoCo's law uses the numbers of the pair, too.
#[test]
fn soft_contacts_have_the_surface_of_their_pair() {
    let text = balls(
        r#"<pair geom1="floor" geom2="ball" condim="3" friction="0.3 0.3" solref="0.05 1"/>
           <pair geom1="tip" geom2="ball" class="grip" margin="0.2"/>"#,
    );
    let model = Model::new(read(&text)).expect("a model");
    let contacts = ContactSet::new(&model, &[Ground::level(-0.099)]).expect("a ground").with_links(&model);
    let mut soft = SoftConstraints::new(&model, 1e-3)
        .expect("weights")
        .with_ground(&model, contacts)
        .expect("no restitution");
    let (mut workspace, mut acceleration) = (Workspace::new(&model), [0.0; 7]);
    let q = robot_dynamics::model::neutral(&model);
    soft.forward(
        &model,
        &mut workspace,
        SoftDynamicsInputs { q: &q, v: &[0.0; 7], tau: &[0.0; 7], contacts: &[] },
        &mut acceleration,
    )
    .expect("a state");
    let found: Vec<_> = soft.contacts().map(|(contact, _)| *contact).collect();
    let [floor, grip] = &found[..] else { panic!("{found:?}") };
    assert_eq!(
        (floor.condim, floor.friction, floor.softness.solref),
        (3, [0.3, 0.3, 0.005, 1e-4, 1e-4], [0.05, 1.0])
    );
    assert_eq!((grip.condim, grip.friction[0], grip.margin), (4, 0.7, 0.2));
    assert!((grip.distance - 0.15).abs() < 1e-12 && grip.other.is_some(), "{grip:?}");
}
