//! A case as a folder: `robot.yaml`, `model.yaml`, `train.csv`, `test.csv`, `truth.json`.

use crate::case::{Case, Log};
use crate::robots::Robot;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

pub fn write(case: &Case, folder: &Path) {
    std::fs::create_dir_all(folder).expect("the folder can be made");
    let put = |name: &str, text: &str| std::fs::write(folder.join(name), text).expect("the file can be written");
    put("robot.yaml", &case.robot.yaml());
    put("model.yaml", &case.model_yaml);
    put("train.csv", &csv(&case.robot, &case.train));
    put("test.csv", &csv(&case.robot, &case.test));
    put("truth.json", &(serde_json::to_string_pretty(&case.truth).expect("JSON") + "\n"));
}

fn csv(robot: &Robot, log: &Log) -> String {
    let mut s = String::from("t_s");
    for j in &robot.joints {
        let _ = write!(s, ",cmd_{}_{}", j.name, j.suffix());
    }
    for j in robot.joints.iter().filter(|_| log.torque.is_some()) {
        let _ = write!(s, ",torque_{}_{}", j.name, if j.revolute { "nm" } else { "n" });
    }
    if log.force.is_some() {
        s.push_str(",fx_n,fy_n,fz_n");
    }
    s.push_str(",x_mm,y_mm,z_mm\n");
    for (row, ((t, cmd), tcp)) in log.t_s.iter().zip(&log.cmd).zip(&log.tcp_mm).enumerate() {
        let _ = write!(s, "{t:.4}");
        for c in cmd {
            let _ = write!(s, ",{c:.*}", log.decimals);
        }
        let torques = log.torque.iter().flat_map(|t| &t[row]);
        for v in torques.chain(log.force.iter().flat_map(|f| &f[row])) {
            let _ = write!(s, ",{v:.4}");
        }
        match tcp {
            Some(p) => {
                let _ = writeln!(
                    s,
                    ",{:.*},{:.*},{:.*}",
                    log.tcp_decimals, p[0], log.tcp_decimals, p[1], log.tcp_decimals, p[2]
                );
            }
            None => s.push_str(",,,\n"),
        }
    }
    s
}

pub fn read_truth(folder: &Path) -> Value {
    let text = std::fs::read_to_string(folder.join("truth.json")).expect("truth.json is there");
    serde_json::from_str(&text).expect("truth.json is JSON")
}

pub fn read_robot(folder: &Path) -> Robot {
    Robot::parse(&std::fs::read_to_string(folder.join("robot.yaml")).expect("robot.yaml is there"))
}

/// Reads a log of a case; commands in file units, in the order of the joints.
pub fn read_log(path: &Path, robot: &Robot) -> Log {
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(path).expect("the log can be opened");
    let header: Vec<String> = reader.headers().expect("a header").iter().map(str::to_lowercase).collect();
    let column = |name: String| header.iter().position(|h| *h == name.to_lowercase());
    let cmd: Vec<usize> = robot
        .joints
        .iter()
        .map(|j| column(format!("cmd_{}_{}", j.name, j.suffix())).expect("a column per joint"))
        .collect();
    let tcp = ["x_mm", "y_mm", "z_mm"].map(|n| column(n.into()).expect("TCP columns"));
    let t = column("t_s".into()).expect("t_s");
    let mut log =
        Log { t_s: vec![], cmd: vec![], tcp_mm: vec![], torque: None, force: None, decimals: 6, tcp_decimals: 4 };
    for row in reader.records() {
        let row = row.expect("a CSV row");
        let number = |k: usize| row.get(k).and_then(|v| v.trim().parse::<f64>().ok());
        log.t_s.push(number(t).expect("a time"));
        log.cmd.push(cmd.iter().map(|&k| number(k).expect("a command")).collect());
        let p = tcp.map(number);
        log.tcp_mm.push(if let [Some(x), Some(y), Some(z)] = p { Some([x, y, z]) } else { None });
    }
    log
}
