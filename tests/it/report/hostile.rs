//! What a page does with words that want to be markup, with values that are no numbers, and with very long logs.

use super::*;

#[test]
fn words_from_files_stay_words() {
    const EVIL: &str = "</title></style></script><script>alert(1)</script>\"' onload=\"x\" &amp; ]]> <b>";
    let e = || EVIL.to_owned();
    let mut page = Page::new(EVIL, EVIL);
    page.summary = e();
    page.verdict(Tone::Bad, EVIL).file(EVIL, EVIL, EVIL).option(EVIL, EVIL).joint(EVIL, JointKind::Revolute);
    page.robot = Some(RobotView { name: e(), sha256: e() });
    page.tile(Tile::text(EVIL, EVIL, EVIL).with_detail(EVIL));
    page.warnings.push(e());
    let run = || Run::new(EVIL, Role::Before);
    page.section(
        EVIL,
        EVIL,
        PathView {
            is_arm: false,
            exaggeration: 10.0,
            nominal_mm: vec![[0.0; 3], [1.0; 3]],
            runs: vec![PathRun { run: run(), reference_mm: vec![[0.0; 3]], error_um: vec![[1.0; 3]] }],
            marks: vec![PathMark { joint: e(), at_mm: [0.0; 3], sense: 1 }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        PolarView {
            runs: vec![PolarRun {
                run: run(),
                angle_deg: vec![0.0, 9.0],
                total_um: vec![1.0, 2.0],
                in_plane_um: vec![1.0, 2.0],
                out_of_plane_um: vec![0.0, 1.0],
            }],
            marks: vec![AngleMark { joint: e(), at_deg: 3.0, sense: -1 }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        TracesView {
            x_name: e(),
            x_unit: e(),
            y_name: e(),
            y_whole: false,
            joints: vec![JointTraces {
                joint: e(),
                panels: vec![TracePanel {
                    title: e(),
                    runs: vec![TraceRun {
                        run: run(),
                        x: vec![0.0, 1.0],
                        error_milli: vec![0.0, 1.0],
                        ..TraceRun::default()
                    }],
                    marks: vec![TraceMark { joint: e(), x: 0.5, sense: 0 }],
                }],
            }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        GapsView {
            over: Default::default(),
            joints: vec![JointGapView {
                joint: e(),
                finding: e(),
                points: vec![GapPointView { half_gap_milli: 1.0, ci95_milli: [0.5, 1.5], ..GapPointView::default() }],
                ..JointGapView::default()
            }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        HistogramView {
            quantity: e(),
            unit: e(),
            runs: vec![HistogramRun { run: run(), values: vec![1.0, 2.0], p95: Some(1.5) }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        BarsView {
            quantity: e(),
            unit: e(),
            runs: vec![run()],
            rows: vec![BarRow { label: e(), values: vec![Some(1.0)] }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        WaterfallView { quantity: e(), unit: e(), start: (e(), 3.0), steps: vec![(e(), 1.0)], floor: Some((e(), 0.5)) },
    );
    page.section(
        EVIL,
        EVIL,
        ReversalsView {
            runs: vec![run()],
            rows: vec![ReversalRow { joint: e(), values: vec![ReversalValue::default()], ..ReversalRow::default() }],
        },
    );
    page.section(
        EVIL,
        EVIL,
        vec![GapRow {
            joint: e(),
            stiction: Some(StictionRow { decay_unit: e(), ..StictionRow::default() }),
            ..GapRow::default()
        }],
    );
    page.section(
        EVIL,
        EVIL,
        vec![CompensatorRow { joint: e(), kind: e(), friction_shape: e(), ..CompensatorRow::default() }],
    );
    page.section(
        EVIL,
        EVIL,
        PlacesView { total: 1, places: vec![Place { joint: e(), what: e(), ..Place::default() }] },
    );
    page.section(EVIL, EVIL, TableView { columns: vec![(e(), true)], rows: vec![vec![e()]] });
    page.section(EVIL, EVIL, vec![e()]);
    page.section(EVIL, EVIL, vec![Method::new(EVIL, EVIL, EVIL)]);
    let html = page.render();
    assert!(!html.contains("<script>alert") && !html.contains("<b>") && !html.contains("]]> <b"));
    with_elements(&html, |all| {
        assert_eq!(named(all, "script").len(), 3, "the data of the path, what turns it, what zooms charts");
        assert_eq!(named(all, "style").len(), 1);
        assert!(all.iter().all(|n| n.attributes().all(|a| !a.name().starts_with("on"))));
        assert!(
            named(all, "h2").iter().filter(|h| text_of(h) == EVIL).count() >= 14,
            "and the reader sees them as they are"
        );
    });
}

#[test]
fn odd_inputs_leave_no_hole_and_values_that_are_no_numbers_are_counted() {
    let nan = f64::NAN;
    let odd: [Vec<f64>; 9] = [
        vec![],
        vec![1.0],
        vec![2.0; 50],
        vec![0.0; 3],
        vec![nan; 4],
        vec![f64::INFINITY, 1.0, f64::NEG_INFINITY, 2.0],
        vec![1e300, -1e300, 1.0],
        vec![1e-300, 2e-300],
        vec![-5.0, nan, -5.0],
    ];
    for x in &odd {
        for y in &odd {
            let cubes = |v: &[f64]| v.iter().map(|v| [*v, 2.0 * v, -v]).collect::<Vec<_>>();
            let mut page = Page::new("test", "Odd");
            page.joint("A1", JointKind::Revolute);
            page.tile(Tile::number("n", *y.first().unwrap_or(&nan), 1, "µm"));
            let first = |v: &[f64]| v.first().copied().unwrap_or(nan);
            let r = || run(Role::After);
            page.section(
                "",
                "",
                PathView {
                    is_arm: false,
                    exaggeration: first(y),
                    nominal_mm: cubes(x),
                    runs: vec![PathRun { run: r(), reference_mm: cubes(x), error_um: cubes(y) }],
                    marks: x.iter().map(|v| PathMark { joint: "A1".into(), at_mm: [*v; 3], sense: 1 }).collect(),
                },
            );
            page.section(
                "",
                "",
                PolarView {
                    runs: vec![PolarRun {
                        run: r(),
                        angle_deg: x.clone(),
                        total_um: y.clone(),
                        in_plane_um: y.clone(),
                        out_of_plane_um: vec![],
                    }],
                    marks: x
                        .iter()
                        .map(|v| AngleMark { joint: "no such joint".into(), at_deg: *v, sense: 0 })
                        .collect(),
                },
            );
            page.section(
                "",
                "",
                TracesView {
                    x_name: "time".into(),
                    x_unit: "s".into(),
                    y_name: String::new(),
                    y_whole: false,
                    joints: vec![JointTraces {
                        joint: "A1".into(),
                        panels: vec![TracePanel {
                            title: String::new(),
                            runs: vec![TraceRun {
                                run: r(),
                                x: x.clone(),
                                error_milli: y.clone(),
                                model_x: y.clone(),
                                model_milli: x.clone(),
                            }],
                            marks: x.iter().map(|v| TraceMark { joint: "A1".into(), x: *v, sense: 1 }).collect(),
                        }],
                    }],
                },
            );
            page.section(
                "",
                "",
                GapsView {
                    over: Default::default(),
                    joints: vec![JointGapView {
                        joint: "A1".into(),
                        finding: String::new(),
                        points: x
                            .iter()
                            .zip(y)
                            .map(|(x, y)| GapPointView {
                                at_deg_mm: *x,
                                half_gap_milli: *y,
                                ci95_milli: [*x, *y],
                                per_cycle_milli: vec![*y, *x],
                            })
                            .collect(),
                        constant_milli: Some((first(y), [first(x), nan])),
                        schedule: Some(ScheduleView {
                            at_deg_mm: x.clone(),
                            half_gap_milli: y.clone(),
                            band_milli: y.iter().map(|v| [*v, nan]).collect(),
                        }),
                    }],
                },
            );
            page.section(
                "",
                "",
                HistogramView {
                    quantity: "error".into(),
                    unit: "µm".into(),
                    runs: vec![HistogramRun { run: r(), values: y.clone(), p95: Some(first(x)) }],
                },
            );
            page.section(
                "",
                "",
                BarsView {
                    quantity: "error".into(),
                    unit: "µm".into(),
                    runs: vec![r(), r()],
                    rows: y
                        .iter()
                        .map(|v| BarRow { label: "row".into(), values: vec![Some(*v), None, Some(1.0)] })
                        .collect(),
                },
            );
            page.section(
                "",
                "",
                WaterfallView {
                    quantity: "error".into(),
                    unit: "µm".into(),
                    start: ("start".into(), first(x)),
                    steps: y.iter().map(|v| ("step".into(), *v)).collect(),
                    floor: Some(("floor".into(), first(y))),
                },
            );
            page.section(
                "",
                "",
                ReversalsView {
                    runs: vec![r()],
                    rows: y
                        .iter()
                        .map(|v| ReversalRow {
                            joint: "A1".into(),
                            at_deg: Some(*v),
                            sense: 1,
                            values: vec![ReversalValue {
                                total_um: *v,
                                beyond_nominal_um: Some(*v),
                                reduction: Some(*v),
                            }],
                        })
                        .collect(),
                },
            );
            page.section(
                "",
                "",
                vec![GapRow {
                    joint: "A1".into(),
                    half_gap_milli: first(y),
                    ci95_milli: [first(x), first(y)],
                    varies_p_value: Some(first(y)),
                    tcp_um: Some(first(x)),
                    ..GapRow::default()
                }],
            );
            draws_only_numbers(&page.render());
        }
    }
    let html = one(HistogramView {
        quantity: "error".into(),
        unit: "µm".into(),
        runs: vec![HistogramRun { run: run(Role::Before), values: vec![1.0, nan, 2.0, f64::INFINITY], p95: None }],
    });
    assert!(html.contains("2 values are not finite numbers and are left out."));
}

#[test]
fn a_long_log_makes_a_page_of_bounded_size_and_keeps_a_spike_of_one_sample() {
    const N: usize = 262_000;
    let x: Vec<f64> = (0..N).map(|i| i as f64 / 250.0).collect();
    let angle: Vec<f64> = (0..N).map(|i| 360.0 * i as f64 / N as f64).collect();
    // a sawtooth of many teeth: the worst case for thinning
    let y: Vec<f64> = (0..N).map(|i| if i == 123_456 { 500.0 } else { ((i * 7919) % 101) as f64 }).collect();
    let cubes: Vec<[f64; 3]> =
        angle.iter().map(|a| [0.0, 250.0 * a.to_radians().cos(), 250.0 * a.to_radians().sin()]).collect();
    let errors: Vec<[f64; 3]> = y.iter().map(|e| [*e, -e, 0.5 * e]).collect();
    let mut page = Page::new("test", "Long");
    let runs = [Role::Before, Role::Between, Role::After].map(run);
    page.section(
        "",
        "",
        PathView {
            is_arm: false,
            exaggeration: 400.0,
            nominal_mm: cubes.clone(),
            runs: runs
                .iter()
                .map(|r| PathRun { run: r.clone(), reference_mm: cubes.clone(), error_um: errors.clone() })
                .collect(),
            marks: vec![],
        },
    );
    page.section(
        "",
        "",
        PolarView {
            runs: runs
                .iter()
                .map(|r| PolarRun {
                    run: r.clone(),
                    angle_deg: angle.clone(),
                    total_um: y.clone(),
                    in_plane_um: y.clone(),
                    out_of_plane_um: y.clone(),
                })
                .collect(),
            marks: vec![],
        },
    );
    page.section(
        "",
        "",
        TracesView {
            x_name: "time".into(),
            x_unit: "s".into(),
            y_name: String::new(),
            y_whole: false,
            joints: (1..=6)
                .map(|j| JointTraces {
                    joint: format!("A{j}"),
                    panels: runs[..2]
                        .iter()
                        .map(|r| TracePanel {
                            title: r.name.clone(),
                            runs: vec![TraceRun {
                                run: r.clone(),
                                x: x.clone(),
                                error_milli: y.clone(),
                                model_x: x.clone(),
                                model_milli: y.clone(),
                            }],
                            marks: vec![],
                        })
                        .collect(),
                })
                .collect(),
        },
    );
    page.section(
        "",
        "",
        HistogramView {
            quantity: "error".into(),
            unit: "µm".into(),
            runs: vec![HistogramRun { run: runs[0].clone(), values: y.clone(), p95: None }],
        },
    );
    page.section("", "", PlacesView { total: 1_000_000, places: vec![Place::default(); 10_000] });
    let html = page.render();
    assert!(html.len() < 1_500_000, "{} bytes", html.len());
    assert!(html.contains("The first 200 of 1\u{202f}000\u{202f}000 places."));
    with_elements(&html, |all| {
        let lines: Vec<_> = named(all, "path").into_iter().filter(|n| class_of(n).starts_with("model")).collect();
        let highest = |d: &str| points(d).iter().map(|p| p[1]).fold(f64::MAX, f64::min);
        let typical = |d: &str| {
            let mut y: Vec<f64> = points(d).iter().map(|p| p[1]).collect();
            y.sort_by(f64::total_cmp);
            y[y.len() / 100]
        };
        assert_eq!(lines.len(), 12);
        for l in lines {
            let d = l.attribute("d").expect("data");
            assert!(typical(d) - highest(d) > 50.0, "the spike stands out: {} {}", typical(d), highest(d));
        }
    });
}
