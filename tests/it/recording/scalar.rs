//! Programs for instruments that read one length: ballbars and dial gauges.

use super::{machine, options, recorded, robot};
use crate::support::bundled;
use lostmotion::error::Error;
use lostmotion::identify::{scalar, static_test};
use lostmotion::machine::measurement::Instrument;
use lostmotion::model::Model;
use lostmotion::plan::recording::{Kind, Note, Options, Recording, plan};
use lostmotion::program::Program;
use nalgebra::{Unit, Vector3};

#[test]
fn val_a_ballbar_circle_gives_the_gaps_of_the_joints_that_it_excites_within_5_percent() {
    let model = Model::load(&bundled("samples/models/kuka-figure5.model.yaml")).unwrap();
    let robot = model.robot.clone();
    let program = Program::load(&bundled("samples/circle/circle_program.csv"), &robot).unwrap();
    let mut q = vec![0.0; robot.dof()];
    let points: Vec<Vector3<f64>> = (0..program.len())
        .map(|i| {
            program.point_into(i, &mut q);
            robot.tcp_m(&q)
        })
        .collect();
    let lo = points.iter().fold(points[0], |a, p| a.inf(p));
    let hi = points.iter().fold(points[0], |a, p| a.sup(p));
    let centre = 0.5 * (lo + hi);
    let (mut base, truth) = machine(&robot);
    base.registration = None;
    let rows: Vec<(f64, Vec<f64>)> = {
        let timing = lostmotion::simulate::Timing::at_speed(&robot, &program, 4e-3);
        (0..program.len()).map(|i| (timing.t_s[i], program.q.iter().map(|c| c[i]).collect())).collect()
    };
    let recording = Recording {
        kind: Kind::Path,
        pose: rows[0].1.clone(),
        duration_s: rows[rows.len() - 1].0,
        rows,
        precision: Vec::new(),
        notes: Vec::new(),
    };
    // set up where the program has its centre, and a millimetre or two off it, across its plane too
    for (known, off_mm) in [(Some(centre), [0.0; 3]), (None, [0.0; 3]), (None, [1.5, -1.0, 0.7])] {
        // the bar's own length is not known: `recorded` writes differences to a nominal length
        let centre_m = centre + Vector3::from(off_mm) * 1e-3;
        let options = Options { instrument: Instrument::Distance { centre_m }, noise_m: 1e-6, ..options() };
        let log = recorded(&base, &recording, &options, 5);
        let setup = scalar::Setup { centre_m: known, direction: None };
        // a bar that stands off the centre changes by millimetres, which as micrometres would be a good robot's
        if off_mm == [0.0; 3] {
            let mut in_mm = log.clone();
            in_mm.instruments.distance_off_m.iter_mut().flatten().flatten().for_each(|r| *r *= 1e-3);
            let refused = scalar::identify(&robot, &[in_mm], &setup).unwrap_err().to_string();
            assert!(refused.contains("readings that change by 0."), "{refused}");
        }
        if known.is_some() {
            let far = scalar::Setup { centre_m: known.map(|c| c * 1e-3), direction: None };
            let refused = scalar::identify(&robot, std::slice::from_ref(&log), &far).unwrap_err().to_string();
            assert!(refused.contains("whose distance from the centre changes"), "a centre in metres: {refused}");
        }
        let found = scalar::identify(&robot, &[log], &setup).unwrap();
        assert!(!found.gaps.joints.is_empty());
        for j in &found.gaps.joints {
            let error = j.half_gap / truth[j.axis] - 1.0;
            assert!(error.abs() < 0.05, "{}: {error:.3} (centre known: {})", robot.axis(j.axis).name, known.is_some());
            assert!(j.significant);
        }
    }
}

#[test]
fn val_a_dial_gauge_gives_the_gaps_of_the_joints_that_move_along_it() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let along = Unit::new_normalize(Vector3::new(0.2, 1.0, 0.1));
    let options = Options { instrument: Instrument::Direction { along }, noise_m: 1e-6, ..options() };
    let recording = plan(&robot, Kind::Static, &options).unwrap();
    let (model, truth) = machine(&robot);
    let log = recorded(&model, &recording, &options, 4);
    let setup = scalar::Setup { centre_m: None, direction: Some(along) };
    let found = static_test::identify(&robot, &[log], &static_test::Options { setup, ..Default::default() }).unwrap();
    assert!(found.gaps.joints.len() >= 5, "{:?}", found.gaps.notes);
    for j in &found.gaps.joints {
        let error = j.half_gap / truth[j.axis] - 1.0;
        assert!(error.abs() < 0.05, "{}: {error:.3}", robot.axis(j.axis).name);
    }
}

#[test]
fn a_plan_says_what_an_instrument_cannot_tell() {
    let robot = robot("gantry-xyz-ballscrew.yaml");
    // a dial along the first axis sees nothing of the other two
    let along = Unit::new_normalize({
        let mut columns = vec![Vector3::zeros(); 3];
        robot.chain().position_and_jacobian(&[0.5, 0.4, -0.2], &mut columns);
        columns[0]
    });
    let options = Options { instrument: Instrument::Direction { along }, ..options() };
    let recording = plan(&robot, Kind::Static, &options).unwrap();
    assert!(recording.precision[0].sigma.is_some() && recording.precision[0].reason.is_none());
    for p in &recording.precision[1..] {
        assert!(p.sigma.is_none() && p.reason.unwrap().to_string().contains("cannot be determined"), "{p:?}");
    }
}

#[test]
fn a_path_with_a_ballbar_says_which_range_its_sensor_needs() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let instrument = Instrument::Distance { centre_m: Vector3::new(1.5, 0.0, 0.8) };
    let recording = plan(&robot, Kind::Path, &Options { instrument, duration_s: 120.0, ..options() }).unwrap();
    assert!(recording.notes.iter().any(|n| n.to_string().contains("is for a draw wire")), "{:?}", recording.notes);
}

#[test]
fn val_circles_for_a_ballbar_keep_its_length_and_tell_the_joints_that_they_say() {
    for (name, centre_m, bar_m) in [
        ("kuka-kr120-r2500-pro.yaml", Vector3::new(1.5, 0.3, 1.2), 0.3),
        ("gantry-xyz-ballscrew.yaml", Vector3::new(0.5, 0.4, 0.1), 0.15),
    ] {
        let robot = robot(name);
        // the middle of a gantry's work is not where its base is
        let centre_m = match robot.dof() {
            3 => robot.tcp_m(&[0.5, 0.4, 0.0]),
            _ => centre_m,
        };
        let instrument = Instrument::Distance { centre_m };
        let options =
            Options { instrument, bar_m: Some(bar_m), noise_m: 1e-6, speed_m_s: 50e-3, duration_s: 1.0, ..options() };
        let recording = plan(&robot, Kind::Path, &options).unwrap();
        for (t, q) in &recording.rows {
            let off = (robot.tcp_m(q) - centre_m).norm() - bar_m;
            assert!(off.abs() < 1e-6, "{name}: {off:e} m after {t} s");
            for (joint, v) in robot.axis_joints().zip(q) {
                assert!(joint.limits.is_none_or(|[lo, hi]| (lo..=hi).contains(v)), "{name}, {}: {v}", joint.name);
            }
        }
        assert_eq!(recording.rows.first().unwrap().1, recording.rows.last().unwrap().1);
        assert!(recording.notes[0].to_string().contains("2 turns each way"), "{:?}", recording.notes);
        assert!(
            recording
                .notes
                .iter()
                .map(ToString::to_string)
                .any(|n| n.starts_with("these circles reverse ") && n.contains("they tell the gaps of ")),
            "{:?}",
            recording.notes
        );
        let (model, truth) = machine(&robot);
        let log = recorded(&model, &recording, &options, 6);
        let found = lostmotion::identify::machine::identify(&robot, &[log], &[]).unwrap();
        let mut told = 0;
        for p in &recording.precision {
            let joint = &robot.axis(p.axis).name;
            let gap = found.joints.iter().find(|j| j.axis == p.axis);
            match p.sigma {
                Some(sigma) => {
                    let e = found.estimate.as_ref().unwrap();
                    let windup = e.joints.iter().find(|j| j.axis == p.axis).map_or(0.0, |j| j.response.windup());
                    let gap = gap.unwrap_or_else(|| panic!("{name}, {joint}: told before, not found"));
                    let off = (gap.half_gap + windup - truth[p.axis]).abs();
                    assert!(
                        off < (0.05 * truth[p.axis]).max(4.0 * sigma),
                        "{name}, {joint}: off by {off:e}, {sigma:e}"
                    );
                    told += 1;
                }
                None => {
                    assert!(p.reason.is_some(), "{name}, {joint}");
                    assert!(
                        recording.notes.iter().any(|n| matches!(n, Note::NotTold { joints } if joints.contains(joint)))
                    );
                }
            }
        }
        assert!(told >= 3, "{name}: {:?}", recording.precision);
    }
}

#[test]
fn a_ballbar_is_not_planned_where_its_length_cannot_be_kept() {
    let robot = robot("kuka-kr120-r2500-pro.yaml");
    let options = |bar_m: f64, x: f64| Options {
        instrument: Instrument::Distance { centre_m: Vector3::new(x, 0.0, 1.0) },
        bar_m: Some(bar_m),
        ..options()
    };
    let refusal = |kind: Kind, bar_m: f64, x: f64| plan(&robot, kind, &options(bar_m, x)).unwrap_err();
    let refused = |kind: Kind, bar_m: f64, x: f64| refusal(kind, bar_m, x).to_string();
    for kind in [Kind::Static, Kind::Excitation] {
        let said = refused(kind, 0.3, 1.5);
        assert!(said.contains("1 mm either way of its length") && said.contains("draw-wire"), "{said}");
        // the command names its option
        let mends = refusal(kind, 0.3, 1.5);
        assert!(matches!(mends, Error::MendedBy { settings: ["draw_wire"], .. }), "{mends:?}");
    }
    // Z of the gantry ends in the plane of the centre: the circle stays at that end, and the arcs hang below
    let gantry = self::robot("gantry-xyz-ballscrew.yaml");
    let at_end = Options {
        instrument: Instrument::Distance { centre_m: gantry.tcp_m(&[0.5, 0.4, 0.0]) },
        bar_m: Some(0.15),
        ..self::options()
    };
    let notes = plan(&gantry, Kind::Path, &at_end).unwrap().notes;
    assert!(notes.iter().any(|n| n.to_string().starts_with("Z comes to less than 2 %")), "{notes:?}");
    assert!(notes.iter().any(|n| n.to_string().contains("hangs below its centre")), "{notes:?}");
    let said = refused(Kind::Path, 0.3, 9.0);
    assert!(said.contains("on no arc of which the arm stays within its ranges"), "{said}");
}
