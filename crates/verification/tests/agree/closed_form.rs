//! Closed form, tree and file agree: the planar arms, written by hand and read from a file, are one
//! mechanism. Every robot of this repository compiles and has a positive definite mass matrix.

use std::path::PathBuf;

use dynamics::{Dynamics, FixedSize, Reach2R, Reach3R};
use nalgebra::{Cholesky, DMatrix, SVector};
use robot_dynamics::algorithms::mass_matrix;
use robot_dynamics::model::{Model, Workspace, neutral, random_within_limits};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::urdf::{LoadOptions, load};

fn robots() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots")
}

fn model(name: &str, options: LoadOptions) -> Model {
    let robot = load(robots().join(format!("{name}.urdf")), &options.with_strict()).expect(name);
    Model::new(robot.description).expect(name)
}

fn same_everywhere<const N: usize>(file: &FixedSize<N>, by_hand: &impl Dynamics<N>, seed: u64) {
    let mut random = SplitMix64::new(seed);
    for _ in 0..100 {
        let mut draw = || SVector::<f64, N>::from_fn(|_, _| random.uniform(-3.0, 3.0));
        let (q, qd, qdd) = (draw(), draw(), draw());
        let off = [
            (file.mass(&q) - by_hand.mass(&q)).amax(),
            (file.velocity_product(&q, &qd) - by_hand.velocity_product(&q, &qd)).amax(),
            (file.gravity(&q) - by_hand.gravity(&q)).amax(),
            (file.inverse(&q, &qd, &qdd) - by_hand.inverse(&q, &qd, &qdd)).amax(),
            (file.kinetic_energy(&q, &qd) - by_hand.kinetic_energy(&q, &qd)).abs(),
            (file.potential_energy(&q) - by_hand.potential_energy(&q)).abs(),
        ];
        // Numbers up to about 100 in SI units, a few dozen roundings of 1e-16 each.
        assert!(off.iter().all(|&difference| difference < 1e-12), "seed {seed}, q {q:?}, qd {qd:?}: {off:?}");
    }
}

#[test]
fn planar_arms_equal_their_closed_forms() {
    let arm = FixedSize::<2>::new(model("two_r", LoadOptions::default())).expect("two joints");
    same_everywhere(&arm, &Reach2R::worked_example(), 1);
    let arm = FixedSize::<3>::new(model("three_r", LoadOptions::default())).expect("three joints");
    same_everywhere(&arm, &Reach3R::reach_3r(), 2);
}

#[test]
fn every_robot_has_positive_definite_mass_matrix() {
    let mut count = 0;
    for entry in std::fs::read_dir(robots()).expect("robots") {
        let path = entry.expect("an entry").path();
        if path.extension().is_none_or(|extension| extension != "urdf") {
            continue;
        }
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        for options in [LoadOptions::default(), LoadOptions::default().with_floating_base()] {
            // Arms on massless stands cannot float: their base would have no mass.
            if options.floating_base && !["quadruped", "humanoid", "hand"].contains(&name.as_str()) {
                continue;
            }
            let model = model(&name, options.clone());
            let report = load(&path, &options).expect("a robot").report;
            assert_eq!(model.nv(), report.counts.degrees_of_freedom, "{name}");
            let mut workspace = Workspace::new(&model);
            let nv = model.nv();
            let mut mass = vec![0.0; nv * nv];
            let mut random = SplitMix64::new(3);
            for pose in 0..20 {
                let q = if pose == 0 { neutral(&model) } else { random_within_limits(&model, &mut random) };
                mass_matrix(&model, &mut workspace, &q, &mut mass);
                let factor = Cholesky::new(DMatrix::from_row_slice(nv, nv, &mass));
                assert!(factor.is_some(), "{name} at {q:?}: M is not positive definite");
            }
            count += 1;
        }
    }
    assert_eq!(count, 13);
}
