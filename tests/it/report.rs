//! The page: well-formed, self-contained, escaped, and steady whatever is put into it.

#[path = "../../examples/report_gallery/data.rs"]
mod gallery;

use lostmotion::report::{method, *};
use lostmotion::robot::JointKind;
use roxmltree::{Document, Node};
use std::sync::LazyLock;

static GALLERY: LazyLock<String> = LazyLock::new(|| gallery::page().expect("the gallery has a page").render());

/// The page as XML: the doctype goes, void elements are closed.
fn xml(html: &str) -> String {
    let mut out = String::new();
    let mut rest = html.strip_prefix("<!DOCTYPE html>").expect("starts with the doctype");
    while let Some(at) = rest.find('<') {
        out.push_str(&rest[..at]);
        let end = at + rest[at..].find('>').expect("every tag ends") + 1;
        let tag = &rest[at..end];
        let void = ["<meta", "<br", "<input"].iter().any(|v| tag.starts_with(v));
        out.push_str(if void { &tag[..tag.len() - 1] } else { tag });
        out.push_str(if void { "/>" } else { "" });
        rest = &rest[end..];
    }
    out + rest
}

/// Parses a page strictly and hands its elements to a check.
fn with_elements(html: &str, check: impl Fn(&[Node])) {
    let text = xml(html);
    let document = Document::parse(&text).unwrap_or_else(|e| panic!("not well-formed: {e}"));
    check(&document.descendants().filter(Node::is_element).collect::<Vec<_>>());
}

fn named<'a, 'i>(all: &[Node<'a, 'i>], name: &str) -> Vec<Node<'a, 'i>> {
    all.iter().copied().filter(|n| n.tag_name().name() == name).collect()
}

fn class_of<'a>(n: &Node<'a, '_>) -> &'a str {
    n.attribute("class").unwrap_or("")
}

fn text_of(n: &Node) -> String {
    n.descendants().filter(Node::is_text).filter_map(|t| t.text()).collect()
}

/// Every attribute of every drawing is free of what no browser can draw.
fn draws_only_numbers(html: &str) {
    assert!(!html.contains("NaN"), "NaN on the page");
    with_elements(html, |all| {
        for n in all.iter().filter(|n| n.ancestors().any(|a| a.tag_name().name() == "svg")) {
            for a in n.attributes().filter(|a| {
                [
                    "d",
                    "x",
                    "y",
                    "x1",
                    "x2",
                    "y1",
                    "y2",
                    "cx",
                    "cy",
                    "r",
                    "width",
                    "height",
                    "points",
                    "viewBox",
                    "transform",
                ]
                .contains(&a.name())
            }) {
                assert!(!a.value().contains("inf"), "{}={}", a.name(), a.value());
            }
        }
    });
}

/// Points of path data with absolute M and L.
fn points(d: &str) -> Vec<[f64; 2]> {
    d.split(['M', 'L'])
        .filter(|s| !s.is_empty())
        .map(|s| {
            let mut v = s.split_whitespace().map(|v| v.parse::<f64>().expect("a number"));
            [v.next().expect("x"), v.next().expect("y")]
        })
        .collect()
}

fn one(content: impl Into<Content>) -> String {
    let mut page = Page::new("test", "Test");
    page.joint("A1", JointKind::Revolute).joint("Z", JointKind::Prismatic);
    page.section("", "", content);
    page.render()
}

fn run(role: Role) -> Run {
    Run::new("run", role)
}

#[test]
fn a_page_with_everything_is_well_formed_and_says_what_its_drawings_are() {
    with_elements(&GALLERY, |all| {
        assert_eq!(named(all, "h1").len(), 1);
        let drawings: Vec<_> = named(all, "svg").into_iter().filter(|n| n.attribute("aria-hidden").is_none()).collect();
        assert!(drawings.len() >= 20, "{}", drawings.len());
        assert!(
            drawings
                .iter()
                .all(|s| s.attribute("role") == Some("img") && s.attribute("aria-label").is_some_and(|l| l.len() > 10))
        );
        assert!(named(all, "th").iter().all(|th| th.attribute("scope").is_some()));
        assert!(named(all, "html")[0].attribute("lang").is_some());
        let ids: Vec<_> = all.iter().filter_map(|n| n.attribute("id")).collect();
        let links: Vec<_> = named(all, "a")
            .iter()
            .filter_map(|a| a.attribute("href"))
            .map(|h| h.trim_start_matches('#').to_owned())
            .collect();
        assert_eq!(ids, links, "the list of sections leads to each of them, in order");
    });
    draws_only_numbers(&GALLERY);
}

#[test]
fn a_page_needs_nothing_from_outside() {
    with_elements(&GALLERY, |all| {
        for n in all {
            for a in n.attributes() {
                let outside = matches!(a.name(), "src" | "href" | "action" | "data" | "poster" | "srcset");
                assert!(!outside || a.value().starts_with('#'), "{} {}", a.name(), a.value());
            }
        }
        assert!(named(all, "link").is_empty() && named(all, "img").is_empty());
    });
    for word in ["http:", "https:", "@import", "url(", "//cdn"] {
        assert!(!GALLERY.contains(word), "{word}");
    }
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    assert_eq!(*GALLERY, gallery::page().expect("a page").render());
}

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
    page.section(EVIL, EVIL, vec![LeftOut { what: e(), why: e() }]);
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
        assert_eq!(named(all, "script").len(), 2, "one for the data of the path, one that turns it");
        assert_eq!(named(all, "style").len(), 1);
        assert!(all.iter().all(|n| n.attributes().all(|a| !a.name().starts_with("on"))));
        assert!(
            named(all, "h2").iter().filter(|h| text_of(h) == EVIL).count() >= 15,
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

#[test]
fn a_constant_error_is_a_circle_and_a_known_value_stands_at_its_tick() {
    let angle: Vec<f64> = (0..=72).map(|k| 5.0 * f64::from(k)).collect();
    let html = one(PolarView {
        runs: vec![PolarRun {
            run: run(Role::After),
            angle_deg: angle.clone(),
            total_um: vec![100.0; 73],
            in_plane_um: vec![-30.0; 73],
            out_of_plane_um: vec![0.0; 73],
        }],
        marks: vec![],
    });
    with_elements(&html, |all| {
        let lines: Vec<_> = named(all, "path").into_iter().filter(|n| class_of(n).starts_with("line")).collect();
        assert_eq!(lines.len(), 3);
        for l in &lines {
            let p = points(l.attribute("d").expect("data"));
            let middle = [0.5 * (p[0][0] + p[36][0]), 0.5 * (p[18][1] + p[54][1])];
            let radius = p[0][0] - middle[0];
            assert!(p.iter().all(|q| ((q[0] - middle[0]).hypot(q[1] - middle[1]) - radius).abs() < 0.15), "{p:?}");
            assert!(p[18][1] < middle[1], "90 degrees are up: anticlockwise");
        }
        // zero out of plane lies on the ring of zero
        let zero = named(all, "circle").into_iter().rfind(|c| class_of(c).contains("zero")).expect("a ring of zero");
        let p = points(lines[2].attribute("d").expect("data"));
        let r: f64 = zero.attribute("r").and_then(|r| r.parse().ok()).expect("a radius");
        let cx: f64 = zero.attribute("cx").and_then(|r| r.parse().ok()).expect("a centre");
        assert!((p[0][0] - cx - r).abs() < 0.15);
    });
    let html = one(TracesView {
        x_name: "time".into(),
        x_unit: "s".into(),
        y_name: String::new(),
        joints: vec![JointTraces {
            joint: "Z".into(),
            panels: vec![TracePanel {
                runs: vec![TraceRun { model_x: vec![0.0, 10.0], model_milli: vec![4.0, -4.0], ..TraceRun::default() }],
                ..TracePanel::default()
            }],
        }],
    });
    assert!(html.contains("error, µm"), "a prismatic joint's error is in micrometres");
    with_elements(&html, |all| {
        let tick =
            named(all, "text").into_iter().find(|t| class_of(t) == "tick" && text_of(t) == "4").expect("a tick at 4");
        let y: f64 = tick.attribute("y").and_then(|y| y.parse().ok()).expect("its place");
        let line = named(all, "path").into_iter().find(|n| class_of(n).starts_with("model")).expect("the line");
        let p = points(line.attribute("d").expect("data"));
        assert!((p[0][1] - (y - 4.0)).abs() < 0.11, "{p:?} {y}");
    });
}

#[test]
fn the_view_in_space_is_isometric_and_errors_are_exaggerated_along_their_direction() {
    let html = one(PathView {
        exaggeration: 400.0,
        nominal_mm: vec![[0.0, -100.0, 0.0], [0.0, 100.0, 0.0]],
        runs: vec![PathRun {
            run: run(Role::After),
            reference_mm: vec![[0.0; 3], [0.0; 3]],
            error_um: vec![[0.0; 3], [0.0, 0.0, 100.0]],
        }],
        marks: vec![],
    });
    with_elements(&html, |all| {
        let get = |n: &Node, a: &str| n.attribute(a).and_then(|v| v.parse::<f64>().ok()).expect("a number");
        let axes: Vec<[f64; 2]> = named(all, "line")
            .iter()
            .filter(|l| l.parent().is_some_and(|p| class_of(&p) == "triad"))
            .map(|l| [get(l, "x2") - get(l, "x1"), get(l, "y2") - get(l, "y1")])
            .collect();
        let lengths: Vec<f64> = axes.iter().map(|a| a[0].hypot(a[1])).collect();
        assert!(lengths.iter().all(|l| (l - lengths[0]).abs() < 0.15), "equally foreshortened: {lengths:?}");
        assert!(axes[2][0].abs() < 0.1 && axes[2][1] < 0.0, "z is up");
        let cosine = (axes[0][0] * axes[1][0] + axes[0][1] * axes[1][1]) / (lengths[0] * lengths[1]);
        assert!((cosine + 0.5).abs() < 0.01, "120 degrees apart");
        let d = |class: &str| {
            points(
                named(all, "path").iter().find(|p| class_of(p) == class).and_then(|p| p.attribute("d")).expect("data"),
            )
        };
        let (nominal, line) = (d("nominal"), d("line after"));
        // 100 um times 400 is 40 mm along z; the nominal path is 200 mm along y, equally foreshortened
        let (error, length) =
            (line[0][1] - line[1][1], (nominal[1][0] - nominal[0][0]).hypot(nominal[1][1] - nominal[0][1]));
        assert!((error / length - 0.2).abs() < 0.002, "{error} {length}");
    });
}

#[test]
fn the_table_of_reversals_shows_each_run_beside_the_others() {
    let value = |total_um, reduction| ReversalValue { total_um, beyond_nominal_um: None, reduction };
    // seed 000 table 5, first two reversals
    let html = one(ReversalsView {
        runs: vec![Run::new("no compensation", Role::Before), Run::new("compensation", Role::After)],
        rows: vec![
            ReversalRow {
                joint: "A1".into(),
                at_deg: None,
                sense: 1,
                values: vec![value(198.0, None), value(14.0, Some(1.0 - 14.0 / 198.0))],
            },
            ReversalRow {
                joint: "A1".into(),
                at_deg: None,
                sense: -1,
                values: vec![value(167.0, None), value(10.0, Some(1.0 - 10.0 / 167.0))],
            },
        ],
    });
    with_elements(&html, |all| {
        let rows: Vec<Vec<String>> = named(all, "tr")
            .iter()
            .map(|r| r.children().filter(Node::is_element).map(|c| text_of(&c)).collect())
            .collect();
        assert_eq!(rows[2], ["A1↑", "198", "14", "93\u{202f}%"]);
        assert_eq!(rows[3], ["A1↓", "167", "10", "94\u{202f}%"]);
        let groups: Vec<_> = named(all, "th").iter().filter_map(|t| t.attribute("colspan")).collect();
        assert_eq!(groups, ["1", "2"]);
    });
}

#[test]
fn a_page_may_have_a_single_section_and_names_its_method_and_source() {
    let html = one(vec![method::PLAY, method::CIRCLE]);
    with_elements(&html, |all| {
        assert_eq!(named(all, "section").len(), 1);
        assert!(named(all, "nav").is_empty() && named(all, "script").is_empty());
        let words = text_of(&named(all, "section")[0]);
        assert!(words.contains("equation 6") && words.contains("Taubin"), "{words}");
    });
}
