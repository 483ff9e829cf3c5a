//! Lists the joint targets of a program, with their lines: `cargo run -p robot-programs --example targets PROGRAM [AXES]`.
//!
//! `AXES` names the axes and their units: `A1:deg,A2:deg,E1:mm`; `A1:pulse` shows joints that a program holds in pulses as they are.
//! Without it the program is read for six revolute axes A1 to A6.

use robot_programs::axes::{Axes, Axis, JointKind};
use robot_programs::files::Files;
use robot_programs::formats::{self, Recognised};
use robot_programs::script::{Goal, Text};
use std::path::Path;

fn axis(text: &str) -> Result<Axis, String> {
    match text.split_once(':') {
        Some((name, "deg")) => Ok(Axis::new(name, JointKind::Revolute)),
        Some((name, "mm")) => Ok(Axis::new(name, JointKind::Prismatic)),
        // one pulse is shown as one degree
        Some((name, "pulse")) => {
            Ok(Axis { pulses: Some(1.0_f64.to_degrees()), ..Axis::new(name, JointKind::Revolute) })
        }
        _ => Err(format!("found `{text}`; expected a name and a unit: `A1:deg`, `A1:pulse` or `X:mm`")),
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: targets PROGRAM [A1:deg,A2:deg,...]")?;
    let table = arguments.next().unwrap_or_else(|| "A1:deg,A2:deg,A3:deg,A4:deg,A5:deg,A6:deg".into());
    let axes = Axes::new("robot", table.split(',').map(axis).collect::<Result<_, _>>()?);

    let bytes = std::fs::read(&path)?;
    let Recognised::Script(format) = formats::recognise(Path::new(&path), &bytes) else {
        return Err(format!("{path}: joint-space CSV; its columns are its targets").into());
    };
    let mut texts = vec![Text::new(&path, bytes)];
    for more in format.companions(Path::new(&path), &Files::Disk) {
        texts.push(Text::new(more.display().to_string(), std::fs::read(&more)?));
    }
    let document = format.parse(texts, &axes)?;
    let script = document.script();
    for (step, m) in script.moves() {
        let place = script.place(script.steps[step].at);
        match &m.goal {
            Goal::Joints(t) => {
                let shown = script.targets.get(*t).unwrap().values.iter().zip(axes.axis_joints());
                let shown = shown.map(|(v, a)| v.map_or("-".into(), |v| format!("{:.4}", a.kind.to_user_unit(v.si))));
                let elsewhere: Vec<&str> = m.displaced.axes().map(|a| axes.axis(a).name.as_str()).collect();
                let origin = if elsewhere.is_empty() {
                    String::new()
                } else {
                    format!(" ({} from another origin)", elsewhere.join(","))
                };
                println!("{place}: {}{origin}", shown.collect::<Vec<_>>().join(" "));
            }
            Goal::Pose(_) => println!("{place}: a Cartesian target"),
            Goal::Opaque(why) => println!("{place}: {why}"),
        }
    }
    Ok(())
}
