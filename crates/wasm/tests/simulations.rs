//! The page's simulations against whole runs of the library.

use dynamics::{EnergyAccount, Integrator, Reach2R, SystemEnergy, SystemStep};
use nalgebra::{Vector2, vector};
use wasm::{Brick, FallingArm, LabError, Race, Robot, RobotFiles};

const PANDA: &str = include_str!("../../../robots/panda.urdf");

/// Steps in frames of any length give the library's run, bit for bit.
#[test]
fn a_robot_falls_as_in_one_run() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    robot.place(&[0.1, -0.4, 0.2, -1.5, 0.3, 1.2, 0.0])?;
    let expected = robot.reference_fall(200)?;
    for frame in [1, 16, 17, 100, 66] {
        robot.advance(frame)?;
    }
    assert_eq!(robot.q(), expected);
    Ok(())
}

/// With gravity compensation at its pose, the robot moves by rounding only.
#[test]
fn a_held_robot_stays() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    let pose = [0.1, -0.4, 0.2, -1.5, 0.3, 1.2, 0.0];
    robot.place(&pose)?;
    robot.hold(20.0, 1.0)?;
    robot.advance(500)?;
    for (q, start) in robot.q().iter().zip(pose) {
        assert!((q - start).abs() < 1e-9, "{q} and {start}");
    }
    Ok(())
}

/// Without other effects, M q̈ + C q̇ + g over a step is zero to second order in its length.
#[test]
fn the_equation_closes_over_a_step() -> Result<(), LabError> {
    let left_over = |h: f64, steps: u32| -> Result<f64, LabError> {
        let mut robot = Robot::load(PANDA, false, false)?;
        robot.place(&[0.1, -0.4, 0.2, -1.5, 0.3, 1.2, 0.0])?;
        assert!(robot.torques().inertial.is_empty() && largest(&robot.torques().coriolis) < 1e-12);
        robot.choose("rk4", h, vec!["dissipation".into()])?;
        robot.advance(steps)?;
        let torques = robot.torques();
        assert!(largest(&torques.coriolis) > 1.0 && largest(&torques.gravity) > 10.0, "{torques:?}");
        for (k, rest) in torques.rest.iter().enumerate() {
            let terms = torques.inertial[k] + torques.coriolis[k] + torques.gravity[k];
            assert!((terms - rest).abs() < 1e-12 && torques.applied[k] == 0.0, "{torques:?}");
        }
        Ok(largest(&torques.rest))
    };
    let (coarse, fine) = (left_over(2e-3, 100)?, left_over(1e-3, 200)?);
    assert!(coarse < 1e-2 && (coarse / fine - 4.0).abs() < 0.4, "{coarse} and {fine} N·m");
    Ok(())
}

/// Motors that hold a pose give g; the ground carries a robot that lies on it.
#[test]
fn the_terms_at_rest() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    robot.place(&[0.1, -0.4, 0.2, -1.5, 0.3, 1.2, 0.0])?;
    robot.hold(20.0, 1.0)?;
    robot.advance(10)?;
    let torques = robot.torques();
    assert!(apart(&torques.applied, &torques.gravity) < 1e-6 && largest(&torques.rest) < 1e-6, "{torques:?}");

    let mut robot = Robot::load(include_str!("../../../robots/quadruped.urdf"), true, false)?;
    robot.set_ground(true)?;
    robot.place(&robot.start_pose())?;
    robot.advance(3000)?;
    let torques = robot.torques();
    // The base's translation in its own frame: the weight, in any orientation of the base.
    let carried = apart(&torques.rest[..3], &[0.0; 3]);
    let weight = robot.total_mass() * 9.81;
    assert!((carried - weight).abs() < 1e-3 * weight, "{carried} of {weight} N: {torques:?}");
    Ok(())
}

/// Both formats, told apart by their content; every shape has an existing link.
#[test]
fn a_file_is_read_by_what_it_is() -> Result<(), LabError> {
    let mut arm = Robot::load(include_str!("../../../robots/arm.xml"), false, false)?;
    let (shapes, links) = (arm.shapes(), arm.bodies().len());
    assert_eq!(shapes.len(), 9);
    assert!(
        shapes.iter().all(|shape| shape.link < links && shape.pose.len() == 12 && !shape.size.is_empty())
    );
    assert_eq!(arm.poses().len(), 12 * links);
    assert!(Robot::load("<sdf/>", false, false).is_err());
    Ok(())
}

/// A four-bar linkage is closed at its placement and while it falls. By every method the loop stays closed
/// and does no work, until it is switched off.
#[test]
fn a_closed_loop_stays_closed() -> Result<(), LabError> {
    let mut ring = Robot::load(include_str!("../../../robots/linkage.xml"), false, false)?;
    // The pin on the coupler and on the rocker, in the x-z plane.
    let gap = |ring: &mut Robot| {
        let (poses, bodies) = (ring.poses(), ring.bodies());
        let pin = |name: &str, at: [f64; 3]| {
            let link = bodies.iter().position(|body| body.name == name).unwrap_or_default();
            let pose = &poses[12 * link..12 * link + 12];
            [0, 1, 2].map(|i| pose[9 + i] + (0..3).map(|j| pose[3 * i + j] * at[j]).sum::<f64>())
        };
        apart(&pin("coupler", [0.5, 0.0, 0.1]), &pin("rocker", [0.0, 0.0, 0.3]))
    };
    ring.place(&[0.6, 0.0, 0.0])?;
    assert!(gap(&mut ring) < 1e-9);
    let mut most = 0.0_f64;
    for _ in 0..100 {
        ring.advance(20)?;
        most = most.max(gap(&mut ring));
    }
    let account = ring.energy_account();
    assert!(most < 1e-9 && account.damping > 1e-3, "{most} m: {account:?}");
    assert!(account.unaccounted.abs() < 1e-3 * (1.0 + account.damping), "{account:?}");
    assert!(ring.acting().contains(&"equalities".to_owned()) && ring.loose().is_none());
    ring.choose("rk4", 1e-3, Vec::new())?;
    ring.advance(200)?;
    assert!(gap(&mut ring) < 1e-9);
    ring.choose("rk4", 1e-3, vec!["equalities".into()])?;
    ring.advance(200)?;
    assert!(!ring.acting().contains(&"equalities".to_owned()) && gap(&mut ring) > 1e-3);
    Ok(())
}

/// A scene from memory gives the robot that it includes.
#[test]
fn a_scene_includes_its_robot() -> Result<(), LabError> {
    let mut files = RobotFiles::new();
    files.add("go/scene.xml", b"<mujoco><include file='robot.xml'/></mujoco>".to_vec());
    files.add("go/robot.xml", include_bytes!("../../../robots/arm.xml").to_vec());
    let mut scene = Robot::load_from_files(&files, "go/scene.xml", false, false)?;
    let mut alone = Robot::load(include_str!("../../../robots/arm.xml"), false, false)?;
    assert_eq!((scene.poses(), scene.total_mass()), (alone.poses(), alone.total_mass()));
    let refused = Robot::load_from_files(&RobotFiles::new(), "go/scene.xml", false, false);
    assert!(refused.is_err_and(|error| error.to_string().contains("go/scene.xml")));
    Ok(())
}

/// Joints without mass are locked, and the rest falls.
#[test]
fn joints_without_mass_are_held_still() -> Result<(), LabError> {
    let text = r#"<robot name="flag">
        <link name="base"/>
        <link name="rod"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
            <inertia ixx="0.1" iyy="0.1" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
        <link name="flag"/>
        <joint name="hinge" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 1 0"/></joint>
        <joint name="pole" type="continuous"><parent link="rod"/><child link="flag"/><axis xyz="0 0 1"/></joint>
    </robot>"#;
    let mut robot = Robot::load(text, false, false)?;
    assert_eq!((robot.locked(), robot.q().len()), (vec!["pole".to_owned()], 1));
    robot.place(&[1.0])?;
    robot.advance(100)?;
    assert!(robot.v()[0].abs() > 0.1, "{:?}", robot.v());
    assert!(Robot::load(PANDA, false, false)?.locked().is_empty());
    Ok(())
}

/// A hand that pulls a falling robot moves the held point towards it, and the energy account includes its
/// work.
#[test]
fn a_hand_pulls() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    robot.place(&robot.start_pose())?;
    let last = robot.bodies().len() - 1;
    let pose = robot.poses()[12 * last..].to_vec();
    let (from, to) = ([pose[9], pose[10], pose[11]], [pose[9] + 0.1, pose[10] + 0.2, pose[11] - 0.1]);
    robot.hold(5.0, 1.0)?;
    robot.grab(last, &from)?;
    assert!(apart(&robot.held_point(), &from) < 1e-12);
    robot.pull_to(&to)?;
    robot.advance(3000)?;
    assert!(apart(&robot.held_point(), &to) < 0.5 * apart(&from, &to), "{:?}", robot.held_point());
    let account = robot.energy_account();
    assert!(account.work.abs() > 0.1 && account.unaccounted.abs() < 1e-2, "{account:?}");
    robot.let_go();
    assert!(robot.held_point().is_empty());
    Ok(())
}

/// At rest the hand guides: the point reaches it by inverse kinematics within the limits, and nothing moves
/// by itself.
#[test]
fn a_hand_leads() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    robot.place(&robot.start_pose())?;
    let last = robot.bodies().len() - 1;
    let pose = robot.poses()[12 * last..].to_vec();
    robot.grab(last, &pose[9..12])?;
    let near = [pose[9] + 0.05, pose[10] + 0.1, pose[11] + 0.05];
    assert!(robot.lead_to(&near)? < 1e-4);
    assert!(apart(&robot.held_point(), &near) < 1e-4);
    let far = robot.lead_to(&[9.0, 0.0, 0.0])?;
    assert!(far > 7.0, "an arm of a metre stays {far} m away");
    for (coordinate, q) in robot.coordinates().iter().zip(robot.q()) {
        assert!(q >= coordinate.lower - 1e-9 && q <= coordinate.upper + 1e-9, "{} at {q}", coordinate.name);
    }
    assert!(robot.v().iter().all(|v| *v == 0.0));
    Ok(())
}

/// The page's default method stops joints at their limits, and reports the losses.
#[test]
fn stops_hold() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    let step = robot.steady_step()?;
    let seconds = 3.0;
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)]
    robot.advance((seconds / step).round() as u32)?;
    for (coordinate, q) in robot.coordinates().iter().zip(robot.q()) {
        assert!(q >= coordinate.lower - 1e-9 && q <= coordinate.upper + 1e-9, "{} at {q}", coordinate.name);
    }
    let account = robot.energy_account();
    assert!(account.stops > 1.0, "{account:?}");
    assert!(
        (account.damping + account.friction + account.stops - account.dissipated).abs() < 1e-9,
        "{account:?}"
    );
    Ok(())
}

/// A floating robot falls on the ground, comes to rest, and loads it with its weight.
#[test]
fn the_ground_holds() -> Result<(), LabError> {
    let mut robot = Robot::load(include_str!("../../../robots/quadruped.urdf"), true, false)?;
    robot.set_ground(true)?;
    assert!(robot.grounded() && robot.left_out().is_empty());
    let step = robot.steady_step()?;
    let start = robot.start_pose();
    assert!(start[2] > 0.3, "lifted out of the ground: {start:?}");
    let count = |seconds: f64| {
        #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // // some thousands
        let steps = (seconds / step).round() as u32;
        steps
    };
    robot.advance(count(0.05))?;
    assert!(robot.contact_forces().is_empty(), "in the air");
    robot.advance(count(4.0))?;
    let height = robot.q()[2];
    robot.advance(count(1.0))?;
    assert!((robot.q()[2] - height).abs() < 1e-9, "it lies still");
    let forces = robot.contact_forces();
    // Its own links may lie on each other, above the ground.
    let on_ground = || forces.chunks_exact(6).filter(|touch| touch[2] < 1e-3);
    let lifted: f64 = on_ground().map(|touch| touch[5]).sum();
    // Joint damping brakes the remaining motion of 1e-11 rad/s.
    assert!((lifted / (robot.total_mass() * 9.81) - 1.0).abs() < 1e-6, "{lifted} N");
    assert!(on_ground().count() >= 3, "it stands: {forces:?}");
    assert!(forces.chunks_exact(6).all(|touch| touch[2] > -1e-3), "where the ground is: {forces:?}");
    let account = robot.energy_account();
    assert!(account.impacts > 1.0 && account.sliding > 0.01, "{account:?}");
    let named = account.damping + account.friction + account.stops + account.sliding + account.impacts;
    assert!((named - account.dissipated).abs() < 1e-9, "{account:?}");
    assert_eq!(robot.q(), {
        let mut again = Robot::load(include_str!("../../../robots/quadruped.urdf"), true, false)?;
        again.set_ground(true)?;
        again.choose("", step, Vec::new())?;
        again.place(&start)?;
        again.reference_fall(usize::try_from(count(0.05) + count(4.0) + count(1.0)).unwrap_or(0))?
    });
    robot.set_ground(false)?;
    robot.advance(count(0.5))?;
    assert!(robot.q()[2] < height - 1.0, "without ground it falls on");
    Ok(())
}

/// A robot's mesh makes contact as its convex hull, once its points are given.
#[test]
fn given_meshes_touch() -> Result<(), LabError> {
    let text = r#"<robot name="cone"><link name="cone">
        <inertial><mass value="2"/><inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
        <collision><geometry><mesh filename="cone.stl"/></geometry></collision></link></robot>"#;
    let mut robot = Robot::load(text, true, false)?;
    robot.set_ground(true)?;
    assert!(!robot.grounded() && robot.left_out().len() == 1, "{:?}", robot.left_out());
    let tetrahedron = [0.0, 0.0, -0.1, 0.1, 0.0, 0.1, -0.1, 0.1, 0.1, -0.1, -0.1, 0.1];
    robot.give_mesh(0, &tetrahedron);
    robot.set_ground(true)?;
    assert!(robot.grounded());
    let start = robot.start_pose();
    // Its tip is 0.1 m above the ground.
    assert!((start[2] - 0.2).abs() < 1e-12, "{start:?}");
    Ok(())
}

/// The file's effects act by the library's default method, which has a reason. Each can be switched off by
/// name, and the lab lists unsupported ones.
#[test]
fn what_acts_is_the_librarys() -> Result<(), LabError> {
    let mut robot = Robot::load(include_str!("../../../robots/hand.xml"), false, false)?;
    let stated = ["dissipation", "limits", "springs", "actuators", "equalities", "contacts", "link-contacts"];
    assert_eq!((robot.effects(), robot.acting()), (stated.map(str::to_owned).to_vec(), robot.effects()));
    assert_eq!(robot.method(), "implicit");
    assert!(!robot.reason().is_empty());
    assert!(robot.left_out().is_empty(), "{:?}", robot.left_out());

    robot.choose("", 1e-3, vec!["limits".into(), "contacts".into()])?;
    assert!(!robot.acting().iter().any(|effect| effect == "limits" || effect.ends_with("contacts")));
    assert_eq!(robot.effects(), stated, "the switches stay");

    robot.choose("rk4", 1e-3, Vec::new())?;
    assert!(!robot.left_out().is_empty());
    assert!(robot.choose("rk5", 1e-3, Vec::new()).is_err() && robot.choose("", 0.0, Vec::new()).is_err());
    assert!(robot.choose("mujoco", 1e-3, vec!["limits".into()]).is_err(), "a method with limits of its own");
    assert_eq!(robot.method(), "rk4", "the choice before is kept");
    Ok(())
}

/// Servos of the file move their joints to the controls, and are off while the page's motors hold a pose.
#[test]
fn the_files_actuators_act() -> Result<(), LabError> {
    let mut robot = Robot::load(include_str!("../../../robots/hand.xml"), false, false)?;
    robot.place(&robot.start_pose())?;
    let names: Vec<String> = robot.actuators().into_iter().map(|one| one.name).collect();
    assert_eq!(names, ["wrist", "first", "second", "spread", "bend"]);
    robot.set_controls(&[0.5, 0.0, 0.0, 0.0, 0.0])?;
    robot.advance(3000)?;
    assert!(
        (robot.q()[0] - 0.5).abs() < 0.1 && robot.energy_account().work.abs() > 1e-3,
        "{:?}: {:?}",
        robot.q(),
        robot.energy_account()
    );
    let time = robot.time();
    robot.hold(20.0, 1.0)?;
    assert!(!robot.acting().contains(&"actuators".to_owned()));
    robot.release()?;
    assert!(robot.acting().contains(&"actuators".to_owned()) && (robot.time() - time).abs() < 1e-12);
    assert!(robot.set_controls(&[0.0]).is_err() && robot.set_controls(&[f64::NAN; 5]).is_err());
    Ok(())
}

/// The page's example: with the controls of the file's poses in turn, fingers grip a box, lift it off a table
/// and hold it.
#[test]
fn a_gripper_lifts_a_box() -> Result<(), LabError> {
    let mut robot = Robot::load(include_str!("../../../robots/gripper_and_box.xml"), false, false)?;
    robot.set_ground(true)?;
    assert!(robot.acting().contains(&"link-contacts".to_owned()) && robot.left_out().is_empty());
    let poses = robot.named_poses();
    let place = |name: &str| poses.iter().find(|pose| pose.name == name);
    let (open, lifted) =
        (place("open").map(|pose| pose.q.clone()), place("lifted").map(|pose| pose.q.clone()));
    assert_eq!(open, Some(robot.start_pose()));
    robot.place(&robot.start_pose())?;
    robot.poses_in_turn();
    robot.advance(1200)?;
    // The box has four corners on the table, and each finger touches it.
    let touching = robot.contact_forces().len() / 6;
    assert!(touching >= 6, "{touching} contacts");
    robot.advance(2800)?;
    let apart = |q: &[f64]| lifted.as_ref().map_or(f64::NAN, |lifted| (q[5] - lifted[5]).abs());
    // The servo of the lift deflects by the weight over its stiffness.
    assert!(apart(&robot.q()) < 2e-3, "{:?}", robot.q());
    let height = robot.q()[5];
    robot.advance(1000)?;
    assert!((robot.q()[5] - height).abs() < 1e-9, "it is held");
    Ok(())
}

/// A torque of the page's motors beyond an effort limit is limited and counted.
#[test]
fn torques_are_cut_off() -> Result<(), LabError> {
    let mut robot = Robot::load(PANDA, false, false)?;
    let pose = robot.start_pose();
    robot.place(&pose)?;
    let mut far = pose.clone();
    far[0] += 2.0;
    robot.hold_at(&far, 200.0, 1.0)?;
    robot.advance(20)?;
    assert!(robot.steps_at_limit() > 0);
    let limit = robot.coordinates()[0].effort;
    assert!((robot.torques().applied[0].abs() - limit).abs() < 1e-12);
    Ok(())
}

fn largest(list: &[f64]) -> f64 {
    list.iter().fold(0.0, |most: f64, x| most.max(x.abs()))
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
}

/// The arm's energy account equals the library's over the same steps.
#[test]
fn the_falling_arm_keeps_the_librarys_energy_account() -> Result<(), LabError> {
    let mut lab = FallingArm::worked_example()?;
    lab.advance(1500)?;
    let arm = Reach2R::worked_example();
    let quarter = core::f64::consts::FRAC_PI_4;
    let (mut q, mut qd, zero) = (vector![quarter, 2.0 * quarter], Vector2::zeros(), Vector2::zeros());
    let mut energy_account = EnergyAccount::open(&arm, &q, &qd);
    for _ in 0..1500 {
        let next = Integrator::RungeKutta4.step(&arm, &q, &qd, &zero, 1e-3)?;
        energy_account.record(&arm, (&q, &qd), (&next.0, &next.1), &zero, 1e-3);
        (q, qd) = next;
    }
    assert_eq!(
        (lab.q(), lab.qd(), lab.drift()),
        (q.as_slice().to_vec(), qd.as_slice().to_vec(), energy_account.drift())
    );
    Ok(())
}

/// Without C q̇ the energy drifts by more than a fifth, with it by less than a millionth.
#[test]
fn leaving_out_coriolis_shows() -> Result<(), LabError> {
    for (coriolis, holds) in [(true, true), (false, false)] {
        let mut lab = FallingArm::worked_example()?;
        lab.set_coriolis(coriolis);
        lab.advance(10_000)?;
        assert_eq!(lab.drift() < 1e-6, holds);
        assert_eq!(lab.drift() > 0.2, !holds);
    }
    Ok(())
}

/// With joint friction the arm ends hanging, and the energy account contains all losses. A copy without
/// friction keeps swinging.
#[test]
fn a_damped_arm_comes_to_rest_and_its_fork_does_not() -> Result<(), LabError> {
    let mut lab = FallingArm::worked_example()?;
    assert!(lab.set_damping(-1.0).is_err() && lab.set_damping(f64::NAN).is_err());
    lab.set_damping(2.0)?;
    lab.advance(1000)?;
    let mut free = lab.fork(1.0)?;
    free.set_damping(0.0)?;
    // The slowest mode takes about 4 s to decay by a factor of e.
    lab.advance(150_000)?;
    free.advance(10_000)?;
    // Hanging: q = (−π/2, 0).
    assert!((lab.q()[0] + core::f64::consts::FRAC_PI_2).abs() + lab.q()[1].abs() < 1e-9, "{:?}", lab.q());
    let energies = lab.energies();
    // Simpson's rule over the friction losses, of order 4 in steps of a millisecond.
    assert!((energies.start - energies.total - lab.dissipated()).abs() < 1e-8 * energies.start.abs());
    assert!(lab.drift() < 1e-8, "{:e}", lab.drift());
    assert!(free.dissipated() == 0.0 && free.drift() < 1e-6, "{:e}", free.drift());
    Ok(())
}

/// The torques of the stack add up to the acting torque, which is zero.
#[test]
fn the_torque_stack_adds_up_to_nothing() -> Result<(), LabError> {
    let mut lab = FallingArm::worked_example()?;
    lab.set_damping(0.7)?;
    lab.advance(700)?;
    let stack = lab.torque_stack()?;
    for joint in 0..2 {
        let sum: f64 = (0..4).map(|term| stack[2 * term + joint]).sum();
        // A dozen roundings of terms below 100 N·m.
        assert!(sum.abs() < 1e-12, "joint {joint}: {sum:e}");
    }
    Ok(())
}

/// A runner that diverges leaves the race; the others go on.
#[test]
fn a_runner_that_fails_does_not_stop_the_race() -> Result<(), LabError> {
    let names = ["explicit-euler", "rk4"].map(str::to_owned).to_vec();
    let mut race = Race::new(names, &[0.8, 1.6], &[0.0, 0.0], 0.3, 3000.0)?;
    race.advance(10_000);
    assert!(!race.fault(0)?.is_empty());
    assert!((race.time() - 3000.0).abs() < 1e-9);
    assert!(race.errors(0)?.len() < race.times().len());
    assert!(race.drift(2).is_err());
    Ok(())
}

/// The texts that the page shows, in `snapshots/messages.snap`. `INSTA_UPDATE=always` writes them anew.
#[test]
fn messages() -> Result<(), LabError> {
    use core::fmt::Write;
    let mut text = String::new();
    let mut add = |call: &str, error: Option<LabError>| {
        let message = error.map_or_else(|| "no error".into(), |error| error.to_string());
        let _ = writeln!(text, "{call}\n  {message}");
    };
    let mut brick = Brick::new(0.3, 0.2, 0.1, 1000.0)?;
    add("Brick::new(0, …)", Brick::new(0.0, 0.2, 0.1, 1000.0).err());
    add("Brick.place(zero quaternion)", brick.place(&[0.0; 4], &[0.0; 3]).err());
    add("Brick.spin(NaN)", brick.spin(&[f64::NAN, 0.0, 0.0]).err());
    add("Brick.set_method(euler)", brick.set_method("euler", 1e-3).err());
    let mut arm = FallingArm::worked_example()?;
    add("FallingArm.set_method(euler)", arm.set_method("euler", 1e-3).err());
    add("FallingArm.set_method(step -1)", arm.set_method("rk4", -1.0).err());
    add("FallingArm.set_damping(-1)", arm.set_damping(-1.0).err());
    arm.set_method("explicit-euler", 0.3)?;
    add("FallingArm.advance, step 0.3", arm.advance(100_000).err());
    let mut race = Race::new(vec!["explicit-euler".to_owned()], &[0.8, 1.6], &[0.0, 0.0], 0.3, 3000.0)?;
    race.advance(10_000);
    add("Race.fault(1)", race.fault(1).err());
    let fault = race.fault(0)?;
    let hand = include_str!("../../../robots/hand.xml");
    let mut robot = Robot::load(hand, false, false)?;
    add("Robot::load(sdf)", Robot::load("<sdf/>", false, false).err());
    add("Robot.place([0])", robot.place(&[0.0]).err());
    add("Robot.choose(without wind)", robot.choose("", 1e-3, vec!["wind".into()]).err());
    add("Robot.choose(mujoco, without limits)", robot.choose("mujoco", 1e-3, vec!["limits".into()]).err());
    add("Robot.hold(-1)", robot.hold(-1.0, 1.0).err());
    add("Robot.grab(link 99)", robot.grab(99, &[0.0; 3]).err());
    robot.choose("rk4", 1e-3, Vec::new())?;
    let _ = writeln!(text, "Race.fault(0)\n  {fault}\nRobot.reason\n  {}", robot.reason());
    let _ = writeln!(text, "Robot.left_out, rk4\n  {}", robot.left_out().join("\n  "));
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!("messages", text));
    Ok(())
}
