//! New points: their blend, time and place in the text.

use super::*;

#[test]
fn a_new_point_has_the_call_of_its_move_and_a_blend_that_fits() {
    let source = format!("def p():\n\tmovej({Q}, a=1.4, v=speed, r=0.05)\nend\n");
    let out = |clearance_m| rewritten(&source, &inserted(&source, 0, &[0.5], clearance_m));
    let copy = Q.replace("[0.1,", "[0.500000,");
    assert!(
        out(0.01)
            .contains(&format!("\tmovej({copy}, a=1.4, v=speed, r=0.00100)\n\tmovej({Q}, a=1.4, v=speed, r=0.05)")),
        "{}",
        out(0.01)
    );
    assert!(out(0.000_456).contains("r=0.00045)"));
    assert!(out(1e-7).contains("r=0)"));
}

#[test]
fn a_copy_of_an_exact_stop_stops() {
    let source = format!("movej({Q}, a=1.4, v=1)\nmovej({Q}, 1.4, 1, 0, 0.0)\n");
    assert_eq!(moves(&source)[1].blend_m, Some(0.0));
    let out = rewritten(&source, &inserted(&source, 1, &[0.5], 0.01));
    assert!(out.contains(", 1.4, 1, 0, 0.0)\nmovej([0.1,"), "{out}");
}

#[test]
fn the_moves_own_blend_is_shrunk_where_it_is_asked_for() {
    let source = format!("rad = 0.03\nmovej({Q}, r=0.05)\nmovej({Q}, r=rad)\nmovej({Q}, r=other)\n");
    let with = |n: usize, most: f64| {
        let mut edits = shifted(&source, &[(n, 0.0)]);
        edits.steps.retain(|_, e| {
            e.blend_at_most_m = Some(most);
            true
        });
        edits
    };
    assert!(rewritten(&source, &with(0, 0.012_345_6)).contains("r=0.01234)"));
    assert!(rewritten(&source, &with(1, 0.01)).contains("r=0.01000)"));
    assert_eq!(rewritten(&source, &with(0, 0.06)), source);
    assert!(document(&source).patches(&with(2, 0.01)).is_err());
}

#[test]
fn a_time_is_shared_out_and_overrides_the_speed() {
    let source = format!("movej({Q}, a=1, v=1, t=2)\n");
    assert_eq!(moves(&source)[0].speed, Speed::Seconds(2.0));
    let out = rewritten(&source, &inserted(&source, 0, &[0.25], 0.01));
    assert!(out.contains("t=0.50000)\n") && out.ends_with("t=1.50000)\n"), "{out}");
    assert_eq!(moves(&format!("movej({Q}, a=1, v=0.7, t=0)\n"))[0].speed, Speed::Joint(0.7));
    assert_eq!(moves(&format!("movel({Q})\n"))[0].speed, Speed::Tcp(0.25));
    assert!(moves(&format!("movej({Q}, t=t1)\n"))[0].closed.is_some());
}

#[test]
fn a_stream_of_set_points_keeps_its_time() {
    let source = format!("servoj({Q}, 0, 0, 0.1, 0.1, 300)\nservoj({Q}, t=0.008, lookahead_time=0.1)\nservoj({Q})\n");
    let all = moves(&source);
    assert_eq!((all[0].speed, all[1].speed), (Speed::Seconds(0.1), Speed::Seconds(0.008)));
    assert!(all[0].closed.is_none() && all[1].closed.is_some() && all[2].closed.is_some());
    let out = rewritten(&source, &inserted(&source, 0, &[0.0, 0.5], 0.01));
    let times: f64 = out.lines().take(3).map(|l| l.split(", ").nth(8).unwrap().parse::<f64>().unwrap()).sum();
    assert!((times - 0.1).abs() < 1e-9, "{out}");
    // three legs of 8 ms and more
    assert!(out.lines().take(3).all(|l| l.split(", ").nth(8).unwrap().parse::<f64>().unwrap() >= 0.008), "{out}");
}

#[test]
fn what_cannot_take_new_points_says_why() {
    let cases = [
        ("movec(p[0,0,0,0,0,0], p[1,0,0,0,0,0], a=1, mode=1)".to_string(), "arc"),
        ("movec(p[0,0,0,0,0,0], p[1,0,0,0,0,0], 1, 0.25, 0, m)".to_string(), "arc"),
        ("movec(elsewhere, p[1,0,0,0,0,0])".to_string(), "arc"),
        (format!("if a: movej({Q}) end"), "line"),
        ("speedj([0.1,0,0,0,0,0], 0.5, 1)".into(), "velocity"),
    ];
    for (source, why) in cases {
        assert!(moves(&source)[0].closed.as_ref().unwrap().to_string().contains(why), "{source}");
    }
}

#[test]
fn a_straight_move_is_not_stopped_on_its_way_and_ends_as_it_did() {
    for (call, copy) in [
        (format!("movel({Q}, a=1.2, v=0.25)"), ", a=1.2, v=0.25, r=0.00100)"),
        (format!("movel({Q}, 1.2, 0.25, 0, 0)"), ", 1.2, 0.25, 0, 0.00100)"),
        (format!("movep({Q}, 1.2, # slowly\n    v=0.25)"), ", 1.2, v=0.25, r=0.00100)"),
    ] {
        let source = format!("{call}\n");
        let out = rewritten(&source, &inserted(&source, 0, &[0.5], 0.02));
        assert!(out.lines().next().unwrap().ends_with(copy), "{out}");
        assert!(out.ends_with(&source), "{out}");
    }
    // no corner fits, and a joint move that stops exactly
    let source = format!("movel({Q}, a=1.2, v=0.25)\n");
    assert!(!rewritten(&source, &inserted(&source, 0, &[0.5], 1e-6)).contains("r="));
    let source = format!("movej({Q}, a=1.2, v=0.25)\n");
    assert!(!rewritten(&source, &inserted(&source, 0, &[0.5], 0.02)).contains("r="));
}

#[test]
fn a_movec_is_split_into_arcs() {
    let source = "  via = p[0.1, 0.2, 0.3, 0, 3.1, 0]\n  movec(via, p[0.5, 0, 0.3, 0, 3.2, 0], a=1.2, v=0.1)\n";
    let (step, m) = {
        let doc = document(source);
        let (step, m) = doc.script().moves().next().unwrap();
        (step, m.clone())
    };
    assert_eq!((m.closed.as_ref(), m.blend_m), (None, Some(0.0)));
    let q = |x: f64| vec![x, 0.0, 0.3, 0.0, 3.2, 0.0];
    let point = |x, share| NewPoint { q: q(x), share, t_s: None, clearance_m: 0.01, of_way: false, waits: false };
    let vias = vec![vec![0.1, 0.04, 0.3], vec![0.2, 0.05, 0.31], vec![0.3, 0.051, 0.3]];
    let edit =
        Edit { before: vec![point(0.41, 0.3), point(0.42, 0.4)], goal: Some(q(0.5001)), vias, ..Edit::default() };
    let edits = |edit: Edit| Edits { steps: [(step, edit)].into(), pose_digit: [1e-7, 1e-6], ..Edits::default() };
    let out = rewritten(source, &edits(edit.clone()));
    let piece = |via: &str, x: &str, r: &str| {
        format!("  movec(p[{via}, 0, 3.2, 0], p[{x}, 0, 0.3, 0, 3.2, 0], a=1.2, v=0.1{r})\n")
    };
    let pieces = [
        piece("0.1000000, 0.0400000, 0.3", "0.4100000", ", r=0.00100"),
        piece("0.2000000, 0.0500000, 0.3100000", "0.4200000", ", r=0.00100"),
        piece("0.3000000, 0.0510000, 0.3", "0.5001000", ""),
    ];
    assert_eq!(out.replace("0.0000000", "0"), source.lines().next().unwrap().to_string() + "\n" + &pieces.concat());
    let doc = document(source);
    assert!(doc.patches(&edits(Edit { vias: Vec::new(), ..edit })).is_err());
    // the point on the way alone
    let alone = rewritten(source, &edits(Edit { vias: vec![vec![0.11, 0.2, 0.3]], ..Edit::default() }));
    assert_eq!(alone, source.replace("movec(via", "movec(p[0.1100000, 0.2000000, 0.3, 0, 3.2, 0]"));
}
