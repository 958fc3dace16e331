//! The laws of constraints, on random trees with random rows.

use nalgebra::{DMatrix, DVector};
use robot_dynamics::algorithms::{bias, kinetic_energy};
use robot_dynamics::constraints::{
    Anchor, Constraint, ConstraintError, ConstraintOptions, ConstraintSet, Coupling, FrameConstraint, NoSlip,
    Plane, RedundantRows, RollingDisc, RollingRow, SpatialAxis, constrained_forward_dynamics,
    constrained_inverse_dynamics, constraint_projections, contact_impulse, project_position,
    project_velocity,
};
use robot_dynamics::description::Pose;
use robot_dynamics::model::{Workspace, integrate, neutral};
use robot_dynamics::number::SplitMix64;
use robot_dynamics::verification::lagrange;

use crate::common::{Family, Robot, families, size};

const CLOSURE: [SpatialAxis; 6] = FrameConstraint::WELD;

#[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a fraction of a small count
fn below(random: &mut SplitMix64, count: usize) -> usize {
    (random.uniform(0.0, 1.0) * count as f64) as usize
}

fn some_rows<R: Copy>(random: &mut SplitMix64, all: &[R]) -> Vec<R> {
    let picked: Vec<R> = all.iter().copied().filter(|_| random.uniform(0.0, 1.0) < 0.5).collect();
    if picked.is_empty() { vec![all[below(random, all.len())]] } else { picked }
}

/// One constraint of any kind between any frames.
fn random_constraint(robot: &Robot, random: &mut SplitMix64) -> Constraint {
    let model = &robot.model;
    let frames: Vec<_> =
        model.frames().iter().map(|frame| model.frame(&frame.name).expect("its own frame")).collect();
    let frame = frames[below(random, frames.len())];
    let angles = [random.uniform(-3.0, 3.0), random.uniform(-1.5, 1.5), random.uniform(-3.0, 3.0)];
    match below(random, 5) {
        0 => {
            FrameConstraint::between(frame, frames[below(random, frames.len())], &some_rows(random, &CLOSURE))
                .into()
        }
        1 => {
            let pose = Pose::from_xyz_rpy([0.3, -0.2, 0.1], angles);
            // The world may be on either side.
            let (a, b) = (Anchor::World(pose), Anchor::Frame(frame));
            let (a, b) = if random.uniform(0.0, 1.0) < 0.5 { (a, b) } else { (b, a) };
            FrameConstraint { a, b, rows: some_rows(random, &CLOSURE) }.into()
        }
        2 => NoSlip { frame, rows: some_rows(random, &CLOSURE) }.into(),
        3 => RollingDisc {
            frame,
            axle: [0.3, 1.0, -0.4],
            radius: 0.2,
            plane: Plane::new([0.1, -0.2, 1.0], [0.0, 0.0, -0.3]),
            rows: some_rows(random, &[RollingRow::Forward, RollingRow::Side, RollingRow::Normal]),
        }
        .into(),
        _ => {
            let names = model.coordinate_names();
            let mut term = || (names[below(random, names.len())].as_str(), random.uniform(-2.0, 2.0));
            Coupling::new(model, &[term(), term()], 0.3).expect("coordinates of the model").into()
        }
    }
}

/// As many random constraints as leave the rows independent and some motion free.
fn random_set(robot: &Robot, random: &mut SplitMix64) -> ConstraintSet {
    let mut chosen: Vec<(String, Constraint)> = Vec::new();
    let mut set = ConstraintSet::default();
    for i in 0..6 {
        chosen.push((format!("c{i}"), random_constraint(robot, random)));
        let bigger = ConstraintSet::new(&robot.model, chosen.clone()).expect("a valid set");
        // Rows within 1e-3 of dependence amplify every rounding a thousandfold; they are not tested here.
        let options = ConstraintOptions { dependence: 1e-3, ..Default::default() };
        let rank = constraint_projections(
            &robot.model,
            &mut Workspace::new(&robot.model),
            &bigger,
            &options,
            &robot.state.q,
        )
        .expect("finite rows")
        .rank;
        if rank == bigger.len() && rank < robot.model.nv() {
            set = bigger;
        } else {
            chosen.pop();
        }
    }
    set
}

fn robots(per_family: usize) -> impl Iterator<Item = (Robot, ConstraintSet)> {
    families().into_iter().flat_map(move |family: Family| {
        family
            .robots()
            .take(per_family)
            .map(|robot| {
                let set = random_set(&robot, &mut SplitMix64::new(robot.seed ^ 0xc0de));
                (robot, set)
            })
            .collect::<Vec<_>>()
    })
}

/// A v is the rate of φ, and Ȧv that of A v at a = 0. Central differences of order 4 along q ⊕ t v give both.
///
/// With t = 1e-3 the truncation is t⁴ times fifth derivatives, below 1e-6 of the terms for rates up to 20
/// rad/s. The rounding is ε/t.
#[test]
fn rows_are_rates_of_errors_and_biases_of_rows() {
    let (mut rows_tested, mut holonomic) = (0, 0);
    for (robot, set) in robots(25) {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let (q, v) = (&robot.state.q[..], &robot.state.v.iter().map(|v| 0.3 * v).collect::<Vec<_>>()[..]);
        let velocity = DVector::from_column_slice(v);
        let mut at = |t: f64| {
            let step: Vec<f64> = v.iter().map(|v| t * v).collect();
            let mut moved = q.to_vec();
            integrate(model, q, &step, &mut moved);
            let rows = set.rows(model, w, &moved, v);
            (rows.position_error, &rows.matrix * &velocity)
        };
        let t = 1e-3;
        let [(p1, s1), (p2, s2), (m1, n1), (m2, n2)] = [at(t), at(2.0 * t), at(-t), at(-2.0 * t)];
        let slope = |plus: DVector<f64>, minus, plus2, minus2| {
            ((plus - minus) * 8.0 - (plus2 - minus2) as DVector<f64>) / (12.0 * t)
        };
        let (error_rate, velocity_rate) = (slope(p1, m1, p2, m2), slope(s1, n1, s2, n2));
        let rows = set.rows(model, &mut Workspace::new(model), q, v);
        let speed = &rows.matrix * &velocity;
        for i in 0..set.len() {
            rows_tested += 1;
            let scale = 1.0 + speed.amax() + rows.bias.amax();
            let name = &set.row_names()[i];
            if rows.holonomic[i] {
                holonomic += 1;
                robot.require(&format!("{name}: A v = φ̇"), (error_rate[i] - speed[i]).abs(), 1e-7 * scale);
            }
            let defect = (velocity_rate[i] - rows.bias[i]).abs();
            robot.require(&format!("{name}: Ȧv"), defect, 1e-7 * scale.powi(2));
        }
    }
    assert!(rows_tested > 400 && holonomic > 150, "{rows_tested} rows, {holonomic} with φ");
}

/// A a + Ȧv = 0. The sparse route, the dense KKT matrix by LU and the projected free motion agree. So do the
/// properties of P and the power of the constraint force.
#[test]
fn constraint_laws_on_random_trees() {
    let (mut tested, mut worst) = (0, 0.0f64);
    for (robot, set) in robots(25) {
        if set.is_empty() {
            continue;
        }
        tested += 1;
        let model = &robot.model;
        let (nv, count) = (model.nv(), set.len());
        let w = &mut Workspace::new(model);
        let options = ConstraintOptions { redundant: RedundantRows::Refuse, ..Default::default() };
        let (q, v, tau) = (&robot.state.q[..], &robot.state.v[..], &robot.state.tau[..]);
        let motion = constrained_forward_dynamics(model, w, &set, &options, q, v, tau)
            .unwrap_or_else(|error| panic!("{error}; family {}, seed {}", robot.family, robot.seed));
        let rows = set.rows(model, w, q, v);
        let (a, lambda) = (&motion.acceleration, &motion.multipliers);
        assert_eq!(motion.rank, count);

        // The constraint, relative to the terms that are summed.
        let defect = (&rows.matrix * a + &rows.bias).amax();
        let scale = rows.matrix.amax() * a.abs().sum() + rows.bias.amax();
        worst = worst.max(defect / scale);
        robot.require("A a + Ȧv = 0", defect, 1e-10 * scale);

        // The dense KKT matrix with M from the Lagrange route.
        let mass = DMatrix::from_row_slice(nv, nv, &lagrange::mass_matrix(model, q));
        let mut force = vec![0.0; nv];
        bias(model, w, q, v, &mut force);
        let force = DVector::from_column_slice(tau) - DVector::from_vec(force);
        let mut kkt = DMatrix::zeros(nv + count, nv + count);
        kkt.view_mut((0, 0), (nv, nv)).copy_from(&mass);
        kkt.view_mut((0, nv), (nv, count)).copy_from(&-rows.matrix.transpose());
        kkt.view_mut((nv, 0), (count, nv)).copy_from(&rows.matrix);
        let mut right = DVector::zeros(nv + count);
        right.rows_mut(0, nv).copy_from(&force);
        right.rows_mut(nv, count).copy_from(&-&rows.bias);
        let singular = kkt.clone().singular_values();
        let condition = singular.max() / singular.min();
        let solution = kkt.full_piv_lu().solve(&right).expect("independent rows");
        let allowed = 100.0 * condition * f64::EPSILON * solution.amax();
        robot.require("a of KKT", (solution.rows(0, nv) - a).amax(), allowed);
        robot.require("λ of KKT", (solution.rows(nv, count) - lambda).amax(), allowed);

        // P a₀ is the part of a without λ, and (1−P) a the part that Ȧv determines.
        let p = constraint_projections(model, w, &set, &options, q).expect("the same rows");
        let free = mass.clone().lu().solve(&force).expect("M is regular");
        let rounding = 1e3 * condition * f64::EPSILON;
        let projected = (&p.velocity * (&free - a)).amax();
        robot.require("P a = P a₀", projected, rounding * (free.amax() + a.amax()));
        let size_p = 1.0 + p.velocity.amax();
        robot.require("A P = 0", (&rows.matrix * &p.velocity).amax(), rounding * rows.matrix.amax() * size_p);
        robot.require("P P = P", (&p.velocity * &p.velocity - &p.velocity).amax(), rounding * size_p.powi(2));
        let identity = DMatrix::identity(nv, nv);
        let orthogonal = p.velocity.transpose() * &mass * (&identity - &p.velocity);
        robot.require("PᵀM(1−P) = 0", orthogonal.amax(), rounding * mass.amax() * size_p.powi(2));
        let mirrored = &p.force * &mass - &mass * &p.velocity;
        robot.require("P_u M = M P", mirrored.amax(), rounding * mass.amax() * size_p);
        robot.require(
            "tr P = nv − K",
            (p.velocity.trace() - (nv - count) as f64).abs(),
            rounding * nv as f64 * size_p,
        );

        // The constraint force has no power on an allowed velocity.
        let mut allowed_v = v.to_vec();
        project_velocity(model, w, &set, &options, q, &mut allowed_v).expect("the same rows");
        let allowed_v = DVector::from_vec(allowed_v);
        let force = rows.matrix.tr_mul(lambda);
        let terms = force.abs().dot(&allowed_v.abs()) + rows.matrix.amax() * lambda.amax() * allowed_v.amax();
        robot.require("power of Aᵀλ", force.dot(&allowed_v).abs(), 1e-10 * terms);

        // Inverse dynamics of that motion: the same force on each coordinate, however τ and λ share it.
        let inverse =
            constrained_inverse_dynamics(model, w, &set, q, v, a.as_slice(), &vec![true; nv]).unwrap();
        let split = &inverse.tau + rows.matrix.tr_mul(&inverse.multipliers)
            - (DVector::from_column_slice(tau) + &force);
        robot.require("τ + Aᵀλ", split.amax(), rounding * (force.amax() + size(tau) + 1.0));
        robot.require(
            "|τ| is least",
            inverse.tau.norm(),
            DVector::from_column_slice(tau).norm() * (1.0 + rounding),
        );
    }
    assert!(tested > 100, "only {tested} robots have constraints");
    println!("{tested} robots, worst |A a + Ȧv| {worst:e} of its terms");
}

/// Impacts: A v⁺ = −e A v⁻, M(v⁺ − v⁻) = Aᵀι, and the energy loss follows its formula.
#[test]
fn impact_laws_on_random_trees() {
    for (robot, set) in robots(8) {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let (q, v) = (&robot.state.q[..], &robot.state.v[..]);
        let rows = set.rows(model, w, q, v);
        let before = DVector::from_column_slice(v);
        let mass = DMatrix::from_row_slice(model.nv(), model.nv(), &robot.mass());
        let rounding = 1e3 * robot.condition() * f64::EPSILON;
        for restitution in [0.0, 0.5, 1.0] {
            let hit = contact_impulse(model, w, &set, &ConstraintOptions::default(), q, v, restitution)
                .expect("regular rows");
            let scale = 1.0 + rows.matrix.amax() * before.abs().sum() + hit.velocity.amax();
            let after = &rows.matrix * &hit.velocity + &rows.matrix * &before * restitution;
            robot.require(
                "A v⁺ = −e A v⁻",
                if set.is_empty() { 0.0 } else { after.amax() },
                rounding * scale,
            );
            let balance = &mass * (&hit.velocity - &before) - rows.matrix.tr_mul(&hit.impulse);
            // M(v⁺ − v⁻) sums entries of M times v.
            robot.require("momentum", balance.amax(), rounding * (1.0 + mass.amax() * scale));
            let lost = kinetic_energy(model, w, q, v) - kinetic_energy(model, w, q, hit.velocity.as_slice());
            let energy = kinetic_energy(model, w, q, v);
            robot.require("energy lost", (lost - hit.energy_lost).abs(), rounding * (1.0 + energy));
            let allowed = if restitution == 1.0 { rounding * energy } else { f64::INFINITY };
            robot.require("e = 1 keeps K", lost.abs(), allowed);
            robot.require("K does not grow", -hit.energy_lost, rounding * energy);
        }
    }
}

/// Duplicate rows change only λ and are named, and the shortest λ is that of the pseudo-inverse.
#[test]
fn redundant_rows_change_multipliers_only() {
    let mut tested = 0;
    for (robot, set) in robots(6) {
        if set.is_empty() {
            continue;
        }
        tested += 1;
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let state = &robot.state;
        let twice: Vec<(String, Constraint)> = set
            .constraints()
            .map(|(name, constraint)| (name.to_owned(), constraint.clone()))
            .chain(set.constraints().map(|(name, constraint)| (format!("{name}again"), constraint.clone())))
            .collect();
        let twice = ConstraintSet::new(model, twice).expect("other names");
        let mut solve = |set: &ConstraintSet, redundant| {
            let options = ConstraintOptions { redundant, ..Default::default() };
            constrained_forward_dynamics(model, w, set, &options, &state.q, &state.v, &state.tau)
        };
        let once = solve(&set, RedundantRows::Drop).expect("independent rows");
        let dropped = solve(&twice, RedundantRows::Drop).expect("consistent rows");
        assert_eq!((dropped.rank, dropped.dependent.len()), (set.len(), set.len()));
        for (i, row) in dropped.dependent.iter().enumerate() {
            let original = &set.row_names()[i];
            assert_eq!(row.row, set.len() + i);
            assert_eq!(row.combination_of, [original.as_str()], "{}", row.name);
        }
        // The same sums over twice as many rows, half of them zero: only the order of summation may differ.
        let allowed = 1e-12 * (1.0 + robot.condition().sqrt()) * (1.0 + once.acceleration.amax());
        robot.require("a", (&dropped.acceleration - &once.acceleration).amax(), allowed);
        let error = solve(&twice, RedundantRows::Refuse).expect_err("half of the rows are redundant");
        let ConstraintError::DependentRows { rows, .. } = &error else { panic!("{error}") };
        assert!(rows.iter().all(|row| row.name.contains("again.")), "{error}");

        let shortest = solve(&twice, RedundantRows::Proximal { damping: 1e-6 }).expect("consistent rows");
        // Both copies share the load: λ/2 each. The proximal steps converge to rounding: κ(Λ)·ε where Λ acts,
        // and ε/damping where only the damping acts.
        let half = DVector::from_fn(2 * set.len(), |i, _| 0.5 * once.multipliers[i % set.len()]);
        let rows = set.rows(model, &mut Workspace::new(model), &state.q, &state.v).matrix;
        let mass = DMatrix::from_row_slice(model.nv(), model.nv(), &robot.mass());
        let gram = &rows * mass.lu().solve(&rows.transpose()).expect("regular");
        let eigen = gram.symmetric_eigenvalues();
        let magnified = eigen.max() / eigen.min() + 1e6;
        let allowed = 100.0 * f64::EPSILON * magnified * half.amax();
        robot.require("the shortest λ", (&shortest.multipliers - &half).amax(), allowed);
    }
    assert!(tested > 30, "{tested}");
}

/// From a state 0.05 away the projection returns to the constraint, to 1e-12.
#[test]
fn positions_are_projected() {
    let mut tested = 0;
    for (robot, _) in robots(20) {
        let model = &robot.model;
        let w = &mut Workspace::new(model);
        let random = &mut SplitMix64::new(robot.seed);
        // A frame held at its current pose: the start satisfies the constraint by construction.
        let frames = model.frames();
        let frame = model.frame(&frames[below(random, frames.len())].name).expect("its own");
        let place = robot_dynamics::algorithms::frame_pose(model, w, &robot.state.q, frame);
        let place = Pose { rotation: place.rotation, translation: place.translation };
        let hold = FrameConstraint::contact(frame, place, &some_rows(random, &CLOSURE));
        let set = ConstraintSet::new(model, [("hold", hold.into())]).expect("valid");
        let mut off = neutral(model);
        let step: Vec<f64> = robot.state.v.iter().map(|v| 0.025 * v).collect();
        integrate(model, &robot.state.q, &step, &mut off);
        let options = ConstraintOptions { dependence: 1e-6, ..Default::default() };
        match project_position(model, w, &set, &options, 1e-12, &mut off) {
            Ok(report) => {
                tested += 1;
                robot.require("φ", report.after, 1e-12);
                assert!(report.iterations <= 20, "{report:?}, seed {}", robot.seed);
            }
            // Near a singular pose the frame may not return: the error names a row.
            Err(
                ConstraintError::NotConverged { name, .. } | ConstraintError::NearlyDependentRow { name },
            ) => assert!(name.starts_with("hold."), "{name}"),
            Err(error) => panic!("{error}"),
        }
    }
    assert!(tested > 140, "only {tested} of 180 projections reach the constraint");
}
