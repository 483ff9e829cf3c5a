//! Programs, macros and routines that no file contains: asked for by name where moves wait for them, and declared to move nothing.

use crate::vendor_calls::{desk, fanuc_named as program, j1};
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

const REWRITE: &str = "rewrite --model model.yaml";

#[test]
fn a_call_that_moves_wait_for_is_named_once_and_can_be_declared() {
    let desk = desk("fanuc-m10ia.yaml", "J1");
    desk.write("p.ls", &program("P", &["  Clear User Page"]));
    let asked = contains("no file contains `CLEAR USER PAGE`, which may move the robot: 1 move waits for it")
        .and(contains("--no-motion \"CLEAR USER PAGE\"").count(1));
    desk.run(&format!("{REWRITE} p.ls --output left.ls --max-added 0")).success().stderr(asked);
    assert_eq!(j1(&desk, "left.ls"), [0.01, 10.01, 5.0, 8.01]);
    let json = desk.run(&format!("{REWRITE} p.ls --dry-run --json")).success();
    let document: serde_json::Value = serde_json::from_slice(&json.get_output().stdout).unwrap();
    assert_eq!(document["missing"]["calls"], serde_json::json!({"CLEAR USER PAGE": 1}));
    // by the option, which has a blank in its value
    let known = crate::support::command()
        .current_dir(desk.folder.path())
        .args("rewrite --model model.yaml p.ls --output known.ls --max-added 0 --no-motion".split(' '))
        .arg("clear  user page")
        .assert()
        .success();
    known.stderr(
        contains("CLEAR USER PAGE moves nothing and leaves frames and tools as they are, as declared")
            .and(contains("no file contains").not()),
    );
    assert_eq!(j1(&desk, "known.ls"), [0.01, 10.01, 4.99, 8.01]);
    let note = String::from_utf8(desk.read("known.ls.lostmotion.json")).unwrap();
    assert!(note.contains("no_motion clear  user page"), "{note}");
    // by the robot file
    let robot = String::from_utf8(desk.read("robot.yaml")).unwrap() + "no_motion: [Clear User Page]\n";
    desk.write("robot.yaml", &robot);
    desk.run(&format!("{REWRITE} p.ls --output by-file.ls --max-added 0")).success();
    assert_eq!(j1(&desk, "by-file.ls"), j1(&desk, "known.ls"));
    assert!(String::from_utf8(desk.read("by-file.ls.lostmotion.json")).unwrap().contains("no_motion Clear User Page"));
}

#[test]
fn a_folder_asks_once_for_all_its_programs_and_a_file_of_the_name_counts() {
    let desk = desk("fanuc-m10ia.yaml", "J1");
    desk.write("cell/A.LS", &program("A", &["  CALL GRIP_KL(1)"]));
    desk.write("cell/B.LS", &program("B", &["  CALL GRIP_KL(2)", "  CALL MOVER"]));
    desk.write("cell/MOVER.LS", &program("MOVER", &[]));
    let asked = contains("no file contains `GRIP_KL`, which may move the robot: 1 move waits for it").count(1);
    desk.run(&format!("{REWRITE} cell --output-dir out --max-added 0")).success().stderr(asked);
    desk.run(&format!("{REWRITE} cell --list-frames")).success().stdout(contains("#   GRIP_KL: 1 move waits for it"));
    desk.run(&format!("{REWRITE} cell --output-dir known --max-added 0 --no-motion GRIP_KL --no-motion mover"))
        .success();
    assert_eq!(j1(&desk, "known/A.LS"), [0.01, 10.01, 4.99, 8.01]);
    // the file of that name moves
    assert_eq!(j1(&desk, "known/B.LS"), [0.01, 10.01, 5.0, 8.01]);
    let said = desk.run(&format!("{REWRITE} cell/B.LS --dry-run --no-motion GRIP_KL --no-motion mover")).success();
    said.stderr(contains("MOVER is declared to move nothing (no_motion), but a file has this name"));
}

#[test]
fn a_declared_name_that_cannot_be_one_is_refused() {
    let desk = desk("fanuc-m10ia.yaml", "J1");
    desk.write("p.ls", &program("P", &[]));
    let run = desk.run(&format!("{REWRITE} p.ls --dry-run --no-motion LBL[1]")).code(2);
    run.stderr(contains("--no-motion `LBL[1]`"));
    let robot = String::from_utf8(desk.read("robot.yaml")).unwrap() + "no_motion: [\"\"]\n";
    desk.write("robot.yaml", &robot);
    desk.run(&format!("{REWRITE} p.ls --dry-run")).code(2).stderr(contains("robot.yaml:").and(contains("no_motion")));
}
