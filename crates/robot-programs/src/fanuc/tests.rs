mod flow;
mod left_alone;
mod lines;
mod registers;
mod triggers;

use super::Fanuc;
use super::props::m10ia;
use crate::script::harness::{self, rewritten};
use crate::script::{Break, Document, Edits, Format, Goal, Move, NewPoint, OtherWay, PathKind, Speed, StepKind, Text};

pub(super) fn samples() -> [&'static [u8]; 6] {
    [
        include_bytes!("../../../../samples/programs/fanuc/reversal.ls"),
        include_bytes!("../../../../samples/programs/fanuc/shared-point.ls"),
        include_bytes!("../../../../samples/programs/fanuc/welding.ls"),
        include_bytes!("../../../../samples/programs/fanuc/german.ls"),
        include_bytes!("../../../../samples/programs/fanuc/groups.ls"),
        include_bytes!("../../../../samples/programs/fanuc/logic.ls"),
    ]
}

fn doc(bytes: &[u8]) -> Box<dyn Document> {
    Fanuc.parse(vec![Text::new("p.ls", bytes.to_vec())], &m10ia()).unwrap()
}

fn refusal(bytes: &[u8]) -> String {
    Fanuc.parse(vec![Text::new("p.ls", bytes.to_vec())], &m10ia()).err().map(|e| e.to_string()).unwrap_or_default()
}

fn moves(doc: &dyn Document) -> Vec<(usize, Move)> {
    harness::moves(doc.script())
}

fn deg(doc: &dyn Document, m: &Move) -> Vec<f64> {
    let Goal::Joints(t) = m.goal else { return Vec::new() };
    doc.script().targets.get(t).unwrap().values.iter().map(|v| v.unwrap().si.to_degrees()).collect()
}

/// Moves goals by `by` degrees and puts a point before each of `before`.
fn edits(doc: &dyn Document, goals: &[(usize, f64)], before: &[usize]) -> Edits {
    let mut edits = Edits { digit: vec![1e-4_f64.to_radians(); 6], ..Edits::default() };
    for (k, by) in goals {
        let StepKind::Move(m) = &doc.script().steps[*k].kind else { panic!("step {k} is no move") };
        let q = deg(doc, m).iter().map(|v| (v + by).to_radians()).collect();
        edits.steps.change_or_insert(*k, |e| e.goal = Some(q));
    }
    for k in before {
        let q = [0.25, -9.5, 30.0, 0.0, -60.0, 179.999].map(f64::to_radians).to_vec();
        let point = NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
        edits.steps.change_or_insert(*k, |e| e.before.push(point));
    }
    edits
}

fn text(doc: &dyn Document) -> String {
    doc.script().texts[0].bytes.iter().map(|b| *b as char).collect()
}

fn rewrite(doc: &dyn Document, edits: &Edits) -> Box<dyn Document> {
    let after = rewritten(&Fanuc, doc, edits, &m10ia()).unwrap();
    assert_eq!(harness::difference(doc.script(), after.script(), edits), None);
    after
}

#[test]
fn joints_speeds_and_ends_are_read() {
    let d = doc(samples()[0]);
    let m = moves(d.as_ref());
    assert_eq!(m.len(), 5);
    let first = deg(d.as_ref(), &m[0].1);
    assert!((first[0] - 0.384).abs() < 1e-12 && (first[4] + 62.5).abs() < 1e-12);
    assert_eq!((m[0].1.speed, m[0].1.blend_m), (Speed::Share(0.5), Some(0.0)));
    assert_eq!((m[1].1.speed, m[1].1.blend_m), (Speed::Share(1.0), None));
    assert_eq!(m[3].1.speed, Speed::Joint(30_f64.to_radians()));
    let Goal::Joints(t) = m[0].1.goal else { panic!() };
    let v = d.script().targets.get(t).unwrap().values.get(0).unwrap();
    assert!((v.finest.to_degrees() - 1e-3).abs() < 1e-15);
    assert_eq!(&d.script().texts[0].bytes[v.span()], b".384");
    assert!(d.script().steps.iter().any(|s| matches!(s.kind, StepKind::Dwell(Some(s)) if s == 0.5)));
}

#[test]
fn a_goal_keeps_its_ten_characters_and_three_decimals() {
    let d = doc(samples()[0]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, -0.5), (m[3].0, 0.0123)], &[])).as_ref());
    assert!(after.contains("\tJ1=     -.116 deg,\tJ2=   -10.500 deg,\tJ3=    34.630 deg,"), "{after}");
    // 0.884 + 0.0123: rounded to the finest that the field holds
    assert!(after.contains("J1=      .896 deg"), "{after}");
    assert_eq!(after.len(), text(d.as_ref()).len());
}

#[test]
fn a_new_point_is_a_line_and_a_position_and_all_numbers_behind_move_up() {
    let d = doc(samples()[0]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[1].0, m[1].0, m[3].0])).as_ref());
    for line in [
        "   5:J P[6] 100% CNT0 ACC80    ;",
        "   6:J P[7] 100% CNT0 ACC80    ;",
        "   7:J P[2] 100% CNT50 ACC80    ;",
        "   9:  WAIT    .50(sec) ;",
        "  10:J P[8] 30deg/sec FINE    ;",
        "  12:J P[5] 100% FINE    ;",
        "LINE_COUNT\t= 12;",
        "MEMORY_SIZE\t= 1500;",
        "P[8]{",
    ] {
        assert!(after.contains(line), "{line}\n{after}");
    }
    assert!(
        after.contains("J1=      .250 deg,\tJ2=    -9.500 deg") && after.contains("J6=   179.999 deg\n};\n/END"),
        "{after}"
    );
}

#[test]
fn a_shared_position_is_changed_in_place_only_where_all_moves_agree() {
    let d = doc(samples()[1]);
    let m = moves(d.as_ref());
    let of = |name: &str| -> Vec<usize> {
        let named =
            |m: &Move| matches!(m.goal, Goal::Joints(t) if d.script().targets.get(t).unwrap().name == Some(name));
        m.iter().filter(|(_, m)| named(m)).map(|(k, _)| *k).collect()
    };
    let p1 = of("P[1]");
    assert_eq!(p1.len(), 3);
    let all: Vec<_> = p1.iter().map(|k| (*k, 0.05)).collect();
    let same = text(rewrite(d.as_ref(), &edits(d.as_ref(), &all, &[])).as_ref());
    assert!(same.contains("P[1:\"wait\"]") && !same.contains("P[8"), "{same}");
    let two = edits(d.as_ref(), &[(p1[0], 0.05), (p1[2], -0.05)], &[]);
    let apart = text(rewrite(d.as_ref(), &two).as_ref());
    assert!(
        apart.contains("J P[8:wait] 100%") && apart.contains("J P[1:wait]") && apart.contains("J P[9:wait]"),
        "{apart}"
    );
    assert!(apart.contains("P[8:\"wait\"]{") && apart.contains("LINE_COUNT\t= 9;"));
    // P[7] is read by a register: its numbers stay
    let p7: Vec<_> = of("P[7]").into_iter().map(|k| (k, 0.05)).collect();
    let register = text(rewrite(d.as_ref(), &edits(d.as_ref(), &p7, &[])).as_ref());
    assert!(
        register.contains("PR[5]=P[7]")
            && register.contains("J P[8] 100% CNT20")
            && register.contains("J P[8] 10% FINE")
    );
}

#[test]
fn welds_arcs_and_actions_stay_with_their_motion() {
    // a new point would delay what starts before the end
    let after_the_end = String::from_utf8_lossy(samples()[2]).replace("TB    .10sec", "TA    .10sec");
    let d = doc(after_the_end.as_bytes());
    let m = moves(d.as_ref());
    let kinds: Vec<PathKind> = m.iter().map(|m| m.1.path).collect();
    use PathKind::{Curve as C, Joint as J, Linear as L};
    assert_eq!(kinds, [J, J, L, L, C, C, L, L, J, J, J]);
    let process: Vec<bool> = d
        .script()
        .steps
        .iter()
        .filter_map(|s| if let StepKind::Process(on) = s.kind { Some(on) } else { None })
        .collect();
    assert_eq!(process, [true, false, true, false]);
    assert_eq!(d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Pragma(_))).count(), 2);
    assert_eq!(m[2].1.speed, Speed::Tcp(0.25));
    assert!(matches!(m[3].1.speed, Speed::Tcp(v) if (v - 0.01).abs() < 1e-12));
    assert!(matches!(m[6].1.speed, Speed::Tcp(v) if (v - 20.0 * 0.0254 / 60.0).abs() < 1e-12));
    assert_eq!(m[9].1.speed, Speed::Seconds(2.0));
    assert!(m[9].1.closed.is_some() && m[4].1.closed.is_some());
    let null = crate::script::pose::Frame::Null;
    let frames: Vec<bool> = m
        .iter()
        .filter_map(|m| if let Goal::Pose(p) = &m.1.goal { Some((&p.frame, &p.tool) != (&null, &null)) } else { None })
        .collect();
    assert_eq!(frames, [true, true, false, true, false, true], "only P[6] has frame 0 and tool 0");
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[1].0])).as_ref());
    assert!(
        after.contains("   5:J P[7] 80% FINE Wjnt ACC60    ;") && after.contains("    :  P[6] 60cm/min"),
        "{after}"
    );
    assert!(after.contains("  12:  Arc Start[2] ;"), "{after}");
}

#[test]
fn words_in_another_language_are_kept_and_bytes_and_line_ends_with_them() {
    let d = doc(samples()[3]);
    let m = moves(d.as_ref());
    let reasons: Vec<bool> = m.iter().map(|m| matches!(m.1.goal, Goal::Opaque(_))).collect();
    assert_eq!(reasons, [false, false, false, false, false, true, true, false]);
    assert!(
        matches!(m[3].1.goal, Goal::Pose(_))
            && d.script().steps.iter().any(|s| matches!(s.kind, StepKind::Process(true)))
    );
    let breaks = d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Break(_))).count();
    assert_eq!(breaks, 3, "the start, SPRUNG, and MRK, which is reached from before it");
    let after = rewrite(d.as_ref(), &edits(d.as_ref(), &[(m[0].0, 0.01)], &[m[1].0]));
    let bytes = &after.script().texts[0].bytes;
    assert!(memchr::memmem::find(bytes, b"ZEILEN\t\t= 13;\r\n").is_some());
    assert!(memchr::memmem::find(bytes, b"GE\xc4NDERT").is_some());
    let ends = memchr::memchr_iter(b'\n', bytes).all(|n| bytes[n - 1] == b'\r');
    assert!(ends, "a line without CRLF");
}

#[test]
fn a_rail_that_moves_allows_no_new_point_and_an_untaught_position_no_edit() {
    let d = doc(samples()[4]);
    let m = moves(d.as_ref());
    let closed: Vec<bool> = m.iter().map(|m| m.1.closed.is_some()).collect();
    // first: where the rail comes from is not known
    assert_eq!(closed[..4], [true, false, true, false]);
    assert!(matches!(&m[4].1.goal, Goal::Opaque(why) if why.to_string().contains("not taught")));
    assert!(m[5].1.closed.is_some());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[3].0])).as_ref());
    assert!(after.contains("P[6]{\n   GP1:") && after.ends_with("\tJ1=  1500.000  mm\n};\n/END\n"), "{after}");
    assert!(after.contains("J1=     0.250 deg"), "this file writes the zero before the point");
}

#[test]
fn labels_jumps_calls_skips_and_registers_are_seen() {
    let d = doc(samples()[5]);
    let m = moves(d.as_ref());
    let goals: Vec<char> = m
        .iter()
        .map(|m| match m.1.goal {
            Goal::Joints(_) => 'j',
            Goal::Pose(_) => 'p',
            Goal::Opaque(_) => 'o',
        })
        .collect();
    assert_eq!(goals.iter().collect::<String>(), "jjjjjjooooojjo");
    let count = |b: Break| d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Break(x) if x == b)).count();
    // jumps away end nothing: two labels, a skip; SUB2, the macro, GRIPPER and OTHER may move
    assert_eq!((count(Break::Jump), count(Break::Loop), count(Break::Call)), (3, 2, 4));
    assert!(m[5].1.closed.as_ref().is_some_and(|c| c.to_string().contains("skip")));
    // point logic keeps its own numbers; a line without a number gets none
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[1].0, m[12].0])).as_ref());
    assert!(after.contains("   4:J P[10] 100% CNT0    ;\n   5:J P[2] 100% CNT50 TB"), "{after}");
    assert!(after.contains("      3:  CALL MAKRO7    ;\n       ------ ;\n   6:  IF R[1]=3"), "{after}");
    assert!(after.contains("    :J P[11] 100% FINE    ;\n    :J P[2] 100% FINE    ;"), "{after}");
}

#[test]
fn files_that_cannot_be_are_refused_with_their_place() {
    let text = String::from_utf8(samples()[0].to_vec()).unwrap();
    let with = |a: &str, b: &str| refusal(text.replacen(a, b, 1).as_bytes());
    assert!(with("/END", "").contains("no /END"));
    assert!(with("/MN", "").contains("no /MN"));
    assert!(
        with("100% CNT50 ACC80    ;", "100% CNT50").contains("p.ls:27"),
        "{}",
        with("100% CNT50 ACC80    ;", "100% CNT50")
    );
    assert!(with("    35.130 deg", "    35,130 deg").contains("unit"), "{}", with("    35.130 deg", "    35,130 deg"));
    assert!(with(",\tJ6=    12.000 deg", "").contains("5 joint values in P[1]"));
    assert!(with("J6=    12.000 deg", "J6=    12.000  mm").contains("J6"));
    assert!(with("P[2]{", "P[1]{").contains("a second P[1]"));
    assert!(refusal(b"J P[1] 100% FINE ;").contains("no /PROG"));
    assert!(Fanuc.recognises(samples()[0]) && !Fanuc.recognises(b"DEF a()"));
}

#[test]
fn without_a_count_of_lines_no_line_is_added() {
    let text = String::from_utf8(samples()[0].to_vec()).unwrap().replace("LINE_COUNT\t= 9;\n", "");
    let d = doc(text.as_bytes());
    let k = moves(d.as_ref())[1].0;
    assert!(
        moves(d.as_ref()).iter().all(|m| m.1.closed.as_ref().is_some_and(|c| c.to_string().contains("LINE_COUNT")))
    );
    assert!(d.patches(&edits(d.as_ref(), &[(k, 0.1)], &[])).is_ok());
}

#[test]
fn a_large_program_is_read_in_linear_time() {
    let mut text = String::from_utf8(samples()[0].to_vec()).unwrap();
    let body: String = (10..60_000).map(|n| format!("{n:4}:J P[{}] 100% FINE    ;\n", n % 5 + 1)).collect();
    text = text.replace("/POS\n", &format!("{body}/POS\n"));
    let start = std::time::Instant::now();
    let d = doc(text.as_bytes());
    let m = moves(d.as_ref());
    assert_eq!(m.len(), 5 + 59_990);
    let goals: Vec<_> = m.iter().map(|m| (m.0, 0.01)).collect();
    rewrite(d.as_ref(), &edits(d.as_ref(), &goals, &[m[3].0, m[40_000].0]));
    // one position, and every motion wants it elsewhere
    let apart: Vec<_> = m.iter().take(30_000).enumerate().map(|(i, m)| (m.0, i as f64 * 1e-3)).collect();
    rewrite(d.as_ref(), &edits(d.as_ref(), &apart, &[]));
    let more: Vec<_> = m.iter().enumerate().map(|(i, m)| (m.0, i as f64 * 1e-3)).collect();
    assert!(d.patches(&edits(d.as_ref(), &more, &[])).is_err_and(|e| e.to_string().contains("32768")));
    assert!(start.elapsed().as_secs() < 60);
}

#[test]
fn a_hostile_megabyte_ends_quickly() {
    let start = std::time::Instant::now();
    for piece in ["[", "P[", "J P[1] ", ":", "'", "J1=1 deg,", "9", "\n:;", "\n   1:J P[1] 1% FINE ;", "P[1]{\n"] {
        let body = piece.repeat(1_000_000 / piece.len());
        for text in [
            format!("/PROG  A\n/MN\n   1:{body} ;\n/POS\n/END\n"),
            format!("/PROG  A\n/MN\n/POS\nP[1]{{\nGP1:\n{body}\n}};\n/END\n"),
        ] {
            let _ = Fanuc.parse(vec![Text::new("p.ls", text.into_bytes())], &m10ia());
        }
    }
    assert!(start.elapsed().as_secs() < 60);
}

#[test]
fn a_second_application_section_is_passed_over_and_a_second_program_is_not() {
    let program = |head: &str| {
        format!(
            "/PROG  TWICE\n/ATTR\nLINE_COUNT\t= 1;\n{head}/MN\n   1:J P[1] 50% FINE    ;\n/POS\nP[1]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n\
             \tJ1=    10.000 deg,\tJ2=      .500 deg,\tJ3=     0.000 deg,\n\
             \tJ4=     0.000 deg,\tJ5=   -60.000 deg,\tJ6=     0.000 deg\n}};\n/END\n"
        )
    };
    let doc = doc(program("/APPL\n/APPL\n").as_bytes());
    let found = moves(doc.as_ref());
    assert_eq!(found.len(), 1);
    assert_eq!(deg(doc.as_ref(), &found[0].1).first().map(|v| v.round()), Some(10.0));
    assert!(refusal(program("/MN\n").as_bytes()).contains("a second /MN"));
}

#[test]
fn a_straight_motion_is_not_stopped_on_its_way_and_ends_as_it_did() {
    for (motion, copy) in [("L P[1] 100mm/sec FINE", "L P[2] 100mm/sec CNT0"), ("J P[1] 50% FINE", "J P[2] 50% FINE")] {
        let joints = "\tJ1=     0.000 deg,\tJ2=     0.000 deg,\tJ3=     0.000 deg,\n\tJ4=     0.000 deg,\tJ5=     0.000 deg,\tJ6=     0.000 deg\n";
        let text = format!(
            "/PROG  LINE\n/ATTR\nLINE_COUNT\t= 1;\n/MN\n   1:{motion}    ;\n/POS\nP[1]{{\n   GP1:\n\tUF : 0, UT : 1,\t\n{joints}}};\n/END\n"
        );
        let d = doc(text.as_bytes());
        let k = moves(d.as_ref())[0].0;
        let after = self::text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[k])).as_ref());
        assert!(after.contains(&format!("   1:{copy}    ;\n   2:{motion}    ;")), "{after}");
    }
}

/// An arm of which the robot file has some joints.
fn some_joints(names: &[&str]) -> crate::axes::Axes {
    use crate::axes::{Axes, Axis, JointKind};
    Axes::new("arm", names.iter().map(|n| Axis::new(*n, JointKind::Revolute)).collect())
}

#[test]
fn joints_of_a_position_are_found_by_the_numbers_in_their_names() {
    let source =
        b"/PROG P\n/ATTR\nLINE_COUNT = 1;\n/MN\n   1:J P[1] 10% FINE    ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\t\n\
        \tJ1= 1.000 deg,\tJ2= 2.000 deg,\tJ3= 3.000 deg,\n\tJ4= 4.000 deg,\tJ5= 5.000 deg,\tJ6= 6.000 deg\n};\n/END\n";
    let of = |names: &[&str]| {
        let doc = Fanuc.parse(vec![Text::new("p.ls", source.to_vec())], &some_joints(names)).unwrap();
        let (_, m) = moves(doc.as_ref()).remove(0);
        let round = |v: f64| (v * 1e6).round() / 1e6;
        match &m.goal {
            Goal::Opaque(why) => Err(why.to_string()),
            _ => Ok(deg(doc.as_ref(), &m).into_iter().map(round).collect::<Vec<f64>>()),
        }
    };
    assert_eq!(of(&["J1", "J2", "J3", "J6"]), Ok(vec![1.0, 2.0, 3.0, 6.0]));
    assert_eq!(of(&["joint_1", "joint_2", "joint_4", "joint_5", "joint_6"]), Ok(vec![1.0, 2.0, 4.0, 5.0, 6.0]));
    assert!(of(&["a", "b", "c"]).unwrap_err().contains("(a, b, c)"));
}
