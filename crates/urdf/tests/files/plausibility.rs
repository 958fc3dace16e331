//! Tests single faults in the robots of the repository: each is suspected, unless it cannot be detected.

use std::path::PathBuf;

use robot_dynamics::description::{JointKind, MassProperties, RobotDescription};
use robot_dynamics::plausibility::{Culprit, Quantity, RobotStatistics, Suspicion, suspicions};
use robot_dynamics::urdf::{LoadOptions, Robot, parse};

const ROBOTS: [&str; 10] =
    ["dual_arm", "gantry", "gripper", "hand", "humanoid", "panda", "quadruped", "three_r", "two_r", "ur5"];

fn text(name: &str) -> String {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../robots");
    std::fs::read_to_string(folder.join(format!("{name}.urdf"))).expect("a robot file")
}

fn suspected_in(text: &str) -> Vec<Suspicion> {
    let Robot { description, angles, .. } = parse(text, &LoadOptions::default()).expect("a robot");
    suspicions(&description, &angles)
}

/// Changes the mass properties (m, c, I) of the links that `which` selects.
fn changed(
    robot: &RobotDescription,
    which: impl Fn(usize) -> bool,
    change: impl Fn(&MassProperties) -> MassProperties,
) -> RobotDescription {
    let mut robot = robot.clone();
    let massive = robot.links.iter_mut().filter(|link| link.mass_properties.is_some());
    for (_, link) in massive.enumerate().filter(|(index, _)| which(*index)) {
        link.mass_properties = link.mass_properties.as_ref().map(&change);
    }
    robot
}

fn scaled(mass: f64, center: f64, moments: f64) -> impl Fn(&MassProperties) -> MassProperties {
    move |p| {
        let inertia = p.inertia_about_center_of_mass() * moments;
        MassProperties::new(p.mass() * mass, p.center_of_mass() * center, inertia).expect("a body")
    }
}

fn suspected(robot: &RobotDescription) -> Vec<Suspicion> {
    suspicions(robot, &[])
}

#[test]
fn robots_of_the_repository_are_not_suspected() {
    for name in ROBOTS {
        assert_eq!(suspected_in(&text(name)), [], "{name}");
    }
}

/// A factor in all masses, moments, offsets or centres of mass is suspected as a fault of the whole robot,
/// with the right culprit and the factor to half a decade.
#[test]
fn wrong_units_of_all_links_are_suspected() {
    use Culprit::{CentersOfMass, Masses, MassesAndMoments, Moments};
    let faults = [
        (Masses, 1e3, scaled(1e3, 1.0, 1.0)),
        (Masses, 1e-3, scaled(1e-3, 1.0, 1.0)),
        (Moments, 1e6, scaled(1.0, 1.0, 1e6)),
        (Moments, 1e3, scaled(1.0, 1.0, 1e3)),
        (Moments, 1e-3, scaled(1.0, 1.0, 1e-3)),
        (Moments, 1e-6, scaled(1.0, 1.0, 1e-6)),
        (MassesAndMoments, 1e3, scaled(1e3, 1.0, 1e3)),
        (CentersOfMass, 1e3, scaled(1.0, 1e3, 1.0)),
    ];
    for name in ROBOTS {
        let robot = parse(&text(name), &LoadOptions::default()).expect("a robot").description;
        let is_rods = matches!(name, "two_r" | "three_r");
        for (culprit, factor, fault) in &faults {
            let found = suspected(&changed(&robot, |_| true, fault));
            let context = format!("{name}, {culprit:?} by {factor:e}: {found:#?}");
            if is_rods && *culprit == MassesAndMoments {
                // A rod has no volume and no shape, so only its mass per length can tell. It differs by more
                // between rods of steel and rods of foam.
                assert_eq!(found, [], "{context}");
                continue;
            }
            let suspicion = found.first().unwrap_or_else(|| panic!("{context}"));
            assert!(suspicion.is_general(), "{context}");
            if is_rods && matches!(culprit, Masses | Moments) {
                // The radius of gyration shows that mass and moments disagree, but not which of them is
                // wrong.
                assert_eq!(suspicion.quantity, Quantity::GyrationOverExtent, "{context}");
                continue;
            }
            assert_eq!(suspicion.cause.culprit, *culprit, "{context}");
            let error = (suspicion.cause.factor / factor).log10().abs();
            assert!(error < 1.0, "{error} decades: {context}");
        }
    }
}

/// With joint offsets in millimetres the links are too small for their spacing.
#[test]
fn spacing_in_millimetres_is_suspected() {
    for name in ROBOTS {
        let mut robot = parse(&text(name), &LoadOptions::default()).expect("a robot").description;
        for joint in &mut robot.joints {
            joint.parent_from_joint.translation = joint.parent_from_joint.translation.map(|x| 1e3 * x);
        }
        let found = suspected(&robot);
        let general = found.first().filter(|suspicion| suspicion.is_general());
        let cause = general.unwrap_or_else(|| panic!("{name}: {found:#?}")).cause;
        assert_eq!(cause.culprit, Culprit::Spacing, "{name}: {found:#?}");
        assert!((cause.factor / 1e3).log10().abs() < 1.0, "{name}: {found:#?}");
    }
}

/// A fault in one link is suspected, with its name, unless its effect is small; the reasons are below.
#[test]
fn a_wrong_unit_of_one_link_is_suspected() {
    // The name, and the factors of m, c and I.
    let faults = [
        ("mass 1000", [1e3, 1.0, 1.0]),
        ("mass 0.001", [1e-3, 1.0, 1.0]),
        ("moments 1e6", [1.0, 1.0, 1e6]),
        ("moments 1e-6", [1.0, 1.0, 1e-6]),
        ("moments 1000", [1.0, 1.0, 1e3]),
        ("center 1000", [1.0, 1e3, 1.0]),
    ];
    let (mut tried, mut missed) = (0, 0);
    for name in ROBOTS {
        let robot = parse(&text(name), &LoadOptions::default()).expect("a robot").description;
        let statistics = RobotStatistics::new(&robot);
        for (fault, [mass, center, moments]) in faults {
            for (index, link) in statistics.links.iter().enumerate() {
                tried += 1;
                let spoilt = changed(&robot, |other| other == index, scaled(mass, center, moments));
                let found = suspected(&spoilt);
                let context = format!("{name}, link {:?}, {fault}: {found:#?}", link.link);
                // No other link is suspected.
                assert!(found.iter().all(|s| s.places == [format!("link {:?}", link.link)]), "{context}");
                if found.is_empty() {
                    missed += 1;
                    let is_light = link.mass < 0.03 * statistics.mass;
                    let is_near =
                        1e3 * link.center_distance < (3.0 * statistics.size).max(30.0 * link.gyration);
                    let reason = if center == 1.0 { is_light } else { is_near };
                    assert!(reason, "{:.4} of the mass, {context}", link.mass / statistics.mass);
                }
            }
        }
    }
    assert!(7 * missed < tried, "{missed} of {tried}");
}

/// The text with each number of each attribute `name` multiplied by a factor.
fn with_attribute(text: &str, name: &str, factor: f64) -> String {
    let start = format!(" {name}=\"");
    let mut out = String::new();
    let mut rest = text;
    while let Some(at) = rest.find(&start) {
        let (before, after) = rest.split_at(at + start.len());
        let end = after.find('"').expect("a closing quote");
        out += before;
        let words: Vec<String> = after[..end]
            .split_whitespace()
            .map(|word| (word.parse::<f64>().expect("a number") * factor).to_string())
            .collect();
        out += &words.join(" ");
        rest = &after[end..];
    }
    out + rest
}

#[test]
fn angles_in_degrees_are_suspected() {
    let degrees = 180.0 / std::f64::consts::PI;
    for name in ROBOTS {
        let good = text(name);
        let Robot { description, angles, .. } = parse(&good, &LoadOptions::default()).expect("a robot");
        // Angles below seven degrees could be radians.
        let shows = angles.iter().flat_map(|written| written.angles).any(|angle| angle.abs() * degrees > 7.0);
        let found = suspected_in(&with_attribute(&good, "rpy", degrees));
        assert_eq!(!found.is_empty(), shows, "{name}: {found:#?}");
        assert!(found.iter().all(|s| s.quantity == Quantity::WrittenAngle), "{name}: {found:#?}");

        let turns =
            description.joints.iter().filter(|joint| matches!(joint.kind, JointKind::Revolute { .. }));
        let wide = |x: f64| x.is_finite() && x.abs() * degrees > 25.2;
        let shows = turns.clone().any(|joint| wide(joint.limits.lower) || wide(joint.limits.upper));
        let limits = with_attribute(&with_attribute(&good, "lower", degrees), "upper", degrees);
        let found = suspected_in(&limits);
        let in_limits = found.iter().any(|s| s.quantity == Quantity::AngleLimit);
        assert_eq!(in_limits, shows, "{name}: {found:#?}");
    }
}

/// Limits of prismatic joints in millimetres.
#[test]
fn slides_in_millimetres_are_suspected() {
    for name in ["gantry", "gripper"] {
        let limits = with_attribute(&with_attribute(&text(name), "lower", 1e3), "upper", 1e3);
        let found = suspected_in(&limits);
        let slide = found.iter().find(|s| s.quantity == Quantity::SlideOverSize);
        assert_eq!(slide.map(|s| s.cause.culprit), Some(Culprit::SlideLimits), "{name}: {found:#?}");
    }
}

/// In a robot of point masses with spheres as shapes, masses in grams are detected by the density of the
/// shapes.
#[test]
fn shapes_show_wrong_units_of_point_masses() {
    let robot = |mass: f64| {
        let link = |name: &str| {
            format!(
                r#"<link name="{name}"><inertial><mass value="{mass}"/><inertia ixx="0" ixy="0" ixz="0" iyy="0" iyz="0" izz="0"/></inertial>
                   <collision><geometry><sphere radius="0.05"/></geometry></collision></link>"#
            )
        };
        let joint = |name: &str, parent: &str, child: &str| {
            format!(
                r#"<joint name="{name}" type="continuous"><parent link="{parent}"/><child link="{child}"/><origin xyz="1 0 0"/></joint>"#
            )
        };
        let parts =
            [link("a"), link("b"), link("c"), joint("one", "a", "b"), joint("two", "b", "c")].concat();
        format!("<robot name=\"balls\">{parts}</robot>")
    };
    assert_eq!(suspected_in(&robot(4.0)), []);
    let found = suspected_in(&robot(4000.0));
    assert_eq!(found.first().map(|s| s.quantity), Some(Quantity::ShapeDensity), "{found:#?}");
}
