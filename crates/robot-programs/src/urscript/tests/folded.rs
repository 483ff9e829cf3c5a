//! Targets that are computed from constants, and what may differ each time.

use super::*;

/// Numbers of the target of a move, if it can be edited.
fn numbers(source: &str, n: usize) -> Option<Vec<f64>> {
    let doc = document(source);
    let (_, m) = doc.script().moves().nth(n).unwrap();
    let target = doc.script().targets.get(m.goal.target()?)?;
    target.values.iter().map(|v| v.map(|v| v.si)).collect()
}

/// Whether a move has these numbers.
fn is(source: &str, n: usize, expected: &[f64]) {
    let found = numbers(source, n).unwrap_or_else(|| panic!("{source}: {}", opaque(&moves(source)[n])));
    let near = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-11);
    assert!(near, "{source}: {found:?}");
}

/// Why the last move stays.
fn why(source: &str) -> String {
    opaque(moves(source).last().unwrap())
}

const A: &str = "p[-0.691, -0.4174, 0.688, -1.2, 0.7, 0.3]";
const B: &str = "p[0.1, -0.02, 0.05, 0.4, -0.3, 1.1]";

const TRANS: [f64; 6] =
    [-0.587415399392, -0.392856629198, 0.648403870560, -0.278654317407, 1.042402083283, 1.163353517768];
const INV: [f64; 6] =
    [0.900976903028, 0.273118818495, 0.488563702290, 1.200000000000, -0.700000000000, -0.300000000000];
const INTERP: [f64; 6] =
    [-0.493250000000, -0.318050000000, 0.528500000000, -0.821138104863, 0.459664044024, 0.553281834844];
const TRANS_INV: [f64; 6] =
    [0.947510305517, 0.172427851965, 0.512976234152, 0.972643667486, -1.617041135459, 0.619746941580];

/// The numbers are those of rotation matrices, by another program.
#[test]
fn poses_are_computed_as_the_controller_does() {
    for (expression, expected) in [
        ("pose_trans(a, b)", TRANS),
        ("pose_inv(a)", INV),
        ("interpolate_pose(a, b, 0.25)", INTERP),
        ("pose_trans(pose_inv(a), b)", TRANS_INV),
        ("pose_add(a, p[0.1, 0, -0.2, 0, 0, 0])", [-0.591, -0.4174, 0.488, -1.2, 0.7, 0.3]),
        ("pose_sub(a, p[0.1, 0, -0.2, 0, 0, 0])", [-0.791, -0.4174, 0.888, -1.2, 0.7, 0.3]),
    ] {
        is(&format!("def m():\n a = {A}\n b = {B}\n c = {expression}\n movel(c)\nend\n"), 0, &expected);
    }
    for unsure in
        ["pose_add(a, b)", "pose_sub(a, b)", "interpolate_pose(p[0,0,0,3.141592653589793,0,0], p[0,0,0,0,0,0], 0.5)"]
    {
        let source = format!("def m():\n a = {A}\n b = {B}\n c = {unsure}\n movel(c)\nend\n");
        assert!(why(&source).contains("no list"), "{unsure}");
    }
}

#[test]
fn a_move_to_a_computed_name_gets_the_pose_itself_and_nothing_else_changes() {
    let source = "def m():\n  pick = p[0.500000, -0.2, 0.3, 0, 0, 0]\n  above = pose_trans(pick, p[0, 0, -0.05, 0, 0, 0])\n  movel(above, a=1.2, v=0.2)\n  movel(pick)\n  movel(above)\nend\n";
    is(source, 0, &[0.5, -0.2, 0.25, 0.0, 0.0, 0.0]);
    let out = rewritten(source, &shifted(source, &[(0, 1e-4)]));
    assert_eq!(out, source.replace("movel(above, a", "movel(p[0.500100, -0.2, 0.25, 0, 0, 0], a"));
    // the point below has a copy, as the point above is made of it
    let out = rewritten(source, &shifted(source, &[(1, 1e-4)]));
    let copy = "  pick_lm1 = p[0.500100, -0.2, 0.3, 0, 0, 0]\n";
    assert!(out.contains(copy) && out.contains("movel(pick_lm1)\n  movel(above)"), "{out}");
    // of what a controller solves, the pose alone
    let solved = source.replace("movel(above, ", "movej(get_inverse_kin(above), ");
    let out = rewritten(&solved, &shifted(&solved, &[(0, 1e-4)]));
    assert!(out.contains("movej(get_inverse_kin(p[0.500100, -0.2, 0.25, 0, 0, 0]), a=1.2"), "{out}");
}

#[test]
fn elements_lists_structures_and_arithmetic_with_names_fold() {
    for (before, target, expected) in [
        (
            "a = p[1,2,3,0,0,0]",
            "p[a[0], a[1], a[2] + 0.1, 0, 0, d2r(180)]",
            [1.0, 2.0, 3.1, 0.0, 0.0, std::f64::consts::PI],
        ),
        ("h = 0.05\n k = -h * 2", "p[0.1 + h, (k - h) / 3, 0, 0, 0, 0]", [0.15, -0.05, 0.0, 0.0, 0.0, 0.0]),
        ("l = [p[1,0,0,0,0,0], p[2,0,0,0,0,0]]\n i = 1", "l[i]", [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ("s = struct(a=p[1,0,0,0,0,0], b=p[2,0,0,0,0,0])", "s.b", [2.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ("h = 0.05", "pose_add(p[1,0,0,0,0,0], p[0,0,h,0,0,0])", [1.0, 0.0, 0.05, 0.0, 0.0, 0.0]),
    ] {
        is(&format!("def m():\n {before}\n movel({target})\nend\n"), 0, &expected);
    }
    let joints = "def m():\n q = [0.1, -1.5, 1.2, -2, 0.5, 3]\n movej([q[0], q[1] + 0.25, d2r(90), q[3], q[4], q[5]], a=1)\nend\n";
    is(joints, 0, &[0.1, -1.25, std::f64::consts::FRAC_PI_2, -2.0, 0.5, 3.0]);
    let out = rewritten(joints, &shifted(joints, &[(0, 1e-3)]));
    assert!(out.contains("movej([0.101000, -1.25, 1.570796326795, -2, 0.5, 3], a=1)"), "{out}");
    let point = rewritten(joints, &inserted(joints, 0, &[0.5], 0.01));
    assert!(point.contains("movej([0.500000, -1.25, 1.570796326795, -2, 0.5, 3], a=1)\n movej([q[0],"), "{point}");
    // what the controller makes of whole numbers that do not divide, and what is no number
    for other in ["p[n/3,0,0,0,0,0]", "p[h,0,0,0,0,0]", "l[2]", "l[-1]", "l[0.5]", "s.c", "sin(1)", "p[1,2]", "l"] {
        let source = format!("def m():\n l = [1, 2]\n s = struct(a=1)\n n = 1\n x = {other}\n movel(x)\nend\n");
        assert!(numbers(&source, 0).is_none(), "{other}");
    }
}

#[test]
fn a_name_that_is_assigned_again_counts_with_what_it_holds_there() {
    let two = format!("def m():\n  q = {A}\n  movel(q)\n  q = {B}\n  movel(q, a=1)\nend\n");
    is(&two, 0, &[-0.691, -0.4174, 0.688, -1.2, 0.7, 0.3]);
    is(&two, 1, &[0.1, -0.02, 0.05, 0.4, -0.3, 1.1]);
    let out = rewritten(&two, &shifted(&two, &[(1, 1e-4)]));
    assert_eq!(out, two.replace("movel(q, a=1)", "movel(p[0.100100, -0.02, 0.05, 0.4, -0.3, 1.1], a=1)"));
    // an element, once and in a row
    let part = "def m():\n q = p[1,2,3,0,0,0]\n q[2] = q[2] + 0.5\n movel(q)\n q[0] = 0\n movel(q)\nend\n";
    is(part, 0, &[1.0, 2.0, 3.5, 0.0, 0.0, 0.0]);
    is(part, 1, &[0.0, 2.0, 3.5, 0.0, 0.0, 0.0]);
    // in both branches, and in the branch itself
    is(&format!("def m():\n if x:\n  q = {A}\n  movel(q)\n end\nend\n"), 0, &[-0.691, -0.4174, 0.688, -1.2, 0.7, 0.3]);
    is(
        "def m():\n if x:\n  q = p[1,0,0,0,0,0]\n else:\n  q = p[1,0,0,0,0,0]\n end\n movel(q)\nend\n",
        0,
        &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
    // global, where the program starts
    let begun = "global q = p[1,0,0,0,0,0]\ndef m():\n movel(q)\n global q = p[2,0,0,0,0,0]\n movel(q)\nend\nm()\n";
    is(begun, 0, &[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    is(begun, 1, &[2.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // global, set by a function that is called
    is(
        "global q = p[1,0,0,0,0,0]\ndef set():\n global q = p[2,0,0,0,0,0]\nend\ndef m():\n set()\n movel(q)\nend\nm()\n",
        0,
        &[2.0, 0.0, 0.0, 0.0, 0.0, 0.0],
    );
}

#[test]
fn what_may_differ_where_a_move_reads_it_stays() {
    let q = "p[1,0,0,0,0,0]";
    for (source, reason) in [
        // one branch, another pass of the loop, a break out of it
        (format!("def m():\n q = {q}\n if x:\n  q = {A}\n end\n movel(q)\nend\n"), "condition"),
        (format!("def m():\n q = {q}\n while x:\n  movel(q)\n  q[0] = q[0] + 0.01\n end\nend\n"), "element"),
        (format!("def m():\n q = {q}\n while x:\n  q[0] = q[0] + 0.01\n end\n movel(q)\nend\n"), "element"),
        (format!("def m():\n q = {q}\n while x:\n  movel(q)\n  q = {A}\n end\nend\n"), "more than once"),
        (format!("def m():\n l = [{q}, {A}]\n i = 0\n while i < 2:\n  movel(l[i])\n  i = i + 1\n end\nend\n"), "expression"),
        (format!("def m():\n l = [{q}, {A}]\n while x:\n  l[0] = get_actual_tcp_pose()\n  movel(l[0])\n end\nend\n"), "expression"),
        // a thread, a function within an expression, one that is not called in this order
        (format!("global q = {q}\nthread t():\n while True:\n  global q = {A}\n  sync()\n end\nend\ndef m():\n run t()\n global q = {q}\n movel(q)\nend\nm()\n"), "more than once"),
        (format!("global q = {q}\ndef f():\n global q = {A}\n return True\nend\ndef m():\n if x or f():\n  sync()\n end\n movel(q)\nend\nm()\n"), "more than once"),
        (format!("global q = {q}\ndef f():\n global q = {A}\n return {q}\nend\ndef m():\n movel(pose_trans(f(), q))\nend\nm()\n"), "expression"),
        (format!("global q = {q}\ndef f():\n movel(q)\n global q = {A}\nend\ndef m():\n f()\n f()\n movej([1,0,0,0,0,0])\nend\nm()\n").replace(" movej([1,0,0,0,0,0])\n", ""), "more than once"),
        // a name without `global` in a function, before it is global anywhere
        (format!("def m():\n q = {q}\n f()\n movel(q)\nend\ndef f():\n global q = {A}\nend\n"), "more than once"),
        // what runs decides
        ("def m():\n q = get_actual_tcp_pose()\n q[2] = 0.5\n movel(q)\nend\n".into(), "element"),
        ("def m():\n r = read_input_float_register(0)\n a = p[r,0,0,0,0,0]\n movel(a)\nend\n".into(), "no list"),
        (format!("def m():\n l = [{q}]\n l.append({A})\n movel(l[0])\nend\n"), "expression"),
        (format!("def pose_inv(a):\n return get_actual_tcp_pose()\nend\ndef m():\n movel(pose_inv({q}))\nend\nm()\n"), "expression"),
    ] {
        assert!(why(&source).contains(reason), "{source}: {}", why(&source));
    }
}

#[test]
fn a_local_name_hides_a_global_one() {
    let source =
        format!("global q = {A}\ndef f():\n local q = {B}\n movel(q)\nend\ndef m():\n f()\n movel(q)\nend\nm()\n");
    is(&source, 0, &[0.1, -0.02, 0.05, 0.4, -0.3, 1.1]);
    is(&source, 1, &[-0.691, -0.4174, 0.688, -1.2, 0.7, 0.3]);
    // a parameter is another name, and has its own value until it is assigned
    let hidden = format!(
        "q = {A}\ndef f(q):\n movel(q)\n q = {B}\n movel(q)\nend\ndef m():\n f(get_actual_tcp_pose())\nend\nm()\n"
    );
    assert!(opaque(&moves(&hidden)[0]).contains("parameter"));
    is(&hidden, 1, &[0.1, -0.02, 0.05, 0.4, -0.3, 1.1]);
}

#[test]
fn functions_that_return_poses_and_parameters_that_all_calls_give_alike_fold() {
    let returned = "def at(x, z):\n  y = 0.25\n  made = p[x, y, z, 0, 0, 0]\n  return made\nend\ndef m():\n  up = at(-0.1, 0.15)\n  movej(up)\n  movel(at(-0.1, 0.05))\nend\n";
    is(returned, 0, &[-0.1, 0.25, 0.15, 0.0, 0.0, 0.0]);
    is(returned, 1, &[-0.1, 0.25, 0.05, 0.0, 0.0, 0.0]);
    let out = rewritten(returned, &shifted(returned, &[(1, 1e-4)]));
    assert!(out.contains("movel(p[-0.099900, 0.25, 0.05, 0, 0, 0])"), "{out}");
    let of = |calls: &str| {
        format!(
            "def go(q, h):\n  movel(pose_trans(q, p[0,0,h,0,0,0]))\nend\ndef m():\n  a = p[1,0,0,0,0,0]\n{calls}end\nm()\n"
        )
    };
    is(&of("  go(a, 0.1)\n  go(p[1,0,0,0,0,0], 0.05 * 2)\n"), 0, &[1.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
    // called otherwise elsewhere, with too few, by keyword, or by nothing
    for calls in
        ["  go(a, 0.1)\n  go(a, 0.2)\n", "  go(a, 0.1)\n  x = go(a)\n", "  go(a, h=0.1)\n", "  textmsg(\"go\")\n"]
    {
        assert!(numbers(&of(calls), 0).is_none(), "{calls}");
    }
    // without `return`, with a branch, with a default, by itself, and two of one name
    for function in [
        "def f():\n p[1,0,0,0,0,0]\nend",
        "def f():\n if x:\n  return p[2,0,0,0,0,0]\n end\n return p[1,0,0,0,0,0]\nend",
        "def f(a=1):\n return p[a,0,0,0,0,0]\nend",
        "def f():\n return f()\nend",
        "def f():\n return p[1,0,0,0,0,0]\nend\ndef f():\n return p[2,0,0,0,0,0]\nend",
        "thread f():\n return p[1,0,0,0,0,0]\nend",
    ] {
        assert!(numbers(&format!("{function}\ndef m():\n movel(f())\nend\nm()\n"), 0).is_none(), "{function}");
    }
}

#[test]
fn arcs_through_computed_points_are_known() {
    let source = "def m():\n movel(p[0.4,0,0.3,0,0,0])\n h = 0.1\n movec(p[0.5,h,0.3,0,0,0], p[0.6,0,0.2 + h,0,0,0], a=1, v=0.1)\nend\n";
    let all = moves(source);
    assert!(
        matches!(&all[1].goal, Goal::Pose(g) if g.via_m.is_some_and(|v| (v.y - 0.1).abs() < 1e-12)),
        "{:?}",
        all[1]
    );
    assert!(all[1].closed.is_none());
}

/// Values that are made of each other by the hundred, and names in each other's place, take no time.
#[test]
fn long_and_deep_values_are_read() {
    let mut source = String::from("def m():\n x = 1\n a0 = p[0,0,0,0,0,0]\n");
    for k in 1..400 {
        source.push_str(&format!(" a{k} = pose_trans(a{}, a{})\n", k - 1, k - 1));
    }
    for k in 0..1000 {
        let deep = if k % 2 == 0 { 9 } else { 399 };
        source.push_str(&format!(" x = x + 1\n movel(p[x, {k}, a{deep}[0], 0, 0, 0])\n"));
    }
    source.push_str("end\n");
    let start = std::time::Instant::now();
    let read = moves(&source);
    assert_eq!(read.len(), 1000);
    // the value that x has there; what is made of too many steps is left
    for (k, x) in [(0, 2.0), (998, 1000.0)] {
        let Goal::Pose(goal) = &read[k].goal else { panic!("{k}: {:?}", read[k].goal) };
        assert_eq!((goal.position_m.x, goal.position_m.y), (x, k as f64));
    }
    for k in [1, 999] {
        assert!(matches!(read[k].goal, Goal::Opaque(_)), "{k}: {:?}", read[k].goal);
    }
    // one that is made of many before it, of which no move asks
    let row = format!("def m():\n x = 1\n{} movel(p[x, 0, 0, 0, 0, 0])\nend\n", " x = x + 1\n".repeat(100_000));
    assert_eq!(moves(&row).len(), 1);
    let open = format!("def m():\n movel({}1{})\nend\n", "p[".repeat(5000), "]".repeat(5000));
    assert_eq!(moves(&open).len(), 1);
    // seconds, where time that grows with the square of the length would be minutes
    assert!(start.elapsed().as_secs() < 120, "{:?}", start.elapsed());
}

/// The digits that are asked for are coarser than what the wish differs by.
#[test]
fn a_number_that_is_hardly_moved_stays_the_very_number() {
    let source = format!("def m():\n  q = {Q}\n  q[1] = d2r(-41.9)\n  movej(q)\nend\n");
    let mut edits = shifted(&source, &[(0, 1e-3)]);
    edits.digit = vec![1e-5; 6];
    edits.steps.retain(|_, edit| {
        edit.goal.iter_mut().for_each(|q| q[1] += 2.9e-7);
        true
    });
    let out = rewritten(&source, &edits);
    assert!(out.contains("movej([0.101000, -0.731292956586, 1.2, "), "{out}");
}
