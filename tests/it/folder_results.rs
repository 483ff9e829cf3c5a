//! The folder of results: what a run replaces there, and what stays.

use crate::support::{WorkFolder, bundled};

pub const RUN: &str = "rewrite --model model.yaml cell --output-dir done --summary s.jsonl";

/// A folder with a program that is rewritten (`turns.csv`), one that needs no change (`plain.csv`), and a pair of KRL files.
pub fn desk() -> WorkFolder {
    let desk = WorkFolder::new();
    std::fs::copy(bundled("configs/kuka-kr120-r2500-pro.yaml"), desk.join("robot.yaml")).unwrap();
    std::fs::create_dir_all(desk.join("cell")).unwrap();
    model(&desk, 0.0125);
    let rows = |a1: &[f64]| a1.iter().map(|a| format!("{a:.4},-90.0,90.0,0.0,30.0,0.0\n")).collect::<String>();
    let head = "a1_deg,a2_deg,a3_deg,a4_deg,a5_deg,a6_deg\n";
    std::fs::write(desk.join("cell/turns.csv"), format!("{head}{}", rows(&[0.0, 20.0, 5.0, 20.0]))).unwrap();
    std::fs::write(desk.join("cell/plain.csv"), format!("{head}{}", rows(&[1.0, 1.0]))).unwrap();
    let target = |a1: &str| format!("A1 {a1},A2 -90.0000,A3 90.0000,A4 0.0000,A5 30.0000,A6 0.0000");
    let source = format!("DEF pair( )\nPTP {{{}}}\nPTP XP1\nPTP {{{}}}\nEND\n", target("0.0000"), target("3.0000"));
    std::fs::write(desk.join("cell/pair.src"), source).unwrap();
    let data = format!("DEFDAT pair\nDECL E6AXIS XP1={{{}}}\nENDDAT\n", target("20.0000"));
    std::fs::write(desk.join("cell/pair.dat"), data).unwrap();
    desk
}

pub fn model(desk: &WorkFolder, half_gap_deg: f64) {
    let effect = format!("{{effect: backlash, joint: A1, half_gap_deg: {half_gap_deg}}}");
    let text = format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect}\n");
    std::fs::write(desk.join("model.yaml"), text).unwrap();
}

#[test]
fn a_program_in_the_output_folder_that_is_no_result_or_was_edited_is_not_replaced() {
    let desk = desk();
    let read = |name: &str| std::fs::read_to_string(desk.join(name)).unwrap();
    std::fs::create_dir(desk.join("done")).unwrap();
    // somebody else's, and a copy of the original
    let foreign = read("cell/turns.csv").replace("20.0", "21.0");
    std::fs::write(desk.join("done/turns.csv"), &foreign).unwrap();
    std::fs::write(desk.join("done/plain.csv"), read("cell/plain.csv")).unwrap();
    let out = desk.run(RUN).ends_with(1);
    let told = "done/turns.csv: no note shows that it is a result of `rewrite`; nothing was written (remove the file, or allow its replacement) (--replace replaces it)";
    assert!(out.stderr.contains(told), "{}", out.stderr);
    assert!(out.stderr.contains("3 programs: 1 written, 1 unchanged, 1 refused, 0 failed"), "{}", out.stderr);
    assert_eq!(read("done/turns.csv"), foreign);
    assert!(!desk.join("done/turns.csv.lostmotion.json").exists());
    let line: serde_json::Value = serde_json::from_str(read("s.jsonl").lines().last().unwrap()).unwrap();
    assert!(line["status"] == "refused" && line["output"].is_null() && line["sha256_out"].is_null(), "{line}");
    desk.run(&format!("{RUN} --replace")).success();
    assert_ne!(read("done/turns.csv"), foreign);
    // results of ours are replaced, a file that was edited is not: neither a program nor its data list
    model(&desk, 0.0128);
    desk.run(RUN).success();
    for name in ["turns.csv", "pair.src", "pair.dat"] {
        let path = format!("done/{name}");
        let result = read(&path);
        let edited = result.replacen("-90.0", "-89.0", 1);
        std::fs::write(desk.join(&path), &edited).unwrap();
        model(&desk, 0.0125);
        let out = desk.run(RUN).ends_with(1);
        assert!(out.stderr.contains(&format!("{path}: changed since `rewrite` wrote it")), "{}", out.stderr);
        assert_eq!(read(&path), edited);
        std::fs::write(desk.join(&path), result).unwrap();
        model(&desk, 0.0128);
        desk.run(RUN).success();
    }
}

#[test]
fn a_result_that_a_loss_of_power_emptied_is_written_again() {
    let desk = desk();
    desk.run(RUN).success();
    let path = desk.join("done/turns.csv");
    let note = desk.join("done/turns.csv.lostmotion.json");
    let (whole, whole_note) = (std::fs::read(&path).unwrap(), std::fs::read(&note).unwrap());
    let half = [&whole[..whole.len() / 2], &[0; 100]].concat();
    for (program, of_note) in [
        (vec![], whole_note.clone()),
        (vec![0; whole.len()], whole_note.clone()),
        (half, whole_note.clone()),
        (whole[..whole.len() / 2].to_vec(), whole_note.clone()),
        (whole.clone(), vec![]),
        (vec![0; 9], vec![0; 9]),
    ] {
        std::fs::write(&path, program).unwrap();
        std::fs::write(&note, of_note).unwrap();
        desk.run(RUN).success();
        assert_eq!((std::fs::read(&path).unwrap(), std::fs::read(&note).unwrap()), (whole.clone(), whole_note.clone()));
    }
}

#[test]
fn a_result_whose_last_lines_were_taken_away_was_edited_and_one_that_ends_within_a_line_was_cut() {
    let desk = desk();
    desk.run(RUN).success();
    for (path, lines) in [("done/turns.csv", 3), ("done/pair.src", 2), ("done/pair.dat", 2)] {
        let whole = std::fs::read_to_string(desk.join(path)).unwrap();
        let edited: String = whole.split_inclusive('\n').take(lines).collect();
        for edited in [edited.as_str(), edited.trim_end()] {
            std::fs::write(desk.join(path), edited).unwrap();
            let out = desk.run(RUN).ends_with(1);
            assert!(out.stderr.contains(&format!("{path}: changed since `rewrite` wrote it")), "{}", out.stderr);
            assert_eq!(std::fs::read_to_string(desk.join(path)).unwrap(), edited);
        }
        std::fs::write(desk.join(path), &edited[..edited.len() - 3]).unwrap();
        desk.run(RUN).success();
        assert_eq!(std::fs::read_to_string(desk.join(path)).unwrap(), whole);
    }
}

#[test]
fn an_untouched_copy_of_a_program_is_replaced_once_its_original_changes_and_an_edited_one_is_not() {
    let desk = desk();
    let read = |name: &str| std::fs::read_to_string(desk.join(name)).unwrap();
    let edit =
        |name: &str, from: &str, to: &str| std::fs::write(desk.join(name), read(name).replace(from, to)).unwrap();
    desk.run(RUN).success();
    let (first, noted) = (read("s.jsonl"), read("done/plain.csv.lostmotion.json"));
    assert!(!noted.contains("\"original\""), "{noted}");
    // finished: it is not done again
    std::fs::write(desk.join("done/plain.csv.lostmotion.json"), format!("{noted}\n")).unwrap();
    desk.run(RUN).success();
    assert_eq!((read("s.jsonl"), read("done/plain.csv.lostmotion.json")), (first, format!("{noted}\n")));
    edit("cell/plain.csv", "1.0000", "2.0000");
    desk.run(RUN).success();
    assert_eq!(read("done/plain.csv"), read("cell/plain.csv"));
    // a copy is no rewritten program, and its original is itself
    desk.run("rewrite --model model.yaml done/plain.csv --output other.csv").success();
    desk.run("undo done/plain.csv --output back.csv").success();
    assert_eq!(read("back.csv"), read("cell/plain.csv"));
    desk.run("rewrite --model model.yaml done --output-dir done --force").ends_with(1);
    desk.run("undo done/plain.csv --in-place").success();
    assert!(read("done/plain.csv") == read("cell/plain.csv") && !desk.join("done/plain.csv.lostmotion.json").exists());
    desk.run(RUN).success();
    edit("done/plain.csv", "2.0000", "3.0000");
    edit("cell/plain.csv", "2.0000", "4.0000");
    let out = desk.run(RUN).ends_with(1);
    assert!(out.stderr.contains("done/plain.csv: changed since `rewrite` wrote it"), "{}", out.stderr);
    assert!(read("done/plain.csv").contains("3.0000"));
}

#[test]
fn a_pair_that_needed_no_change_is_written_once_it_needs_one() {
    let desk = desk();
    for keeps_note in [true, false] {
        model(&desk, 0.0);
        desk.run(&format!("{RUN} --replace")).success();
        assert_eq!(
            std::fs::read(desk.join("done/pair.dat")).unwrap(),
            std::fs::read(desk.join("cell/pair.dat")).unwrap()
        );
        if !keeps_note {
            std::fs::remove_file(desk.join("done/pair.src.lostmotion.json")).unwrap();
        }
        model(&desk, 0.0125);
        desk.run(RUN).success();
        assert_ne!(
            std::fs::read(desk.join("done/pair.dat")).unwrap(),
            std::fs::read(desk.join("cell/pair.dat")).unwrap()
        );
    }
}

#[test]
fn a_program_that_gains_a_column_replaces_its_earlier_result() {
    let desk = desk();
    let alone = "rewrite --model model.yaml cell/turns.csv --output one.csv";
    desk.run(RUN).success();
    desk.run(alone).success();
    let add = |name: &str, value: &str| {
        let text = std::fs::read_to_string(desk.join("cell/turns.csv")).unwrap();
        let line = |(k, line): (usize, &str)| format!("{line},{}\n", if k == 0 { name } else { value });
        std::fs::write(desk.join("cell/turns.csv"), text.lines().enumerate().map(line).collect::<String>()).unwrap();
    };
    for (name, value) in [("speed", "7"), ("note", "x")] {
        add(name, value);
        desk.run(RUN).success();
        desk.run(alone).success();
        assert_eq!(std::fs::read(desk.join("one.csv")).unwrap(), std::fs::read(desk.join("done/turns.csv")).unwrap());
    }
    // a table of somebody else is no result
    std::fs::remove_file(desk.join("one.csv.lostmotion.json")).unwrap();
    add("tool", "1");
    let out = desk.run(alone).ends_with(2);
    assert!(out.stderr.contains("a table with other columns than the one that would replace it"), "{}", out.stderr);
    std::fs::write(desk.join("one.csv.lostmotion.json"), "").unwrap();
}

#[test]
fn results_that_version_control_gave_other_line_ends_are_written_again_and_a_note_stays_readable() {
    let desk = desk();
    desk.run(RUN).success();
    let names = ["turns.csv", "plain.csv", "pair.src", "pair.dat"];
    let whole = names.map(|n| std::fs::read(desk.join("done").join(n)).unwrap());
    for entry in std::fs::read_dir(desk.join("done")).unwrap() {
        let path = entry.unwrap().path();
        let text = std::fs::read_to_string(&path).unwrap().replace('\n', "\r\n");
        std::fs::write(path, text).unwrap();
    }
    desk.run(RUN).success();
    assert_eq!(names.map(|n| std::fs::read(desk.join("done").join(n)).unwrap()), whole);
    let note = desk.join("done/turns.csv.lostmotion.json");
    let text = std::fs::read_to_string(&note).unwrap();
    std::fs::write(&note, text.replace('\n', "\r\n")).unwrap();
    desk.run("undo done/turns.csv --output back.csv").success();
    std::fs::write(&note, &text[..text.len() / 2]).unwrap();
    let out = desk.run("undo done/turns.csv --output other.csv").ends_with(2);
    assert!(out.stderr.contains("damaged") && !out.stderr.contains("--force"), "{}", out.stderr);
}

#[test]
fn only_what_its_own_note_shows_to_be_a_result_is_left_out_of_a_folder() {
    let desk = desk();
    let read = |name: &str| std::fs::read_to_string(desk.join(name)).unwrap();
    std::fs::create_dir_all(desk.join("cell/station3")).unwrap();
    std::fs::write(desk.join("cell/station3/other.csv"), read("cell/turns.csv").replace("20.0000", "30.0000")).unwrap();
    desk.run("rewrite --model model.yaml cell/turns.csv --output cell/station3/turns.csv").success();
    let out = desk.run(RUN).success();
    let told = "1 program in cell/station3 is a result of an earlier rewrite and is left out";
    assert!(out.stderr.contains(told), "{}", out.stderr);
    assert!(desk.join("done/station3/other.csv").exists() && !desk.join("done/station3/turns.csv").exists());
    desk.run("manifest cell --output m.jsonl").success();
    assert!(read("m.jsonl").contains("station3/other.csv") && !read("m.jsonl").contains("station3/turns.csv"));
    // a copy of an original beside a result, and a result that was edited, are programs
    std::fs::write(desk.join("cell/station3/plain.csv"), read("cell/plain.csv")).unwrap();
    std::fs::write(desk.join("cell/station3/turns.csv"), read("cell/turns.csv").replace("20.0000", "25.0000")).unwrap();
    let out = desk.run(RUN).success();
    assert!(!out.stderr.contains("left out"), "{}", out.stderr);
    assert!(desk.join("done/station3/plain.csv").exists() && desk.join("done/station3/turns.csv").exists());
}

#[test]
fn a_folder_of_results_is_left_out_also_where_an_original_has_changed_since() {
    let desk = desk();
    desk.run("rewrite --model model.yaml cell --output-dir cell/out").success();
    let changed = std::fs::read_to_string(desk.join("cell/turns.csv")).unwrap().replace("20.0000", "25.0000");
    std::fs::write(desk.join("cell/turns.csv"), changed).unwrap();
    let out = desk.run(RUN).success();
    assert!(out.stderr.contains("3 programs in cell/out are results of an earlier rewrite"), "{}", out.stderr);
    assert!(!desk.join("done/out").exists());
}

#[test]
fn a_result_of_another_program_under_the_name_of_one_is_not_taken_for_its_own() {
    let desk = desk();
    let read = |name: &str| std::fs::read(desk.join(name)).unwrap();
    std::fs::create_dir(desk.join("done")).unwrap();
    desk.run("rewrite --model model.yaml cell/turns.csv --output done/plain.csv").success();
    assert_ne!(read("done/plain.csv"), read("cell/plain.csv"));
    desk.run(RUN).success();
    assert_eq!(read("done/plain.csv"), read("cell/plain.csv"));
}

#[test]
fn the_folder_of_the_results_may_be_made_for_the_summary() {
    let desk = desk();
    let run = "rewrite --model model.yaml cell --output-dir new --summary new/s.jsonl --report new/r.html";
    desk.run(&format!("{run} --dry-run")).ends_with(2);
    desk.run(run).success();
    assert!(desk.join("new/s.jsonl").exists() && desk.join("new/r.html").exists());
    desk.run("schema --output-dir schemas/all").success();
    assert!(desk.join("schemas/all/robot.schema.json").exists());
}

/// The results are whole, so that this is no bad input: the counts are printed, and a run that follows goes on.
#[test]
#[cfg(target_os = "linux")]
fn a_summary_that_cannot_be_written_leaves_the_results_and_says_so() {
    let desk = desk();
    let out = desk.run("rewrite --model model.yaml cell --output-dir done --summary /dev/full").ends_with(4);
    assert!(out.stderr.contains("3 programs: 2 written, 1 unchanged, 0 refused, 0 failed"), "{}", out.stderr);
    assert!(out.stderr.contains("the results of 2 programs are in place"), "{}", out.stderr);
    assert!(desk.join("done/turns.csv").exists() && desk.join("done/turns.csv.lostmotion.json").exists());
    desk.run(RUN).success();
    // nothing was to be written: the same error is one of its own
    desk.run("rewrite --model model.yaml cell --dry-run --summary /dev/full").ends_with(2);
}
