//! Subprograms, loops and conditions: what a script says of the order of its steps, and of what stands after calls.

use super::*;

const HEAD_OF_TEXT: &str = "G21 G90 G17\nG0 X0.0 Y0.0 Z0.0\n";

/// Lines (from 1) of the breaks that are joins, and of the last moves before the places from which control comes there; 0: none, as it is a
/// break.
fn joins(text: &str) -> Vec<(u64, Vec<u64>)> {
    let script = script_of(&Gcode, text, &robot());
    let line = |k: usize| script.steps[k].at.line;
    let last = |k: &usize| match k.checked_sub(1).map(|n| &script.steps[n]) {
        Some(step) if matches!(step.kind, StepKind::Move(_)) => step.at.line,
        _ => 0,
    };
    script.joins.iter().map(|j| (line(j.at), j.from.iter().map(last).collect())).collect()
}

/// Lines of loops of which every pass is alike, first and last.
fn rounds(text: &str) -> Vec<(u64, u64)> {
    let script = script_of(&Gcode, text, &robot());
    let line = |k: usize| script.steps[k].at.line;
    script.rounds.iter().map(|r| (line(r.open), line(r.close))).collect()
}

#[test]
fn a_subprogram_is_entered_from_its_calls_and_what_stands_after_them_from_its_end() {
    let main = format!("{HEAD_OF_TEXT}M98 P100\nG0 X5.0\nM98 P0100\nG0 X6.0 Y1.0\nM30\n");
    let text = format!("{main}O100\nG1 X1.0 F100\nG1 Y2.0\nM99\n");
    assert_eq!(joins(&text), [(3, vec![10]), (5, vec![10]), (8, vec![2, 4])]);
    let text = "G21 G90 G17\no100 sub\nG1 X1.0 F100\no100 endsub\nG0 X0.0 Y0.0 Z0.0\no100 call\nG0 X6.0\nM2\n";
    assert_eq!(joins(text), [(2, vec![5]), (4, vec![0]), (6, vec![3])]);
    // a call in a subprogram
    let text = format!("{HEAD_OF_TEXT}M98 P1\nM30\nO1\nG0 X1.0\nM98 P2\nG0 X2.0\nM99\nO2\nG0 Y1.0\nM99\n");
    assert_eq!(joins(&text), [(3, vec![8]), (5, vec![2]), (7, vec![11]), (10, vec![6])]);
}

#[test]
fn of_a_call_that_may_not_run_once_or_may_run_another_text_nothing_is_known() {
    let sub = "O100\nG1 X1.0 F100\nM99\n";
    let of = |call: &str| joins(&format!("{HEAD_OF_TEXT}{call}\nG0 X5.0\nM30\n{sub}"));
    assert_eq!(of("M98 P100"), [(3, vec![7]), (6, vec![2])]);
    // it runs from its own end, too
    assert_eq!(of("M98 P100 L3"), [(3, vec![7])]);
    assert_eq!(of("M98 P100 L1"), of("M98 P100"));
    for call in [
        "M98 P100 L0",
        "M98 P100 L#1",
        "M98 P30100",
        "M98 P200",
        "M98 P#1",
        "/M98 P100",
        "G65 P100",
        "M98 P100\nG65 P9000",
        "M98 P100 Q5",
        "M97 P100",
        "o100 call",
        "M98 P100\nN5 GOTO 5",
        "M98 P100\nIF [#1 EQ 2] GOTO 5",
        "M198 P100",
        "M99 P5",
        "M98 P100\n/M30",
        "M98 P100\nG66 P9000",
        "M98 P100\nPOCKET3(1)",
        "M98 P100\n#3005=1",
        "M98 P100 M99",
    ] {
        assert_eq!(of(call), [], "{call}");
    }
    for tail in [
        // no end, two of one name, an end in a loop, a subprogram into which the program runs
        "M30\nO100\nG1 X1.0 F100\n",
        "M30\nO100\nG1 X1.0 F100\nM99\nO100\nG1 X2.0\nM99\n",
        "M30\nO100\nG1 X1.0 F100\nWHILE [#1 LT 2] DO1\nM99\nEND1\nM99\n",
        "O100\nG1 X1.0 F100\nM99\n",
        "M30\nO100\nG1 X1.0 F100\n/M99\nM99\n",
        "M30\nO100\nG1 X1.0 F100\nM99 P7\n",
    ] {
        let text = format!("{HEAD_OF_TEXT}M98 P100\nG0 X5.0\n{tail}");
        assert!(joins(&text).iter().all(|j| j.0 != 3 && j.0 != 6), "{tail}: {:?}", joins(&text));
    }
    // LinuxCNC looks for what it has not met in a file
    let text = format!("{HEAD_OF_TEXT}o100 call\nG0 X5.0\no100 sub\nG1 X1.0\no100 endsub\nM2\n");
    assert_eq!(joins(&text), [(7, vec![4])]);
    for word in ["o100 return", "o1 break", "o1 continue"] {
        let text = format!("{HEAD_OF_TEXT}o100 sub\nG1 X1.0\n{word}\no100 endsub\no100 call\nG0 X5.0\nM2\n");
        assert_eq!(joins(&text), [], "{word}");
    }
}

#[test]
fn where_numbers_may_count_from_another_origin_nothing_is_known_of_the_order() {
    let text = |first: &str, sub: &str, last: &str| {
        format!("G21 G90 G17{first}\nG0 X0.0 Y0.0 Z0.0\nM98 P100\n{last}G0 X5.0\nM30\nO100\n{sub}G1 X1.0 F100\nM99\n")
    };
    for (first, sub, last) in
        [("", "", ""), (" G54", "", ""), (" G55", "", ""), (" G55", "G55\n", "G55\n"), ("", "G54\n", "")]
    {
        assert!(joins(&text(first, sub, last)).iter().any(|j| j.0 == 3), "{first} {sub} {last}");
    }
    for (first, sub, last) in [
        ("", "G55\n", ""),
        ("", "", "G55\n"),
        (" G54", "G55\n", ""),
        ("", "G92 X0.0\n", ""),
        ("", "G52 X1.0\n", ""),
        ("", "", "G10 L2 P1 X5.0\n"),
        (" G54.1 P1", "", "G54.1 P2\n"),
        ("", "G154 P1\n", ""),
    ] {
        assert_eq!(joins(&text(first, sub, last)), [], "{first} {sub} {last}");
    }
    // in a definition the work frame is that of its calls
    let text = |first: &str| {
        format!(
            "G21 G90 G17\no100 sub\nG55\nG1 X1.0 F100\no100 endsub\n{first}G0 X0.0 Y0.0 Z0.0\no100 call\nG55\nG0 X6.0\nM2\n"
        )
    };
    assert_eq!(joins(&text("")), []);
    assert!(!joins(&text("G55\n")).is_empty());
    let breaks = |text: &str| {
        let script = script_of(&Gcode, text, &robot());
        script.steps.iter().filter(|s| matches!(s.kind, StepKind::Break(Break::Frame))).count()
    };
    assert_eq!([breaks(&text("")), breaks(&text("G55\n"))], [2, 2]);
}

#[test]
fn loops_are_entered_from_above_and_from_their_ends() {
    let text = |head: &str, end: &str| format!("{HEAD_OF_TEXT}{head}\nG1 X5.0 F100\n{end}\nG1 X6.0\n");
    let [line, after] = [3, 5];
    for (head, end, entered) in [
        ("WHILE [#1 LT 3] DO1", "END1", false),
        ("WHILE [1 LT 3] DO1", "END1", true),
        ("WHILE [3 LT 1] DO2", "END2", false),
        ("o1 while [#1 lt 3]", "o1 endwhile", false),
        ("o1 repeat [3]", "o1 endrepeat", true),
        ("o1 repeat [0]", "o1 endrepeat", false),
        ("o1 repeat [#1]", "o1 endrepeat", false),
        ("o1 do", "o1 while [#1 lt 3]", true),
    ] {
        let text = text(head, end);
        let from = if entered { vec![4] } else { vec![2, 4] };
        assert_eq!(joins(&text), [(line, vec![2, 4]), (after, from)], "{head}");
        assert_eq!(rounds(&text), if entered { vec![(3, 5)] } else { vec![] }, "{head}");
    }
    // the variable is known where the loop begins
    let text = format!("#1=1\n{}", text("WHILE [#1 LE 3] DO1", "#1=#1+1\nEND1"));
    assert_eq!(rounds(&text), [(4, 7)]);
    for (head, end) in
        [("WHILE [#1 LT 3] DO1", "END2"), ("WHILE [#1 LT 3] DO1", ""), ("o1 while [1]", "o2 endwhile"), ("", "END1")]
    {
        let text = format!("{HEAD_OF_TEXT}{head}\nG1 X5.0 F100\n{end}\nG1 X6.0\n");
        assert_eq!((joins(&text), rounds(&text)), (vec![], vec![]), "{head} {end}");
    }
    // a loop with a break in it is none whose passes are known to be alike
    let text = format!("{HEAD_OF_TEXT}o1 repeat [3]\nG1 X5.0 F100\nM6 T1\no1 endrepeat\n");
    assert_eq!(rounds(&text), []);
}

#[test]
fn branches_are_reached_from_their_condition_and_their_end_from_all_of_them() {
    let text = format!("{HEAD_OF_TEXT}o1 if [#1 eq 2]\nG1 X5.0 F100\no1 else\nG1 X6.0\no1 endif\nG1 X7.0\n");
    assert_eq!(joins(&text), [(3, vec![2]), (5, vec![2]), (7, vec![4, 6])]);
    let text =
        format!("{HEAD_OF_TEXT}o1 if [#1 eq 2]\nG1 X5.0 F100\no1 elseif [#1 eq 3]\nG1 X6.0\no1 endif\nG1 X7.0\n");
    assert_eq!(joins(&text)[2], (7, vec![2, 4, 6]));
    assert_eq!(joins(&format!("{HEAD_OF_TEXT}IF [#1 EQ 2] THEN #2=3\nG1 X7.0\n")), [(3, vec![2])]);
    for line in [
        "IF [#1 EQ 2] THEN",
        "IF [#1 EQ 2] GOTO 3",
        "IF [#1 EQ 2] THEN G91",
        "o1 else",
        "o1 endif",
        "/IF [#1 EQ 2] THEN #2=3",
    ] {
        assert_eq!(joins(&format!("{HEAD_OF_TEXT}{line}\nG1 X7.0\n")), [], "{line}");
    }
}

#[test]
fn modes_after_a_call_are_those_that_the_subprogram_sets_last() {
    let after = |sub: &str, call: &str| {
        let text =
            format!("{HEAD_OF_TEXT}{call}\nG0 X5.0 Y1.0 Z1.0\nX6.0\nM30\nO100\n{sub}\nM99\nO200\nG0 X3.0\nM99\n");
        goals(&text).get(1).cloned().flatten().map(|q| q[0])
    };
    assert_eq!(after("G1 X1.0", "M98 P100"), Some(5.0));
    assert_eq!(after("G91 G1 X1.0\nG90", "M98 P100"), Some(5.0));
    assert_eq!(after("G91 G1 X1.0\nG90", "M98 P100 L4"), Some(5.0));
    assert_eq!(after("G20 G1 X1.0", "M98 P100"), Some(127.0));
    assert_eq!(after("G20 G1 X1.0", "M98 P200"), Some(5.0));
    for sub in [
        "G91 G1 X1.0",
        "/G91\nG90 G1 X1.0\n/G91",
        "G90\nM98 P200\nG91",
        "G90 G1 X1.0\nWHILE [#1 LT 2] DO1\nG91\nEND1\nG90",
        "G91 G1 X1.0\nIF [#1 EQ 1] THEN #2=1\nG90",
    ] {
        assert_eq!(after(sub, "M98 P100"), None, "{sub}");
    }
    for call in ["M98 P100 L#1", "M98 P100 L0", "M98 P#1", "M98 P100\nG65 P9000"] {
        assert_eq!(after("G91 G1 X1.0\nG90", call), None, "{call}");
    }
    // at its start those of all its calls
    let first = |before: &str| {
        let text =
            format!("{HEAD_OF_TEXT}M98 P100\n{before}M98 P100\nG90\nM30\nO100\nG1 X5.0\nG91\nG1 X1.0\nG90\nM99\n");
        opaque(&text).is_empty() || goals(&text).iter().rev().nth(1).is_some_and(Option::is_some)
    };
    assert!(first("") && !first("G91\n"));
    // a definition that the program passes leaves its modes
    let text = "G21 G90 G17\no1 sub\nG91 G1 X1.0\no1 endsub\nG0 X2.0 Y0.0 Z0.0\nM2\n";
    assert_eq!(goals(text).last().cloned().flatten().map(|q| q[0]), Some(2.0));
}

#[test]
fn a_definition_in_front_of_its_calls_has_their_modes() {
    let of = |subs: &str, head: &str, calls: &str| {
        let text = format!("{subs}{head}G0 X0.0 Y0.0 Z0.0\n{calls}M2\n");
        goals(&text).iter().map(|q| q.as_ref().map(|q| q[0])).collect::<Vec<_>>()
    };
    let (sub, head) = ("o100 sub\nG1 X1.0 F100\nG1 X2.0\no100 endsub\n", "G21 G90 G17\n");
    assert_eq!(of(sub, head, "o100 call\nG0 X5.0\n"), [Some(1.0), Some(2.0), Some(0.0), Some(5.0)]);
    assert_eq!(of(sub, "G20 G90 G17\n", "o100 call\nG0 X5.0\n")[0], Some(25.4));
    // a definition that calls one above it, three of them
    let chain =
        "o1 sub\nG1 X1.0 F100\no1 endsub\no2 sub\no1 call\no2 endsub\no3 sub\nG1 X3.0 F100\no2 call\no3 endsub\n";
    assert_eq!(of(chain, head, "o3 call\nG0 X5.0\n"), [Some(1.0), Some(3.0), Some(0.0), Some(5.0)]);
    assert_eq!(of(sub, head, "/o100 call\nG0 X5.0\n")[0], Some(1.0));
    // calls in modes that differ, one from itself, and one of a text elsewhere
    for calls in ["o100 call\nG91\no100 call\nG90\n", "o100 call\no200 call\n"] {
        assert_eq!(of(sub, head, calls)[0], None, "{calls}");
    }
    let own = "o100 sub\nG1 X1.0 F100\no1 if [#1 gt 0]\nG91\no100 call\no1 endif\no100 endsub\n";
    assert_eq!(of(own, head, "o100 call\nG0 X5.0\n")[0], None);
    // what a call finds, and what the definition leaves
    let relative = "o100 sub\nG1 X1.0 F100\nG91\nG1 X1.0\no100 endsub\n";
    assert_eq!(of(relative, head, "o100 call\nG90\nG0 X5.0\n")[0], Some(1.0));
    assert_eq!(of(relative, head, "o100 call\no100 call\nG90\nG0 X5.0\n")[0], None);
}

#[test]
fn a_program_starts_after_its_number_and_after_definitions() {
    let entry = |text: &str| {
        let script = script_of(&Gcode, text, &robot());
        script.entry.map(|k| script.steps[k].at.line)
    };
    assert_eq!(entry("%\nO1000\nG21 G90\nG0 X1.0\nM30\n%\n"), Some(2));
    assert_eq!(entry("G21 G90\no1 sub\nG0 X1.0\no1 endsub\no2 sub\nG0 X1.0\no2 endsub\nG0 X1.0\nM2\n"), Some(7));
    assert_eq!(entry("G21 G90\nG0 X1.0\nM30\n%\n"), None);
    // it runs again, it has moved, another calls it
    assert_eq!(entry("O1000\nG21 G90\nG0 X1.0\nM99\n"), None);
    assert_eq!(entry("G21 G90\nG0 X2.0\no1 sub\nG0 X1.0\no1 endsub\nG0 X1.0\nM2\n"), None);
    assert_eq!(entry("O1\nG21 G90\nG0 X1.0\nM30\nO2\nM98 P1\nM99\n"), None);
}
