//! Samples, robots and outputs against the JSON Schemas of `lostmotion schema`.

use crate::support::{self, WorkFolder, bundled, root};
use lostmotion::schemas;
use serde_json::Value;
use std::path::{Path, PathBuf};

/// Faults of a value against a schema, for the keywords that the schemas use; any other keyword is a fault of the test.
fn faults(value: &Value, schema: &Value, whole: &Value, at: &str, out: &mut Vec<String>) {
    let Some(keys) = schema.as_object() else {
        if schema == &Value::Bool(false) {
            out.push(format!("{at}: not allowed"));
        }
        return;
    };
    for (key, expected) in keys {
        match key.as_str() {
            "$ref" => {
                let name = expected.as_str().unwrap().strip_prefix("#/$defs/").unwrap();
                faults(value, &whole["$defs"][name], whole, at, out);
            }
            "type" => {
                let fits = |t: &str| match t {
                    "object" => value.is_object(),
                    "array" => value.is_array(),
                    "string" => value.is_string(),
                    "number" => value.is_number(),
                    "integer" => value.is_i64() || value.is_u64(),
                    "boolean" => value.is_boolean(),
                    "null" => value.is_null(),
                    other => panic!("type {other}"),
                };
                let any = expected
                    .as_array()
                    .map_or_else(|| fits(expected.as_str().unwrap()), |a| a.iter().any(|t| fits(t.as_str().unwrap())));
                if !any {
                    out.push(format!("{at}: {value} is no {expected}"));
                }
            }
            "const" if value != expected => out.push(format!("{at}: {value}, not {expected}")),
            "enum" if !expected.as_array().unwrap().iter().any(|e| same(e, value)) => {
                out.push(format!("{at}: {value} is none of {expected}"))
            }
            "required" => {
                for name in expected.as_array().unwrap() {
                    if value.get(name.as_str().unwrap()).is_none() {
                        out.push(format!("{at}: no {name}"));
                    }
                }
            }
            "properties" => {
                for (name, part) in expected.as_object().unwrap() {
                    if let Some(v) = value.get(name) {
                        faults(v, part, whole, &format!("{at}.{name}"), out);
                    }
                }
            }
            "additionalProperties" => {
                for (name, v) in value.as_object().into_iter().flatten() {
                    if schema["properties"].get(name).is_none() {
                        faults(v, expected, whole, &format!("{at}.{name}"), out);
                    }
                }
            }
            "items" => {
                for (i, v) in value.as_array().into_iter().flatten().enumerate() {
                    faults(v, expected, whole, &format!("{at}[{i}]"), out);
                }
            }
            "prefixItems" => {
                for (i, (v, part)) in
                    value.as_array().into_iter().flatten().zip(expected.as_array().unwrap()).enumerate()
                {
                    faults(v, part, whole, &format!("{at}[{i}]"), out);
                }
            }
            "minItems" | "maxItems" => {
                let n = value.as_array().map_or(0, Vec::len) as u64;
                let bound = expected.as_u64().unwrap();
                if value.is_array() && if key == "minItems" { n < bound } else { n > bound } {
                    out.push(format!("{at}: {n} items"));
                }
            }
            "anyOf" => {
                let any = expected.as_array().unwrap().iter().any(|s| {
                    let mut of = Vec::new();
                    faults(value, s, whole, at, &mut of);
                    of.is_empty()
                });
                if !any {
                    out.push(format!("{at}: {value} fits none of {expected}"));
                }
            }
            "oneOf" => {
                let fits = |s: &&Value| {
                    let mut of = Vec::new();
                    faults(value, s, whole, at, &mut of);
                    of.is_empty()
                };
                let n = expected.as_array().unwrap().iter().filter(fits).count();
                if n != 1 {
                    out.push(format!("{at}: {value} fits {n} of {expected}"));
                }
            }
            "const" | "enum" | "minimum" | "maximum" | "$schema" | "$defs" | "title" | "description" | "default"
            | "format" => {}
            other => panic!("keyword {other}"),
        }
    }
}

/// 1 and 1.0 are one number.
fn same(a: &Value, b: &Value) -> bool {
    a == b || a.as_f64().is_some() && a.as_f64() == b.as_f64()
}

fn of(name: &str, value: &Value) -> Vec<String> {
    let schema = schemas::of(name).unwrap();
    let mut out = Vec::new();
    faults(value, &schema, &schema, name, &mut out);
    out
}

/// Every YAML file below a folder, with the short name of its document.
fn documents(folder: &Path, out: &mut Vec<(PathBuf, String, Value)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            documents(&path, out);
        } else if path.extension().is_some_and(|e| e == "yaml") {
            let text = std::fs::read_to_string(&path).unwrap();
            // trajectories of ROS are several documents, and none of ours
            if !text.contains("schema: lostmotion/") {
                continue;
            }
            let value: Value = serde_yaml::from_str(&text).unwrap();
            let schema = value["schema"].as_str().unwrap_or_default().to_string();
            let name = schema.split('/').nth(1).unwrap_or_default().to_string();
            out.push((path, name, value));
        }
    }
}

#[test]
fn every_file_of_the_repository_fits_its_schema() {
    let mut all = Vec::new();
    for folder in ["configs", "samples", "src/log/maps", "tests/real", "tests/data"] {
        documents(&root().join(folder), &mut all);
    }
    let mut checked = std::collections::BTreeMap::new();
    for (path, name, value) in &all {
        if schemas::of(name).is_some() {
            let faults = of(name, value);
            assert!(faults.is_empty(), "{}: {faults:#?}", path.display());
            *checked.entry(name.as_str()).or_insert(0) += 1;
        }
    }
    for (name, least) in [("robot", 45), ("model", 3), ("columns", 8), ("compensator", 1)] {
        assert!(checked.get(name).copied().unwrap_or(0) >= least, "{checked:?}");
    }
}

#[test]
fn what_the_program_refuses_the_schema_refuses_too() {
    let text = std::fs::read_to_string(bundled("configs/kuka-kr16-2.yaml")).unwrap();
    for (from, to) in [
        ("alpha_deg", "alpha"),
        ("kind: revolute", "kind: rotary"),
        ("convention: dh-standard", "convention: dh"),
        ("joints:", "joint:"),
        ("d_mm: 0", "d_mm: none"),
    ] {
        let broken = text.replacen(from, to, 1);
        assert_ne!(broken, text, "{from}");
        assert!(lostmotion::robot::Robot::parse("robot.yaml", &broken).is_err(), "{to}");
        let value: Value = serde_yaml::from_str(&broken).unwrap();
        assert!(!of("robot", &value).is_empty(), "{to}");
    }
}

#[test]
#[ignore = "takes long: .ci/run runs it"]
fn what_the_commands_write_fits_its_schema() {
    let work = WorkFolder::new();
    let run = |args: &[&str]| {
        let out = support::process().current_dir(root()).args(args).output().unwrap();
        assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
        out.stdout
    };
    let path = |name: &str| work.join(name).to_str().unwrap().to_string();
    let robot = "configs/kuka-kr120-r2500-pro.yaml";
    let (gaps, compensator, log) = (path("gaps.yaml"), path("compensator.yaml"), path("log.csv"));
    let stdout = run(&[
        "identify",
        "static",
        "--robot",
        robot,
        "--log",
        "samples/static/single_axis_A1.csv.gz",
        "--output",
        &gaps,
        "--json",
    ]);
    assert!(of("gaps", &serde_json::from_slice(&stdout).unwrap()).is_empty());
    run(&["fit", "--robot", robot, "--gaps", &gaps, "--output", &compensator]);
    let urdf = path("scara.yaml");
    // the line for editors stands where the schema lies beside the file
    run(&["schema", "robot", "--output", &path("robot.schema.json")]);
    run(&["robot", "init", "--urdf", "samples/robots/scara.urdf", "--output", &urdf]);
    assert!(std::fs::read_to_string(&urdf).unwrap().starts_with("# yaml-language-server: $schema="));
    for (name, file) in [("gaps", &gaps), ("compensator", &compensator), ("robot", &urdf)] {
        let value: Value = serde_yaml::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
        assert_eq!(of(name, &value), Vec::<String>::new(), "{file}");
    }
    let joined = run(&[
        "join",
        "--robot",
        robot,
        "--controller",
        "samples/join/controller_2.csv.gz",
        "--tracker",
        "samples/join/tracker_2.csv.gz",
        "--output",
        &log,
        "--json",
    ]);
    assert_eq!(of("join", &serde_json::from_slice(&joined).unwrap()), Vec::<String>::new());
    let printed: Value = serde_json::from_slice(&run(&["schema", "robot"])).unwrap();
    assert_eq!(Some(printed), schemas::of("robot"));
}

#[test]
fn documents_of_results_fit_their_schemas() {
    let work = WorkFolder::new();
    // an answer that is no (exit code 1) has a document, too
    let run = |line: &str| {
        let line = line.replace("{}", work.path().to_str().unwrap());
        let out = support::process().current_dir(root()).args(line.split_whitespace()).output().unwrap();
        assert!(out.status.code().is_some_and(|c| c < 2), "{line}: {}", String::from_utf8_lossy(&out.stderr));
        out.stdout
    };
    let fits = |name: &str, bytes: &[u8]| {
        let value: Value = serde_yaml::from_slice(bytes).unwrap();
        assert_eq!(value["schema"], schemas::of(name).unwrap()["title"], "{name}");
        assert_eq!(of(name, &value), Vec::<String>::new());
    };
    let file = |name: &str| std::fs::read(work.join(name)).unwrap();
    let (kuka, model) = ("configs/kuka-kr120-r2500-pro.yaml", "samples/models/kuka-figure5.model.yaml");
    let (program, circle) = ("samples/circle/circle_program.csv", "samples/circle/circle_uncompensated_figure5.csv.gz");
    let (arm, excitation) = ("configs/micro-iges-4dof.yaml", "samples/instrument/excitation_compensated.log.csv.gz");
    for (name, line) in [
        ("rewrite", format!("rewrite --model {model} {program} --speed-mm-s 1.5 --output {{}}/out.csv --json")),
        (
            "rewrite",
            format!(
                "rewrite --model {model} samples/programs/krl/folds.src --speed-mm-s 20 --output {{}}/folds.src --json"
            ),
        ),
        (
            "program-assessment",
            format!("assess program --model {model} --before {program} --after {{}}/out.csv --json"),
        ),
        ("circle", format!("assess circle --robot {kuka} --nominal {program} --before {circle} --json")),
        ("bidirectional", "assess bidirectional --readings samples/bidirectional/irb1600_y.csv --json".into()),
        (
            "learning",
            format!(
                "learn --robot {arm} --log {excitation} --commands samples/instrument/excitation.csv.gz --hidden 3 --coordinates xy --output {{}}/k.yaml --json"
            ),
        ),
        (
            "tracking",
            format!(
                "track --robot {arm} --kinematics {{}}/k.yaml --path samples/instrument/ellipse_12x20.csv --tolerance-mm 5 --output {{}}/t.csv --json"
            ),
        ),
        (
            "plan",
            format!("plan-experiment --model {model} --between backlash:A2,hysteresis:A2 --output {{}}/p.csv --json"),
        ),
        ("diagnosis", format!("diagnose --robot {kuka} --log samples/static/single_axis_A1.csv.gz --json")),
    ] {
        fits(name, &run(&line));
    }
    fits("rewritten", &file("out.csv.lostmotion.json"));
    fits("kinematics", &file("k.yaml"));
    fits("frames", &run(&format!("rewrite --model {model} samples/programs/krl/folds.src --list-frames")));
}

#[test]
fn show_draws_every_kind_of_file() {
    let work = WorkFolder::new();
    let robot = "configs/kuka-kr120-r2500-pro.yaml";
    for (k, (file, needs, holds)) in [
        (robot, false, "The arm at zero"),
        ("samples/models/kuka-table3.model.yaml", false, "Effects of the model"),
        ("samples/circle/circle_program.csv", true, "Path of the TCP"),
        ("samples/static/single_axis_A1.csv.gz", true, "measured"),
    ]
    .into_iter()
    .enumerate()
    {
        let out = work.join(format!("{k}.html"));
        let mut args = vec!["show", file, "--output", out.to_str().unwrap()];
        if needs {
            args.extend(["--robot", robot]);
        }
        let done = support::process().current_dir(root()).args(&args).output().unwrap();
        assert!(done.status.success(), "{file}: {}", String::from_utf8_lossy(&done.stderr));
        let page = std::fs::read_to_string(&out).unwrap();
        assert!(page.contains(holds) && page.contains("<svg"), "{file}");
        assert!(!page.contains(work.path().to_str().unwrap()) && !page.contains("NaN"), "{file}");
    }
    let done = support::process()
        .current_dir(root())
        .args(["show", "samples/circle/circle_program.csv", "--output", "-"])
        .output()
        .unwrap();
    assert_eq!(done.status.code(), Some(2));
    assert!(String::from_utf8_lossy(&done.stderr).contains("--robot"));
}

#[test]
fn show_reads_documents_from_standard_input() {
    let robot = "configs/kuka-kr120-r2500-pro.yaml";
    let work = WorkFolder::new();
    let gaps = work.join("gaps.yaml");
    let run = |args: &[&str], input: Option<&Path>| {
        let mut command = support::process();
        if let Some(file) = input {
            command.stdin(std::fs::File::open(file).unwrap());
        }
        let out = command.current_dir(root()).args(args).output().unwrap();
        assert!(out.status.success(), "{args:?}: {}", String::from_utf8_lossy(&out.stderr));
        out.stdout
    };
    let log = "samples/static/single_axis_A1.csv.gz";
    run(&["identify", "static", "--robot", robot, "--log", log, "-o", gaps.to_str().unwrap()], None);
    // the model names its robot inline, as standard input lies in no folder
    let model = work.join("model.yaml");
    let path = root().join(robot);
    std::fs::write(&model, format!("schema: lostmotion/model/1\nrobot: {}\neffects: []\n", path.display())).unwrap();
    for (file, needs) in [(root().join(robot), false), (model, false), (gaps, true)] {
        let more: &[&str] = if needs { &["--robot", robot] } else { &[] };
        let piped = run(&[&["show", "-", "-o", "-"], more].concat(), Some(&file));
        assert!(String::from_utf8_lossy(&piped).contains("<svg"), "{}", file.display());
    }
}

#[test]
fn every_schema_is_written_at_once_and_files_beside_them_name_theirs() {
    let work = WorkFolder::new();
    let run = |line: &str| {
        let out = support::run_from_root(work.path(), line);
        assert!(out.succeeded(), "{line}: {}", out.stderr);
    };
    run("schema --output-dir {}");
    for (name, _) in schemas::NAMES {
        let text = std::fs::read_to_string(work.join(format!("{name}.schema.json"))).unwrap();
        assert_eq!(serde_json::from_str::<Value>(&text).ok(), schemas::of(name), "{name}");
    }
    let robot = "configs/kuka-kr120-r2500-pro.yaml";
    run(&format!("identify static --robot {robot} --log samples/static/single_axis_A1.csv.gz --output {{}}/gaps.yaml"));
    run(&format!("fit --robot {robot} --gaps {{}}/gaps.yaml --output {{}}/compensator.yaml"));
    run(&format!("columns samples/join/tracker_2.csv.gz --robot {robot} --output {{}}/columns.yaml"));
    for name in ["gaps", "compensator", "columns"] {
        let text = std::fs::read_to_string(work.join(format!("{name}.yaml"))).unwrap();
        assert!(text.starts_with(&format!("# yaml-language-server: $schema={name}.schema.json\n")), "{name}: {text}");
    }
    // an editor complains of a schema that it does not find
    std::fs::remove_file(work.join("gaps.schema.json")).unwrap();
    run(&format!("identify static --robot {robot} --log samples/static/single_axis_A1.csv.gz --output {{}}/gaps.yaml"));
    assert!(!std::fs::read_to_string(work.join("gaps.yaml")).unwrap().contains("$schema"));
}
