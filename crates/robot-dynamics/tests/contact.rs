//! Compares contact of robots from files with another method, and with the laws of contact.

use std::path::PathBuf;

use robot_dynamics::contact::{ContactSet, Ground};
use robot_dynamics::model::{Model, Workspace, neutral};
use robot_dynamics::simulation::{Method, SimulationBuilder, StepForces, StepWorkspace, Stepper};
use robot_dynamics::verification::admm;
use robot_dynamics::{LoadOptions, load_description_from_text, load_with, mesh_corners};

fn robot(file: &str) -> Model {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots").join(file);
    let options = LoadOptions::default().with_floating_base();
    load_with(path, &options).unwrap_or_else(|error| panic!("{file}: {error}")).model
}

/// After a drop from 5 cm, the velocities of every step with contacts equal those of the alternating
/// direction method of multipliers.
#[test]
fn dropped_robots_move_as_by_the_alternating_method() {
    for (file, steps) in [("quadruped.urdf", 400), ("humanoid.urdf", 400)] {
        let model = robot(file);
        let contacts = ContactSet::with_meshes(&model, &[Ground::level(0.0)], mesh_corners).unwrap();
        let (mut q, mut v) = (neutral(&model), vec![0.0; model.nv()]);
        let gap = contacts.clearance(&model, &mut Workspace::new(&model), &q).unwrap();
        q[2] += 0.05 - gap;
        let simulation = SimulationBuilder::new(&model).method(Method::Implicit).contacts(contacts);
        let mut implicit = simulation.build().unwrap().stepper();
        let (mut workspace, tau) = (StepWorkspace::new(&model), vec![0.0; model.nv()]);
        let (mut same, mut several, mut unsettled, mut without, mut farthest) = (0, 0, 0, 0, 0.0_f64);
        for step in 0..steps {
            implicit
                .step(&model, &mut workspace, &StepForces::new(&tau, true), 1e-3, &mut q, &mut v)
                .unwrap_or_else(|error| panic!("{file}, step {step}: {error}"));
            let Some(problem) = implicit.contact_problem() else { continue };
            if !problem.is_solved {
                without += 1;
                continue;
            }
            let other = admm::solve(&problem, &admm::Options::default());
            if !other.is_settled {
                unsettled += 1;
                continue;
            }
            let fastest = problem.free_velocity.amax().max(1e-3);
            // The library computes s to 1e-7 of the speeds.
            let own = problem.violation(&problem.impulse).worst();
            assert!(own < 1e-6 * fastest, "{file}, step {step}: {own} from the laws");
            let off = (&problem.velocity - &other.velocity).amax() / fastest;
            if off < 1e-5 {
                (same, farthest) = (same + 1, farthest.max(off));
            } else {
                several += 1;
            }
        }
        println!(
            "{file}: {same} steps the same to {farthest:.1e} of the speeds, {several} with several solutions, {without} without \
             one, {unsettled} that the other method did not finish"
        );
        let all = same + several + unsettled + without;
        assert!(all > steps / 2 && same * 100 >= 95 * all, "{file}: {same} of {all}");
        let laws = implicit.contact_laws().unwrap();
        assert!(laws.solved >= all && laws.violation.worst() < 1e-5, "{file}: {laws:?}");
    }
}

/// Bodies that slide on a flat height field lose the speed μg per second, each with the μ of its own pair:
/// that of a `<pair>`, or the larger one of both geoms. A pair with a plane does not affect the height field,
/// and masks and exclusions hold for it as for planes.
#[test]
fn bodies_on_a_height_field_have_the_friction_of_their_pairs() {
    let bodies = ["own", "mixed", "paired", "excluded", "masked"];
    let body = |(k, name): (usize, &&str)| {
        let (y, masks) = (k as f64 - 2.0, if *name == "masked" { "contype='2' conaffinity='2'" } else { "" });
        let geom = format!("name='{name}' type='box' size='0.1 0.1 0.02' mass='1' {masks}");
        format!("<body name='{name}' pos='0 {y} 0.02'><freejoint/><geom {geom} friction='0.7 0 0'/></body>")
    };
    let bodies_text: String = bodies.iter().enumerate().map(body).collect();
    let text = format!(
        "<mujoco><asset><hfield name='flat' size='5 5 1 1' nrow='3' ncol='3'/></asset>
         <worldbody>
           <geom name='abyss' type='plane' size='1 1 1' pos='0 0 -50'/>
           <body name='land'><geom name='land' type='hfield' hfield='flat' friction='0.4 0 0'/></body>
           {bodies_text}
         </worldbody>
         <contact>
           <pair geom1='paired' geom2='abyss' friction='0.9 0.9'/>
           <pair geom1='mixed' geom2='abyss' friction='0.9 0.9'/>
           <pair geom1='land' geom2='own' friction='0.2 0.2'/>
           <pair geom1='paired' geom2='land' friction='0.3 0.3'/>
           <exclude body1='excluded' body2='land'/>
         </contact></mujoco>"
    );
    let robot = load_description_from_text(&text, &LoadOptions::default()).unwrap().compile().unwrap();
    let mut simulation = robot.simulation().method(Method::Implicit).build().unwrap();
    // Without the feature `convex` boxes do not touch each other. Contact with the ground is not affected.
    assert!(
        simulation.left_out().iter().all(|line| line.contains("`convex`")),
        "{:?}",
        simulation.left_out()
    );
    let mut v = vec![0.0; 30];
    for k in 0..5 {
        v[6 * k] = 2.0;
    }
    let q = simulation.q().to_vec();
    simulation.set_state(&q, &v).unwrap();
    simulation.run_for(0.2).unwrap();
    for (k, (name, friction)) in bodies.iter().zip([Some(0.2), Some(0.7), Some(0.3), None, None]).enumerate()
    {
        let [forward, up] = [0, 2].map(|i| simulation.v()[6 * k + i]);
        let expected =
            friction.map_or([2.0, -9.81 * 0.2], |friction: f64| [2.0 - 9.81 * friction * 0.2, 0.0]);
        // Velocities are along the axes of the body, whose orientation is constant. The box touches at its
        // corners from the first step.
        assert!(
            (forward - expected[0]).abs() < 1e-8 && (up - expected[1]).abs() < 1e-8,
            "{name}: {forward}, {up}"
        );
    }
    let contacts = simulation.contacts();
    let touching: Vec<_> = contacts.iter().map(|contact| contact.other_shape).collect();
    assert!(!touching.is_empty() && touching.iter().all(|name| *name == "land"), "{touching:?}");
}
