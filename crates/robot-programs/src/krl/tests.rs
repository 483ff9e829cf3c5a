mod absolute;
mod computed;
mod folds;
mod frames;
mod going;
mod in_force;
mod led;
mod limits;
mod points;
mod project;
mod relative;
mod run;
mod still;
mod triggers;
mod with;

use super::Krl;
use super::props::kr120;
use crate::files::Files;
use crate::script::harness::{self, rewritten};
use crate::script::pose::{Configuration, Frame};
use crate::script::{
    Break, Document, Edit, Edits, Format, Goal, Move, NewPoint, PathKind, PoseGoal, Solution, Speed, StepKind, Text,
};

const LITERALS: &[u8] = include_bytes!("../../../../samples/programs/krl/literals.src");
const FOLDS: [&[u8]; 2] = [
    include_bytes!("../../../../samples/programs/krl/folds.src"),
    include_bytes!("../../../../samples/programs/krl/folds.dat"),
];
const LOGIC: [&[u8]; 2] = [
    include_bytes!("../../../../samples/programs/krl/logic.src"),
    include_bytes!("../../../../samples/programs/krl/logic.dat"),
];
const POINTS: [&[u8]; 2] = [
    include_bytes!("../../../../samples/programs/krl/points.src"),
    include_bytes!("../../../../samples/programs/krl/points.DAT"),
];
const SPLINE: [&[u8]; 2] = [
    include_bytes!("../../../../samples/programs/krl/spline-forms.src"),
    include_bytes!("../../../../samples/programs/krl/spline-forms.dat"),
];
const LONELY: &[u8] = include_bytes!("../../../../samples/programs/krl/lonely.src");

pub(super) fn samples() -> Vec<Vec<Vec<u8>>> {
    let all: [&[&[u8]]; 6] = [&[LITERALS], &FOLDS, &LOGIC, &POINTS, &SPLINE, &[LONELY]];
    all.iter().map(|p| p.iter().map(|t| t.to_vec()).collect()).collect()
}

fn parse(texts: &[&[u8]]) -> crate::error::Result<Box<dyn Document>> {
    let names = ["p.src", "p.dat"];
    Krl.parse(texts.iter().zip(names).map(|(t, n)| Text::new(n, t.to_vec())).collect(), &kr120())
}

fn doc(texts: &[&[u8]]) -> Box<dyn Document> {
    parse(texts).unwrap()
}

fn refusal(src: &str) -> String {
    parse(&[src.as_bytes()]).err().map(|e| e.to_string()).unwrap_or_default()
}

fn moves(doc: &dyn Document) -> Vec<(usize, Move)> {
    harness::moves(doc.script())
}

fn deg(doc: &dyn Document, m: &Move) -> Vec<Option<f64>> {
    let Goal::Joints(t) = m.goal else { return Vec::new() };
    doc.script().targets.get(t).unwrap().values.iter().map(|v| v.map(|v| v.si.to_degrees())).collect()
}

fn goals(doc: &dyn Document) -> String {
    let letter = |m: &Move| match m.goal {
        Goal::Joints(_) => 'j',
        Goal::Pose(_) => 'p',
        Goal::Opaque(_) => 'o',
    };
    doc.script().moves().map(|(_, m)| letter(m)).collect()
}

fn edits(doc: &dyn Document, goals: &[(usize, f64)], before: &[usize]) -> Edits {
    let mut edits = Edits { digit: vec![1e-4_f64.to_radians(); 6], ..Edits::default() };
    for (k, by) in goals {
        let StepKind::Move(m) = &doc.script().steps[*k].kind else { panic!("step {k} is no move") };
        let q = deg(doc, m).iter().map(|v| (v.unwrap_or(0.0) + by).to_radians()).collect();
        edits.steps.change_or_insert(*k, |e| e.goal = Some(q));
    }
    for k in before {
        let q = [0.25, -89.5, 90.0, 0.0, 1.0, 179.9999].map(f64::to_radians).to_vec();
        let point = NewPoint { q, share: 0.5, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
        edits.steps.change_or_insert(*k, |e| e.before.push(point));
    }
    edits
}

fn text(doc: &dyn Document, file: usize) -> String {
    String::from_utf8_lossy(&doc.script().texts[file].bytes).into_owned()
}

fn rewrite(doc: &dyn Document, edits: &Edits) -> Box<dyn Document> {
    let after = rewritten(&Krl, doc, edits, &kr120()).unwrap();
    assert_eq!(harness::difference(doc.script(), after.script(), edits), None);
    after
}

#[test]
fn axis_values_in_line_are_read_in_any_order_and_number() {
    let d = doc(&[LITERALS]);
    assert_eq!(goals(d.as_ref()), "jjjjjoopj");
    let m = moves(d.as_ref());
    assert_eq!(deg(d.as_ref(), &m[2].1), [Some(11.875), None, None, None, None, Some(-5.5)]);
    assert!((deg(d.as_ref(), &m[4].1)[2].unwrap() - 95.0).abs() < 1e-12);
    assert_eq!((m[0].1.blend_m, m[1].1.blend_m), (Some(0.0), None));
    assert!(matches!(&m[7].1.goal, Goal::Pose(p) if matches!((&p.frame, &p.tool), (Frame::Named(_), Frame::Named(_)))));
    assert_eq!(d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Dwell(_))).count(), 3);
}

#[test]
fn numbers_keep_their_style_and_no_more_than_seven_digits_are_written() {
    // the motion before a relative one stays
    let text_of = String::from_utf8_lossy(LITERALS).replace("PTP_REL {A2 5.0}\n", "");
    let d = doc(&[text_of.as_bytes()]);
    let m = moves(d.as_ref());
    let all: Vec<_> = [1, 2, 3, 4].iter().map(|i| (m[*i].0, 0.01234)).collect();
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &all, &[])).as_ref(), 0);
    let expected = "PTP {E6AXIS: A1 12.5123, A2 -85.2377, A3 95.1123, A4 3.0123, A5 -9.9877, A6 .5123} C_PTP\n\
                    PTP {AXIS:A6 -5.4877,A1 11.8873}\nWAIT SEC 0.5\n  \
                    ptp {A1 10.2623,A2 -86.4877,A3 96.13580,A4 2.5123,A5 -10.9877,A6 0.0123} C_PTP C_DIS ; lower case\n\
                    PTP {A3 95.0123}\n;PTP {A1 99.0}\n";
    assert!(after.contains(expected), "{after}");
}

#[test]
fn a_new_point_in_line_keeps_approximation_and_indentation() {
    let d = doc(&[LITERALS]);
    let m = moves(d.as_ref());
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[], &[m[3].0, m[3].0, m[8].0])).as_ref(), 0);
    assert_eq!(
        after.matches("  ptp {A1 0.2500,A2 -89.5000,A3 90.00000,A4 0.0000,A5 1.0000,A6 179.9999} C_PTP\n").count(),
        2,
        "{after}"
    );
    assert!(
        after.contains("\nPTP {A1 0.2500,A2 -89.5000,A3 90.0,A4 0.0,A5 1.0000,A6 179.9999}\nPTP {A1 0.0,"),
        "{after}"
    );
}

#[test]
fn loops_branches_calls_and_triggers_are_seen() {
    let d = doc(&LOGIC);
    assert_eq!(goals(d.as_ref()), "jjjjjjjjjjopoojjppjjjjjjjpj");
    let count = |b: Break| d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Break(x) if x == b)).count();
    assert_eq!((count(Break::Start), count(Break::Loop), count(Break::Call), count(Break::Interrupt)), (2, 6, 2, 1));
    assert_eq!(count(Break::Frame), 0, "poses have their own frames");
    let m = moves(d.as_ref());
    let why = |i: usize| m[i].1.closed.as_ref().map(ToString::to_string).unwrap_or_default();
    assert!(why(6).contains("TRIGGER") && why(10).contains("arc") && why(14).contains("spline"), "{:?}", why(6));
    assert_eq!((m[14].1.path, m[10].1.path), (PathKind::Curve, PathKind::Curve));
    assert!(why(7).is_empty());
    let lin = &m[25].1;
    assert_eq!((lin.path, lin.speed, lin.blend_m), (PathKind::Linear, Speed::Tcp(0.5), Some(0.01)));
    assert_eq!(d.script().steps.iter().filter(|s| matches!(s.kind, StepKind::Pragma(_))).count(), 2);
}

#[test]
fn points_that_are_assigned_passed_or_unknown_are_not_edited() {
    // without its project, a point of all modules is not certain
    assert_eq!(goals(doc(&POINTS).as_ref()), "jojoooojjooo");
    let own = POINTS.iter().zip(["p.src", "p.dat"]).map(|(t, n)| Text::new(n, t.to_vec()));
    let config = Text::of_context("$config.dat", b"DEFDAT $CONFIG\nENDDAT\n".to_vec());
    let d = Krl.parse(own.chain([config]).collect(), &kr120()).unwrap();
    assert_eq!(goals(d.as_ref()), "jjjjooojjooo");
    let m = moves(d.as_ref());
    let why = |i: usize| if let Goal::Opaque(w) = &m[i].1.goal { w.to_string() } else { String::new() };
    assert!(why(4).contains("line 7") && why(5).contains("assigned") && why(6).contains("TEACH"), "{}", why(4));
    assert!(why(9).contains("no value") && why(10).contains("not declared") && why(11).contains("computed"));
    // XGLOB belongs to others, XREAD is read: cloned even where every move agrees
    let both = edits(d.as_ref(), &[(m[1].0, 0.1), (m[3].0, 0.1), (m[8].0, 0.1)], &[]);
    let after = rewrite(d.as_ref(), &both);
    let dat = text(after.as_ref(), 1);
    assert!(dat.contains("DECL E6AXIS XGLOB_2={A1 20.1000") && dat.contains("GLOBAL E6AXIS XGLOB={A1 20.0,"), "{dat}");
    assert!(dat.contains("XREAD_2={") && text(after.as_ref(), 0).contains("IF XREAD.A1>0.0"), "{dat}");
}

/// Frames of the poses of a program, in order.
fn frames(src: &str) -> Vec<(Frame, Frame)> {
    let d = Krl.parse(vec![Text::new("p.src", src.as_bytes().to_vec())], &kr120()).unwrap();
    let of = |m: &Move| match &m.goal {
        Goal::Pose(p) => (p.frame.clone(), p.tool.clone()),
        other => panic!("{other:?}"),
    };
    d.script().moves().map(|(_, m)| of(m)).collect()
}

#[test]
fn base_and_tool_of_a_pose_are_those_in_force_by_the_controllers_numbers() {
    let named = |n: &str| Frame::Named(n.into());
    let at = "LIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}\n";
    let one = |before: &str| frames(&format!("DEF a()\n{before}{at}END\n")).remove(0);
    assert_eq!(one(""), (named("$BASE"), named("$TOOL")));
    assert_eq!(one("$BASE=$NULLFRAME\n$TOOL=TOOL_DATA[3]\n"), (Frame::Null, named("3")));
    assert_eq!(one("BAS(#BASE,2)\nBAS(#TOOL,0)\n"), (named("2"), Frame::Null));
    let (base, tool) = one("$BASE={X 100,Y 0,Z 0,A 90,B 0,C 0}\n$TOOL=other\n");
    let Frame::Given(base) = base else { panic!("{base:?}") };
    assert!(
        (base.translation.vector.x - 0.1).abs() < 1e-12
            && (base.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-12
    );
    assert_eq!(tool, Frame::Computed("other".into()));
    assert_eq!(one("$BASE=BASE_DATA[N]\n").0, Frame::Computed("BASE_DATA[N]".into()));
    // frame data of an inline form
    let form = "DECL FDAT FP1={TOOL_NO 4,BASE_NO 0,IPO_FRAME #BASE}\nFDAT_ACT=FP1\nBAS(#CP_PARAMS,0.1)\n";
    assert_eq!(one(form), (Frame::Null, named("4")));
}

#[test]
fn behind_a_call_a_base_is_certain_where_the_file_sets_but_one() {
    let at = "LIN {X 1.0,Y 2.0,Z 3.0,A 10.0,B 20.0,C 30.0}\n";
    let one = frames(&format!("DEF a()\n$BASE=BASE_DATA[2]\n{at}WORK()\n{at}END\n"));
    assert!(one.iter().all(|f| f.0 == Frame::Named("2".into())), "{one:?}");
    let two = frames(&format!("DEF a()\n$BASE=BASE_DATA[2]\n{at}WORK()\n{at}$BASE=BASE_DATA[3]\n{at}END\n"));
    assert!(matches!(&two[1].0, Frame::Any(all) if all.len() == 2) && two[2].0 == Frame::Named("3".into()), "{two:?}");
}

#[test]
fn the_share_of_speed_is_known_where_all_axes_have_the_same() {
    let all: String = (1..=6).map(|i| format!("$VEL_AXIS[{i}]=30\n")).collect();
    let src = format!(
        "DEF a()\n{all}PTP {{A1 1}}\n$VEL_AXIS[2]=10\nPTP {{A1 2}}\nBAS(#VEL_PTP,40)\nPTP {{A1 3}}\nWORK()\nPTP {{A1 4}}\nEND\n"
    );
    let speeds: Vec<Speed> = moves(doc(&[src.as_bytes()]).as_ref()).iter().map(|m| m.1.speed).collect();
    assert_eq!(speeds, [Speed::Share(0.3), Speed::Unknown, Speed::Share(0.4), Speed::Unknown]);
}

#[test]
fn external_axes_beside_a_cartesian_position_do_not_make_it_an_axis_target() {
    let src = "DEF p()\nPTP {X 500,Y 10,Z 700,A 0,B 90,C 0,S 2,T 10,E1 250,E2 0} C_PTP\n\
               LIN {X 510,Y 10,Z 700,A 0,B 90,C 0,E1 250,E2 0}\nPTP {A1 1,A2 -90,A3 90,A4 0,A5 0,A6 0,E1 250,E2 0}\nEND\n";
    let doc = doc(&[src.as_bytes()]);
    assert_eq!(goals(doc.as_ref()), "ppj");
    let mixed = refusal("DEF p()\nPTP {X 500,A1 10}\nEND\n");
    assert!(mixed.contains("p.src:2") && mixed.contains("`X`"), "{mixed}");
}

#[test]
fn the_turn_of_a_position_chooses_its_solution_on_joint_moves_alone() {
    let src = "DEF p()\n$BASE=$NULLFRAME\n$TOOL=$NULLFRAME\nPTP {X 500,Y 10,Z 700,A 0,B 90,C 0,S 2,T 35}\nLIN {X 510,Y 10,Z 700,A 0,B 90,C 0,S 2,T 35}\n\
               PTP {X 500,Y 10,Z 700,A 0,B 90,C 0,E1 250}\nPTP {X 500,Y 10,Z 700,A 0,B 90,C 0,S 'B010',T 'B100011'}\n\
               PTP {X 500,Y 10,Z 700,A 0,B 90,C 0,T nTurn}\nEND\n";
    let robot = kr120();
    let doc = Krl.parse(vec![Text::new("p.src", src.as_bytes().to_vec())], &robot).unwrap();
    let poses: Vec<&PoseGoal> = doc
        .script()
        .moves()
        .map(|(_, m)| match &m.goal {
            Goal::Pose(p) => &**p,
            other => panic!("{other:?}"),
        })
        .collect();
    // 35 = 100011: A1, A2 and A6 below zero
    let taught = Solution::Configured(Configuration::Kuka { status: Some(2), turn: Some(0b100011) });
    assert_eq!((&poses[0].solution, poses[0].binding), (&taught, true));
    // on a straight path it only tells how the point was taught
    assert_eq!((&poses[1].solution, poses[1].binding), (&taught, false));
    assert_eq!((&poses[2].solution, &poses[3].solution), (&Solution::Same, &taught));
    let unknown = |p: &PoseGoal, word: &str| p.unknown().is_some_and(|w| w.to_string().contains(word));
    assert!(unknown(poses[4], "turn"), "{:?}", poses[4]);
    // what an external axis carries is not known
    assert_eq!((poses[0].unknown(), &poses[0].frame), (None, &Frame::Null));
    assert_eq!(poses[2].frame, Frame::Named("$NULLFRAME at E1 250".into()));
}

#[test]
fn an_arc_of_arctech_burns_from_the_motion_to_the_seam_to_the_motion_to_its_end() {
    let src = "DEF p()\nPTP {A1 1,A2 -90,A3 90,A4 0,A5 0,A6 0}\n\
               TRIGGER WHEN PATH = ArcGetPath(#OnTheFlyArcOn, WD1) DELAY = 0 DO ArcMainNG(#ArcOnMoveStd, WD1, WP1) PRIO = -1\n\
               ArcMainNG(#ArcOnBeforeMoveStd, WD1, WP1)\nLIN {X 1,Y 2,Z 3,A 0,B 0,C 0}\nArcMainNG(#ArcOnAfterMoveStd, WD1, WP1)\n\
               LIN {X 2,Y 2,Z 3,A 0,B 0,C 0} C_DIS\nArcMainNG(#ArcOffBeforeMoveStd, WD2, WP2)\n\
               LIN {X 3,Y 2,Z 3,A 0,B 0,C 0}\nArcMainNG(#ArcOffAfterMoveStd, WD2, WP2)\nArcMainNG()\n\
               PTP {A1 2,A2 -90,A3 90,A4 0,A5 0,A6 0}\nEND\n";
    let doc = doc(&[src.as_bytes()]);
    let mut burns = false;
    let mut found = Vec::new();
    for step in &doc.script().steps {
        match &step.kind {
            StepKind::Process(on) => burns = *on,
            StepKind::Move(_) => found.push(burns),
            _ => {}
        }
    }
    assert_eq!(found, [false, true, true, true, false]);
}

/// Frame and tool of the poses of a program, as they are shown.
fn places(body: &str) -> Vec<String> {
    let d = doc(&[format!("DEF a( )\nDECL FRAME f\nf={{X 100,Y 0,Z 0,A 0,B 0,C 0}}\n{body}END\n").as_bytes()]);
    let name = |frame: &Frame| match frame {
        Frame::Named(name) | Frame::Computed(name) => name.clone(),
        Frame::Given(at) => format!("x {:.0}", at.translation.vector.x * 1e3),
        Frame::Any(all) => format!("any {}", all.len()),
        other => format!("{other:?}"),
    };
    let of = |(_, m): (usize, Move)| match m.goal {
        Goal::Pose(pose) => Some(format!("{}/{}", name(&pose.frame), name(&pose.tool))),
        _ => None,
    };
    moves(d.as_ref()).into_iter().filter_map(of).collect()
}

#[test]
fn frames_are_known_by_number_by_name_and_by_what_computes_them() {
    const LIN: &str = "LIN {X 500,Y 0,Z 700,A 0,B 90,C 0}\n";
    for (set, place) in [
        ("FDAT_ACT={TOOL_NO 3,BASE_NO 2,IPO_FRAME #BASE}\nBAS(#PTP_PARAMS,15)\n", "2/3"),
        ("$BASE=f\n$TOOL=$NULLFRAME\n", "x 100/Null"),
        ("BASE_DATA[2]={FRAME: X 7,Y 0,Z 0,A 0,B 0,C 0}\n$BASE=BASE_DATA[2]\n$TOOL=TOOL_DATA[2]\n", "x 7/2"),
        ("BAS(#BASE,n)\nBAS(#TOOL,1)\n", "BASE_DATA[n]/1"),
        ("$BASE=EK(MACHINE_DEF[2].ROOT,1,f)\n$TOOL=TOOL_DATA[k]\n", "EK(MACHINE_DEF[2].ROOT,1,f)/TOOL_DATA[k]"),
    ] {
        assert_eq!(places(&format!("{set}{LIN}")), [place], "{set}");
    }
    // after a loop either may be in force
    let several = format!("BAS(#TOOL,1)\nLOOP\nBAS(#BASE,1)\n{LIN}BAS(#BASE,2)\n{LIN}ENDLOOP\n{LIN}");
    assert_eq!(places(&several), ["1/1", "2/1", "any 2/1"]);
}

#[test]
fn a_status_in_bits_may_have_blanks_and_an_angle_leaves_the_end_of_an_arc_open() {
    let d = doc(&[b"DEF a( )\nPTP {X 500,Y 0,Z 700,A 0,B 90,C 0,S 'B 010',T 'B100010'}\nCIRC {X 1,Y 2,Z 3},{X 500,Y 9,Z 700,A 0,B 90,C 0}\nCIRC {X 1,Y 2,Z 3},{X 500,Y 9,Z 700,A 0,B 90,C 0},CA 90\nEND\n"]);
    let m = moves(d.as_ref());
    let Goal::Pose(first) = &m[0].1.goal else { panic!() };
    assert_eq!(first.solution, Solution::Configured(Configuration::Kuka { status: Some(2), turn: Some(34) }));
    let Goal::Pose(arc) = &m[1].1.goal else { panic!() };
    assert!((arc.via_m.unwrap() - nalgebra::Vector3::new(1e-3, 2e-3, 3e-3)).norm() < 1e-12);
    assert!(matches!(&m[2].1.goal, Goal::Opaque(why) if why.to_string().contains("CA")));
}

#[test]
fn a_point_on_the_way_that_is_a_product_of_frames_is_not_its_first_factor() {
    let d = doc(&[b"DEF a( )\nPTP {X 500,Y 0,Z 700,A 0,B 90,C 0,S 2,T 2}\nCIRC {X 1,Y 2,Z 3}:{X 9,Y 0,Z 0,A 0,B 0,C 0},{X 500,Y 9,Z 700,A 0,B 90,C 0}\nEND\n"]);
    let via = |m: &Move| match &m.goal {
        Goal::Pose(goal) => goal.via_m,
        _ => None,
    };
    assert!(moves(d.as_ref()).iter().all(|(_, m)| via(m).is_none()));
}

#[test]
fn an_arc_is_split_into_arcs() {
    let pose = |x: f64, y: f64| format!("{{X {x},Y {y},Z 700.0,A 0,B 90,C 0}}");
    let arc = format!("CIRC XAUX , {} C_DIS ; weld\n", pose(500.0, 9.0));
    let source = |before: &str, arc: &str| {
        let aux = "DECL POS XAUX\nXAUX={X 1,Y 2,Z 700.0,A 0,B 90,C 0}\n";
        format!("DEF a( )\n{aux}{before}LIN {} C_DIS\n{arc}LIN XAUX\nEND\n", pose(500.0, 0.0))
    };
    let text_of = source("", &arc);
    let d = doc(&[text_of.as_bytes()]);
    let m = moves(d.as_ref());
    assert_eq!(m[1].1.closed, None);
    let Goal::Pose(goal) = &m[1].1.goal else { panic!() };
    let own: Vec<f64> =
        d.script().targets.get(goal.target.unwrap()).unwrap().values.iter().map(|v| v.unwrap().si).collect();
    let point = |x_mm: f64, share| {
        let q = std::iter::once(x_mm * 1e-3).chain(own[1..].iter().copied()).collect();
        NewPoint { q, share, t_s: None, clearance_m: 0.01, of_way: false, waits: false }
    };
    let vias = vec![vec![0.4, 0.001, 0.7], vec![0.411, 0.002, 0.7], vec![0.4500004, 0.005, 0.7]];
    let edit = Edit { before: vec![point(410.0, 0.5), point(411.5, 0.52)], vias, ..Edit::default() };
    let wish = |vias: usize| {
        let edit = Edit { vias: edit.vias[..vias].to_vec(), ..edit.clone() };
        Edits { steps: [(m[1].0, edit)].into(), pose_digit: [1e-7, 1e-6], ..Edits::default() }
    };
    let out = text(rewrite(d.as_ref(), &wish(3)).as_ref(), 0);
    let first = "CIRC {X 400.0000,Y 1.0000,Z 700.0000},{X 410.0000,Y 9,Z 700.0,A 0,B 90,C 0} C_DIS\n";
    let short = "CIRC {X 411.0000,Y 2.0000,Z 700.0000},{X 411.5000,Y 9,Z 700.0,A 0,B 90,C 0} C_DIS\n";
    let last = format!("CIRC {{X 450.0004,Y 5.0000,Z 700.0000}} , {} C_DIS ; weld\nLIN XAUX\n", pose(500.0, 9.0));
    assert!(out.contains(&format!("{first}{short}{last}")), "{out}");
    assert!(d.patches(&wish(0)).is_err() && d.patches(&wish(2)).is_err());
    // the point on the way alone
    let moved = Edit { vias: vec![vec![0.4500004, 0.005, 0.7]], ..Edit::default() };
    let moved = Edits { steps: [(m[1].0, moved)].into(), pose_digit: [1e-7, 1e-6], ..Edits::default() };
    let alone = text_of.replace("CIRC XAUX", "CIRC {X 450.0004,Y 5.0000,Z 700.0000}");
    assert_eq!(text(rewrite(d.as_ref(), &moved).as_ref(), 0), alone);
    // what a controller or a form does with the arc beside is not known
    for (before, arc) in [
        ("$CIRC_TYPE=#PATH\n", arc.as_str()),
        ("", &arc.replace("CIRC", "SCIRC")),
        ("", &arc.replace("XAUX", "XELSE")),
        ("", &format!("TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[1]=TRUE\n{arc}")),
        ("", &format!(";FOLD arc\n{arc};ENDFOLD\n")),
    ] {
        let d = doc(&[source(before, arc).as_bytes()]);
        assert!(moves(d.as_ref())[1].1.closed.is_some(), "{before}{arc}");
    }
}

#[test]
fn joints_of_other_names_are_found_by_their_numbers() {
    use crate::axes::{Axes, Axis, JointKind};
    let source = "DEF p( )\nPTP {A1 1,A2 2,A3 3,A4 0,A5 0,A6 6}\nEND\n";
    let of = |names: &[&str]| {
        let robot = Axes::new("arm", names.iter().map(|n| Axis::new(*n, JointKind::Revolute)).collect());
        let script = harness::script_of(&Krl, source, &robot);
        let (step, m) = harness::moves(&script).remove(0);
        let deg = |v: f64| (v.to_degrees() * 1e6).round() / 1e6;
        match m.goal {
            Goal::Opaque(why) => Err(why.to_string()),
            _ => Ok(harness::values(&script, step).into_iter().map(deg).collect::<Vec<f64>>()),
        }
    };
    assert_eq!(of(&["J1", "J2", "J3", "J6"]), Ok(vec![1.0, 2.0, 3.0, 6.0]));
    assert_eq!(of(&["A1", "A2", "A3", "A6"]), Ok(vec![1.0, 2.0, 3.0, 6.0]));
    assert!(of(&["a", "b", "c"]).unwrap_err().contains("name them so"));
}
