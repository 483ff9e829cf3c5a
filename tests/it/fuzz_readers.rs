//! Readers of documents, logs and recordings on mutated samples: an input is read or refused, and no reader panics. With the stable
//! compiler and a fixed seed; `fuzz/` has the same targets for cargo-fuzz, and `crates/robot-programs/tests/fuzz.rs` the languages.

use crate::support::bundled;
use lostmotion::assess::bidirectional::readings::Readings;
use lostmotion::compensator::Compensator;
use lostmotion::gaps::Gaps;
use lostmotion::io::bag::{self, TopicChoice};
use lostmotion::io::input::{Input, from_bytes};
use lostmotion::io::journal::Journal;
use lostmotion::io::name::{path_of, text_of};
use lostmotion::io::workbook;
use lostmotion::learn::network::Network;
use lostmotion::learn::{Evidence, Input as Range, Kind, Learned};
use lostmotion::log::{ColumnMap, Log};
use lostmotion::model::Model;
use lostmotion::plan::question::of_diagnosis;
use lostmotion::plan::sizes::Scale;
use lostmotion::rewrite::guard::{Note, note_text, parse_note};
use lostmotion::rewrite::{manifest, original};
use lostmotion::robot::Robot;
use lostmotion::robot::frames::Frames;
use lostmotion::robot::urdf;
use lostmotion::track::path::Path as TrackPath;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Pieces that readers stumble over.
const WORDS: [&[u8]; 24] = [
    b"\"",
    b"\r\n",
    b"\n\n",
    b",",
    b";",
    b":",
    b"- ",
    b"1e999",
    b"nan",
    b"-0.0",
    b"99999999999999999999",
    b"\0",
    b"\xff\xfe",
    b"\xc3\x28",
    b"{",
    b"}",
    b"[",
    b"]]",
    b"&a *a",
    b"<",
    b"/>",
    b"#",
    b"../",
    b"\t",
];

pub fn mutated(seeds: &[Vec<u8>], random: &mut ChaCha8Rng) -> Vec<u8> {
    let mut bytes = seeds[random.random_range(0..seeds.len())].clone();
    for _ in 0..=random.random_range(0..4) {
        let (a, b) = (random.random_range(0..=bytes.len()), random.random_range(0..=bytes.len()));
        let (a, b) = (a.min(b), a.max(b).min(a.min(b) + 200));
        match random.random_range(0..6) {
            0 if a < bytes.len() => bytes[a] = random.random(),
            1 => drop(bytes.drain(a..b)),
            2 => {
                let piece = bytes[a..b].to_vec();
                bytes.splice(b..b, piece);
            }
            3 | 4 => drop(bytes.splice(a..a, WORDS[random.random_range(0..WORDS.len())].iter().copied())),
            _ => bytes.truncate(bytes.len() - random.random_range(0..=bytes.len() / 4)),
        }
    }
    bytes
}

fn file(path: &str) -> Vec<u8> {
    std::fs::read(bundled(path)).unwrap_or_else(|e| panic!("{path}: {e}"))
}

/// The head of a CSV in a gzip file: mutations should meet its header, not a thousandth row.
fn head_of_gz(path: &str, lines: usize) -> Vec<u8> {
    let input = from_bytes(path.into(), file(path)).unwrap();
    let text = String::from_utf8(input.bytes).unwrap();
    text.lines().take(lines).flat_map(|l| [l, "\n"]).collect::<String>().into_bytes()
}

fn robot() -> Robot {
    Robot::load(&bundled("configs/kuka-kr120-r2500-pro.yaml")).unwrap()
}

fn input(name: &str, bytes: &[u8]) -> Input {
    Input { name: name.into(), bytes: bytes.to_vec(), sha256: String::new() }
}

/// Runs `read` on mutated seeds and says how many were taken; every seed itself must be taken.
fn run(what: &str, runs: usize, seeds: &[Vec<u8>], read: &dyn Fn(&[u8]) -> bool) {
    for (k, seed) in seeds.iter().enumerate() {
        assert!(read(seed), "{what}: seed {k} is refused");
    }
    let mut random = ChaCha8Rng::seed_from_u64(0x9e37_79b9);
    let taken = (0..runs).filter(|_| read(&mutated(seeds, &mut random))).count();
    println!("{what}: {runs} inputs, {taken} of them taken");
}

fn text(bytes: &[u8], read: impl FnOnce(&str) -> bool) -> bool {
    std::str::from_utf8(bytes).is_ok_and(read)
}

fn documents(runs: usize) {
    run(
        "robot file",
        runs,
        &[file("configs/kuka-kr120-r2500-pro.yaml"), file("configs/gantry-xyz-ballscrew.yaml")],
        &|b| text(b, |t| Robot::parse("robot.yaml", t).is_ok()),
    );
    run("URDF", runs, &[file("samples/robots/scara.urdf")], &|b| text(b, |t| urdf::read("arm.urdf", t, None).is_ok()));
    run("model", runs, &[file("samples/models/kuka-table3.model.yaml")], &|b| {
        text(b, |t| Model::parse("model.yaml", t, &|_| Ok(robot())).is_ok())
    });
    let maps = ["rsi", "rtde", "rws", "tracker"].map(|m| file(&format!("src/log/maps/{m}.yaml")));
    run("column map", runs, &maps, &|b| text(b, |t| ColumnMap::parse("map.yaml", t).is_ok()));
    let frames: [&[u8]; 2] = [
        b"schema: lostmotion/frames/1\nframes:\n  wobj1: {xyz_mm: [1, 2, 3], rpy_deg: [0, 0, 90]}\ntools:\n  tool1: {xyz_mm: [0, 0, 100], rpy_deg: [0, 0, 0]}\n",
        b"DEFDAT  $CONFIG\nBASE_DATA[1]={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 90.0}\nTOOL_DATA[2]={X 0.0,Y 0.0,Z 100.0,A 0.0,B 0.0,C 0.0}\nENDDAT\n",
    ];
    run("frames", runs, &frames.map(<[u8]>::to_vec), &|b| text(b, |t| Frames::parse("frames.yaml", t).is_ok()));
    run("manifest", runs, &[manifest_seed()], &|b| {
        manifest::parse("manifest.jsonl", b, &|_| true)
            .inspect(|entries| {
                assert!(entries.iter().all(|e| manifest::below(&e.key).is_some()), "a path out of the folder")
            })
            .is_ok()
    });
    let instrument = Robot::load(&bundled("configs/micro-iges-4dof.yaml")).unwrap();
    run("compensator", runs, &[file("samples/instrument/compensator.yaml")], &|b| {
        text(b, |t| Compensator::parse("c.yaml", t, &instrument).is_ok())
    });
    let (kuka, gaps) = (robot(), gaps_seed());
    run("gaps", runs, &[gaps.into_bytes()], &|b| text(b, |t| Gaps::parse("gaps.yaml", t, &kuka).is_ok()));
}

fn gaps_seed() -> String {
    format!(
        "schema: lostmotion/gaps/1\nrobot: {{name: K, sha256: {}}}\nlogs: [{{name: circle.csv, sha256: aa}}]\ntcp_speed_mm_s: 1.5\npoints:\n  \
         - {{joint: A2, at_deg: -100, half_gap_deg: 0.0035, ci95: [0.0034, 0.0036], cycles: 4}}\njoints:\n  \
         - {{joint: A1, half_gap_deg: 0.0028, ci95: [0.0027, 0.0029], stiction: {{spike_deg: 0.0034, ci95: [0.003, 0.0038], decay_s: 5.2}}}}\n  \
         - {{joint: A2, half_gap_deg: 0.002, schedule: {{kind: pchip, knots: [[-100, 0.0035], [0, 0.0001]]}}}}\n",
        robot().fingerprint()
    )
}

/// Notes beside rewritten programs, and names of files: what `undo` and a resumed batch rely on.
fn notes_and_names(runs: usize) {
    let sha = "0123456789abcdef".repeat(4);
    let note = Note {
        schema: "lostmotion/rewritten/1".into(),
        sha256_in: Some(sha.clone()),
        sha256_out: sha,
        original: original::pack(b"DEF p()\nPTP {A1 0}\nEND\n"),
        ..Note::default()
    };
    let checked = note_text(&note).unwrap();
    let old = checked.split(",\n  \"check\"").next().unwrap().to_string() + "\n}\n";
    run("note", runs, &[checked.into_bytes(), old.into_bytes()], &|b| {
        parse_note(b)
            .inspect(|n| {
                assert_eq!(n.sha256_out.len(), 64);
                drop(n.original.as_deref().map(|packed| original::unpack("note", packed)));
            })
            .is_some()
    });
    #[cfg(unix)]
    run("name", runs, &[b"cell/a b.src".to_vec(), b"a%25\xff\x1b[31m.ls".to_vec()], &|b| {
        use std::os::unix::ffi::OsStrExt;
        let path = Path::new(std::ffi::OsStr::from_bytes(b));
        let text = text_of(path);
        assert!(!text.chars().any(robot_programs::error::is_obeyed), "a name that commands a terminal");
        path_of(&text).as_deref() == Some(path)
    });
}

/// A manifest of the sample programs, as the command writes it.
fn manifest_seed() -> Vec<u8> {
    let entries = manifest::of_folder(&bundled("samples/programs/krl"), None).unwrap();
    manifest::text(&entries).into_bytes()
}

/// What one command leaves for another: learned kinematics, a diagnosis, a summary of a shard, the journal of an interrupted run.
fn results(runs: usize) {
    let instrument = Robot::load(&bundled("configs/micro-iges-4dof.yaml")).unwrap();
    run("learned kinematics", runs, &[learned_seed(&instrument)], &|b| {
        text(b, |t| {
            let read = Learned::parse("k.yaml", t, &instrument);
            read.inspect(|k| assert_eq!(k.position_m(&[0.0; 4]).len(), k.coordinates.len())).is_ok()
        })
    });
    let diagnosis = br#"{"schema": "lostmotion/diagnosis/1", "verdict": "named_set",
        "rounds": [{"effect": "backlash", "target": "A3", "set": [{"effect": "backlash", "target": "A3"}, {"effect": "hysteresis", "target": "A3"}]}],
        "effects": [{"effect": "backlash", "target": "A3", "joint": "A3", "half_gap_deg": 0.0041}]}"#;
    let (kuka, window) = (robot(), [[-1.0, 1.0]; 6]);
    run("diagnosis", runs, &[diagnosis.to_vec()], &|b| {
        let mut scale =
            Scale { robot: &kuka, window: &window, speed_m_s: 0.25, duration_s: 60.0, lost: vec![None; kuka.dof()] };
        text(b, |t| of_diagnosis("diagnosis.json", t, &mut scale).is_ok())
    });
    let entries = manifest::of_folder(&bundled("samples/programs/krl"), None).unwrap();
    let line = |e: &manifest::Entry| format!("{{\"key\":\"{}\",\"status\":\"written\"}}\n", e.key);
    let summary: String = entries.iter().map(line).collect();
    run("summary", runs, &[summary.into_bytes()], &|b| {
        let merged = manifest::Merged::parse(&entries, "summary.jsonl", b);
        merged.inspect(|m| assert_eq!(m.lines.len(), entries.len())).is_ok()
    });
    let journal = br#"{"schema": "lostmotion/journal/1", "back": false, "files":
        [{"target": "out.src", "new": ".lostmotion-1.part", "bytes": 12, "old": ".lostmotion-1.old"}, {"target": "out.dat", "new": null, "old": null}]}"#;
    run("journal", runs, &[journal.to_vec()], &|b| {
        let names = |j: &Journal| {
            let all = j.files().iter().flat_map(|f| [Some(&f.target), f.new.as_ref(), f.old.as_ref()]);
            all.flatten().all(|n| !n.contains('/') && n != "..")
        };
        Journal::parse(b).inspect(|j| assert!(names(j), "a file out of the folder")).is_some()
    });
}

fn learned_seed(robot: &Robot) -> Vec<u8> {
    let network = Network::random(robot.dof(), 2, 0.0, 0.01, &mut ChaCha8Rng::seed_from_u64(1));
    let learned = Learned {
        robot_name: robot.name.clone(),
        robot_sha256: robot.fingerprint(),
        kind: Kind::Plain,
        coordinates: vec![0],
        inputs: vec![Range { centre: 0.1, half_range: 0.2 }; robot.dof()],
        networks: vec![network],
        evidence: Evidence::default(),
        file: None,
    };
    learned.to_yaml(robot).unwrap().into_bytes()
}

fn tables(runs: usize) {
    let kuka = robot();
    let log = head_of_gz("samples/static/single_axis_A1.csv.gz", 60);
    run("log", runs, &[log], &|b| from_bytes("log.csv".into(), b.to_vec()).is_ok_and(|i| Log::parse(i, &kuka).is_ok()));
    run("readings", runs, &[file("samples/bidirectional/irb1600_y.csv")], &|b| {
        from_bytes("readings.csv".into(), b.to_vec()).is_ok_and(|i| Readings::parse(i, None, None).is_ok())
    });
    let path: &[u8] = b"t_s,x_mm,y_mm,z_mm\n0,1,2,3\n0.5,1.5,2,3\n1,2,2.5,3\n";
    run("path", runs, &[path.to_vec()], &|b| {
        from_bytes("path.csv".into(), b.to_vec())
            .and_then(TrackPath::parse)
            .inspect(|p| assert!(p.points_m.iter().flatten().all(|v| v.is_finite()), "a number that is none"))
            .is_ok()
    });
}

fn containers(runs: usize) {
    run("recording", runs, &[file("tests/data/ros2.mcap")], &|b| {
        let wanted = [TopicChoice::Places, TopicChoice::Any, TopicChoice::Topic("/joint_states")];
        wanted.into_iter().for_each(|wanted| drop(bag::unpacked(input("r.mcap", b), wanted)));
        bag::unpacked(input("r.mcap", b), TopicChoice::Joints).is_ok()
    });
    for name in ["log.xlsx", "log.ods"] {
        run(name, runs, &[file(&format!("tests/data/workbook/{name}"))], &|b| {
            workbook::unpacked(input(name, b)).is_ok()
        });
    }
}

#[test]
fn readers_of_documents_never_panic() {
    documents(200);
}

#[test]
fn notes_are_whole_or_refused_and_names_come_back() {
    notes_and_names(2_000);
}

#[test]
fn readers_of_results_of_other_commands_never_panic() {
    results(200);
}

#[test]
fn readers_of_tables_never_panic() {
    tables(200);
}

#[test]
fn readers_of_recordings_and_workbooks_never_panic() {
    containers(60);
}

/// `LOSTMOTION_FUZZ_RUNS=1000000 cargo test --release --test it fuzz_readers -- --ignored --nocapture`
#[test]
#[ignore = "takes as long as LOSTMOTION_FUZZ_RUNS asks for"]
fn many_more_inputs_of_every_reader() {
    let runs = std::env::var("LOSTMOTION_FUZZ_RUNS").ok().and_then(|v| v.parse().ok()).unwrap_or(20_000);
    documents(runs);
    notes_and_names(runs);
    results(runs);
    tables(runs);
    containers(runs / 10);
}
