//! `robot check` and `robot init` through the binary.

use crate::support::{WorkFolder, root, run_args};
use serde_json::Value;
use std::path::Path;

#[test]
fn every_bundled_robot_passes_the_check() {
    let mut checked = 0;
    for entry in std::fs::read_dir("configs").unwrap() {
        let path = entry.unwrap().path();
        let out = run_args(root(), &["robot", "check", path.to_str().unwrap()]);
        assert!(out.succeeded(), "{}: {}", path.display(), out.stderr);
        checked += 1;
    }
    assert!(checked >= 7, "{checked}");
}

/// The KR 120 at zero, by hand from its data sheet: 350 + 1150 + 1000 mm out, wrist flange and tool beyond, 675 - 41 mm up.
#[test]
fn the_tcp_at_a_pose_is_that_of_forward_kinematics() {
    let robot = "configs/kuka-kr120-r2500-pro.yaml";
    let out = run_args(root(), &["robot", "check", robot, "--pose", "0,-90,90,0,0,0", "--json"]);
    let doc: Value = serde_json::from_slice(&out.stdout).unwrap();
    assert_eq!(doc["schema"], "lostmotion/robot-check/1");
    let loaded = lostmotion::robot::Robot::load(Path::new(robot)).unwrap();
    let q: Vec<f64> = [0.0f64, -90.0, 90.0, 0.0, 0.0, 0.0].map(f64::to_radians).to_vec();
    let tcp = loaded.tcp_m(&q) * 1e3;
    let pose = &doc["poses"][2]["xyz_mm"];
    for k in 0..3 {
        assert!((pose[k].as_f64().unwrap() - tcp[k]).abs() < 1e-9);
    }
}

#[test]
fn metres_and_radians_are_found() {
    let text = std::fs::read_to_string("configs/kuka-kr120-r2500-pro.yaml").unwrap();
    let folder = WorkFolder::new();
    let path = folder.join("a robot in metres.yaml");
    let mut in_metres = String::new();
    for line in text.lines() {
        let changed = line.replace("d_mm: ", "d_mm: 0.000").replace("a_mm: ", "a_mm: 0.000");
        in_metres.push_str(
            &changed.replace("0.000-", "-0.000").replace("xyz_mm: [156, 0, 63]", "xyz_mm: [0.156, 0, 0.063]"),
        );
        in_metres.push('\n');
    }
    std::fs::write(&path, in_metres).unwrap();
    let out = run_args(root(), &["robot", "check", path.to_str().unwrap()]);
    assert_eq!(out.code, Some(1), "{}", out.text());
    assert!(out.stderr.contains("metres written as millimetres"), "{}", out.stderr);
}

#[test]
fn a_urdf_becomes_a_robot_file_that_is_read_again() {
    let folder = WorkFolder::new();
    let made = folder.join("robot.yaml");
    let out =
        run_args(root(), &["robot", "init", "--urdf", "samples/robots/scara.urdf", "--output", made.to_str().unwrap()]);
    assert!(out.succeeded(), "{}", out.stderr);
    let robot = lostmotion::robot::Robot::load(&made).unwrap();
    assert_eq!(robot.axis_names(), ["shoulder", "elbow", "quill"]);
    // by hand: arms of 325 and 225 mm in line, quill 60 mm down from 400 mm, flange 20 mm below it
    let tcp = robot.tcp_m(&[0.0, 0.0, 0.06]) * 1e3;
    assert!((tcp - nalgebra::Vector3::new(550.0, 0.0, 320.0)).norm() < 1e-9, "{tcp}");
    // elbow at a right angle
    let tcp = robot.tcp_m(&[0.0, std::f64::consts::FRAC_PI_2, 0.0]) * 1e3;
    assert!((tcp - nalgebra::Vector3::new(325.0, 225.0, 380.0)).norm() < 1e-9, "{tcp}");
}

#[test]
fn what_is_no_urdf_is_refused_with_line_and_column() {
    let folder = WorkFolder::new();
    let path = folder.join("x.urdf");
    for (text, needle) in
        [("", "XML"), ("<robot name='r'>", "x.urdf:1:"), ("<mujoco/>", "<robot>"), ("<robot name='r'/>", "no chain")]
    {
        std::fs::write(&path, text).unwrap();
        let out = run_args(root(), &["robot", "init", "--urdf", path.to_str().unwrap()]);
        assert_eq!(out.code, Some(2), "{text}");
        assert!(out.stderr.contains(needle), "{text}: {}", out.stderr);
        assert!(out.stdout.is_empty());
    }
}

#[test]
fn single_numbers_in_another_unit_and_poses_beyond_limits_are_noted() {
    let text = std::fs::read_to_string("configs/universal-robots-ur10e.yaml").unwrap();
    let folder = WorkFolder::new();
    let path = folder.join("robot.yaml");
    let check = |text: &str, pose: Option<&str>| {
        std::fs::write(&path, text).unwrap();
        let mut args = vec!["robot", "check", path.to_str().unwrap()];
        args.extend(pose.iter().flat_map(|p| ["--pose", p]));
        let out = run_args(root(), &args);
        (out.code, out.text() + &out.stderr)
    };
    let (code, clean) = check(&text, None);
    assert!(code == Some(0) && !clean.contains("is this"), "{clean}");
    let changed = |key: &str, to: &str| {
        let pattern = regex::Regex::new(&format!(r"{key}: -?[0-9.]*[1-9][0-9.]*")).unwrap();
        assert!(pattern.is_match(&text), "{key}");
        pattern.replacen(&text, 1, format!("{key}: {to}")).into_owned()
    };
    let (code, said) = check(&changed("a_mm", "-0.6127"), None);
    assert!(code == Some(0) && said.contains("is this metres?"), "{said}");
    let (code, said) = check(&changed("alpha_deg", "-1.5708"), None);
    assert!(code == Some(1) && said.contains("is this radians?"), "{said}");
    let (code, said) = check(&changed("max_speed_deg_s", "2.0944"), None);
    assert!(code == Some(0) && said.contains("is this rad/s?"), "{said}");
    let with = |key: &str, to: &str| {
        let pattern = regex::Regex::new(&format!(r"(?m)^{key}: .*$")).unwrap();
        pattern.replace(&text, "").into_owned() + &format!("\n{key}: {to}\n")
    };
    for (key, to) in [("tool", "[0, 1.5708, 0]"), ("base", "[0, 0, 3.14159]")] {
        let (code, said) = check(&with(key, &format!("{{xyz_mm: [0, 0, 0], rpy_deg: {to}}}")), None);
        assert!(code == Some(1) && said.contains(&format!("rpy_deg of {key} has an angle of")), "{said}");
    }
    let (code, said) = check(&with("tool", "{xyz_mm: [0.156, 0, 0.063], rpy_deg: [0, 0, 0]}"), None);
    assert!(code == Some(0) && said.contains("tool is 0.168241 mm long: is xyz_mm in metres?"), "{said}");
    let limits = regex::Regex::new(r"limits_deg: \[[^]]*\]").unwrap();
    let (code, said) = check(&limits.replacen(&text, 1, "limits_deg: [-2.44, -0.087]"), None);
    assert!(code == Some(0) && said.contains("has limits -2.44 to -0.087 deg"), "{said}");
    let (code, said) = check(&text, Some("500,0,0,0,0,0"));
    assert!(code == Some(0) && said.contains("is beyond its limits"), "{said}");
}

#[test]
fn a_robot_file_is_replaced_only_when_forced_and_holds_no_rounding() {
    let folder = WorkFolder::new();
    let made = folder.join("robot.yaml");
    let urdf = std::fs::read_to_string("samples/robots/scara.urdf").unwrap();
    let init = |urdf: &str, more: &[&str]| {
        let path = folder.join("arm.urdf");
        std::fs::write(&path, urdf).unwrap();
        let made = made.to_str().unwrap();
        run_args(root(), &[&["robot", "init", "--urdf", path.to_str().unwrap(), "--output", made], more].concat())
    };
    assert!(init(&urdf, &[]).succeeded());
    let first = std::fs::read_to_string(&made).unwrap();
    assert!(!first.contains("99999") && !first.contains("00000") && !first.contains("$schema"), "{first}");
    // as the files of the library: where it is from, and a line for each joint
    assert!(first.starts_with("# made by: lostmotion robot init --urdf arm.urdf\nschema: "), "{first}");
    assert_eq!(first.lines().filter(|l| l.starts_with("  - {name: ") && l.contains(", kind: ")).count(), 3, "{first}");
    let digits = |l: &str| l.split(['.']).skip(1).map(|d| d.bytes().take_while(u8::is_ascii_digit).count()).max();
    let limits = first.lines().filter_map(|l| l.split_once("limits_")).map(|l| l.1);
    assert!(limits.filter_map(digits).all(|n| n <= 4), "{first}");
    let edited = first + "# by hand\n";
    std::fs::write(&made, &edited).unwrap();
    let out = init(&urdf, &[]);
    assert!(out.code == Some(2) && out.stderr.contains("--force"), "{}", out.stderr);
    assert_eq!(std::fs::read_to_string(&made).unwrap(), edited);
    assert!(init(&urdf, &["--force"]).succeeded());
    // millimetres in place of metres
    let numbers = regex::Regex::new(r#"xyz="([^"]*)""#).unwrap();
    let thousandfold = numbers.replace_all(&urdf, |c: &regex::Captures| {
        let scaled: Vec<String> =
            c[1].split_whitespace().map(|v| (v.parse::<f64>().unwrap() * 1e3).to_string()).collect();
        format!("xyz=\"{}\"", scaled.join(" "))
    });
    // the axes are directions
    let axis = regex::Regex::new(r#"<axis xyz="[^"]*""#).unwrap();
    let axes: Vec<String> = axis.find_iter(&urdf).map(|m| m.as_str().to_string()).collect();
    let mut k = 0;
    let in_mm = axis.replace_all(&thousandfold, |_: &regex::Captures| {
        k += 1;
        axes[k - 1].clone()
    });
    let out = init(&in_mm, &["--force"]);
    assert!(out.code == Some(2) && out.stderr.contains("metres"), "{}", out.stderr);
}
