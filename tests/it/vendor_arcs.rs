//! An arc inside of which a joint turns becomes several arcs on the same circle.
//!
//! The only gap is that of the first axis, which turns the arm about the vertical through the origin: so the offset of every written
//! point is known without any kinematics. Turned back by half the gap, each point must lie on the circle of the program.

use crate::support::{self, WorkFolder, bundled};

const HALF_GAP_DEG: f64 = 0.004;
/// Most of an arc that a step may take: with 4.6 deg the largest error of the circle of `benches/cartesian_circle.py` grows.
const LONGEST_STEP_DEG: f64 = 3.0;
/// Half a last digit of 0.0001 mm in three coordinates, and what the orientation's digits and rounding of the centre add, mm.
const DIGITS_MM: f64 = 1.5e-4;

/// The circle of a program: centre and radius in a horizontal plane, mm, and where its arc starts and ends, deg.
struct Circle {
    centre: [f64; 3],
    radius: f64,
    ends_deg: [f64; 2],
    /// Distance of the arm's plane from its first axis, mm.
    beside: f64,
}

impl Circle {
    fn at(&self, deg: f64) -> [f64; 3] {
        let [x, y, z] = self.centre;
        [x + self.radius * deg.to_radians().cos(), y + self.radius * deg.to_radians().sin(), z]
    }

    /// Distance of a point from the circle, mm.
    fn off(&self, p: [f64; 3]) -> f64 {
        let [x, y, z] = [0, 1, 2].map(|k| p[k] - self.centre[k]);
        (x.hypot(y) - self.radius).hypot(z)
    }

    /// By how many half gaps the point is turned about the vertical axis: -1, 0 or 1, the one with which it lies on the circle.
    fn side(&self, p: [f64; 3]) -> (i32, f64) {
        [-1, 0, 1]
            .into_iter()
            .map(|side| (side, self.off(turned_back(p, f64::from(side)))))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .unwrap()
    }

    /// Angle of a point, deg, next to where the arc is.
    fn deg(&self, p: [f64; 3]) -> f64 {
        let middle = 0.5 * (self.ends_deg[0] + self.ends_deg[1]);
        let deg = (p[1] - self.centre[1]).atan2(p[0] - self.centre[0]).to_degrees();
        deg + 360.0 * ((middle - deg) / 360.0).round()
    }
}

/// A point turned back about the vertical axis by a number of half gaps.
fn turned_back(p: [f64; 3], half_gaps: f64) -> [f64; 3] {
    let (s, c) = (-half_gaps * HALF_GAP_DEG.to_radians()).sin_cos();
    [c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]]
}

/// A piece: over a place (`None`: straight) to a place.
type Piece = (Option<[f64; 3]>, [f64; 3]);

fn rewritten(robot: &str, joint: &str, name: &str, program: &str, options: &str) -> (String, String) {
    let folder = WorkFolder::new();
    let path = |n: &str| folder.join(n);
    std::fs::copy(bundled("configs").join(robot), path("robot.yaml")).unwrap();
    let effect = format!("{{effect: backlash, joint: {joint}, half_gap_deg: {HALF_GAP_DEG}}}");
    std::fs::write(
        path("model.yaml"),
        format!("schema: lostmotion/model/1\nrobot: robot.yaml\neffects:\n  - {effect}\n"),
    )
    .unwrap();
    std::fs::write(path(name), program).unwrap();
    let line = format!("rewrite --model model.yaml {name} --output out_{name} {options}");
    let run = support::command().current_dir(folder.path()).args(line.split_whitespace()).output();
    let run = run.unwrap();
    let said = String::from_utf8_lossy(&run.stdout).into_owned() + &String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{said}");
    (std::fs::read_to_string(path(&format!("out_{name}"))).unwrap(), said)
}

/// All numbers of a text, in their order, unit letters and brackets left out.
fn numbers(text: &str) -> Vec<f64> {
    let parts = text.split(|c: char| !(c.is_ascii_digit() || "+-.E".contains(c)));
    parts.filter(|p| p.contains(|c: char| c.is_ascii_digit())).filter_map(|p| p.parse().ok()).collect()
}

fn xyz(text: &str) -> [f64; 3] {
    let n = numbers(text);
    [n[0], n[1], n[2]]
}

/// Three points of a circle: whether it stays within `most` of another one between the first and the last.
fn bends(circle: &Circle, a: [f64; 3], b: [f64; 3], c: [f64; 3], most: f64) {
    // in the plane: centre from the bisectors
    let [bx, by, cx, cy] = [b[0] - a[0], b[1] - a[1], c[0] - a[0], c[1] - a[1]];
    let d = 2.0 * (bx * cy - by * cx);
    let (bb, cc) = (bx * bx + by * by, cx * cx + cy * cy);
    let centre = [a[0] + (cy * bb - by * cc) / d, a[1] + (bx * cc - cx * bb) / d];
    let radius = (a[0] - centre[0]).hypot(a[1] - centre[1]);
    for k in 0..=20 {
        let (from, to) = ((a[1] - centre[1]).atan2(a[0] - centre[0]), (c[1] - centre[1]).atan2(c[0] - centre[0]));
        let sweep = to - from - std::f64::consts::TAU * ((to - from) / std::f64::consts::TAU).round();
        let at = from + sweep * f64::from(k) / 20.0;
        let p = [centre[0] + radius * at.cos(), centre[1] + radius * at.sin(), 0.5 * (a[2] + c[2])];
        assert!(circle.off(p) <= most, "{p:?} is {} mm off", circle.off(p));
    }
}

/// Every piece lies on the circle once the offset is taken back, in order, and the side changes once inside the arc. Each goes over its
/// middle, unless less than `after_via_deg` would follow.
fn check(circle: &Circle, start: [f64; 3], pieces: &[Piece], digits_mm: f64, after_via_deg: f64) {
    assert!(pieces.len() >= 2, "{pieces:?}");
    let reach = circle.centre[0].hypot(circle.centre[1]) + circle.radius;
    let most = HALF_GAP_DEG.to_radians() * reach + digits_mm;
    let (mut before, mut sides) = (start, vec![circle.side(start).0]);
    for (via, end) in pieces {
        let (side, off) = circle.side(*end);
        assert!(off <= digits_mm, "{end:?} is {off} mm off the circle ({side})");
        let sign = (circle.ends_deg[1] - circle.ends_deg[0]).signum();
        assert!(sign * circle.deg(*end) > sign * circle.deg(before), "{pieces:?}");
        if let Some(via) = via {
            // the step is spread over the piece: on its way there is the part of the place
            let [from, to] = [before, *end].map(|p| f64::from(circle.side(p).0));
            let [a, c] = [(before, from), (*end, to)].map(|(p, side)| sign * circle.deg(turned_back(p, side)));
            let part = (1.0 - after_via_deg / (c - a)).min(0.5);
            let own = turned_back(*via, (1.0 - part) * from + part * to);
            let (off, b) = (circle.off(own), sign * circle.deg(own));
            assert!(off <= digits_mm, "{via:?} is {off} mm off the circle");
            assert!((a + part * (c - a) - b).abs() < 0.01, "{b} is not at {part} of {a} to {c}");
            bends(circle, before, *via, *end, most);
        }
        sides.push(circle.side(*end).0);
        before = *end;
    }
    let (first, last) = (sides[0], sides[sides.len() - 1]);
    assert!(first * last == -1 && sides.windows(2).filter(|w| w[0] != w[1]).count() == 1, "{sides:?}");
    // the axis turns where the circle's tangent lies in the arm's plane: at its distance from the origin
    let turn = sides.iter().position(|s| *s != first).unwrap();
    let at = circle.deg(if turn == 1 { start } else { pieces[turn - 2].1 });
    let touches = 180.0 - ((circle.radius - circle.beside) / circle.centre[0]).acos().to_degrees();
    assert!((at - touches).abs() < 0.5, "{at} and not {touches}");
    // a step over more of the arc leaves the path further than the gap itself does
    let step_deg = (circle.deg(pieces[turn - 1].1) - at).abs();
    assert!(step_deg < LONGEST_STEP_DEG, "the step takes {step_deg} deg: {pieces:?}");
}

const KRL: Circle = Circle { centre: [1500.0, 0.0, 1200.0], radius: 150.0, ends_deg: [30.0, 170.0], beside: 0.0 };

fn krl(arc: &str, more: &str) -> String {
    let p = |deg: f64| {
        let [x, y, z] = KRL.at(deg);
        format!("{{X {x:.6},Y {y:.6},Z {z:.6},A 0.0,B 180.0,C 0.0}}")
    };
    let arc = arc.replace("AUX", &p(80.0)).replace("END", &p(170.0));
    format!(
        "&ACCESS RVP\r\nDEF arcs( )\r\n{more}$BASE=$NULLFRAME\r\n$TOOL=$NULLFRAME\r\n\
         PTP {{A1 20.0,A2 -90.0,A3 90.0,A4 0.0,A5 90.0,A6 0.0}}\r\nLIN {}\r\n{arc}\r\nEND\r\n",
        p(30.0)
    )
}

fn krl_pieces(out: &str) -> ([f64; 3], Vec<Piece>) {
    let lines: Vec<&str> = out
        .lines()
        .map(|l| l.trim_start_matches('S'))
        .filter(|l| l.starts_with("LIN") || l.starts_with("CIRC"))
        .collect();
    let piece = |l: &&str| match l.strip_prefix("CIRC") {
        Some(rest) => {
            let (via, end) = rest.split_once("},").unwrap();
            (Some(xyz(via)), xyz(end))
        }
        None => (None, xyz(l)),
    };
    (xyz(lines[0]), lines[1..].iter().map(piece).collect())
}

#[test]
fn a_circ_becomes_several_on_its_circle() {
    let (out, said) = rewritten("kuka-kr120-r2500-pro.yaml", "A1", "arcs.src", &krl("CIRC AUX,END C_DIS", ""), "");
    let (start, pieces) = krl_pieces(&out);
    // seven digits of a metre
    check(&KRL, start, &pieces, 8e-4, 0.0);
    assert!(out.lines().filter(|l| l.starts_with("CIRC")).all(|l| l.ends_with(" C_DIS")), "{out}\n{said}");
    // the words of the program's own arc stay, and its numbers but for the changed ones
    assert!(out.contains(",A 0.0,B 180.0,C 0.0} C_DIS\r\nEND") || out.contains("} C_DIS\r\nEND"), "{out}");
}

/// Arcs of a few tenths of a millimetre, of the size of the gap: an arc through a point on the way that stays while its ends move may
/// go anywhere. As a CIRC the point moves with its ends; that of a SCIRC cannot, so that the arc stays where it would bend.
#[test]
fn an_arc_as_small_as_the_gap_goes_where_the_program_s_goes() {
    for (word, radius, step_deg) in
        [("CIRC", 0.1, 30.0), ("CIRC", 0.3, 90.0), ("SCIRC", 0.1, 30.0), ("SCIRC", 3.0, 60.0)]
    {
        let circle = Circle { radius, ..KRL };
        let p = |deg: f64| {
            let [x, y, z] = circle.at(deg);
            format!("{{X {x:.4},Y {y:.4},Z {z:.4},A 0.0,B 180.0,C 0.0}}")
        };
        let count = (720.0 / step_deg) as u32;
        let end = |n: u32| 30.0 + step_deg * f64::from(n);
        let arcs: String =
            (0..count).map(|n| format!("{word} {},{}\r\n", p(end(n) + 0.5 * step_deg), p(end(n + 1)))).collect();
        let home = "PTP {A1 20.0,A2 -90.0,A3 90.0,A4 0.0,A5 90.0,A6 0.0}";
        let program = format!(
            "DEF small( )\r\n$BASE=$NULLFRAME\r\n$TOOL=$NULLFRAME\r\n{home}\r\nLIN {}\r\n{arcs}END\r\n",
            p(30.0)
        );
        let (out, said) = rewritten("kuka-kr120-r2500-pro.yaml", "A1", "small.src", &program, "");
        let from = out.lines().position(|l| l.starts_with("CIRC") || l.starts_with("SCIRC")).unwrap();
        let mut start = xyz(out.lines().nth(from - 1).unwrap());
        let most = 2.5 * HALF_GAP_DEG.to_radians() * 1600.0;
        for line in out.lines().skip(from).filter(|l| l.contains("CIRC")) {
            let (via, end) = line.split_once("},").unwrap();
            let [via, end] = [xyz(via), xyz(end)];
            bends(&circle, start, via, end, most);
            start = end;
        }
        let edited = out.lines().zip(program.lines()).filter(|(a, b)| a.contains("CIRC") && a != b).count();
        assert!(word == "SCIRC" && radius < 1.0 || edited > 3, "{word} {radius}: {edited}\n{out}\n{said}");
    }
}

#[test]
fn an_arc_whose_orientation_is_steered_or_turns_stays_whole() {
    let whole = |program: &str| {
        let (out, said) = rewritten("kuka-kr120-r2500-pro.yaml", "A1", "arcs.src", program, "");
        assert_eq!(krl_pieces(&out).1.len(), 1, "{out}\n{said}");
    };
    whole(&krl("CIRC AUX,END", "$CIRC_TYPE=#PATH\r\n"));
    whole(
        &krl("CIRC AUX,END", "")
            .replace("Z 1200.000000,A 0.0,B 180.0,C 0.0}\r\nEND", "Z 1200.000000,A 5.0,B 180.0,C 0.0}\r\nEND"),
    );
    whole(&krl("SCIRC AUX,END", ""));
}

const RAPID: Circle = Circle { centre: [750.0, 0.0, 900.0], radius: 120.0, ends_deg: [30.0, 170.0], beside: 0.0 };

#[test]
fn a_movec_becomes_several_on_its_circle() {
    let p = |deg: f64| {
        let [x, y, z] = RAPID.at(deg);
        format!("[[{x:.4},{y:.4},{z:.4}],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]")
    };
    let program = format!(
        "MODULE arcs\n  CONST robtarget p2:={};\n  PROC main()\n    ConfL\\Off;\n    \
         MoveAbsJ [[-20,0,0,0,90,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,fine,tool0;\n    MoveL {},v100,z1,tool0;\n    \
         MoveC p2, {}, v100, z10, tool0\\WObj:=wobj0;\n  ENDPROC\nENDMODULE\n",
        p(80.0),
        p(30.0),
        p(170.0)
    );
    let (out, said) = rewritten("abb-irb1600-6-145.yaml", "J1", "arcs.mod", &program, "");
    let lines: Vec<&str> =
        out.lines().map(str::trim).filter(|l| l.starts_with("MoveL") || l.starts_with("MoveC")).collect();
    let piece = |l: &&str| {
        let n: Vec<[f64; 3]> = l.split("[[").skip(1).map(xyz).collect();
        if l.starts_with("MoveC") { (Some(n[0]), n[1]) } else { (None, n[0]) }
    };
    let pieces: Vec<Piece> = lines[1..].iter().map(piece).collect();
    check(&RAPID, piece(&lines[0]).1, &pieces, DIGITS_MM, 0.04f64.to_degrees());
    // ABB (RAPID Instructions, MoveC): the angle between CirPoint and ToPoint, seen from the start, is at least 1 deg
    for (start, (via, end)) in std::iter::once(piece(&lines[0]).1).chain(pieces.iter().map(|p| p.1)).zip(&pieces) {
        let Some(via) = via else { continue };
        let seen = |p: &[f64; 3]| nalgebra::Vector3::from(*p) - nalgebra::Vector3::from(start);
        assert!(seen(via).angle(&seen(end)).to_degrees() > 1.0, "{start:?} {via:?} {end:?}");
    }
    // the point that it went over stays as it is declared
    assert!(out.contains(&format!("CONST robtarget p2:={};", p(80.0))), "{out}\n{said}");
    assert!(lines[1..].iter().all(|l| l.ends_with("tool0\\WObj:=wobj0;")), "{out}");
}

/// The UR10's fourth length, 163.941 mm, puts its plane beside the first axis.
const UR: Circle = Circle { centre: [700.0, 0.0, 400.0], radius: 120.0, ends_deg: [30.0, 170.0], beside: 163.941 };

#[test]
fn a_movec_of_urscript_becomes_several_on_its_circle() {
    let p = |deg: f64| {
        let [x, y, z] = UR.at(deg).map(|v| v * 1e-3);
        format!("p[{x:.9}, {y:.9}, {z:.9}, 0, 3.14159265, 0]")
    };
    let program = |mode: &str| {
        format!(
            "def arcs():\n  set_tcp(p[0, 0, 0, 0, 0, 0])\n  movej([3.0, -1.6, 2.0, -1.97, -1.57, 0.2], a=1.4, v=1.05)\n  \
             movel({}, a=1.2, v=0.1, r=0.001)\n  movec({}, {}, a=1.2, v=0.1, r=0.01{mode})\nend\n",
            p(30.0),
            p(80.0),
            p(170.0)
        )
    };
    let pieces = |out: &str| -> Vec<Piece> {
        let lines = out.lines().map(str::trim).filter(|l| l.starts_with("movel") || l.starts_with("movec"));
        let piece = |l: &str| {
            let n: Vec<[f64; 3]> = l.split("p[").skip(1).map(|t| xyz(t).map(|v| v * 1e3)).collect();
            if l.starts_with("movec") { (Some(n[0]), n[1]) } else { (None, n[0]) }
        };
        lines.map(piece).collect()
    };
    let joint = "base";
    let (out, said) = rewritten("universal-robots-ur10.yaml", joint, "arcs.script", &program(", mode=0"), "");
    let all = pieces(&out);
    assert!(all.len() > 2, "{out}\n{said}");
    check(&UR, all[0].1, &all[1..], DIGITS_MM, 0.0);
    assert!(out.lines().filter(|l| l.contains("movec")).all(|l| l.ends_with(", mode=0)")), "{out}");
    // the tool turns with the tangent
    let (out, said) = rewritten("universal-robots-ur10.yaml", joint, "arcs.script", &program(", mode=1"), "");
    assert_eq!(pieces(&out).len(), 2, "{out}\n{said}");
}
