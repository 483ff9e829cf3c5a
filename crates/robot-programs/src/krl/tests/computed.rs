//! Points that the program computes: what they are where that is certain, and where it is not.

use super::*;

const DAT: &str = "DEFDAT p\nDECL E6POS XP1={X 500.0,Y 20.5,Z 900.0,A 0.0,B 90.0,C 0.0,S 2,T 3}\nDECL E6POS XUP\nDECL E6POS XFAR\n\
                   DECL E6AXIS XA={A1 1.0,A2 -90.0,A3 90.0,A4 0.0,A5 5.0,A6 0.0}\nDECL E6AXIS XB\nDECL FRAME F\n\
                   DECL E6POS P[2]\nP[1]={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0}\nDECL REAL H=50\nDECL INT N=4\nDECL REAL G=0.25,K[2]\nENDDAT\n";

/// A program of these routines, with its list.
fn program(source: &str) -> Box<dyn Document> {
    doc(&[source.as_bytes(), DAT.as_bytes()])
}

/// A program of these lines.
fn of(lines: &str) -> Box<dyn Document> {
    program(&format!("DEF main()\n{lines}END\n"))
}

/// X, Y and Z of a move in mm; none: it is not known.
fn position(doc: &dyn Document, i: usize) -> Option<[f64; 3]> {
    let m = moves(doc);
    let Goal::Pose(pose) = &m.get(i)?.1.goal else { return None };
    Some([0, 1, 2].map(|k| (pose.position_m[k] * 1e9).round() * 1e-6))
}

fn is_open(m: &Move) -> bool {
    matches!(m.goal, Goal::Opaque(_))
}

#[test]
fn a_copy_of_a_point_with_parts_from_constants_is_known() {
    for (lines, expected) in [
        ("XUP=XP1\nXUP.Z=XUP.Z+150\nLIN XUP\n", [500.0, 20.5, 1050.0]),
        ("XUP=XP1\nXUP.z = xp1.Z + H\nLIN XUP C_DIS\n", [500.0, 20.5, 950.0]),
        ("XUP=XP1\nXUP.Z=H\nXUP.X=-(H+H)/G/2\nLIN XUP\n", [-200.0, 20.5, 50.0]),
        ("XUP=XP1\nXUP.Y=N\nXFAR=XUP\nXFAR.Z=XFAR.Z-XUP.Y\nLIN XFAR\n", [500.0, 4.0, 896.0]),
        ("XUP={X 1,Y 2,Z 3,A 0,B 0,C 0}\nXUP.Z=H\nPTP XUP\n", [1.0, 2.0, 50.0]),
        ("XUP=XP1\nIF $IN[1] THEN\nH1=2\nENDIF\nXUP.Z=H\nLIN XUP\n", [500.0, 20.5, 50.0]),
        ("LOOP\nXUP=XP1\nXUP.Z=XUP.Z+H\nLIN XUP\nENDLOOP\n", [500.0, 20.5, 950.0]),
        // both ways give the same
        ("IF $IN[1] THEN\nXUP=XP1\nELSE\nXUP=XP1\nENDIF\nLIN XUP\n", [500.0, 20.5, 900.0]),
        ("XUP=XP1\nXUP.X=P[1].X+1\nLIN XUP\n", [2.0, 20.5, 900.0]),
        ("XUP=XP1\nBAS(#VEL_PTP,H)\nG=ABS(H)\nXUP.Z=H\nLIN XUP\n", [500.0, 20.5, 50.0]),
    ] {
        assert_eq!(position(of(lines).as_ref(), 0), Some(expected), "{lines}");
    }
    let d = of("XB=XA\nXB.A1=XB.A1+N\nPTP XB\n");
    assert_eq!(deg(d.as_ref(), &moves(d.as_ref())[0].1)[..2], [Some(5.0), Some(-90.0)]);
}

#[test]
fn each_motion_has_the_value_that_its_point_has_there() {
    let d = of("XUP=XP1\nXUP.Z=1000\nPTP XUP\nXUP.Z=XUP.Z-100\nLIN XUP\nXUP=XP1\nLIN XUP\n");
    let z = [0, 1, 2].map(|i| position(d.as_ref(), i).unwrap()[2]);
    assert_eq!(z, [1000.0, 900.0, 900.0]);
}

#[test]
fn local_variables_and_numbers_that_are_assigned_before_are_known() {
    let d = of("DECL E6POS L\nDECL REAL UP\nUP=400\nL=XP1\nsub()\nL.Z=L.Z+UP\nPTP L\nUP=UP+1\nL.Z=UP\nLIN L\n");
    assert_eq!([0, 1].map(|i| position(d.as_ref(), i).unwrap()[2]), [1300.0, 401.0]);
    // a routine of the same names has its own
    let sub = "DEF sub()\nDECL E6POS L\nL.Z=1\nsub()\nEND\n";
    let d = program(&format!("DEF p()\nDECL E6POS L\nL=XP1\nsub()\nL.Z=H\nLIN L\nEND\n{sub}"));
    assert_eq!(position(d.as_ref(), 0).unwrap()[2], 50.0);
}

#[test]
fn routines_of_the_file_are_followed() {
    let of =
        |main: &str, sub: &str| position(program(&format!("DEF p()\n{main}END\nDEF sub()\n{sub}END\n")).as_ref(), 0);
    assert_eq!(of("sub()\nXUP.Z=H\nLIN XUP\n", "XUP=XP1\n"), Some([500.0, 20.5, 50.0]));
    assert_eq!(of("XUP=XP1\nXUP.Z=H\nsub()\n", "LIN XUP\n"), Some([500.0, 20.5, 50.0]));
    assert_eq!(of("XUP=XP1\nXUP.Z=H\nsub()\nXUP=XP1\nsub()\n", "LIN XUP\n"), None);
    assert_eq!(of("XUP=XP1\nXUP.Z=H\nsub()\nLIN XUP\n", "XUP.Z=XUP.Z+1\n"), Some([500.0, 20.5, 51.0]));
    assert_eq!(of("XUP=XP1\nXUP.Z=H\nsub()\nLIN XUP\n", "IF $IN[1] THEN\nXUP.Z=1\nENDIF\n"), None);
    // one that is GLOBAL may be called by others
    let global = "DEF p()\nXUP=XP1\nXUP.Z=H\nsub()\nEND\nGLOBAL DEF sub()\nLIN XUP\nEND\n";
    assert_eq!(position(program(global).as_ref(), 0), None);
    // and what no file has may call it
    let back = "DEF p()\nXUP=XP1\nXUP.Z=H\nelsewhere()\nLIN XUP\nEND\nGLOBAL DEF sub()\nXUP.Z=1\nEND\n";
    assert_eq!(position(program(back).as_ref(), 0), None);
}

#[test]
fn what_a_condition_calls_comes_before_all_branches() {
    let fun = "DEFFCT BOOL fun()\nXUP.Z=1\nRETURN $IN[1]\nENDFCT\n";
    let of = |lines: &str| position(program(&format!("DEF main()\nXUP=XP1\n{lines}END\n{fun}")).as_ref(), 0);
    for lines in [
        "IF fun() THEN\nI=1\nENDIF\nLIN XUP\n",
        "IF fun() THEN\nI=1\nELSE\nLIN XUP\nENDIF\n",
        "WHILE fun()\nLIN XUP\nXUP=XP1\nENDWHILE\n",
        "WHILE fun()\nXUP=XP1\nENDWHILE\nLIN XUP\n",
        "REPEAT\nXUP=XP1\nUNTIL fun()\nLIN XUP\n",
        "SWITCH fun()\nCASE 1\nI=1\nENDSWITCH\nLIN XUP\n",
        "I=fun()\nLIN XUP\n",
        "WAIT FOR fun()\nLIN XUP\n",
    ] {
        assert_eq!(of(lines), Some([500.0, 20.5, 1.0]), "{lines}");
    }
    assert_eq!(of("WHILE fun()\nEXIT\nXUP=XP1\nENDWHILE\nWHILE $IN[1]\nXUP=XP1\nENDWHILE\nLIN XUP\n"), None);
}

#[test]
fn what_the_ways_of_the_program_leave_open_is_not_known() {
    for lines in [
        // the list keeps what an earlier run has left
        "XUP.Z=H\nLIN XUP\n",
        "LIN XUP\nXUP=XP1\nXUP.Z=H\n",
        "IF $IN[1] THEN\nXUP=XP1\nENDIF\nXUP.Z=H\nLIN XUP\n",
        "XUP=XP1\nIF $IN[1] THEN\nXUP.Z=H\nENDIF\nLIN XUP\n",
        "XUP=XP1\nSWITCH N\nCASE 1\nXUP.Z=H\nCASE 2\nXUP.Z=G\nENDSWITCH\nLIN XUP\n",
        "XUP=XP1\nLOOP\nXUP.Z=XUP.Z+H\nLIN XUP\nENDLOOP\n",
        "XUP=XP1\nXUP.Z=H\nLOOP\nLIN XUP\nXUP.Z=G\nENDLOOP\n",
        "XUP=XP1\nXUP.Z=H\nagain:\nLIN XUP\nXUP.Z=G\nGOTO again\n",
        "XUP=XP1\nWHILE $IN[1]\nXUP.Z=H\nENDWHILE\nLIN XUP\n",
        "XUP=XP1\nFOR I=1 TO N\nXUP.Z=H\nENDFOR\nLIN XUP\n",
        "XUP=XP1\nFOR N=1 TO 3\nXUP.Z=N\nLIN XUP\nENDFOR\n",
        "XUP=XP1\nREPEAT\nXUP.Z=XUP.Z+1\nUNTIL $IN[1]\nLIN XUP\n",
        "XUP=XP1\nN=N+1\nXUP.Z=N\nLIN XUP\n",
        "XUP=XP1\nIF $IN[1] THEN\nGOTO over\nENDIF\nXUP.Z=H\nover:\nLIN XUP\n",
    ] {
        let m = moves(of(lines).as_ref());
        assert!(is_open(&m[0].1), "{lines}");
    }
}

#[test]
fn what_anything_else_may_change_is_not_known() {
    let sub = "DEF sub()\nXUP.Z=5\nH=6\nEND\n";
    for lines in [
        "sub2(XUP)\nXUP=XP1\nLIN XUP\n",
        "XUP=XP1\nXUP.Z=H\nLIN XUP\nsub2(H)\n",
        "XUP=XP1\nXUP.Z=H\nLIN XUP\nI=INVERSE(XP1,XA,H)\n",
        "INTERRUPT DECL 3 WHEN $IN[1]==TRUE DO sub()\nINTERRUPT ON 3\nXUP=XP1\nXUP.X=1\nLIN XUP\n",
        "INTERRUPT DECL 3 WHEN $IN[1]==TRUE DO XUP.Z=1\nXUP=XP1\nXUP.X=1\nLIN XUP\n",
        "XUP=XP1\nXUP.X=1\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO sub() PRIO=-1\nLIN XP1\nLIN XUP\n",
        "XUP=XP1\nXUP.X=1\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO H=1\nLIN XP1\nXUP.Z=H\nLIN XUP\n",
        "XUP=XP1\nXUP.X=1\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO XUP.Z=1\nLIN XP1\nLIN XUP\n",
        "XUP=XP1\nANIN ON H=1.0*SIG+0\nXUP.Z=H\nLIN XUP\n",
        "XUP=XP1\nXUP.Z=H\nLIN XUP\nRESUME\n",
        "XUP=XP1\nON_ERROR_PROCEED\nXUP.Z=H\nLIN XUP\n",
        "IMPORT REAL Q IS /R1/Program/P..H\nXUP=XP1\nXUP.Z=H\nLIN XUP\n",
    ] {
        let d = program(&format!("DEF p()\n{lines}END\n{sub}"));
        assert!(moves(d.as_ref()).last().is_some_and(|m| is_open(&m.1)), "{lines}");
    }
    // a structure of a routine that has the name of the point is another variable
    let d = program("DEF p()\nXUP=XP1\nXUP.X=1\nsub()\nLIN XUP\nEND\nDEF sub()\nDECL OWN_T XUP\nXUP.Z=5\nEND\n");
    assert!(is_open(&moves(d.as_ref())[0].1));
    // what an interrupt calls is of no file, or resumes the program
    let of = |sub: &str| {
        let src = "DEF p()\nINTERRUPT DECL 3 WHEN $IN[1] DO isr()\nXUP=XP1\nXUP.X=1\nLIN XUP\nEND\n";
        let own = [("p.src", src), ("p.dat", DAT)].map(|(n, t)| Text::new(n, t.as_bytes().to_vec()));
        let d =
            Krl.parse(own.into_iter().chain([Text::of_context("i.src", sub.as_bytes().to_vec())]).collect(), &kr120());
        is_open(&moves(d.unwrap().as_ref())[0].1)
    };
    assert!(!of("DEF isr()\n$OUT[1]=TRUE\nEND\nDEF other()\nRESUME\nEND\n"));
    assert!(
        of("DEF other()\nEND\n") && of("DEF isr()\nRESUME\nEND\n") && of("DEF isr()\nb()\nEND\nDEF b()\nRESUME\nEND\n")
    );
    // a routine that an interrupt calls calls what no file has, or the program by a routine of another file
    assert!(of("DEF isr()\nb()\nEND\n"));
    assert!(of("DEF isr()\np()\nEND\n"));
    // parameters may be anything of their callers
    let d = program(
        "DEF p()\nsub(XP1,H)\nEND\nDEF sub(L:OUT,Q:IN)\nDECL E6POS L\nDECL REAL Q\nL=XFAR\nL.Z=Q\nQ=1\nL=XA\nLIN L\nEND\n",
    );
    assert!(is_open(&moves(d.as_ref())[0].1));
    let d = program("DEF p()\nsub(XP1,H)\nEND\nDEF sub(L:OUT,Q:IN)\nDECL E6POS L\nL=P[1]\nL.Z=1\nLIN L\nEND\n");
    assert!(is_open(&moves(d.as_ref())[0].1));
}

#[test]
fn what_is_no_plain_expression_or_of_another_type_is_not_known() {
    for value in ["N/3", "7/2*1.0", "f(H)", "K[1]", "$VEL.CP", "H+", "Q", "XP1.S", "XP1.E1", "1001*N", "1E3"] {
        let m = moves(of(&format!("XUP=XP1\nXUP.Z={value}\nLIN XUP\n")).as_ref());
        assert!(is_open(&m[0].1), "{value}");
    }
    for whole in ["F", "P[N]", "XP1:XP1", "$POS_ACT", "P", "{Z 5}", "XA", "f(XP1)"] {
        let m = moves(of(&format!("XUP=XP1\nXUP={whole}\nXUP.X=1\nLIN XUP\n")).as_ref());
        assert!(is_open(&m[0].1), "{whole}");
    }
    for part in ["Q", "A1", "S", "T"] {
        let m = moves(of(&format!("XUP=XP1\nXUP.{part}=-1.5\nLIN XUP\n")).as_ref());
        assert!(is_open(&m[0].1), "{part}");
    }
    // an INT takes no decimals
    let m = moves(of("N=1.5\nXUP=XP1\nXUP.Z=N\nLIN XUP\n").as_ref());
    assert!(is_open(&m[0].1));
    // what an aggregate leaves out may stand there from before
    let m = moves(of("XUP=XP1\nXUP={X 1,Y 2,Z 3,A 0,B 0,C 0}\nXUP.E1=3\nLIN XUP\n").as_ref());
    assert!(is_open(&m[0].1));
}

#[test]
fn values_of_all_modules_are_known_in_a_whole_project_that_leaves_them() {
    let config = "DEFDAT $CONFIG\nDECL E6POS XALL={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0}\nDECL E6POS XTO\nDECL REAL HIGH=800.0\nENDDAT\n";
    let of = |lines: &str, others: &[(&str, &str)]| {
        let src = format!("DEF p( )\n{lines}END\n");
        let own = [("p.src", src.as_str()), ("p.dat", "DEFDAT p\nDECL E6POS L\nENDDAT\n")];
        let own = own.map(|(n, t)| Text::new(n, t.as_bytes().to_vec()));
        let more = others.iter().map(|(n, t)| Text::of_context(*n, t.as_bytes().to_vec()));
        let d = Krl.parse(own.into_iter().chain(more).collect(), &kr120()).unwrap();
        position(d.as_ref(), 0)
    };
    let (lines, config) = ("L=XALL\nL.Z=HIGH\nLIN L\n", ("$config.dat", config));
    assert_eq!(of(lines, &[config]), Some([1.0, 2.0, 800.0]));
    for teach in [
        "HIGH=5\n",
        "f(HIGH)\n",
        "XALL.Z=1\n",
        "FOR HIGH=1 TO 2\nENDFOR\n",
        "IMPORT REAL Q IS /R1/System/$config..HIGH\n",
    ] {
        let teach = format!("DEF teach( )\n{teach}END\n");
        assert_eq!(of(lines, &[config, ("teach.src", &teach)]), None, "{teach}");
    }
    assert_eq!(of(lines, &[config, ("a.dat", "DEFDAT a PUBLIC\nDECL GLOBAL REAL HIGH=3\nENDDAT\n")]), None);
    assert_eq!(
        of(
            lines,
            &[(
                "all.dat",
                "DEFDAT all PUBLIC\nDECL GLOBAL REAL HIGH=3\nDECL GLOBAL E6POS XALL={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0}\nENDDAT\n"
            )]
        ),
        None
    );
    // one of all modules that the program assigns: what no file has may change it
    assert_eq!(of("XTO=XALL\nXTO.Z=HIGH\nLIN XTO\n", &[config]), Some([1.0, 2.0, 800.0]));
    assert_eq!(of("XTO=XALL\nXTO.Z=HIGH\nelsewhere()\nLIN XTO\n", &[config]), None);
    assert_eq!(of("XTO=XALL\nIF elsewhere() THEN\nI=1\nELSE\nLIN XTO\nENDIF\n", &[config]), None);
    let sub = ("sub.src", "DEF sub( )\nPTP XALL\nEND\n");
    assert_eq!(of("XTO=XALL\nXTO.Z=HIGH\nsub()\nLIN XTO\n", &[config, sub]), Some([1.0, 2.0, 800.0]));
    let sub = ("sub.src", "DEF sub( )\nXTO.Z=1\nEND\n");
    assert_eq!(of("XTO=XALL\nXTO.Z=HIGH\nsub()\nLIN XTO\n", &[config, sub]), None);
    let sub = ("sub.src", "DEF sub( )\nelsewhere()\nEND\n");
    assert_eq!(of("XTO=XALL\nXTO.Z=HIGH\nsub()\nLIN XTO\n", &[config, sub]), None);
    // what another file runs beside the program may call what it sees of it
    let lines = "L=XALL\nL.Z=L.Z+1\nLIN L\nEND\nGLOBAL DEF seth( )\nL.Z=0\n";
    assert_eq!(of(lines, &[config]), Some([1.0, 2.0, 4.0]));
    for (name, other) in [
        ("b.src", "DEF b( )\nINTERRUPT DECL 3 WHEN $IN[1] DO seth( )\nINTERRUPT ON 3\np( )\nEND\n"),
        ("b.src", "DEF b( )\nGLOBAL INTERRUPT DECL 3 WHEN $IN[1] DO between( )\nEND\nDEF between( )\nseth( )\nEND\n"),
        ("b.src", "DEF b( )\nTRIGGER WHEN DISTANCE=0 DELAY=0 DO seth( )\nPTP XALL\np( )\nEND\n"),
        ("b.sub", "DEF b( )\nLOOP\nseth( )\nENDLOOP\nEND\n"),
    ] {
        assert_eq!(of(lines, &[config, (name, other)]), None, "{other}");
        assert_eq!(of(&lines.replace("GLOBAL ", ""), &[config, (name, other)]), Some([1.0, 2.0, 4.0]), "{other}");
    }
    // it calls the program again
    let sub = ("sub.src", "DEF sub( )\np()\nEND\n");
    assert_eq!(of("XTO=XALL\nsub()\nXTO.Z=HIGH\nLIN XTO\n", &[config, sub]), None);
}

/// New numbers of the pose of a move, by mm in Z.
fn higher(doc: &dyn Document, i: usize, mm: f64) -> Edits {
    let (k, m) = &moves(doc)[i];
    let t = m.goal.target().unwrap();
    let mut q: Vec<f64> = doc.script().targets.get(t).unwrap().values.iter().map(|v| v.unwrap().si).collect();
    q[2] += mm * 1e-3;
    let mut edits = Edits { pose_digit: [1e-6, 1e-6], ..edits(doc, &[], &[]) };
    edits.steps.change_or_insert(*k, |e| e.goal = Some(q));
    edits
}

#[test]
fn a_computed_goal_is_written_in_line_and_its_point_stays() {
    let d = of("XUP=XP1\nXUP.Z=XUP.Z+H\nLIN XUP C_DIS\nLIN XP1\nLIN XUP\n");
    let after = rewrite(d.as_ref(), &higher(d.as_ref(), 0, 0.25));
    let out = text(after.as_ref(), 0);
    let line = "LIN {X 500.0,Y 20.5,Z 950.250,A 0.0,B 90.0,C 0.0,S 2,T 3} C_DIS\nLIN XP1\nLIN XUP\n";
    assert!(out.contains(&format!("XUP=XP1\nXUP.Z=XUP.Z+H\n{line}")), "{out}");
    assert_eq!(text(after.as_ref(), 1), DAT);
    // the point from which it is copied parts as it is read
    let after = rewrite(d.as_ref(), &higher(d.as_ref(), 1, 0.25));
    assert!(
        text(after.as_ref(), 0).contains("XUP=XP1\nXUP.Z=XUP.Z+H\nLIN XUP C_DIS\nLIN XP1_2\n"),
        "{}",
        text(after.as_ref(), 0)
    );
    let d = of("XB=XA\nXB.A1=XB.A1+N\nPTP {A1 0}\nPTP XB C_PTP\n");
    let k = moves(d.as_ref())[1].0;
    let after = text(rewrite(d.as_ref(), &edits(d.as_ref(), &[(k, 0.01)], &[k])).as_ref(), 0);
    let new = "PTP {A1 0.2500,A2 -89.5000,A3 90.0,A4 0.0,A5 1.0000,A6 179.9999} C_PTP\n";
    assert!(
        after.contains(&format!("{new}PTP {{A1 5.0100,A2 -89.9900,A3 90.0100,A4 0.0100,A5 5.0100,A6 0.0100}} C_PTP\n")),
        "{after}"
    );
}

#[test]
fn a_computed_goal_of_an_inline_form_is_known_and_stays() {
    let form = ";FOLD LIN UP Vel=1 m/s CPDAT1;%{PE}%R 8.3.44,%MKUKATPBASIS,%CMOVE,%VLIN,%P 1:LIN, 2:UP, 3:, 5:1, 7:CPDAT1\n\
                LDAT_ACT=LCPDAT1\nFDAT_ACT=FUP\nBAS(#CP_PARAMS,1)\nLIN XUP\n;ENDFOLD\n";
    let d = of(&format!("XUP=XP1\nXUP.Z=H\n{form}"));
    assert_eq!(position(d.as_ref(), 0), Some([500.0, 20.5, 50.0]));
    let m = moves(d.as_ref());
    assert_eq!(m[0].1.fixed, Some(crate::krl::Reason::ComputedInForm("XUP".into()).into()));
    assert!(d.patches(&higher(d.as_ref(), 0, 0.25)).is_err());
}
