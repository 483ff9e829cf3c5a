//! One circle in every format: written, rewritten, executed on the machine, against what the CSV program gains.
//!
//! The circle is the bundled one (independent inverse kinematics, joints A1 to A3). The machine has half gaps alone: a gap
//! that fades in seconds would compare the formats' speeds, not their numbers.

use crate::support::{WorkFolder, bundled, run};
use serde_json::Value;
use std::fmt::Write;

const MODEL: &str = "schema: lostmotion/model/1
robot: robot.yaml
effects:
  - {effect: backlash, joint: A1, half_gap_deg: 0.0028}
  - {effect: backlash, joint: A2, half_gap_deg: 0.0037}
  - {effect: backlash, joint: A3, half_gap_deg: 0.0022}
";

/// Joints of the bundled circle, deg.
pub fn circle() -> Vec<[f64; 6]> {
    let text = std::fs::read_to_string(bundled("samples/circle/circle_program.csv")).unwrap();
    let rows = text.lines().filter(|l| !l.starts_with('#')).skip(1);
    let row = |l: &str| {
        let v: Vec<f64> = l.split(',').map(|c| c.parse().unwrap()).collect();
        [v[0], v[1], v[2], v[3], v[4], v[5]]
    };
    rows.map(row).collect()
}

/// The circle in a format: file name, text, last digit of a joint in deg.
pub fn written(format: &str, points: &[[f64; 6]]) -> (String, String, f64) {
    let mut t = String::new();
    let list = |q: &[f64; 6], decimals: usize| q.map(|v| format!("{v:.decimals$}")).join(",");
    match format {
        "krl" => {
            t.push_str("&ACCESS RVP\r\nDEF circle( )\r\n");
            for q in points {
                let parts: Vec<String> = q.iter().enumerate().map(|(k, v)| format!("A{} {v:.6}", k + 1)).collect();
                let _ = write!(t, "PTP {{{}}} C_PTP\r\n", parts.join(","));
            }
            t.push_str("END\r\n");
            ("circle.src".into(), t, 1e-4)
        }
        "rapid" => {
            t.push_str("MODULE circle\n  PROC main()\n");
            for q in points {
                let _ = writeln!(
                    t,
                    "    MoveAbsJ [[{}],[9E9,9E9,9E9,9E9,9E9,9E9]]\\NoEOffs, [1.5,500,5000,1000], z0, tool0;",
                    list(q, 5)
                );
            }
            t.push_str("  ENDPROC\nENDMODULE\n");
            ("circle.mod".into(), t, 1e-4)
        }
        "fanuc" => {
            let _ = write!(t, "/PROG  CIRCLE\n/ATTR\nLINE_COUNT\t= {};\n/MN\n", points.len());
            for k in 1..=points.len() {
                let _ = writeln!(t, "{k:4}:J P[{k}] 100% CNT100    ;");
            }
            t.push_str("/POS\n");
            for (k, q) in points.iter().enumerate() {
                let f = |i: usize| format!("J{}={:>10.3} deg", i + 1, q[i]);
                let rows = [[f(0), f(1), f(2)].join(",\t"), [f(3), f(4), f(5)].join(",\t")];
                let _ = write!(t, "P[{}]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\t{},\n\t{}\n}};\n", k + 1, rows[0], rows[1]);
            }
            t.push_str("/END\n");
            ("circle.ls".into(), t, 1e-3)
        }
        "urscript" => {
            t.push_str("def circle():\n");
            for q in points {
                let _ = writeln!(t, "  movej([{}], a=1.4, v=1.05, r=0)", list(&q.map(f64::to_radians), 8));
            }
            t.push_str("end\n");
            ("circle.script".into(), t, 1e-4)
        }
        "inform" => {
            let n = points.len();
            let _ = write!(t, "/JOB\r\n//NAME CIRCLE\r\n//POS\r\n///NPOS {n},0,0,0,0,0\r\n///TOOL 0\r\n");
            t.push_str("///POSTYPE PULSE\r\n///PULSE\r\n");
            for (k, q) in points.iter().enumerate() {
                let pulses: Vec<String> =
                    q.iter().zip(PULSES).map(|(v, p)| format!("{}", (v * p).round() as i64)).collect();
                let _ = write!(t, "C{k:05}={}\r\n", pulses.join(","));
            }
            t.push_str("//INST\r\n///DATE 2020/01/01 00:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n");
            for k in 0..n {
                let _ = write!(t, "MOVJ C{k:05} VJ=50.00 \r\n");
            }
            t.push_str("END\r\n");
            ("circle.JBI".into(), t, 1.0 / 1341.4)
        }
        "trajectory" => {
            t.push_str("joint_names: [A1, A2, A3, A4, A5, A6]\npoints:\n");
            for (k, q) in points.iter().enumerate() {
                let _ = writeln!(t, "- positions: [{}]", list(&q.map(f64::to_radians), 8));
                // chords of 7.8537 mm at 1.5 mm/s
                let ns = k as u64 * 5_235_800_000;
                let (sec, ns) = (ns / 1_000_000_000, ns % 1_000_000_000);
                let _ = writeln!(t, "  time_from_start: {{sec: {sec}, nanosec: {ns}}}");
            }
            ("circle.yaml".into(), t, 1e-4)
        }
        _ => {
            t.push_str("a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n");
            for q in points {
                let _ = writeln!(t, "{}", list(q, 6));
            }
            ("circle.csv".into(), t, 1e-4)
        }
    }
}

const PULSES: [f64; 6] = [1341.4, 1341.4, 1341.4, 1000.0, 1000.0, 622.0];

/// The KUKA with pulses, so that one robot serves every format.
pub fn robot() -> String {
    let text = std::fs::read_to_string(bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap();
    let mut n = 0;
    let lines = text.lines().map(|l| {
        if !l.trim_start().starts_with("- {name: A") {
            return l.to_string();
        }
        n += 1;
        l.replacen("kind: revolute,", &format!("kind: revolute, pulses_per_deg: {},", PULSES[n - 1]), 1)
    });
    // in a FANUC program, too, this arm's third axis is its motor's own
    lines.collect::<Vec<_>>().join("\n") + "\ngap_of: {A3: A3}\n"
}

/// Largest error beyond the circle at each reversal, um, without and with compensation.
fn errors(format: &str) -> (Vec<[f64; 2]>, f64) {
    let folder = WorkFolder::new();
    let at = folder.path();
    let points = circle();
    let (name, text, digit) = written(format, &points);
    std::fs::write(at.join("robot.yaml"), robot()).unwrap();
    std::fs::write(at.join("model.yaml"), MODEL).unwrap();
    std::fs::write(at.join(&name), &text).unwrap();
    std::fs::write(at.join("nominal.csv"), written("csv", &points).1).unwrap();
    let out = format!("out-{name}");
    run(at, &format!("rewrite --model model.yaml {name} --output {out}")).success();
    run(at, &format!("simulate --model model.yaml --input {name} --output before.csv --speed-mm-s 1.5")).success();
    run(at, &format!("simulate --model model.yaml --input {out} --output after.csv --speed-mm-s 1.5")).success();
    let json =
        run(at, "assess circle --robot robot.yaml --nominal nominal.csv --before before.csv --after after.csv --json")
            .success()
            .stdout;
    let found: Value = serde_json::from_slice(&json).unwrap();
    let totals = |which: &str| -> Vec<f64> {
        let list = found[which]["reversals"].as_array().unwrap();
        list.iter().map(|r| r["beyond_nominal_um"].as_f64().unwrap()).collect()
    };
    (totals("before").into_iter().zip(totals("after")).map(|(a, b)| [a, b]).collect(), digit)
}

#[test]
fn every_format_takes_out_what_the_csv_program_takes_out_within_its_resolution() {
    let (csv, _) = errors("csv");
    assert_eq!(csv.len(), 6);
    for format in ["krl", "rapid", "urscript", "trajectory", "fanuc", "inform"] {
        let (found, digit) = errors(format);
        // half a digit of each of three joints at 2 m, there and back
        let rounding_um = 3.0 * 0.5 * digit.to_radians() * 2.0 * 1e6;
        for (k, (a, b)) in csv.iter().zip(&found).enumerate() {
            assert!((a[0] - b[0]).abs() < 2.0 + rounding_um, "{format}, reversal {k}: before {} and {}", a[0], b[0]);
            assert!(b[1] < a[1] + 2.0 + rounding_um, "{format}, reversal {k}: after {} and {}", a[1], b[1]);
        }
        println!("{format}: {found:?}");
    }
    println!("csv: {csv:?}");
}
