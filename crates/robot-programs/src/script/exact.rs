//! A changed number is what stood there and its offset, to the last digit that is written, in every format: no binary fraction of
//! another unit stands between them.

use super::harness::{applied, moves, parse, values};
use super::{Edit, Edits, Format};
use crate::axes::Axes;
use crate::fanuc::Fanuc;
use crate::fixtures::{gantry, irb1600, kr120, m10ia, ma2010, ur10};
use crate::gcode::Gcode;
use crate::inform::Inform;
use crate::krl::Krl;
use crate::rapid::Rapid;
use crate::trajectory::Ros;
use crate::urscript::UrScript;

/// The program after the first number of its first move has got `by`, rad or m, with the digits that it has.
fn moved(format: &dyn Format, robot: &Axes, source: &str, by: f64) -> String {
    let document = parse(format, source.as_bytes(), robot).unwrap_or_else(|e| panic!("{e}\n{source}"));
    let step = moves(document.script())[0].0;
    let mut goal = values(document.script(), step);
    goal[0] += by;
    let edit = Edit { goal: Some(goal), ..Edit::default() };
    let out = applied(document.as_ref(), &Edits { steps: [(step, edit)].into(), ..Edits::default() }).unwrap();
    String::from_utf8(out.into_iter().next().unwrap()).unwrap()
}

/// Offsets by half a last digit: through radians and back half of these sums fall to the wrong side.
#[test]
fn half_a_last_digit_is_rounded_away_from_zero_in_every_format() {
    let degree = 1f64.to_radians();
    let pulse = 1.0 / ma2010(None).axis(0).pulses.unwrap();
    let formats: [(&dyn Format, Axes, &str, f64); 7] = [
        (&Krl, kr120(), "DEF a( )\nPTP {A1 $,A2 -90,A3 90,A4 0,A5 10,A6 0}\nEND\n", degree),
        (
            &Rapid,
            irb1600(),
            "MODULE m\nPROC main()\nMoveAbsJ [[$,2,3,4,5,6],[9E9,9E9,9E9,9E9,9E9,9E9]],v5,fine,tool0;\nENDPROC\nENDMODULE\n",
            degree,
        ),
        (&UrScript, ur10(), "def p():\n  movej([$, -1.5, 1, 0, 0, 0], a=1, v=1)\nend\n", 1.0),
        (&Gcode, gantry(), "%\nO1\nG21 G90\nG1 X$ Y10.5 F1000\nM30\n", 1e-3),
        (
            &Ros,
            ur10(),
            "joint_names: [base, shoulder, elbow, wrist1, wrist2, wrist3]\npoints:\n- positions: [$, 0.5, 0.5, 0.5, 0.5, 0.5]\n  time_from_start: {secs: 1, nsecs: 0}\n",
            1.0,
        ),
        (
            &Fanuc,
            m10ia(),
            "/PROG  A\n/MN\n   1:J P[1] 100% FINE    ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\n\tJ1= $ deg,\tJ2= 0.000 deg,\tJ3= 0.000 deg,\n\tJ4= 0.000 deg,\tJ5= 0.000 deg,\tJ6= 0.000 deg\n};\n/END\n",
            degree,
        ),
        (
            &Inform,
            ma2010(None),
            "/JOB\n//NAME A\n//POS\n///NPOS 1,0,0,0,0,0\n///TOOL 0\n///POSTYPE PULSE\n///PULSE\nC00000=$,0,0,0,0,0\n//INST\n///DATE 2024/01/01 10:00\n///ATTR SC,RW\n///GROUP1 RB1\nNOP\nMOVJ C00000 VJ=25.00\nEND\n",
            pulse,
        ),
    ];
    for (format, robot, source, unit) in formats {
        let decimals: usize = match format.name() {
            "inform" => 0,
            "fanuc" => 3,
            _ => 2,
        };
        let shown = |count: i64| match decimals {
            0 => count.to_string(),
            d => {
                let (sign, size) = (if count < 0 { "-" } else { "" }, count.abs());
                format!("{sign}{}.{:0d$}", size / 10i64.pow(d as u32), size % 10i64.pow(d as u32))
            }
        };
        for count in (1i64..320).flat_map(|n| [n, -n]) {
            let half = 0.5 * 10f64.powi(-(decimals as i32)) * unit * (count as f64).signum();
            let out = moved(format, &robot, &source.replace('$', &shown(count)), half);
            let want = source.replace('$', &shown(count + count.signum()));
            let blanks = |text: &str| text.split_ascii_whitespace().collect::<Vec<_>>().join(" ");
            assert_eq!(blanks(&out), blanks(&want), "{} {count}", format.name());
        }
    }
}
