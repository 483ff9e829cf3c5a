//! The page of the effect catalogue and a picture of what each effect does, simulated with the program's own machine chain.

use lostmotion::effects::catalogue::{ALL, FORMS};
use lostmotion::effects::{EffectForm, View, entry};
use lostmotion::io::yaml::Document;
use lostmotion::machine::{CommandTrajectory, predict};
use lostmotion::model::Model;
use lostmotion::report::plots::axes::{Frame, Size, extent, widen};
use lostmotion::report::plots::line;
use lostmotion::robot::Robot;
use maud::html;
use nalgebra::Vector3;
use std::fmt::Write;

/// A made-up arm of two joints in a vertical plane.
const ROBOT: &str = "schema: lostmotion/robot/1
joints:
  - {name: A1, kind: revolute, a_mm: 900, alpha_deg: 0}
  - {name: A2, kind: revolute, a_mm: 700}
links:
  - {mass_kg: 60, com_mm: [-450, 0, 0]}
  - {mass_kg: 30, com_mm: [-350, 0, 0]}
base: {xyz_mm: [0, 0, 0], rpy_deg: [90, 0, 0]}
";

/// Every file: path from the root of the repository, content.
pub fn all() -> Vec<(String, String)> {
    let mut files = vec![("docs/effects.md".to_string(), page())];
    let effects = ALL.iter().map(|c| (c.name, c.adds, c.example));
    let all = effects.chain(FORMS.iter().map(|f| (f.name, f.heading, f.example)));
    files.extend(all.map(|(name, says, example)| (format!("docs/effects/{name}.svg"), picture(name, says, example))));
    files
}

/// Commands in rad at 50 Hz over 24 s: A1 swings by 20 deg, ever slower in the view over speed; A2 by 30 deg.
fn motion(view: View) -> (Vec<f64>, Vec<Vec<f64>>) {
    let t_s: Vec<f64> = (0..=1200).map(|i| f64::from(i) * 0.02).collect();
    let turn = |t: f64| if view == View::JointWhileSlowing { 0.06 * t * t } else { t * std::f64::consts::FRAC_PI_4 };
    let a1 = t_s.iter().map(|&t| (20.0 * turn(t).sin()).to_radians()).collect();
    let a2 = t_s.iter().map(|&t| (60.0 + 30.0 * (0.5 * t).sin()).to_radians()).collect();
    (t_s, vec![a1, a2])
}

fn picture(name: &str, says: &str, (effect, view): (&str, View)) -> String {
    let robot = Robot::parse("example", ROBOT).expect("the example's robot is one");
    let mut model = Model::ideal(robot.clone());
    let (t_s, cmd) = motion(view);
    // a tool that is pressed down, harder and softer
    let force = t_s.iter().map(|t| Vector3::new(0.0, 0.0, -200.0 - 120.0 * (1.7 * t).sin())).collect();
    let drive = CommandTrajectory::of_columns(&robot, t_s.clone(), cmd.clone(), None, false).with_force(Some(force));
    let ideal = predict(&model, &drive);
    let value = serde_yaml::from_str(effect).expect("the example's effect is YAML");
    let placed = entry::read(&value, &robot, &Document { name: "example", text: effect });
    model.effects.push(placed.expect("the example's effect is one"));
    let real = predict(&model, &drive);
    let joint: Vec<f64> = real.joint[0].iter().zip(&cmd[0]).map(|(a, b)| (a - b).to_degrees() * 1e3).collect();
    let coordinate = |c: usize| -> Vec<f64> {
        real.points_m[0].iter().zip(&ideal.points_m[0]).map(|(a, b)| (a[c] - b[c]) * 1e6).collect()
    };
    let degrees = |axis: usize| cmd[axis].iter().map(|q| q.to_degrees()).collect::<Vec<f64>>();
    let (x, x_title, y_title, series): (_, _, _, Vec<Vec<f64>>) = match view {
        View::JointOverCommand => (degrees(0), "command of A1, deg", "error of A1, mdeg", vec![joint]),
        View::JointOverOther => (degrees(1), "command of A2, deg", "error of A1, mdeg", vec![joint]),
        View::JointOverTime | View::JointWhileSlowing => (t_s, "time, s", "error of A1, mdeg", vec![joint]),
        View::TcpOverTime => {
            (t_s, "time, s", "TCP error, um: along x (full), along z (dashed)", vec![coordinate(0), coordinate(2)])
        }
    };
    draw((name, says), &x, &series, x_title, y_title)
}

fn draw((name, says): (&str, &str), x: &[f64], series: &[Vec<f64>], x_title: &str, y_title: &str) -> String {
    const STYLE: &str = "text{font:11px system-ui,sans-serif;fill:#57616c}.grid{stroke:#dde2e7}.zero{stroke:#8a949e}\
.axis{stroke:#57616c}path{fill:none;stroke:#0072b2;stroke-width:1.6}.second{stroke:#d55e00;stroke-dasharray:5 3}\
@media(prefers-color-scheme:dark){text{fill:#a3adb8}.grid{stroke:#2e363f}path{stroke:#4da9e6}.second{stroke:#f58549}}";
    let xs = widen(extent(x.iter().copied()).unwrap_or([0.0, 1.0]), 0.02);
    let [lo, hi] = extent(series.iter().flatten().copied()).unwrap_or([0.0, 1.0]);
    let ys = widen([lo.min(0.0), hi.max(0.0)], 0.08);
    let frame = Frame::new(Size { top: 22.0, ..Size::SMALL }, xs, ys, false);
    let paths: Vec<String> = series
        .iter()
        .map(|y| {
            // a loop over the command goes back and forth: every point is drawn
            let (points, _) = line::points(x, y);
            line::path(points.into_iter().step_by(2).map(|p| p.map(|[x, y]| [frame.x.at(x), frame.y.at(y)])))
        })
        .collect();
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox=(frame.size.view_box()) width="360" height="240" role="img" aria-label=(name) {
            title { (name) ": " (says) }
            style { (maud::PreEscaped(STYLE)) }
            (frame.axes(x_title, y_title))
            @for (i, d) in paths.iter().enumerate() { path.second[i == 1] d=(d) {} }
        }
    };
    markup.into_string() + "\n"
}

fn page() -> String {
    let mut md = String::from(
        "# The effect catalogue

Written by `cargo run --example effect_pictures` from the files of `src/effects`; a test checks that this page is up to date.
[Add an effect](add-an-effect.md) shows how to extend the catalogue.

One catalogue serves `simulate`, `diagnose`, `assess` and `rewrite --model`. Each effect has one name, one equation and one place in the
chain: command -> servo -> gear -> link -> geometry -> TCP -> measurement. Each stage acts on the result of the stage before: the gear
follows the output of the servo. Within a stage, effects act in the order of the model file; a joint may have the same effect twice.

`p` is the commanded position of a joint, `dir` the sign of its last movement (a pause keeps it), `t_rev` the time of its last reversal.
Before a joint's first movement, the play is in the middle of its gap and `z = 0`, unless the model file states
`initial_gap_side: {A1: +1}` (`preload` in older files). Times count from the first row of a log. Settled poses (a log without `t_s`) have no time: whatever fades
over time has faded, and there is no lag, drift, vibration or time offset.

An entry names its joint (`joint: A1`), its coupling (`target: A6<-A5`) or its DH parameter (`target: A2.a`); effects of the tool, the TCP
and the log need no name. Keys end in `_deg` for a revolute joint and in `_mm` for a prismatic one (`compliance_mm_per_n`,
`slope_mm_per_mm_s`; `cycles_per_rev` counts turns of its lead screw). The bounds apply to a fit. A model file may exceed them, unless the
equation would have no meaning (a negative gap, a decay of 0).

The pictures show an invented arm of two joints: the error of joint A1 in thousandths of a degree, or of the TCP in micrometres.

| effect | stage | target | adds |
| --- | --- | --- | --- |
",
    );
    for c in ALL {
        let _ = writeln!(
            md,
            "| [`{0}`](#{0}) | {1} | {2} | {3} |",
            c.name,
            c.stage.text(),
            cell(c.acts_on.text()),
            cell(c.adds)
        );
    }
    for c in ALL {
        let (effect, _) = c.example;
        let _ = write!(
            md,
            "\n## {0}\n\n![{0}](effects/{0}.svg)\n\n{1}. Acts on: {2}; stage: {3}.\n\n    {4}\n\nReference: {5}.\n\n```yaml\n- {effect}\n```\n\n| parameter | meaning and bounds |\n| --- | --- |\n",
            c.name,
            capital(c.adds),
            c.acts_on.text(),
            c.stage.text(),
            c.equation,
            c.reference,
        );
        for (key, meaning) in c.parameters {
            let _ = writeln!(md, "| `{key}` | {} |", cell(meaning));
        }
        let alternatives: Vec<String> = c.confused_with.iter().map(|r| format!("[`{r}`](#{r})")).collect();
        let _ = write!(
            md,
            "\n- Confused with: {}.\n- What decides: {}.\n- What to do: {}.\n",
            alternatives.join(", "),
            c.decide_by,
            c.action
        );
        FORMS.iter().filter(|f| f.of.name == c.name).for_each(|f| form(f, &mut md));
    }
    md.push_str(TAIL);
    md.push_str("\n## What `rewrite` compensates\n\nA note of `rewrite --model` names the effects that it does not compensate.\n\n| effect | what `rewrite --model` compensates |\n| --- | --- |\n");
    for c in ALL {
        let _ = writeln!(md, "| [`{0}`](#{0}) | {1} |", c.name, cell(c.undone));
    }
    md
}

/// The part of a form of an effect.
fn form(f: &EffectForm, md: &mut String) {
    let (effect, _) = f.example;
    let _ = write!(
        md,
        "\n### {0} {1}\n\n![{2}](effects/{2}.svg)\n\n    {3}\n\nReference: {4}. Typical: {5}.\n\n```yaml\n- {effect}\n```\n\n- A diagnosis {6}.\n- `rewrite --model` undoes {7}.\n",
        f.of.name, f.heading, f.name, f.equation, f.reference, f.typical, f.diagnosis, f.undone,
    );
}

const TAIL: &str = "
## What is not in the catalogue

- The part of refraction along the beam: air of another mean temperature than was entered lengthens every distance alike, which is
  [`tracker_scale`](#tracker_scale).
- Moments of a process on the tool: [`process_force`](#process_force) knows the force at the TCP alone. Without columns of the force, the
  joints yield to its torque all the same, which [`torque_windup`](#torque_windup) takes from the drives where these are logged.

## How it was checked

`tests/oracle/catalogue_oracle.py` was written from the equations alone. It steps every joint in time at 0.25 ms, with commands known as
formulas, kinematics as products of 4 x 4 matrices, and the torque of gravity as the derivative of the potential energy. `simulate` gets
the commands as rows at 20 Hz. There are 73 cases on two invented robots (a six-axis arm in the standard convention; a slide in Craig's
convention, with a lead screw and a joint that follows another), with settled poses and a program among them. The largest difference of
the TCP is 0.2 um (`backlash_speed`, whose speed comes from the rows, and a stiction before a lag), and below 0.1 um in the other cases.
`tests/it/catalogue.rs` requires 0.5 um.
";

/// Text in a table's cell.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |c| c.to_uppercase().chain(chars).collect())
}
