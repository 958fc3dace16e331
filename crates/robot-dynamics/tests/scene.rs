//! Scenes of several robots: laws that tie the scene to its parts.

use robot_dynamics::algorithms::{
    ReferenceFrame, frame_pose, frame_velocity, kinetic_energy, potential_energy,
};
use robot_dynamics::description::{
    Base, JointKind, ModelError, Mount, Object, Pose, RandomRobotOptions, RobotDescription, Scene, Shape,
    pendulum, random_robot,
};
use robot_dynamics::model::{Model, Workspace, random_state};
use robot_dynamics::nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::{Format, LoadOptions, load_description, load_description_from_text};

fn robot(file: &str) -> RobotDescription {
    let path = format!("{}/../../robots/{file}", env!("CARGO_MANIFEST_DIR"));
    load_description(path, &LoadOptions::default()).expect("a robot of the repository").description
}

fn place(random: &mut SplitMix64) -> Pose {
    let mut three = || core::array::from_fn(|_| random.uniform(-1.0, 1.0));
    let at = three();
    Pose::from_xyz_rpy(at, three())
}

/// The values of q or v of the joints with a prefix, in the order of a robot's own joints.
fn part(scene: &Model, own: &Model, prefix: &str, values: &[f64], of_q: bool) -> Vec<f64> {
    let moving = |joint: &&robot_dynamics::model::Joint| if of_q { joint.nq > 0 } else { joint.nv > 0 };
    let values_of = |joint: &robot_dynamics::model::Joint| {
        let name = format!("{prefix}{}", joint.name);
        let joint = scene.joints().iter().find(|joint| joint.name == name).expect("a joint of the scene");
        values[if of_q { joint.q() } else { joint.v() }].to_vec()
    };
    own.joints().iter().filter(moving).flat_map(values_of).collect()
}

/// Two robots in one world have the sum of their energies, at the state of each.
#[test]
fn energies_of_robots_in_the_world_add() {
    let mut random = SplitMix64::new(7);
    for seed in 0..30 {
        let options = RandomRobotOptions::default();
        let robots = [random_robot(seed, &options), random_robot(seed + 1000, &options)];
        let mut scene = Scene::new("both").with_gravity(robots[0].gravity);
        let places = [place(&mut random), place(&mut random)];
        for ((robot, place), prefix) in robots.iter().zip(places).zip(["a_", "b_"]) {
            scene.add(robot, &Mount::at(place).with_prefix(prefix)).expect("other names");
        }
        let model = Model::new(scene.into_description()).expect("a valid scene");
        let state = random_state(&model, &mut random);
        let w = &mut Workspace::new(&model);
        let (mut kinetic, mut size) = (0.0, 0.0);
        for (robot, prefix) in robots.into_iter().zip(["a_", "b_"]) {
            // The kinetic energy of a robot does not depend on the pose of its base.
            let own = Model::new(robot).expect("a valid robot");
            let (q, v) =
                (part(&model, &own, prefix, &state.q, true), part(&model, &own, prefix, &state.v, false));
            let energy = kinetic_energy(&own, &mut Workspace::new(&own), &q, &v);
            kinetic += energy;
            size += energy.abs();
        }
        let found = kinetic_energy(&model, w, &state.q, &state.v);
        assert!((found - kinetic).abs() < 1e-11 * size, "robots of seed {seed}: {found}, not {kinetic}");
    }
}

/// A robot on a frame of another moves with that frame. Poses compose, and its energies are those of the
/// robot with a floating base at the frame's pose and velocity.
#[test]
fn a_mounted_robot_moves_with_its_parent() {
    let mut random = SplitMix64::new(8);
    for seed in 0..30 {
        let options = RandomRobotOptions::default();
        let (mut carrier, mut load) = (random_robot(seed, &options), random_robot(seed + 1000, &options));
        (carrier.base, load.base) = (Base::Floating, Base::Fixed);
        let (mount_pose, tip) = (place(&mut random), carrier.links.last().expect("a link").name.clone());
        let mut scene = Scene::new("carried").with_gravity(carrier.gravity);
        scene.add(&carrier, &Mount::at(Pose::IDENTITY)).expect("an empty scene");
        let mount = Mount::on(&tip).with_pose(mount_pose).with_prefix("load_");
        scene.add(&load, &mount).expect("other names");
        let gravity = carrier.gravity;
        let model = Model::new(scene.into_description()).expect("a valid scene");
        let state = random_state(&model, &mut random);
        let (q, v, w) = (&state.q[..], &state.v[..], &mut Workspace::new(&model));
        let root = model.frame("load_link0").expect("the root of the load");
        let (pose, velocity) =
            (frame_pose(&model, w, q, root), frame_velocity(&model, w, q, v, root, ReferenceFrame::Local));
        let expected = frame_pose(&model, w, q, model.frame(&tip).expect("a link")).compose(&mount_pose);
        let off = pose.translation.iter().zip(expected.translation).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12, "seed {seed}: {pose:?}, not {expected:?}");

        let carrier = Model::new(carrier).expect("a valid robot");
        load.base = Base::Floating;
        load.gravity = gravity;
        let load = Model::new(load).expect("a valid robot");
        let (own_q, own_v) = (part(&model, &carrier, "", q, true), part(&model, &carrier, "", v, false));
        let of_load: Vec<_> = load.joints().iter().skip(1).collect();
        let joint_values = |values: &[f64], of_q: bool| -> Vec<f64> {
            let values_of = |joint: &&robot_dynamics::model::Joint| {
                let name = format!("load_{}", joint.name);
                let joint = model.joints().iter().find(|joint| joint.name == name).expect("a joint");
                values[if of_q { joint.q() } else { joint.v() }].to_vec()
            };
            of_load.iter().flat_map(values_of).collect()
        };
        let mut load_q = pose.translation.to_vec();
        let rotation = Matrix3::from_fn(|i, j| pose.rotation[i][j]);
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rotation));
        load_q.extend(turn.coords.iter());
        load_q.extend(joint_values(q, true));
        let load_v = [velocity.linear.to_vec(), velocity.angular.to_vec(), joint_values(v, false)].concat();
        let (cw, lw) = (&mut Workspace::new(&carrier), &mut Workspace::new(&load));
        let kinetic =
            [kinetic_energy(&carrier, cw, &own_q, &own_v), kinetic_energy(&load, lw, &load_q, &load_v)];
        let found = kinetic_energy(&model, w, q, v);
        let expected: f64 = kinetic.iter().sum();
        assert!((found - expected).abs() < 1e-10 * expected, "seed {seed}: K = {found}, not {expected}");
        let potential = [potential_energy(&carrier, cw, &own_q), potential_energy(&load, lw, &load_q)];
        let found = potential_energy(&model, w, q);
        let expected: f64 = potential.iter().sum();
        let size = 1.0 + potential.iter().map(|u| u.abs()).sum::<f64>();
        assert!((found - expected).abs() < 1e-11 * size, "seed {seed}: U = {found}, not {expected}");
    }
}

/// A robot with actuators, tendons, equalities, sensors and contact moves in a scene as it does alone.
#[test]
fn a_robot_moves_in_a_scene_as_alone() {
    let text = r#"<mujoco><option timestep="0.002" gravity="0 0 -9.81"/>
        <worldbody>
          <geom name="floor" type="plane" size="0 0 0.1"/>
          <body name="upper" pos="0 0 1">
            <joint name="shoulder" axis="0 1 0" damping="0.1"/>
            <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.04"/>
            <body name="lower" pos="0.4 0 0">
              <joint name="elbow" axis="0 1 0" damping="0.1"/>
              <geom type="capsule" fromto="0 0 0 0.4 0 0" size="0.03"/>
              <site name="hand" pos="0.4 0 0"/>
            </body>
          </body>
          <body name="slider" pos="0 0.5 1">
            <joint name="rail" type="slide" axis="1 0 0"/>
            <geom name="cart" type="box" size="0.1 0.1 0.1"/>
          </body>
          <body name="stone" pos="0 -0.5 0.3"><freejoint/><geom name="stone" type="box" size="0.1 0.1 0.1"/></body>
        </worldbody>
        <contact><exclude body1="upper" body2="lower"/><pair geom1="stone" geom2="floor" friction="0.3 0.3 0 0 0"/></contact>
        <tendon><fixed name="cord" stiffness="5"><joint joint="shoulder" coef="1"/><joint joint="elbow" coef="-0.5"/></fixed></tendon>
        <equality><joint name="gear" joint1="rail" joint2="shoulder" polycoef="0 0.2 0 0 0"/></equality>
        <actuator><position name="servo" joint="elbow" kp="20"/></actuator>
        <sensor><jointpos name="angle" joint="elbow"/><framepos name="at" objtype="site" objname="hand"/></sensor>
        <keyframe><key name="bent" qpos="0.3 -0.4 0.06 0 -0.5 0.3 1 0 0 0" ctrl="0.2"/></keyframe>
      </mujoco>"#;
    let alone = load_description_from_text(text, &LoadOptions::default()).expect("a valid robot").description;
    let (first, mut scene) = (pendulum(1.0, 0.2), Scene::new("with an arm"));
    scene.add(&first, &Mount::at(Pose::from_translation([5.0, 5.0, 5.0]))).expect("an empty scene");
    scene.add(&alone, &Mount::at(Pose::IDENTITY).with_prefix("arm_")).expect("other names");
    assert_eq!(scene.notes(), &[] as &[String]);
    let scene = Model::new(scene.into_description()).expect("a valid scene");
    let alone = Model::new(alone).expect("a valid robot");
    let (start, _) = alone.named_pose("bent").expect("a pose");
    let (scene_start, _) = scene.named_pose("arm_bent").expect("a pose");
    assert_eq!(part(&scene, &alone, "arm_", &scene_start, true), start);
    let run = |model: &Model, pose: &str| {
        let mut simulation = robot_dynamics::simulation(model).build().expect("a valid simulation");
        simulation.reset_to(pose).expect("a pose of the robot");
        assert_eq!(simulation.controls(), [0.2]);
        simulation.run_for(0.5).expect("a run");
        (simulation.q().to_vec(), simulation.v().to_vec())
    };
    let (q, v) = run(&alone, "bent");
    let (scene_q, scene_v) = run(&scene, "arm_bent");
    let (found_q, found_v) =
        (part(&scene, &alone, "arm_", &scene_q, true), part(&scene, &alone, "arm_", &scene_v, false));
    let off = |a: &[f64], b: &[f64]| {
        assert_eq!(a.len(), b.len());
        a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    // The contact problem of the scene has the same rows; its iteration stops at 1e-10 of the forces.
    assert!(off(&q, &found_q) < 1e-8 && off(&v, &found_v) < 1e-7, "{q:?}\n{found_q:?}");
    assert!(off(&q, &alone.named_pose("bent").expect("a pose").0) > 0.1, "the robot does not move");
}

/// A base with an arm, a gripper and objects is one tree that both file formats take.
#[test]
fn a_scene_is_written_and_read_back() {
    let mut scene = Scene::new("kitchen");
    scene.add(&robot("panda.urdf"), &Mount::at(Pose::from_translation([0.0, 0.0, 0.4]))).expect("an arm");
    let table = Object::fixed("table", Shape::Box { size: [1.0, 0.6, 0.04] });
    scene.add_object(&table, Pose::from_translation([0.7, 0.0, 0.38])).expect("a new name");
    for (k, x) in [0.5, 0.6, 0.7].into_iter().enumerate() {
        let cube = Object::of_density(format!("cube{k}"), Shape::Box { size: [0.05; 3] }, 500.0);
        scene.add_object(&cube, Pose::from_translation([x, 0.1, 0.425])).expect("a new name");
    }
    let model = Model::new(scene.into_description()).expect("a valid scene");
    let panda = Model::new(robot("panda.urdf")).expect("a valid robot");
    assert_eq!(model.nv(), panda.nv() + 3 * 6);
    let cubes = 3.0 * 500.0 * 0.05_f64.powi(3);
    assert!((model.mass() - panda.mass() - cubes).abs() < 1e-12);
    let written = robot_dynamics::write(model.description(), Format::Mjcf, None).expect("MJCF");
    let again = load_description_from_text(&written.text, &LoadOptions::default()).expect("its own output");
    let again = Model::new(again.description).expect("a valid robot");
    let q = robot_dynamics::model::neutral(&model);
    let (ours, theirs) = (model.mass_matrix(&q).expect("M"), again.mass_matrix(&q).expect("M"));
    assert!((&ours - &theirs).amax() < 1e-12 * ours.amax());
}

#[test]
fn refused_robots_leave_the_scene_as_it_is() {
    let mut scene = Scene::new("scene");
    scene.add(&pendulum(1.0, 1.0), &Mount::at(Pose::IDENTITY)).expect("an empty scene");
    let before = scene.clone();
    let again = scene.add(&pendulum(1.0, 1.0), &Mount::at(Pose::IDENTITY));
    assert!(matches!(&again, Err(ModelError::NameInScene { name, .. }) if name == "ceiling"), "{again:?}");
    let unknown = scene.add(&pendulum(1.0, 1.0), &Mount::on("tipp").with_prefix("b_"));
    let unknown = unknown.unwrap_err().to_string();
    assert_eq!(unknown, "the robot has no link or frame `tipp`; did you mean `tip`?");
    let mut forest = pendulum(1.0, 1.0);
    forest.joints.clear();
    assert!(matches!(
        scene.add(&forest, &Mount::at(Pose::IDENTITY).with_prefix("c_")),
        Err(ModelError::SeveralRoots { .. })
    ));
    let plane = Object::of_density("floor", Shape::Plane { half_size: [0.0; 2] }, 1000.0);
    let refused = scene.add_object(&plane, Pose::IDENTITY).unwrap_err();
    assert_eq!(refused.to_string(), "the mass of object `floor` must be positive and finite, got NaN kg");
    assert!(matches!(&refused, ModelError::Input(error) if error.quantity == "the mass of object `floor`"));
    assert_eq!(scene, before);
}

/// A joint of any kind holds a robot, and gravity and steps that differ are noted.
#[test]
fn joints_of_mounts_and_notes() {
    let mut scene = Scene::new("rail");
    let rail = JointKind::Prismatic { axis: [1.0, 0.0, 0.0] };
    scene.add(&pendulum(2.0, 0.5), &Mount::at(Pose::IDENTITY).with_joint(rail)).expect("an empty scene");
    let mut light = pendulum(1.0, 0.5);
    (light.gravity, light.time_step) = ([0.0, 0.0, -1.62], Some(0.01));
    scene.add(&light, &Mount::on("tip").with_prefix("moon_")).expect("other names");
    light.time_step = Some(0.02);
    scene.add(&light, &Mount::on("tip").with_prefix("step_")).expect("other names");
    assert_eq!(scene.notes().len(), 3, "{:?}", scene.notes());
    let model = Model::new(scene.into_description()).expect("a valid scene");
    assert_eq!(model.coordinate_names(), ["ceiling_joint", "hinge", "moon_hinge", "step_hinge"]);
    assert_eq!(model.description().time_step, Some(0.01));
    // 4 kg on the rail: M = 4 at its first entry.
    assert!((model.mass_matrix(&[0.0; 4]).expect("M")[(0, 0)] - 4.0).abs() < 1e-14);
}
