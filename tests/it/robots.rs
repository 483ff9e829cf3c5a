//! The bundled arms against poses of the public URDF files that they come from (tests/oracle/robots.py).

use lostmotion::robot::{Robot, plausible};
use serde_json::Value;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn oracle() -> serde_json::Map<String, Value> {
    let text = std::fs::read_to_string(root().join("tests/oracle/robots.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

fn load(name: &str) -> (Robot, String) {
    let path = root().join(format!("configs/{name}.yaml"));
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
    let page = std::fs::read_to_string(root().join("docs/robot.md")).unwrap();
    for entry in std::fs::read_dir(root().join("configs")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().and_then(|n| n.to_str()).unwrap().to_string();
        assert!(page.contains(&format!("`{name}`")), "{name} is not in docs/robot.md");
        assert!(Path::new(&path).extension().is_some_and(|e| e == "yaml"), "{}", path.display());
    }
}
