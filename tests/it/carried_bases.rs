//! Bases of a KUKA that count from an external axis: `MACHINE_FRAME_DAT[n]` of `$config.dat` names it, and frame data put them into force.

use crate::vendor_rewrite::Desk;
use predicates::prelude::PredicateBooleanExt;
use predicates::str::contains;

/// Targets of inline forms in base 1, of which the second is reached downwards.
fn program() -> (String, String) {
    let (mut src, mut dat) =
        (String::from("DEF p( )\nPTP {A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 60.0,A6 0.0}\n"), String::new());
    for (k, y) in [0.0, 150.0, -100.0, 50.0].into_iter().enumerate() {
        src += &format!("FDAT_ACT=FP{k}\nBAS(#CP_PARAMS,0.5)\nLIN XP{k}\n");
        dat += &format!("DECL E6POS XP{k}={{X 0.0,Y {y:.4},Z 0.0,A 0.0,B 180.0,C 0.0,S 2,T 2,E1 0.0}}\n");
        dat += &format!("DECL FDAT FP{k}={{TOOL_NO 0,BASE_NO 1,IPO_FRAME #BASE}}\n");
    }
    (src + "END\n", format!("DEFDAT p\n{dat}ENDDAT\n"))
}

/// `$config.dat` with base 1 on a machine.
fn config(machine: u32) -> String {
    format!(
        "DEFDAT $CONFIG PUBLIC\nDECL FRAME BASE_DATA[32]\nBASE_DATA[1]={{X 1500.0,Y 100.0,Z 900.0,A 0.0,B 0.0,C 0.0}}\n\
         MACHINE_DEF[1]={{NAME[] \"KR 120\",COOP_KRC_INDEX 1,PARENT[] \"WORLD\",ROOT {{X 0.0}},MECH_TYPE #ROBOT}}\n\
         MACHINE_DEF[2]={{NAME[] \"DKP-400\",COOP_KRC_INDEX 1,PARENT[] \"WORLD\",ROOT {{X 150.0}},MECH_TYPE #EASYS}}\n\
         MACHINE_FRAME_DAT[1]={{MACH_DEF_INDEX {machine},PARENT[] \"DKP-400\",GEOMETRY[] \" \"}}\nENDDAT\n"
    )
}

fn desk(machine: u32) -> Desk {
    let desk = Desk::new(0.02);
    let (src, dat) = program();
    desk.write("R1/Program/p.src", &src);
    desk.write("R1/Program/p.dat", &dat);
    desk.write("config.dat", &config(machine));
    desk
}

const REWRITE: &str = "rewrite --model model.yaml R1/Program/p.src --output out.src --force --frames";

#[test]
fn a_base_on_a_table_is_asked_for_and_never_taken_from_the_world() {
    let asked = "as poses: 0 moves";
    let name = "1 on MACHINE_DEF[2]";
    // in the file that is given, and in the project
    let desk = desk(2);
    desk.run(&format!("{REWRITE} config.dat")).success().stderr(contains(asked).and(contains(name)));
    desk.write("R1/System/$config.dat", &config(2));
    let world = "schema: lostmotion/frames/1\nframes: {\"1\": {xyz_mm: [1500, 100, 900], rpy_deg: [0, 0, 0]}}\n";
    desk.write("frames.yaml", world);
    desk.run(&format!("{REWRITE} frames.yaml")).success().stderr(contains(asked).and(contains(name)));
    desk.run("rewrite --model model.yaml R1/Program/p.src --list-frames").success().stdout(contains(name));
    // where its place is given it is that base
    desk.write("frames.yaml", &world.replace("\"1\"", "\"1 on MACHINE_DEF[2]\""));
    desk.run(&format!("{REWRITE} frames.yaml")).success().stderr(contains("as poses: 4 moves"));
}

#[test]
fn a_base_that_no_machine_carries_is_that_of_its_list() {
    for machine in [0, 1] {
        desk(machine).run(&format!("{REWRITE} config.dat")).success().stderr(contains("as poses: 4 moves"));
    }
}
