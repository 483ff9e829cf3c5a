//! A made run: the circle of Zhang (2023) (radius 250 mm, A1 to A3, 1.5 mm/s) on a machine with gaps and stiction, without
//! compensation, with a plain offset, and with offsets that follow both effects; white noise on top.

mod run;

use lostmotion::effects::GapCurve;
use lostmotion::effects::curve::Pchip;
use lostmotion::error::{Error, Result};
use lostmotion::report::{method, *};
use lostmotion::robot::Robot;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use run::{DECAY_S, JOINTS, Measured, NOISE_UM, RATE_HZ, Reversal, commands, largest, measure, p95, reversals};
use std::path::Path;

/// The whole page.
pub fn page() -> Result<Page> {
    let robot = Robot::load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("configs/kuka-kr120-r2500-pro.yaml"))?;
    let (t_s, nominal, circle_deg) = commands(&robot);
    let turns = reversals(&t_s, &nominal);
    let runs = [
        (Run::new("without", Role::Before), measure(&robot, &t_s, &nominal, &circle_deg, None, 1)),
        (Run::new("constant offset", Role::Between), measure(&robot, &t_s, &nominal, &circle_deg, Some((0.8, 0.0)), 2)),
        (Run::new("this tool", Role::After), measure(&robot, &t_s, &nominal, &circle_deg, Some((1.0, 1.0)), 3)),
    ];
    let window = (20.0 * RATE_HZ) as usize;
    let at = |r: &Reversal| runs[0].1.circle_deg[r.1];
    let worst = |k: usize| turns.iter().map(|r| largest(&runs[k].1.total_um, r.1, window)).fold(0.0, f64::max);
    let names: Vec<Run> = runs.iter().map(|r| r.0.clone()).collect();

    let mut page = Page::new("report", "A 250 mm circle with A1, A2 and A3, before and after compensation");
    page.summary = "Gaps and stiction were identified, a compensator was fitted, the program was rewritten and the circle was run again at 1.5 mm/s. Made data: a simulated machine.".into();
    page.robot = Some(RobotView { name: robot.name.clone(), sha256: "9f2c4e7a51b80d36c1aa0f".into() });
    for j in robot.axis_joints() {
        page.joint(&j.name, j.kind);
    }
    page.verdict(
        Tone::Good,
        format!(
            "The largest total error at a reversal falls from {} to {} µm.",
            number(worst(0), 0),
            number(worst(2), 0)
        ),
    );
    for (role, name, sha) in [
        ("program", "circle_program.csv", "d1a0c3a44ee2bb7108"),
        ("log before", "circle_uncompensated.csv", "07be51d0f6a2cc9043"),
        ("log after", "circle_compensated.csv", "c8e19ab47d33f0517e"),
        ("compensator", "compensator.yaml", "5b71d26e0c99a4f83d"),
    ] {
        page.file(role, name, sha);
    }
    page.option("--refine", "cartesian").option("--tcp-speed-mm-s", "1.5").option("--smooth-s", "1");
    page.tile(
        Tile::number("Largest error at a reversal", worst(2), 0, "µm")
            .with_detail(format!("before: {} µm", number(worst(0), 0))),
    );
    page.tile(
        Tile::text("Reduction", number(100.0 * (1.0 - worst(2) / worst(0)), 0), "%").with_detail("over all reversals"),
    );
    page.tile(Tile::number("Reversals", turns.len() as f64, 0, "").with_detail("two each of A1, A2, A3"));
    page.tile(Tile::text("Half gap of A2", "2.2 to 5.0", "mdeg").with_detail("depends on its position"));
    page.warnings.push("A4, A5 and A6 do not move on this path: this log does not determine them.".into());

    page.section(
        "Errors stand at the reversals, and hardly anywhere after compensation",
        "TCP by laser tracker, registered away from the reversals; errors against the nominal path, 4 values a second.",
        PathView {
            is_arm: false,
            exaggeration: 400.0,
            nominal_mm: runs[0].1.nominal_mm.clone(),
            runs: [0, 2]
                .map(|k| PathRun {
                    run: names[k].clone(),
                    reference_mm: runs[k].1.nominal_mm.clone(),
                    error_um: runs[k].1.error_um.clone(),
                })
                .into(),
            marks: turns
                .iter()
                .map(|r| PathMark { joint: JOINTS[r.0].into(), at_mm: runs[0].1.nominal_mm[r.1], sense: r.2 })
                .collect(),
        },
    );
    page.section(
        "Errors of A1 lie in the plane; those of A2 and A3 leave it too",
        "Second revolution, errors beyond the nominal path; angle anticlockwise from the y axis of the base.",
        PolarView {
            runs: [0, 2]
                .map(|k| PolarRun {
                    run: names[k].clone(),
                    angle_deg: runs[k].1.circle_deg.clone(),
                    total_um: runs[k].1.total_um.clone(),
                    in_plane_um: runs[k].1.in_plane_um.clone(),
                    out_of_plane_um: runs[k].1.error_um.iter().map(|e| e[0]).collect(),
                })
                .into(),
            marks: turns.iter().map(|r| AngleMark { joint: JOINTS[r.0].into(), at_deg: at(r), sense: r.2 }).collect(),
        },
    );
    page.section(
        "Every reversal falls by five sixths or more",
        "Largest error from each reversal to 20 s after it.",
        ReversalsView {
            runs: names.clone(),
            rows: turns
                .iter()
                .map(|r| ReversalRow {
                    joint: JOINTS[r.0].into(),
                    at_deg: Some(at(r)),
                    sense: r.2,
                    values: runs
                        .iter()
                        .enumerate()
                        .map(|(k, (_, m))| {
                            let total_um = largest(&m.total_um, r.1, window);
                            ReversalValue {
                                total_um,
                                beyond_nominal_um: Some(total_um),
                                reduction: (k > 0).then(|| 1.0 - total_um / largest(&runs[0].1.total_um, r.1, window)),
                            }
                        })
                        .collect(),
                })
                .collect(),
        },
    );
    page.section(
        "",
        "The same figures as bars.",
        BarsView {
            quantity: "largest total error".into(),
            unit: "µm".into(),
            runs: names.clone(),
            rows: turns
                .iter()
                .map(|r| BarRow {
                    label: format!("{} at {}°", JOINTS[r.0], number(at(r), 0)),
                    values: runs.iter().map(|(_, m)| Some(largest(&m.total_um, r.1, window))).collect(),
                })
                .collect(),
        },
    );
    page.section(
        "Nearly the whole path is within 20 µm",
        "All samples of the second revolution.",
        HistogramView {
            quantity: "total error".into(),
            unit: "µm".into(),
            runs: runs
                .iter()
                .map(|(run, m)| HistogramRun { run: run.clone(), values: m.total_um.clone(), p95: p95(&m.total_um) })
                .collect(),
        },
    );
    page.section(
        "Steps of a gap at each reversal, with a spike for A1 and A3",
        "Joint positions by inverse kinematics from the measured TCP, less the command.",
        TracesView {
            x_name: "time".into(),
            x_unit: "s".into(),
            y_name: String::new(),
            y_whole: false,
            joints: (0..3)
                .map(|j| JointTraces {
                    joint: JOINTS[j].into(),
                    panels: [0, 2]
                        .map(|k| TracePanel {
                            title: names[k].name.clone(),
                            runs: vec![trace(&names[k], &runs[k].1, j, 0, usize::MAX)],
                            marks: turns
                                .iter()
                                .map(|r| TraceMark { joint: JOINTS[r.0].into(), x: runs[k].1.t_s[r.1], sense: r.2 })
                                .collect(),
                        })
                        .into(),
                })
                .collect(),
        },
    );
    page.section(
        "The gap is crossed within seconds after a reversal",
        "The same errors from 10 s before to 30 s after each reversal of A1 and A3.",
        TracesView {
            x_name: "time since the reversal".into(),
            x_unit: "s".into(),
            y_name: String::new(),
            y_whole: false,
            joints: [0, 2]
                .map(|j| JointTraces {
                    joint: JOINTS[j].into(),
                    panels: turns
                        .iter()
                        .filter(|r| r.0 == j)
                        .map(|r| TracePanel {
                            title: format!("at {}° of the circle", number(at(r), 0)),
                            runs: [0, 2]
                                .map(|k| {
                                    let from = r.1.saturating_sub((10.0 * RATE_HZ) as usize);
                                    trace(&names[k], &runs[k].1, j, from, r.1)
                                })
                                .into(),
                            marks: vec![TraceMark { joint: JOINTS[j].into(), x: 0.0, sense: r.2 }],
                        })
                        .collect(),
                })
                .into(),
        },
    );
    static_test(&mut page, &robot)?;
    page.section(
        "Two steps take away nearly all of it",
        "Largest total error at a reversal.",
        WaterfallView {
            quantity: "largest total error".into(),
            unit: "µm".into(),
            start: ("without".into(), worst(0)),
            steps: vec![("constant offsets".into(), worst(1)), ("friction offsets, dense points".into(), worst(2))],
            floor: Some(("noise".into(), 2.0 * NOISE_UM)),
        },
    );
    words(&mut page);
    Ok(page)
}

/// Errors of joint `j`; times count from sample `zero` where a part is cut out.
fn trace(run: &Run, m: &Measured, j: usize, from: usize, zero: usize) -> TraceRun {
    let (to, t0) = if zero == usize::MAX {
        (m.t_s.len(), 0.0)
    } else {
        ((zero + (30.0 * RATE_HZ) as usize).min(m.t_s.len()), m.t_s[zero])
    };
    let x: Vec<f64> = m.t_s[from..to].iter().map(|t| t - t0).collect();
    TraceRun {
        run: run.clone(),
        x: x.clone(),
        error_milli: m.joint_mdeg[j][from..to].to_vec(),
        model_x: x,
        model_milli: m.model_mdeg[j][from..to].to_vec(),
    }
}

/// Gaps over position and their tables (Zhang (2023) figure 5).
fn static_test(page: &mut Page, robot: &Robot) -> Result<()> {
    let pose = [40.0, -10.0, 5.0, 0.0, 0.0, 0.0].map(f64::to_radians);
    let curve = |knots: &[[f64; 2]]| {
        Pchip::new(knots).map(GapCurve::Pchip).ok_or_else(|| Error::internal("draw a gap curve", "knots do not rise"))
    };
    let curves = [
        (GapCurve::Constant(2.8), [-45.0, 55.0, 10.0], 0.02),
        (curve(&[[-110.0, 4.2], [-70.0, 2.2], [-45.0, 3.8], [-10.0, 5.0], [10.0, 4.6]])?, [-110.0, 10.0, 10.0], 0.05),
        (GapCurve::Constant(2.2), [23.0, 140.0, 9.0], 0.05),
        (GapCurve::Constant(6.1), [-170.0, 170.0, 20.0], 0.6),
        (
            curve(&[[-90.0, 9.4], [-50.0, 5.5], [0.0, 3.4], [40.0, 1.1], [65.0, 4.2], [90.0, 9.4]])?,
            [-90.0, 90.0, 10.0],
            0.3,
        ),
        (GapCurve::Constant(6.0), [-170.0, 170.0, 20.0], 0.6),
    ];
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    let mut view = GapsView::default();
    let mut rows = Vec::new();
    for (name, (curve, [from, to, step], sigma)) in JOINTS.iter().zip(&curves) {
        let mut points = Vec::new();
        let mut at = *from;
        while at <= to + 1e-9 {
            let per_cycle: Vec<f64> =
                (0..4).map(|_| curve.at(at) + sigma * Distribution::<f64>::sample(&StandardNormal, &mut rng)).collect();
            let mean = per_cycle.iter().sum::<f64>() / 4.0;
            points.push(GapPointView {
                at_deg_mm: at,
                half_gap_milli: mean,
                ci95_milli: [mean - 1.6 * sigma, mean + 1.6 * sigma],
                per_cycle_milli: per_cycle,
            });
            at += step;
        }
        let n = points.len() as f64;
        let mean = points.iter().map(|p| p.half_gap_milli).sum::<f64>() / n;
        let ci = [mean - 1.0 * sigma / n.sqrt(), mean + 1.0 * sigma / n.sqrt()];
        let constant = curve.constant().is_some();
        let grid: Vec<f64> = (0..=120).map(|k| from + (to - from) * f64::from(k) / 120.0).collect();
        view.joints.push(JointGapView {
            joint: (*name).into(),
            finding: if constant {
                "the same everywhere, p = 0.41".into()
            } else {
                "varies with position, p < 0.001".into()
            },
            constant_milli: constant.then_some((mean, ci)),
            schedule: (!constant).then(|| ScheduleView {
                at_deg_mm: grid.clone(),
                half_gap_milli: grid.iter().map(|a| curve.at(*a)).collect(),
                band_milli: grid.iter().map(|a| [curve.at(*a) - 1.2 * sigma, curve.at(*a) + 1.2 * sigma]).collect(),
            }),
            points,
        });
        let spike = match *name {
            "A1" => Some(3.4),
            "A3" => Some(1.7),
            _ => None,
        };
        rows.push(GapRow {
            joint: (*name).into(),
            half_gap_milli: mean,
            ci95_milli: ci,
            significant: true,
            varies_p_value: Some(if constant { 0.41 } else { 1e-9 }),
            tcp_um: Some(impact_um(robot, &pose, name, mean)),
            stiction: spike.map(|s| StictionRow {
                spike_milli: s,
                ci95_milli: [s - 0.1, s + 0.12],
                decay: DECAY_S,
                decay_ci95: [4.8, 5.7],
                decay_unit: "s".into(),
            }),
        });
    }
    page.section(
        "The gaps of A2 and A5 depend on position; those of the others do not",
        "Static test: each position reached from both sides by 2 deg, four cycles, rests of 1 s.",
        view,
    );
    page.section(
        "Every joint has a gap; A1 and A3 also stick",
        "Gaps from the static test, stiction from the circle; at the TCP: one half gap at (40, -10, 5, 0, 0, 0) deg.",
        rows,
    );
    page.section(
        "",
        "",
        vec![
            CompensatorRow {
                joint: "A1".into(),
                positive_milli: Some([2.8, 2.8]),
                negative_milli: Some([2.8, 2.8]),
                kind: "constant".into(),
                friction_gain_milli: Some(3.4),
                friction_shape: "decays over 5.2 s".into(),
            },
            CompensatorRow {
                joint: "A2".into(),
                positive_milli: Some([2.2, 5.0]),
                negative_milli: Some([2.2, 5.0]),
                kind: "PCHIP, 5 knots".into(),
                friction_gain_milli: None,
                friction_shape: String::new(),
            },
            CompensatorRow {
                joint: "A3".into(),
                positive_milli: Some([2.2, 2.2]),
                negative_milli: Some([2.2, 2.2]),
                kind: "constant".into(),
                friction_gain_milli: Some(1.7),
                friction_shape: "decays over 5.2 s".into(),
            },
        ],
    );
    Ok(())
}

/// TCP error of one half gap (mdeg) of a joint at a pose, µm.
fn impact_um(robot: &Robot, pose: &[f64; 6], joint: &str, half_gap_mdeg: f64) -> f64 {
    let mut moved = *pose;
    if let Some(axis) = robot.axis_named(joint) {
        moved[axis] += (half_gap_mdeg * 1e-3).to_radians();
    }
    (robot.tcp_m(&moved) - robot.tcp_m(pose)).norm() * 1e6
}

/// Sections of words.
fn words(page: &mut Page) {
    let left_out = [
        ["A4 at 130 deg, cycle 3", "the reflector was lost for 0.7 s of a rest of 1 s"],
        ["stiction of A2", "no spike above the noise after its reversals (p = 0.62)"],
    ];
    let rows = left_out.iter().map(|row| row.map(String::from).to_vec());
    page.section("Left out", "", TableView::words(&["What", "Why"], rows));
    page.section(
        "",
        "",
        PlacesView {
            total: 84,
            places: (0..12)
                .map(|k| Place {
                    line: Some(38 + 31 * k),
                    joint: JOINTS[(k % 3) as usize].into(),
                    what: if k % 2 == 0 { "reversal" } else { "inserted point" }.into(),
                    at_deg_mm: -14.2345 + k as f64,
                    offset_milli: if k % 2 == 0 { 6.2 } else { -2.8 },
                })
                .collect(),
        },
    );
    page.section(
        "",
        "",
        vec![
            "Two revolutions were run; the second is shown.".to_owned(),
            "Errors are those beyond the nominal path; the chords of the program leave 18 µm by themselves.".to_owned(),
        ],
    );
    page.section(
        "",
        "",
        vec![
            method::PLAY,
            method::STICTION,
            method::STATIC_GAP,
            method::FEEDFORWARD,
            method::FRICTION_POINTS,
            method::IMPACT,
            method::CIRCLE,
            method::REGISTRATION,
        ],
    );
}
