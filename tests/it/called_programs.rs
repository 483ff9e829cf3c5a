//! Programs that another program beside them calls: at their start the robot may stand anywhere.

use crate::support::bundled;
use crate::vendor_cycle::taught;
use crate::vendor_rewrite::Desk;

const AXES: &str = "[9E9,9E9,9E9,9E9,9E9,9E9]";

fn desk(robot: &str, joint: &str) -> Desk {
    let desk = Desk::new(0.0);
    std::fs::copy(bundled(&format!("configs/{robot}.yaml")), desk.path("robot.yaml")).unwrap();
    let model = format!(
        "schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {{effect: backlash, joint: {joint}, half_gap_deg: 0.05}}\n"
    );
    desk.write("model.yaml", &model);
    desk
}

/// A program with the first joint at these angles, deg, and a last instruction.
fn krl(name: &str, joint: [i32; 2], last: &str) -> String {
    let to = |a: i32| format!("PTP {{A1 {a},A2 -90,A3 90,A4 0,A5 30,A6 0}}\n");
    format!("DEF {name}()\n{}{}{last}\nEND\n", to(joint[0]), to(joint[1]))
}

fn rapid(name: &str, joint: [i32; 2], last: &str) -> String {
    let to = |a: i32| format!("MoveAbsJ [[{a},0,0,0,30,0],{AXES}],v100,fine,tool0;\n");
    format!("MODULE m{name}\nPROC {name}()\n{}{}{last};\nENDPROC\nENDMODULE\n", to(joint[0]), to(joint[1]))
}

fn inform(name: &str, joint: [i32; 2], last: &str) -> String {
    let points: String =
        (0..2).map(|n| format!("C0000{n}={}.0000,0.0000,0.0000,0.0000,-45.0000,0.0000\n", joint[n])).collect();
    format!(
        "/JOB\n//NAME {name}\n//POS\n///NPOS 2,0,0,0,0,0\n///TOOL 0\n///POSTYPE ANGLE\n///ANGLE\n{points}//INST\n\
         {INFORM_HEAD}MOVJ C00000 VJ=25.00\nMOVJ C00001 VJ=25.00\n{last}\nEND\n"
    )
}

const INFORM_HEAD: &str = "///DATE 2024/05/06 07:08\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\n";

fn fanuc(name: &str, joint: [i32; 2], last: &str) -> String {
    let taught: String = (0..2).map(|n| taught(n, joint[n])).collect();
    format!(
        "/PROG  {name}\n/ATTR\nLINE_COUNT\t= 3;\nDEFAULT_GROUP\t= 1,*,*,*,*;\n/MN\n   1:J P[1] 50% FINE ;\n   2:J P[2] 50% FINE ;\n   \
         3:  {last} ;\n/POS\n{taught}/END\n"
    )
}

/// Goes down from 80 to 20 deg, though its caller comes from below.
const DOWN: [i32; 2] = [80, 20];
const CALLER: [i32; 2] = [0, 10];

#[test]
fn the_first_target_of_a_program_that_another_one_calls_stays() {
    let kr = ("kuka-kr120-r2500-pro", "A1", "{A1 80,");
    let ar = ("motoman-ar2010", "S", "C00000=80.0000,");
    let m20 = ("fanuc-m20ia", "J1", "J1=    80.000 deg");
    let irb = ("abb-irb1600-6-145", "J1", "MoveAbsJ [[80,");
    for ((robot, joint, first), own, text, beside, caller, stays) in [
        (kr, "pick.src", krl("pick", DOWN, ""), "go.src", krl("go", CALLER, "pick()"), true),
        (kr, "pick.src", krl("pick", DOWN, ""), "go.src", krl("go", CALLER, "place()"), false),
        (kr, "pick.src", krl("pick", DOWN, ""), "go.src", krl("go", CALLER, ";pick()"), false),
        (ar, "PICK.JBI", inform("PICK", DOWN, ""), "GO.JBI", inform("GO", CALLER, "CALL JOB:PICK"), true),
        (ar, "PICK.JBI", inform("PICK", DOWN, ""), "GO.JBI", inform("GO", CALLER, "JUMP JOB:PICK IF IN#(1)=ON"), true),
        (ar, "PICK.JBI", inform("PICK", DOWN, ""), "GO.JBI", inform("GO", CALLER, "CALL JOB:PLACE"), false),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "CALL PICK"), true),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "RUN PICK"), true),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "IF DI[1]=ON,CALL PICK"), true),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "CALL PLACE"), false),
        (irb, "pick.mod", rapid("pick", DOWN, "WaitTime 1"), "go.mod", rapid("main", CALLER, "pick"), true),
        (irb, "pick.mod", rapid("pick", DOWN, "WaitTime 1"), "go.mod", rapid("go", CALLER, "pick"), true),
        (irb, "pick.mod", rapid("pick", DOWN, "WaitTime 1"), "go.mod", rapid("main", CALLER, "%\"pick\"%"), true),
        (irb, "pick.mod", rapid("pick", DOWN, "WaitTime 1"), "go.mod", rapid("go", CALLER, "%s1%"), true),
        (irb, "pick.mod", rapid("pick", DOWN, "WaitTime 1"), "go.mod", rapid("go", CALLER, "place;! pick"), false),
        (kr, "pick.src", krl("pick", DOWN, ""), "go.src", krl("go", CALLER, "EXT pick()"), false),
        (ar, "PICK.JBI", inform("PICK", DOWN, ""), "GO.JBI", inform("GO", CALLER, "'CALL JOB:PICK"), false),
        (ar, "PICK.JBI", inform("PICK", DOWN, ""), "GO.JBI", inform("GO", CALLER, "CALL JOB:S000"), true),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "!CALL PICK"), false),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "//CALL PICK"), false),
        (m20, "PICK.LS", fanuc("PICK", DOWN, "END"), "GO.LS", fanuc("GO", CALLER, "CALL SR[1]"), true),
    ] {
        let desk = desk(robot, joint);
        desk.write(&format!("in/{own}"), &text);
        let rewrite = |out: &str, more: &str| {
            let line = format!("rewrite --model model.yaml in/{own} --output {out} --force{more}");
            desk.run(&line).success();
            String::from_utf8(desk.read(out)).unwrap()
        };
        assert!(!rewrite("alone", " --max-added 0").contains(first), "{own} alone");
        desk.write(&format!("in/{beside}"), &caller);
        let out = rewrite("called", " --max-added 0");
        assert_eq!(out.contains(first), stays, "{own} beside {caller}:\n{out}");
        assert_ne!(out, text);
        let dry = desk.run(&format!("rewrite --model model.yaml in/{own} --dry-run --force")).success();
        let said = String::from_utf8_lossy(&dry.get_output().stderr).into_owned();
        assert_eq!(said.contains("another program calls this one"), stays, "{said}");
        // in a folder, too, where the caller is looked at once for all
        desk.run("rewrite --model model.yaml in --output-dir out --force --max-added 0").success();
        assert_eq!(String::from_utf8(desk.read(&format!("out/{own}"))).unwrap(), out);
    }
}

/// A result is made anew where a caller has come: its first target stays from then on.
#[test]
fn a_result_is_not_kept_where_another_program_calls_its_original_now() {
    let desk = desk("fanuc-m20ia", "J1");
    desk.write("in/PICK.LS", &fanuc("PICK", DOWN, "END"));
    let line = "rewrite --model model.yaml in --output-dir out --max-added 0";
    desk.run(line).success();
    let alone = desk.read("out/PICK.LS");
    desk.run(line).success();
    assert_eq!(desk.read("out/PICK.LS"), alone);
    desk.write("in/GO.LS", &fanuc("GO", CALLER, "CALL PICK"));
    desk.run(line).success();
    assert_ne!(desk.read("out/PICK.LS"), alone);
}

/// A name that stands far behind the start of a large module decides, too.
#[test]
fn a_result_of_a_large_module_is_kept_where_nothing_has_changed() {
    let desk = desk("abb-irb1600-6-145", "J1");
    let remarks = "! a remark that makes the module longer than what is read of its start\n".repeat(1200);
    let own = rapid("pick", DOWN, "WaitTime 1").replacen("PROC", &format!("{remarks}PROC"), 1);
    desk.write("in/pick.mod", &own);
    desk.write("in/go.mod", &rapid("main", CALLER, "%\"pick\"%"));
    let line = "rewrite --model model.yaml in --output-dir out --max-added 0";
    let made = || {
        desk.run(line).success();
        std::fs::metadata(desk.path("out/pick.mod")).unwrap().modified().unwrap()
    };
    assert_eq!(made(), made());
}

#[test]
fn callers_are_found_in_folders_of_many_programs() {
    let desk = desk("kuka-kr120-r2500-pro", "A1");
    desk.write("in/pick.src", &krl("pick", DOWN, ""));
    desk.write("in/go.src", &krl("go", CALLER, "pick()"));
    (0..70).for_each(|k| desk.write(&format!("in/p{k}.src"), &krl(&format!("p{k}"), CALLER, "")));
    desk.run("rewrite --model model.yaml in/pick.src --output out --force --max-added 0").success();
    assert!(String::from_utf8(desk.read("out")).unwrap().contains("{A1 80,"));
}
