//! Steps with contact on the device.

use robot_dynamics::description::{LinkShape, Pose, Shape, ShapeRole};
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::simulation::{ContactStep, ContactStepInputs};
use robot_dynamics_generate::Table;
use robot_dynamics_gpu::Function;

use crate::robots;

const H: f64 = 2e-3;
const SWEEPS: u16 = 12;

/// The quadruped, of which only the feet touch.
fn quadruped() -> Model {
    let mut robot = robots::named("quadruped.urdf").description().clone();
    robot.shapes.retain(|shape| matches!(shape.shape, Shape::Sphere { .. }));
    Model::new(robot).unwrap()
}

/// Quadrupeds that fall onto their feet have the states of the same steps in doubles. Contact begins at other
/// roundings, so that a foot may touch a step earlier: then its speed differs by that of one step of gravity
/// and its place by its way in a step.
#[test]
#[allow(clippy::cast_possible_truncation)] // the states are singles
fn quadrupeds_land_as_in_doubles() {
    let Some(device) = crate::device() else { return };
    let model = quadruped();
    let function = Function::ContactStep { sweeps: SWEEPS };
    let mut batches = device.compile::<f32>(&model, std::slice::from_ref(&function)).unwrap();
    let step = ContactStep::new(&model, SWEEPS.into()).unwrap();
    let (nq, nv, np, count) = (model.nq(), model.nv(), step.impulse_count(), 100);
    let mut random = SplitMix64::new(11);
    let (mut q, mut v, mut p) = (Vec::new(), vec![0.0_f32; count * nv], vec![0.0_f32; count * np]);
    for _ in 0..count {
        q.extend([0.0, 0.0, 0.45, 0.0, 0.0, 0.0, 1.0]);
        q.extend((0..4).flat_map(|_| [0.0, 0.7, -1.4]).map(|x| x + random.uniform(-0.05, 0.05) as f32));
    }
    let mut states: Vec<_> =
        (0..count).map(|state| (robots::row(&q, count, state), vec![0.0; nv], vec![0.0; np])).collect();
    let start = states.clone();
    let (h, friction) = (vec![H as f32; count], vec![0.7_f32; count]);
    let mut workspace = Workspace::new(&model);
    for _ in 0..150 {
        // Joint springs, from the states on the device.
        let mut tau = vec![0.0_f32; count * nv];
        for (state, row) in tau.chunks_mut(nv).enumerate() {
            for (k, tau) in row.iter_mut().enumerate().skip(6) {
                let target = start[state].0[k + 1] as f32;
                *tau = 60.0 * (target - q[state * nq + k + 1]) - 2.0 * v[state * nv + k];
            }
        }
        let (mut q_next, mut v_next, mut p_next) = (q.clone(), v.clone(), p.clone());
        let inputs: [&[f32]; 6] = [&q, &v, &tau, &h, &friction, &p];
        batches.compute(&function, &inputs, &mut [&mut q_next, &mut v_next, &mut p_next]).unwrap();
        (q, v, p) = (q_next, v_next, p_next);
        for (state, (q, v, p)) in states.iter_mut().enumerate() {
            let spring = |k: usize| 60.0 * (start[state].0[k + 1] - q[k + 1]) - 2.0 * v[k];
            let tau: Vec<f64> = (0..nv).map(|k| if k < 6 { 0.0 } else { spring(k) }).collect();
            let (q0, v0, p0) = (q.clone(), v.clone(), p.clone());
            let friction = f64::from(0.7_f32);
            let inputs = ContactStepInputs::new([&q0, &v0, &tau], f64::from(H as f32), friction, &p0);
            step.step(&model, &mut workspace, &inputs, q, v, p);
        }
    }
    let (mut worst, mut pushing) = (0.0_f64, 0);
    for (state, (expected, ..)) in states.iter().enumerate() {
        let found = robots::row(&q, count, state);
        worst = found.iter().zip(expected).fold(worst, |worst, (x, y)| worst.max((x - y).abs()));
        pushing += p[state * np..][..12].chunks(3).filter(|impulse| impulse[0] > 0.0).count();
    }
    println!("the largest difference of a coordinate is {worst:e}");
    assert!(worst < 2.0 * H * H * 9.81 + 1e-4, "{worst:e}");
    assert!(pushing > 3 * count, "{pushing}");
}

/// A step and its pullback agree with the same operations on the processor.
#[test]
fn steps_and_their_pullbacks_agree_with_the_library() {
    let Some(device) = crate::device() else { return };
    let mut robot = robots::named("two_r.urdf").description().clone();
    robot.shapes.clear();
    let tip = robot.links[robot.links.len() - 1].name.clone();
    let ball = Shape::Sphere { radius: 0.1 };
    robot.shapes.push(LinkShape::new(tip, ShapeRole::Collision, Pose::IDENTITY, ball));
    let step = Function::ContactStep { sweeps: 5 };
    let functions = [step.clone(), step.pullback(), Function::ContactFixedPoint];
    crate::functions::check(&device, &Model::new(robot).unwrap(), &functions);
}

/// The same call gives the same bits.
#[test]
fn steps_have_the_same_bits_in_each_call() {
    let Some(device) = crate::device() else { return };
    let model = quadruped();
    let function = Function::ContactStep { sweeps: SWEEPS };
    let mut batches = device.compile::<f32>(&model, std::slice::from_ref(&function)).unwrap();
    let widths: Vec<usize> = function.reads(&model).iter().map(Table::width).collect();
    let mut random = SplitMix64::new(2);
    #[allow(clippy::cast_possible_truncation)] // random singles
    let inputs: Vec<Vec<f32>> = widths
        .iter()
        .map(|width| (0..64 * width).map(|_| random.uniform(0.01, 0.5) as f32).collect())
        .collect();
    let inputs: Vec<&[f32]> = inputs.iter().map(Vec::as_slice).collect();
    let mut compute = || {
        let mut results: Vec<Vec<f32>> =
            function.writes(&model).iter().map(|table| vec![0.0; 64 * table.width()]).collect();
        let mut rows: Vec<&mut [f32]> = results.iter_mut().map(Vec::as_mut_slice).collect();
        batches.compute(&function, &inputs, &mut rows).unwrap();
        results
    };
    let first = compute();
    assert!(first[2].iter().any(|x| *x != 0.0));
    assert_eq!(compute(), first);
}
