//! The bundled arms against poses of the public URDF files that they come from (tests/oracle/robots.py).

use crate::support::bundled;
use lostmotion::robot::{Robot, plausible};
use serde_json::Value;
use std::path::Path;

fn oracle() -> serde_json::Map<String, Value> {
    let text = std::fs::read_to_string(bundled("tests/oracle/robots.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn load(name: &str) -> (Robot, String) {
    let path = bundled(&format!("configs/{name}.yaml"));
    (Robot::load(&path).unwrap(), std::fs::read_to_string(&path).unwrap())
}

#[test]
fn every_arm_stands_where_its_urdf_says() {
    let oracle = oracle();
    assert!(oracle.len() >= 25, "{} arms", oracle.len());
    for (name, expected) in &oracle {
        let (robot, _) = load(name);
        for pose in expected["poses"].as_array().unwrap() {
            let joints = numbers(&pose["joints_deg"]);
            assert_eq!(joints.len(), robot.dof(), "{name}");
            let q: Vec<f64> = joints.iter().map(|v| v.to_radians()).collect();
            let found = robot.forward(&q);
            let want = numbers(&pose["xyz_m"]);
            for k in 0..3 {
                assert!((found.position[k] - want[k]).abs() < 1e-9, "{name}: {} and {want:?}", found.position);
                let row = numbers(&pose["rotation"][k]);
                for (column, want) in row.iter().enumerate() {
                    assert!((found.rotation[(k, column)] - want).abs() < 1e-9, "{name}");
                }
            }
        }
    }
}

/// Orientation of the null tool at the position that pendants call zero (KUKA: A2 -90, A3 90): columns x and z of the flange in the world.
/// ABB (product manuals): q = 0.7071, 0, 0.7071, 0. KUKA: A 0, B 90, C 0. FANUC and Yaskawa: 180, -90, 0 about fixed X, Y, Z.
fn at_zero(name: &str) -> Option<(Vec<f64>, [f64; 3], [f64; 3])> {
    let zero = vec![0.0; 6];
    match name.split('-').next()? {
        "abb" => Some((zero, [0.0, 0.0, -1.0], [1.0, 0.0, 0.0])),
        "kuka" if !name.contains("iiwa") => {
            Some((vec![0.0, -90.0, 90.0, 0.0, 0.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]))
        }
        "fanuc" => Some((zero, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])),
        // the arms with seven joints and for people begin upright or folded
        "motoman" if !name.contains("hc10") && !name.contains("sia") => Some((zero, [0.0, 0.0, 1.0], [1.0, 0.0, 0.0])),
        _ => None,
    }
}

#[test]
fn flange_and_world_of_every_arm_are_its_makers() {
    let mut seen = 0;
    for entry in std::fs::read_dir(bundled("configs")).unwrap() {
        let name = entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_string();
        let Some((deg, x, z)) = at_zero(&name) else { continue };
        let (robot, _) = load(&name);
        let bare = robot.with_geometry(robot.joints.clone(), nalgebra::Isometry3::identity());
        let q: Vec<f64> = deg.iter().map(|v| v.to_radians()).collect();
        let found = bare.forward(&q);
        for k in 0..3 {
            assert!((found.rotation[(k, 0)] - x[k]).abs() < 1e-6, "{name}: x of the flange\n{}", found.rotation);
            assert!((found.rotation[(k, 2)] - z[k]).abs() < 1e-6, "{name}: z of the flange\n{}", found.rotation);
        }
        // FANUC and Yaskawa count heights from the second axis, the others from the foot
        let height = robot.base.translation.z + robot.joints[0].d_m;
        if name.starts_with("fanuc") || name.starts_with("motoman") {
            assert!(height.abs() < 1e-9, "{name}: the second axis at {height} m");
        } else {
            assert!(robot.base.translation.z.abs() < 1e-9, "{name}");
        }
        if name != "kuka-kr120-r2500-pro" {
            assert!(
                robot.tool.translation.vector.norm() == 0.0 && robot.tool.rotation.angle() == 0.0,
                "{name}: a tool"
            );
        }
        seen += 1;
    }
    assert!(seen >= 36, "{seen} arms");
}

#[test]
fn every_arm_reaches_as_far_as_its_data_sheet_says_and_names_its_origin() {
    for (name, expected) in &oracle() {
        let (robot, text) = load(name);
        let (reach, sheet) = (expected["reach_mm"].as_f64().unwrap(), expected["data_sheet_mm"].as_f64().unwrap());
        // makers measure to the wrist centre, to the flange (Staubli), or without offsets (Universal Robots)
        assert!((reach / sheet - 1.0).abs() < 0.12, "{name}: {reach} against {sheet} mm");
        assert!(plausible::reach_m(&robot) * 1e3 >= reach - 1.0, "{name}");
        assert!(plausible::findings(&robot).iter().all(|f| !f.is_fault()), "{name}");
        assert!(robot.axis_joints().all(|j| j.limits.is_some() && j.max_speed.is_some()), "{name}");
        for part in ["github.com/", "at commit", "data sheet"] {
            assert!(text.lines().filter(|l| l.starts_with('#')).any(|l| l.contains(part)), "{name}: no {part}");
        }
    }
}

#[test]
fn no_robot_of_the_library_is_left_out_of_the_page() {
    let page = std::fs::read_to_string(bundled("docs/robot.md")).unwrap();
    for entry in std::fs::read_dir(bundled("configs")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().and_then(|n| n.to_str()).unwrap().to_string();
        assert!(page.contains(&format!("`{name}`")), "{name} is not in docs/robot.md");
        assert!(Path::new(&path).extension().is_some_and(|e| e == "yaml"), "{}", path.display());
    }
}

/// Where a linkage drives the forearm (ABB), or the pendant counts it so (FANUC), J2 alone does not tilt it.
#[test]
fn j2_alone_leaves_the_forearm_level_on_the_arms_whose_controller_counts_it_so() {
    let level = |name: &str| {
        let (robot, _) = load(name);
        let tilt = |j2: f64| robot.forward(&[0.0, j2, 0.1, 0.2, 0.3, 0.4]).rotation;
        (tilt(0.0).matrix() - tilt(0.5).matrix()).norm() < 1e-9
    };
    for name in ["abb-irb2400-12-155", "abb-irb4400l-30-243", "fanuc-m10ia", "fanuc-m20ia", "fanuc-lrmate200id"] {
        assert!(level(name), "{name}");
    }
    for name in ["abb-irb1600-6-145", "abb-irb6600-225-255", "abb-irb6640-185-280", "motoman-gp25"] {
        assert!(!level(name), "{name}");
    }
}

/// Standard Denavit-Hartenberg parameters that Universal Robots publishes ("DH Parameters for calculations of kinematics and dynamics",
/// universal-robots.com/articles/ur/application-installation): robot file, `a` of joints 2 and 3, `d` of joints 1, 4, 5 and 6, m. `alpha`
/// is 90, 0, 0, 90, -90, 0 deg.
const PUBLISHED: [(&str, [f64; 2], [f64; 4]); 4] = [
    ("universal-robots-ur3e", [-0.24355, -0.2132], [0.15185, 0.13105, 0.08535, 0.0921]),
    ("universal-robots-ur5e", [-0.425, -0.3922], [0.1625, 0.1333, 0.0997, 0.0996]),
    ("universal-robots-ur10e", [-0.6127, -0.57155], [0.1807, 0.17415, 0.11985, 0.11655]),
    ("universal-robots-ur20", [-0.8620, -0.7287], [0.2363, 0.2010, 0.1593, 0.1543]),
];

/// Pose of the flange by published parameters.
fn by_parameters([a2, a3]: [f64; 2], [d1, d4, d5, d6]: [f64; 4], q: &[f64]) -> nalgebra::Isometry3<f64> {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
    let quarter = std::f64::consts::FRAC_PI_2;
    let links =
        [(d1, 0.0, quarter), (0.0, a2, 0.0), (0.0, a3, 0.0), (d4, 0.0, quarter), (d5, 0.0, -quarter), (d6, 0.0, 0.0)];
    links.iter().zip(q).fold(Isometry3::identity(), |pose, ((d, a, alpha), q)| {
        let turn = Isometry3::from_parts(
            Translation3::new(0.0, 0.0, *d),
            UnitQuaternion::from_axis_angle(&Vector3::z_axis(), *q),
        );
        let lean = Isometry3::from_parts(
            Translation3::new(*a, 0.0, 0.0),
            UnitQuaternion::from_axis_angle(&Vector3::x_axis(), *alpha),
        );
        pose * turn * lean
    })
}

/// Joints, rad, and the pose without a tool, m and a rotation vector, rad, that the maker's controller in simulation (URSim) wrote side by
/// side into programs: UR10e of `Move_Circle.script` of github.com/rparak/URScript_Examples, UR5e of an article on URSim's image for
/// the e-Series (masayuki-kono, 2023-03-29).
const WRITTEN: [(&str, [f64; 6], [f64; 6]); 3] = [
    (
        "universal-robots-ur10e",
        [
            -1.3196121919157342,
            -1.756599685698049,
            -2.0634078196113883,
            -0.8922170360694253,
            1.572415943754062,
            0.2949248755915077,
        ],
        [0.000027413165, -0.700008089541, 0.307642439671, 0.068667031305, 3.139237750912, 0.000437121225],
    ),
    (
        "universal-robots-ur5e",
        [-1.6007, -1.7271, -2.203, -0.808, 1.5951, -0.031],
        [-0.143968656714, -0.435620060803, 0.202030025428, -0.001221359682, 3.116276528482, 0.038891915637],
    ),
    (
        "universal-robots-ur5e",
        [
            -1.6006999999466975,
            -1.5433880589507778,
            -2.04162795671306,
            -1.1530839843348648,
            1.5951000000013709,
            -0.030999999946700108,
        ],
        [-0.143968656711, -0.435620060727, 0.316972358784, -0.001221359682, 3.116276528482, 0.038891915637],
    ),
];

#[test]
fn arms_of_universal_robots_are_those_of_the_parameters_and_poses_that_their_maker_publishes() {
    use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
    let pose_of = |robot: &Robot, q: &[f64]| {
        let at = robot.forward(q);
        let rotation = UnitQuaternion::from_rotation_matrix(&at.rotation);
        Isometry3::from_parts(Translation3::from(at.position), rotation)
    };
    let near = |a: &Isometry3<f64>, b: &Isometry3<f64>, m: f64, rad: f64| {
        let by = a.inverse() * b;
        by.translation.vector.norm() < m && by.rotation.angle() < rad
    };
    for (name, a, d) in PUBLISHED {
        let (robot, _) = load(name);
        for k in 0..50_u32 {
            let q: Vec<f64> = (0..6_u32).map(|i| 2.0 * f64::from(k * (7 + 3 * i) + 11 * i).sin()).collect();
            let [ours, theirs] = [pose_of(&robot, &q), by_parameters(a, d, &q)];
            // the URDF's own numbers have lengths to 25 pm and an angle to 1e-10 rad
            assert!(near(&ours, &theirs, 1e-8, 1e-8), "{name} at {q:?}: {ours} and {theirs}");
        }
    }
    for (name, q, pose) in WRITTEN {
        let (robot, _) = load(name);
        let turn = UnitQuaternion::from_scaled_axis(Vector3::new(pose[3], pose[4], pose[5]));
        let theirs = Isometry3::from_parts(Translation3::new(pose[0], pose[1], pose[2]), turn);
        let ours = pose_of(&robot, &q);
        // twelve decimals are written
        assert!(near(&ours, &theirs, 3e-9, 3e-9), "{name}: {ours} and {theirs}");
    }
}
