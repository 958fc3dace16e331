//! Masses and inertias of meshes.

use robot_dynamics::algorithms::inverse_dynamics;
use robot_dynamics::model::{Model, Workspace};
use robot_dynamics_mjcf::{LoadOptions, Robot, parse};

/// A hinge that carries a tetrahedron with these faces.
fn swinging(faces: &str) -> Result<Robot, String> {
    let text = format!(
        "<mujoco><asset>
           <mesh name='m' vertex='0 0 0  0.3 0 0  0 0.4 0  0 0 0.5' face='{faces}' inertia='exact'/>
         </asset><worldbody><body pos='0 0 1'>
           <joint axis='0 1 0'/><geom type='mesh' mesh='m' pos='0.2 0.1 0'/>
         </body></worldbody></mujoco>"
    );
    parse(&text, &LoadOptions::default()).map_err(|error| error.to_string())
}

/// Mass, torque at rest, and M of the hinge.
fn numbers(robot: &Robot) -> [f64; 3] {
    let mass = robot.description.links[1].mass_properties.expect("a mass").mass();
    let model = Model::new(robot.description.clone()).expect("a model");
    let torque = |a: f64| {
        let mut tau = [0.0];
        inverse_dynamics(&model, &mut Workspace::new(&model), &[0.0], &[0.0], &[a], &mut tau);
        tau[0]
    };
    [mass, torque(0.0), torque(1.0) - torque(0.0)]
}

/// With `inertia="exact"` the surface must be oriented, as in MuJoCo. An open one is taken as MuJoCo takes
/// it, with a warning. The numbers are those of mujoco 4.0.0. It diagonalizes inertia with an error of 1e-9,
/// and its sums have other orders.
#[test]
fn exact_inertia_checks_the_surface() {
    let near = |robot: &Robot, expected: [f64; 3]| {
        let found = numbers(robot);
        assert!(found.iter().zip(expected).all(|(x, y)| (x - y).abs() < 1e-9 * y.abs()), "{found:?}");
    };
    let closed = swinging("0 2 1  0 3 2  0 1 3  1 2 3").expect("a robot");
    near(&closed, [10.000000546375919, -26.977501766346435, 1.0400000755989431]);
    assert_eq!(closed.report.warnings().count(), 0);

    let open = swinging("0 3 2  0 1 3  1 2 3").expect("a robot");
    near(&open, [6.666667030917279, -17.428138434925827, 0.7363986866945922]);
    let warnings: Vec<String> = open.report.warnings().map(|each| each.message().to_string()).collect();
    assert!(matches!(&warnings[..], [one] if one.contains("open at 3 edges")), "{warnings:?}");

    for (faces, fault) in [
        ("0 2 1  0 3 2  0 1 3  2 1 3", "same direction"),
        ("0 2 1  0 3 2  0 1 3  1 2 3  0 2 1  0 3 2  0 1 3  1 2 3", "occurs twice"),
        ("0 1 2  0 2 3  0 3 1  2 1 3", "not positive"),
    ] {
        let message = swinging(faces).expect_err(faces);
        assert!(message.contains(fault), "{message}");
    }
}

/// Meshes by their parameters, as mujoco 4.0.0 makes them: mass, height of the centre of mass, and principal
/// moments, scaled by 0.3, 0.2 and 0.1. Its coordinates have single precision.
#[test]
fn builtin_meshes_are_those_of_mujoco() {
    let cases: &[(&str, &str, &str, [f64; 5])] = &[
        (
            "sphere",
            "0",
            "exact",
            [15.21690283597444, 0.0, 0.2862873947831868, 0.22022107291014373, 0.1101105364550719],
        ),
        (
            "sphere",
            "3",
            "legacy",
            [24.91644466877148, 0.0, 0.644107394734648, 0.49546722545040994, 0.2477336111463377],
        ),
        (
            "hemisphere",
            "2",
            "exact",
            [
                10.713843470540942,
                0.03542788482201565,
                0.25083762235654233,
                0.1795046970269316,
                0.0830286884282614,
            ],
        ),
        (
            "cone",
            "5 0.4",
            "exact",
            [
                14.83648186094593,
                -0.02692307742716622,
                0.2354645179417466,
                0.20399711630384487,
                0.11343384201645046,
            ],
        ),
        (
            "cone",
            "7 0",
            "legacy",
            [10.945640636568731, -0.05, 0.18665254506796594, 0.14563945289489064, 0.07385001408278154],
        ),
        (
            "supersphere",
            "9 0.5 2",
            "exact",
            [13.887620370986125, 0.0, 0.3026189537868418, 0.22321830115146013, 0.10725021997942275],
        ),
        (
            "supertorus",
            "11 0.3 0.5 1.5",
            "legacy",
            [14.255292805029349, 0.0, 0.5900319610734549, 0.4117331466913305, 0.18443390070751098],
        ),
        (
            "supertorus",
            "11 0.3 0.5 1.5",
            "exact",
            [9.347051793536158, 0.0, 0.5130125901160967, 0.3577390370469759, 0.1601108218462561],
        ),
        (
            "wedge",
            "4 3 60 40 0.5",
            "legacy",
            [0.846244532311, -0.0814842959, 0.00701726, 0.00552339, 0.00155845],
        ),
        (
            "wedge",
            "5 5 180 90 0.3",
            "exact",
            [16.5254542466, -0.00784979623, 0.33648802, 0.24113267, 0.14154357],
        ),
        ("plate", "4 5", "exact", [144.000002146, -0.1, 3.65880009, 2.43000004, 1.22880005]),
    ];
    for (shape, parameters, inertia, expected) in cases {
        let text = format!(
            "<mujoco><asset>
               <mesh name='m' builtin='{shape}' params='{parameters}' inertia='{inertia}' scale='0.3 0.2 0.1'/>
             </asset><worldbody><body><freejoint/><geom type='mesh' mesh='m'/></body></worldbody></mujoco>"
        );
        let robot = parse(&text, &LoadOptions::default()).unwrap_or_else(|error| panic!("{shape}: {error}"));
        assert_eq!(robot.report.warnings().count(), 0, "{shape}: {}", robot.report);
        let body = robot.description.links[1].mass_properties.expect("a mass");
        let mut moments: Vec<f64> = body.principal().moments.iter().copied().collect();
        moments.sort_by(|a, b| b.total_cmp(a));
        let found = [body.mass(), body.center_of_mass().z, moments[0], moments[1], moments[2]];
        let near = |(x, y): (f64, &f64)| (x - y).abs() < 1e-6 * y.abs().max(0.1);
        assert!(found.into_iter().zip(expected).all(near), "{shape} {parameters}: {found:?}");
    }
}

/// With `fitaabb` a primitive has the size of the mesh's bounding box along its principal axes. Mass, center
/// of mass, and the inertia about it (xx, yy, zz, xy, xz, yz) are MuJoCo's, whose iteration for principal
/// axes ends with a rotation below 1.4e-6 rad. The bounds move by as much, hence the tolerance.
#[test]
fn primitives_fit_bounding_boxes_as_in_mujoco() {
    const ALLOWED: f64 = 1e-6;
    const CENTER: [f64; 3] = [1.210_206_775_517_131_7, 2.477_564_212_707_300_8, 3.329_406_755_173_418_6];
    #[rustfmt::skip]
    const FITTED: [(&str, f64, [f64; 6]); 5] = [
        ("sphere", 808.184_451_975_754_3, [107.940_660_282_655_07, 107.940_660_282_655_09, 107.940_660_282_655_09, 0.0, 0.0, 0.0]),
        ("capsule", 614.403_323_572_519_5, [69.471_884_790_257_2, 65.082_891_984_884_44, 73.551_899_603_309_62, -5.901_281_101_946_204, -0.297_603_078_856_751_86, -0.428_183_127_598_441_24]),
        ("cylinder", 852.845_817_999_759_6, [130.424_878_615_170_66, 114.823_449_471_364_2, 144.927_992_389_610_24, -20.977_117_769_934_097, -1.057_881_284_762_754_8, -1.522_050_507_265_117_4]),
        ("ellipsoid", 316.826_952_945_938_73, [24.633_187_857_363_367, 22.206_450_310_875_127, 34.488_489_115_225_33, -3.696_569_872_765_903_3, 2.643_196_941_474_178_7, -2.592_667_466_203_431]),
        ("box", 605.094_907_993_073_8, [78.409_872_232_212_68, 70.685_326_710_006_65, 109.780_270_449_182_78, -11.766_547_354_705_446, 8.413_557_176_019_895, -8.252_716_860_796_307]),
    ];
    for (kind, mass, inertia) in FITTED {
        let text = format!(
            "<mujoco><compiler fitaabb='true'/><asset>
               <mesh name='m' vertex='0 0 0  1 0 0.2  0.1 0.7 0  0.3 0.2 0.5  0.9 0.8 0.1'/></asset>
             <worldbody><body><geom type='{kind}' mesh='m' pos='1 2 3' euler='20 30 40' fitscale='1.1'/></body>
             </worldbody></mujoco>"
        );
        let robot = parse(&text, &LoadOptions::default()).expect("a robot");
        let body = robot.description.links[1].mass_properties.expect("a mass");
        let (center, own) = (body.center_of_mass(), body.inertia_about_center_of_mass());
        assert!((body.mass() - mass).abs() < ALLOWED * mass, "{kind}: {}", body.mass());
        for k in 0..3 {
            assert!((center[k] - CENTER[k]).abs() < ALLOWED, "{kind}: {center}");
        }
        for ((i, j), expected) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().zip(inertia) {
            assert!((own[(i, j)] - expected).abs() < ALLOWED * inertia[2], "{kind}: {own}");
        }
    }
}
