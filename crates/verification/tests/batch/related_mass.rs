//! The packed entries of mass matrices of batches against the full matrices, bit for bit.

use nalgebra::Vector3;
use robot_dynamics::batch;
use robot_dynamics::batch::{BatchFloat, BatchOptions, BatchWorkspace};
use robot_dynamics::description::{
    JointDescription, JointKind, LinkDescription, MassProperties, Pose, RobotDescription,
};
use robot_dynamics::model::{InstructionSet, Model, neutral, random_state};
use robot_dynamics::number::SplitMix64;

use crate::common::{families, max_difference};

/// q of `count` states.
fn configurations<T: BatchFloat>(model: &Model, count: usize) -> Vec<T> {
    let mut random = SplitMix64::new(7);
    (0..count).flat_map(|_| random_state(model, &mut random).q).map(T::from_f64).collect()
}

fn workspace<T: BatchFloat>(
    model: &Model,
    threads: usize,
    limit: Option<InstructionSet>,
) -> BatchWorkspace<T> {
    let mut options = BatchOptions::default();
    (options.threads, options.limit) = (threads, limit);
    BatchWorkspace::with_options(model, options).unwrap()
}

/// The full matrix of each state has the packed entries in both triangles and zeros elsewhere. They are equal
/// bit for bit with any lanes and threads, and with partial blocks. Returns the share of the matrix that is
/// packed.
fn require_same_bits<T: BatchFloat>(model: &Model, what: &str) -> f64 {
    let (nv, count) = (model.nv(), 19);
    let q = configurations::<T>(model, count);
    let entries = batch::mass_matrix_related_entries(model);
    assert!(entries.is_sorted() && entries.iter().all(|&(i, j)| i <= j && j < nv), "{what}: {entries:?}");
    for (threads, limit) in
        [(1, None), (1, Some(InstructionSet::Avx2)), (1, Some(InstructionSet::Portable)), (3, None)]
    {
        let mut workspace = workspace::<T>(model, threads, limit);
        let mut packed = vec![T::from_f64(-7.0); count * entries.len()];
        let mut mass = vec![T::from_f64(-7.0); count * nv * nv];
        batch::mass_matrix_related(model, &mut workspace, &q, &mut packed).unwrap();
        batch::mass_matrix(model, &mut workspace, &q, &mut mass).unwrap();
        for state in 0..count {
            let mut expanded = vec![T::zero(); nv * nv];
            for (&(i, j), &m) in entries.iter().zip(&packed[state * entries.len()..]) {
                (expanded[i * nv + j], expanded[j * nv + i]) = (m, m);
            }
            // `Debug` distinguishes −0 from 0.
            let bits = |x: &[T]| x.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>();
            let own = &mass[state * nv * nv..(state + 1) * nv * nv];
            assert_eq!(bits(&expanded), bits(own), "{what}, state {state}, {threads} threads, {limit:?}");
        }
    }
    entries.len() as f64 / ((nv * nv) as f64).max(1.0)
}

#[test]
fn packed_entries_match_full_matrix() {
    let (mut least, mut coupled) = (1.0f64, 0);
    for family in families() {
        for robot in family.robots().take(4) {
            let what = format!("\"{}\" seed {}", robot.family, robot.seed);
            let part = require_same_bits::<f64>(&robot.model, &what);
            require_same_bits::<f32>(&robot.model, &what);
            least = least.min(part);
            if robot.model.description().joints.iter().any(|joint| joint.mimic.is_some()) {
                let nv = robot.model.nv();
                assert_eq!(
                    batch::mass_matrix_related_entries(&robot.model).len(),
                    nv * (nv + 1) / 2,
                    "{what}"
                );
                coupled += 1;
            }
        }
    }
    assert!(
        least < 0.4 && coupled > 0,
        "bushes have less than a triangle: {least}, {coupled} with mimic joints"
    );
}

/// A body with two arms of two hinges, with the entries by hand. Its slide is so long that poses are relative
/// to moving reference points.
#[test]
fn branches_have_no_common_entries() {
    let mut robot = RobotDescription::new("two arms");
    robot.links.push(LinkDescription::new("ground", None));
    let solid = MassProperties::solid_box(1000.0, Vector3::new(0.3, 0.2, 0.1)).unwrap();
    let mut add = |name: &str, parent: &str, kind: JointKind| {
        robot.links.push(LinkDescription::new(name, solid));
        let place = Pose::from_translation([0.1, 0.2, 0.3]);
        robot.joints.push(JointDescription::new(format!("to {name}"), kind, parent, name, place));
    };
    let hinge = JointKind::Revolute { axis: [0.0, 1.0, 0.0] };
    add("turntable", "ground", JointKind::Revolute { axis: [0.0, 0.0, 1.0] });
    add("cart", "turntable", JointKind::Prismatic { axis: [1.0, 0.0, 0.0] });
    for side in ["left", "right"] {
        add(&format!("{side} upper"), "cart", hinge);
        add(&format!("{side} fore"), &format!("{side} upper"), hinge);
    }
    let model = Model::new(robot).unwrap();
    let expected: Vec<(usize, usize)> = [(0, 0..6), (1, 1..6), (2, 2..4), (3, 3..4), (4, 4..6), (5, 5..6)]
        .into_iter()
        .flat_map(|(i, columns)| columns.map(move |j| (i, j)))
        .collect();
    assert_eq!(batch::mass_matrix_related_entries(&model), expected);
    require_same_bits::<f64>(&model, "two arms");
    // Against the function of a single state, up to rounding.
    let mut q = neutral(&model);
    (q[0], q[1], q[3], q[4]) = (0.3, 1e3, 0.5, -0.7);
    let mut mass = vec![0.0; 36];
    robot_dynamics::algorithms::mass_matrix(
        &model,
        &mut robot_dynamics::model::Workspace::new(&model),
        &q,
        &mut mass,
    );
    let mut packed = vec![0.0; expected.len()];
    batch::mass_matrix_related(&model, &mut workspace(&model, 1, None), &q, &mut packed).unwrap();
    let own: Vec<f64> = expected.iter().map(|&(i, j)| mass[i * 6 + j]).collect();
    let size = own.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!(max_difference(&packed, &own) < 1e-12 * size, "{packed:?} {own:?}");
}

#[test]
fn bad_state_is_named_and_others_unchanged() {
    let family = &families()[2];
    let model = family.robots().next().unwrap().model;
    let mut q = configurations::<f64>(&model, 10);
    let width = batch::mass_matrix_related_entries(&model).len();
    let compute = |q: &[f64]| {
        let mut packed = vec![-7.0; 10 * width];
        let result = batch::mass_matrix_related(&model, &mut workspace(&model, 2, None), q, &mut packed);
        (packed, result)
    };
    let (good, result) = compute(&q);
    assert_eq!(result, Ok(()));
    q[4 * model.nq() + 7] = f64::NAN;
    let (found, result) = compute(&q);
    assert_eq!(result.unwrap_err().states, [4]);
    for i in 0..10 {
        let (found, good) = (&found[i * width..(i + 1) * width], &good[i * width..(i + 1) * width]);
        assert!(if i == 4 { found.iter().all(|m| m.is_nan()) } else { found == good }, "state {i}");
    }
}

#[test]
fn table_of_wrong_length_panics() {
    let model = families()[2].robots().next().unwrap().model;
    let (w, q) = (&mut BatchWorkspace::new(&model), neutral(&model));
    let call = std::panic::AssertUnwindSafe(|| batch::mass_matrix_related(&model, w, &q, &mut [0.0; 3]));
    assert!(std::panic::catch_unwind(call).is_err());
}
