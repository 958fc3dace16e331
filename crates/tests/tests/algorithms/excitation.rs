//! Exciting motions, and the identification of a seven-joint arm from one.

use std::error::Error;
use std::sync::OnceLock;

use nalgebra::DVector;
use robot_dynamics::algorithms::{dissipation, inertial_parameters, inverse_dynamics};
use robot_dynamics::control::identification::{
    BaseParameters, ConsistentOptions, Excitation, ExcitationCriterion, ExcitationLimits, ExcitationOptions,
    FourierSeries, IdentificationError, JointTerm, JointTermKind, MotionRecord, design_excitation,
    identify_consistent, physical_consistency,
};
use robot_dynamics::derivatives::{parameter_values, with_parameters};
use robot_dynamics::load;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics::number::SplitMix64;

type Tested = Result<(), Box<dyn Error>>;

fn panda() -> Result<Model, Box<dyn Error>> {
    Ok(load(concat!(env!("CARGO_MANIFEST_DIR"), "/../../robots/panda.urdf"))?.model)
}

/// The limits of the file, with the accelerations of the maker's data sheet.
fn limits(model: &Model) -> ExcitationLimits {
    let mut limits = ExcitationLimits::of(model);
    limits.acceleration = vec![15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0];
    limits
}

const TERMS: [JointTermKind; 2] = [JointTermKind::Damping, JointTermKind::Friction];

/// The motion of the greatest determinant, which several tests use.
static DESIGNED: OnceLock<Excitation> = OnceLock::new();

fn designed(model: &Model) -> &'static Excitation {
    DESIGNED.get_or_init(|| design(model, ExcitationCriterion::Determinant).expect("limits of an arm"))
}

fn design(model: &Model, criterion: ExcitationCriterion) -> Result<Excitation, IdentificationError> {
    let terms = JointTerm::of_all(model, &TERMS);
    let options = ExcitationOptions::new(10.0, 5).with_terms(&terms).with_steps(30).with_criterion(criterion);
    design_excitation(model, &limits(model), &options)
}

/// q, v and a of a series at equidistant times of its period.
fn states(series: &FourierSeries, count: usize) -> Vec<[Vec<f64>; 3]> {
    let n = series.offsets.len();
    let state = |k: usize| {
        let mut state = [vec![0.0; n], vec![0.0; n], vec![0.0; n]];
        let [q, v, a] = &mut state;
        series.evaluate(series.period * (k as f64 + 0.5) / count as f64, q, v, a);
        state
    };
    (0..count).map(state).collect()
}

fn torques(model: &Model, [q, v, a]: &[Vec<f64>; 3]) -> Vec<f64> {
    let (mut tau, mut lost) = (vec![0.0; q.len()], vec![0.0; q.len()]);
    inverse_dynamics(model, &mut Workspace::new(model), q, v, a, &mut tau);
    dissipation(model, v, &mut lost);
    tau.iter().zip(lost).map(|(tau, lost)| tau + lost).collect()
}

/// Whether a motion stays inside its limits at 1000 times.
fn is_within(model: &Model, limits: &ExcitationLimits, series: &FourierSeries) -> bool {
    states(series, 1000).iter().all(|state| {
        let tau = torques(model, state);
        let [q, v, a] = state;
        (0..q.len()).all(|i| {
            let [lower, upper] = limits.position[i];
            let held = lower <= q[i] && q[i] <= upper && v[i].abs() <= limits.velocity[i];
            held && a[i].abs() <= limits.acceleration[i] && tau[i].abs() <= limits.torque[i]
        })
    })
}

/// The condition number that the identification from this motion reports, and ln det(WᵀW)/(2n) by its
/// covariance σ² (WᵀW)⁻¹.
fn quality(model: &Model, base: &BaseParameters, series: &FourierSeries) -> Result<[f64; 2], Box<dyn Error>> {
    let mut record = MotionRecord::new(model, true).with_terms(&JointTerm::of_all(model, &TERMS))?;
    let random = &mut SplitMix64::new(1);
    for state in &states(series, 60) {
        let mut tau = torques(model, state);
        for tau in &mut tau {
            *tau += random.uniform(-1.0, 1.0);
        }
        record.push(&state[0], &state[1], &state[2], &tau)?;
    }
    let found = base.identify(&record)?;
    let (equations, unknowns) = (7.0 * 60.0, base.len() as f64);
    let variance = found.residual.powi(2) * equations / (equations - unknowns);
    let spread = (found.covariance / variance).symmetric_eigenvalues();
    Ok([found.condition, -0.5 * spread.iter().map(|x| x.ln()).sum::<f64>() / unknowns])
}

/// A random series as large as the limits allow, around the middle of the position limits: by one factor, or
/// by one factor for each joint.
fn random_series(
    model: &Model,
    limits: &ExcitationLimits,
    random: &mut SplitMix64,
    joint_by_joint: bool,
) -> FourierSeries {
    let mut list = |n: usize| -> Vec<Vec<f64>> {
        (0..n).map(|_| (0..5).map(|_| random.uniform(-1.0, 1.0)).collect()).collect()
    };
    let offsets = limits.position.iter().map(|[lower, upper]| 0.5 * (lower + upper)).collect();
    let mut series =
        FourierSeries { period: 10.0, offsets, sines: list(model.nv()), cosines: list(model.nv()) };
    let alone = |series: &FourierSeries, i: usize| {
        states(series, 200).iter().all(|[q, v, a]| {
            let [lower, upper] = limits.position[i];
            let held = lower <= q[i] && q[i] <= upper && v[i].abs() <= limits.velocity[i];
            held && a[i].abs() <= limits.acceleration[i]
        })
    };
    let scale = |series: &mut FourierSeries, i: usize, factor: f64| {
        series.sines[i].iter_mut().chain(&mut series.cosines[i]).for_each(|x| *x *= factor);
    };
    for i in 0..model.nv() {
        while joint_by_joint && alone(&series, i) {
            scale(&mut series, i, 1.1);
        }
        while joint_by_joint && !alone(&series, i) {
            scale(&mut series, i, 0.97);
        }
    }
    while !is_within(model, limits, &series) {
        (0..model.nv()).for_each(|i| scale(&mut series, i, 0.97));
    }
    series
}

/// The designed motions stay inside all limits, start and end at rest, and tell more than random series that
/// use the same limits as far as they can.
#[test]
fn designed_motions_beat_random_series() -> Tested {
    let model = panda()?;
    let limits = limits(&model);
    let base = BaseParameters::of_with_terms(&model, &JointTerm::of_all(&model, &TERMS), 100, 1)?;
    let random = &mut SplitMix64::new(8);
    let mut medians = |joint_by_joint: bool| -> Result<[f64; 2], Box<dyn Error>> {
        let (mut conditions, mut volumes) = (Vec::new(), Vec::new());
        for _ in 0..11 {
            let series = random_series(&model, &limits, random, joint_by_joint);
            let [condition, information] = quality(&model, &base, &series)?;
            conditions.push(condition);
            volumes.push(information);
        }
        conditions.sort_by(f64::total_cmp);
        volumes.sort_by(f64::total_cmp);
        Ok([conditions[5], volumes[5]])
    };
    let (common, each) = (medians(false)?, medians(true)?);
    for criterion in [ExcitationCriterion::Determinant, ExcitationCriterion::Condition] {
        let found = match criterion {
            ExcitationCriterion::Determinant => designed(&model).clone(),
            ExcitationCriterion::Condition => design(&model, criterion)?,
        };
        assert!(is_within(&model, &limits, &found.series) && found.usage <= 1.0, "{criterion:?}");
        let mut state = [vec![0.0; 7], vec![0.0; 7], vec![0.0; 7]];
        let [q, v, a] = &mut state;
        found.series.evaluate(10.0, q, v, a);
        assert!(v.iter().chain(a.iter()).all(|x| x.abs() < 1e-12), "{v:?} {a:?}");
        let [condition, information] = quality(&model, &base, &found.series)?;
        assert!((condition / found.condition - 1.0).abs() < 1e-6, "{condition} {}", found.condition);
        assert!((information - found.log_information).abs() < 1e-6, "{information}");
        match criterion {
            // Standard deviations, in the geometric mean over β: 2.5 and 1.8 times smaller.
            ExcitationCriterion::Determinant => {
                assert!(information > common[1] + 2.2_f64.ln(), "{information} {common:?}");
                assert!(information > each[1] + 1.6_f64.ln(), "{information} {each:?}");
            }
            // 7.6 against 13.3 and 10.5.
            ExcitationCriterion::Condition => {
                assert!(condition < 0.65 * common[0] && condition < 0.8 * each[0], "{condition}");
            }
        }
    }
    Ok(())
}

/// Equal seeds give equal motions; limits that cannot hold are errors.
#[test]
fn design_is_deterministic_and_checks_limits() -> Tested {
    let model = panda()?;
    let options = ExcitationOptions::new(10.0, 3).with_samples(20).with_steps(3);
    let [first, second] =
        [1, 1].map(|seed| design_excitation(&model, &limits(&model), &options.clone().with_seed(seed)));
    let first = first?;
    assert_eq!(first, second?);
    assert_ne!(first, design_excitation(&model, &limits(&model), &options.clone().with_seed(2))?);
    let mut weak = limits(&model);
    weak.torque[1] = 1.0; // the shoulder does not hold the arm
    assert!(design_excitation(&model, &weak, &options).unwrap_err().to_string().contains("torque limits"));
    let mut free = limits(&model);
    (free.position[3], free.velocity[3]) = ([f64::NEG_INFINITY, f64::INFINITY], f64::INFINITY);
    free.acceleration[3] = f64::INFINITY;
    assert!(design_excitation(&model, &free, &options).unwrap_err().to_string().contains("panda_joint4"));
    for options in [ExcitationOptions::new(0.0, 3), ExcitationOptions::new(1.0, 1)] {
        assert!(design_excitation(&model, &limits(&model), &options).is_err());
    }
    let few = ExcitationOptions::new(10.0, 3).with_samples(5);
    let error = design_excitation(&model, &limits(&model), &few).unwrap_err();
    assert!(matches!(error, IdentificationError::TooFewData { equations: 35, .. }), "{error}");
    Ok(())
}

/// A real arm differs from its file by masses of links (±20 %), their shapes, and friction. From thirty
/// seconds of a designed motion at 100 Hz with noise of 0.3 N·m, every body is possible, β is within 1 %, and
/// torques of another motion are predicted far below the noise.
///
/// The error of β is |β − β₀|/|β₀|, with β in the same units (kg, kg·m, kg·m²) and its entries divided by the
/// largest of their kind, so that masses do not hide moments of inertia.
#[test]
fn arm_is_identified_within_one_percent() -> Tested {
    let model = panda()?;
    let terms = JointTerm::of_all(&model, &TERMS);
    let random = &mut SplitMix64::new(42);
    let mut values = parameter_values(&model);
    let count = inertial_parameters(&model).len();
    for link in values[..count].chunks_exact_mut(10) {
        let (mass, size) = (random.uniform(0.8, 1.2), random.uniform(0.95, 1.05));
        // Equal shapes of another density and size.
        let factors = [0, 1, 1, 1, 2, 2, 2, 2, 2, 2];
        link.iter_mut().zip(factors).for_each(|(x, power)| *x *= mass * f64::powi(size, power));
    }
    for joint in values[count..count + 5 * model.moving_joints().count()].chunks_exact_mut(5) {
        (joint[1], joint[2]) = (random.uniform(0.5, 2.0), random.uniform(0.5, 2.0));
    }
    let real = Model::new(with_parameters(&model, &values)?)?;
    let noise = 0.3;
    let mut record = MotionRecord::new(&model, true).with_terms(&terms)?.with_noise(&[noise; 7])?;
    // A normal number by the sum of twelve uniform ones.
    let mut bell = || noise * (0..12).map(|_| random.uniform(-0.5, 0.5)).sum::<f64>();
    for _period in 0..3 {
        for state in &states(&designed(&model).series, 1000) {
            let mut tau = torques(&real, state);
            for tau in &mut tau {
                *tau += bell();
            }
            record.push(&state[0], &state[1], &state[2], &tau)?;
        }
    }
    let mut truth = inertial_parameters(&real);
    truth.extend(terms.iter().map(|term| term.nominal(&real)));
    let base = BaseParameters::of_with_terms(&model, &terms, 100, 1)?;
    let expected = base.values(&truth)?;
    let options = ConsistentOptions::new(1e-2)
        .with_joint_nominal(JointTermKind::Damping, 1.0)
        .with_joint_nominal(JointTermKind::Friction, 1.0);
    let found = identify_consistent(&record, &options)?;
    let squares = base.identify(&record)?;
    // The kind of a parameter is the first letter of its name after the link.
    let kind = |i: usize| base.parameters[i].name.rsplit('.').next().and_then(|name| name.chars().next());
    let largest = DVector::from_fn(base.len(), |i, _| {
        let same = (0..base.len()).filter(|&j| kind(j) == kind(i));
        same.map(|j| expected[j].abs()).fold(0.0, f64::max)
    });
    let error = |beta: &DVector<f64>| {
        (beta - &expected).component_div(&largest).norm() / expected.component_div(&largest).norm()
    };
    let consistent = base.values(&found.parameters)?;
    assert!(error(&consistent) < 0.01 && error(&squares.values) < 0.01);
    let links = physical_consistency(&model, &found.parameters[..count])?;
    assert!(links.iter().all(|link| link.smallest > 0.0), "{links:?}");
    // The residual of every joint is the noise: 3000 samples give it to 1.3 %.
    assert!(found.residuals.iter().all(|residual| (residual / noise - 1.0).abs() < 0.05), "{found:?}");
    let identified = Model::new(found.description(&model)?)?;
    let other = random_series(&model, &limits(&model), &mut SplitMix64::new(77), true);
    let (mut sum, mut by_file) = (0.0, 0.0);
    for state in &states(&other, 500) {
        let (own, real, file) = (torques(&identified, state), torques(&real, state), torques(&model, state));
        sum += own.iter().zip(&real).map(|(own, real)| (own - real).powi(2)).sum::<f64>();
        by_file += file.iter().zip(&real).map(|(file, real)| (file - real).powi(2)).sum::<f64>();
    }
    let rms = |sum: f64| (sum / 3500.0).sqrt();
    assert!(rms(sum) < 0.2 * noise && rms(by_file) > noise);
    Ok(())
}
