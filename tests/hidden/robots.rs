//! Robots: catalogue machines with lengths, masses and tools perturbed per case, and their files.
//!
//! Lengths in metres, angles in radians inside; the numbers are rounded as the file prints them before they are used,
//! so that the file says exactly what the physics runs.

use crate::kinematics::{Pose, rpy, translation};
use nalgebra::Vector3;
use rand::Rng;
use rand_chacha::ChaCha8Rng;
use serde_yaml::Value;
use std::fmt::Write as _;

/// One joint: Denavit-Hartenberg numbers, limits and the swing a path gives it (rad or m).
#[derive(Clone, Debug)]
pub struct Joint {
    pub name: String,
    pub revolute: bool,
    pub theta_rad: f64,
    pub d_m: f64,
    pub a_m: f64,
    pub alpha_rad: f64,
    pub direction: f64,
    pub limits: [f64; 2],
    pub max_speed: f64,
    pub max_accel: f64,
    pub lead_m: f64,
    pub home: f64,
    pub swing: f64,
}

impl Joint {
    /// Inside per file unit: rad per degree, m per millimetre.
    pub fn unit(&self) -> f64 {
        if self.revolute { 1f64.to_radians() } else { 1e-3 }
    }

    /// `deg` or `mm`.
    pub fn suffix(&self) -> &'static str {
        if self.revolute { "deg" } else { "mm" }
    }
}

/// Mass and centre of mass of a link, in the frame of its joint.
#[derive(Clone, Debug)]
pub struct Link {
    pub mass_kg: f64,
    pub com_m: Vector3<f64>,
}

#[derive(Clone, Debug)]
pub struct Robot {
    pub name: String,
    pub modified: bool,
    pub joints: Vec<Joint>,
    pub links: Vec<Link>,
    pub tool_xyz_m: [f64; 3],
    pub tool_rpy_rad: [f64; 3],
    /// The three joints that carry the TCP through a circle or a raster.
    pub arm: [usize; 3],
}

/// A value as the file prints it, with so many decimals.
pub fn rounded(value: f64, decimals: i32) -> f64 {
    let scale = 10f64.powi(decimals);
    let r = (value * scale).round() / scale;
    if r == 0.0 { 0.0 } else { r }
}

struct Row(&'static str, char, [f64; 4], f64, [f64; 2], f64, f64, f64);

struct Entry {
    name: &'static str,
    modified: bool,
    rows: &'static [Row],
    masses: &'static [(f64, [f64; 3])],
    arm: [usize; 3],
}

// Row: name, kind, [theta, d, a, alpha] (deg, mm), direction, limits, max speed, home, swing.
const KUKA: Entry = Entry {
    name: "KUKA KR 120 R2500 PRO variant",
    modified: false,
    rows: &[
        Row("A1", 'r', [0., 675., 350., -90.], -1., [-185., 185.], 136., 0., 75.),
        Row("A2", 'r', [0., 0., 1150., 0.], 1., [-140., -5.], 130., -77., 36.),
        Row("A3", 'r', [-90., 0., -41., -90.], 1., [-120., 155.], 120., 96., 38.),
        Row("A4", 'r', [0., 1000., 0., 90.], -1., [-350., 350.], 292., -8., 95.),
        Row("A5", 'r', [0., 0., 0., -90.], 1., [-125., 125.], 258., 42., 70.),
        Row("A6", 'r', [0., 215., 0., 0.], -1., [-350., 350.], 284., 15., 155.),
    ],
    masses: &[
        (280., [-200., 370., 0.]),
        (180., [-620., 20., 10.]),
        (115., [30., 0., 0.]),
        (45., [-20., -530., 0.]),
        (21., [0., 0., 0.]),
        (13., [0., 0., -130.]),
    ],
    arm: [0, 1, 2],
};

const ABB: Entry = Entry {
    name: "ABB IRB 1600-6/1.45 variant",
    modified: false,
    rows: &[
        Row("J1", 'r', [0., 486.5, 150., -90.], 1., [-180., 180.], 150., 10., 72.),
        Row("J2", 'r', [-90., 0., 700., 0.], 1., [-63., 110.], 160., 17., 36.),
        Row("J3", 'r', [0., 0., 0., -90.], 1., [-235., 55.], 170., -13., 40.),
        Row("J4", 'r', [0., 600., 0., 90.], 1., [-200., 200.], 320., 3., 90.),
        Row("J5", 'r', [0., 0., 0., -90.], 1., [-115., 115.], 400., 40., 70.),
        Row("J6", 'r', [180., 65., 0., 0.], 1., [-400., 400.], 460., 20., 155.),
    ],
    masses: &[
        (73., [-85., 255., 0.]),
        (45., [-390., 0., 0.]),
        (33., [-15., 0., 0.]),
        (11.5, [0., -340., 0.]),
        (6.5, [0., 0., -10.]),
        (3.2, [0., 0., -35.]),
    ],
    arm: [0, 1, 2],
};

const UR: Entry = Entry {
    name: "UR10e variant",
    modified: false,
    rows: &[
        Row("base", 'r', [0., 180.7, 0., 90.], 1., [-360., 360.], 120., 2., 78.),
        Row("shoulder", 'r', [0., 0., -612.7, 0.], 1., [-360., 360.], 120., -110., 38.),
        Row("elbow", 'r', [0., 0., -571.55, 0.], 1., [-360., 360.], 180., 91., 40.),
        Row("wrist1", 'r', [0., 174.15, 0., 90.], 1., [-360., 360.], 180., -72., 80.),
        Row("wrist2", 'r', [0., 119.85, 0., -90.], 1., [-360., 360.], 180., -80., 65.),
        Row("wrist3", 'r', [0., 116.55, 0., 0.], 1., [-360., 360.], 180., -12., 150.),
    ],
    masses: &[
        (7.4, [-20., -120., 0.]),
        (13.5, [350., 0., 20.]),
        (3.9, [310., 0., 0.]),
        (1.9, [0., -90., -15.]),
        (2.0, [0., 40., 10.]),
        (0.65, [0., 0., -80.]),
    ],
    arm: [0, 1, 2],
};

const FANUC: Entry = Entry {
    name: "FANUC M-20iA like",
    modified: true,
    rows: &[
        Row("J1", 'r', [0., 525., 0., 0.], 1., [-170., 170.], 195., -12., 73.),
        Row("J2", 'r', [-90., 0., 150., -90.], 1., [-100., 160.], 175., 11., 40.),
        Row("J3", 'r', [0., 0., 770., 0.], -1., [-185., 120.], 180., 3., 40.),
        Row("J4", 'r', [0., 835., 240., -90.], -1., [-200., 200.], 360., 25., 85.),
        Row("J5", 'r', [0., 0., 0., 90.], 1., [-140., 140.], 360., 36., 68.),
        Row("J6", 'r', [0., 100., 0., -90.], -1., [-270., 270.], 550., -10., 155.),
    ],
    masses: &[
        (100., [50., 0., -10.]),
        (60., [370., 0., 0.]),
        (48., [90., 350., 0.]),
        (14., [0., 0., 0.]),
        (5.5, [0., 20., 0.]),
        (2.7, [0., 0., 15.]),
    ],
    arm: [0, 1, 2],
};

const STAUBLI: Entry = Entry {
    name: "Staubli TX2-90 like",
    modified: true,
    rows: &[
        Row("J1", 'r', [0., 478., 0., 0.], 1., [-180., 180.], 200., 5., 75.),
        Row("J2", 'r', [-90., 0., 50., -90.], 1., [-130., 147.], 200., 25., 40.),
        Row("J3", 'r', [90., 50., 425., 0.], 1., [-145., 145.], 285., 65., 45.),
        Row("J4", 'r', [0., 425., 0., 90.], 1., [-270., 270.], 300., -10., 90.),
        Row("J5", 'r', [0., 0., 0., -90.], 1., [-115., 140.], 270., 45., 68.),
        Row("J6", 'r', [0., 100., 0., 90.], 1., [-270., 270.], 400., 20., 155.),
    ],
    masses: &[
        (40., [0., 30., -60.]),
        (28., [210., 0., 60.]),
        (18., [10., 0., 30.]),
        (9., [0., -20., -150.]),
        (3., [0., 0., 10.]),
        (1.2, [0., 0., -20.]),
    ],
    arm: [0, 1, 2],
};

const SCARA: Entry = Entry {
    name: "SCARA 650 like",
    modified: true,
    rows: &[
        Row("J1", 'r', [0., 340., 0., 0.], 1., [-140., 140.], 300., -20., 95.),
        Row("J2", 'r', [0., 0., 325., 0.], 1., [-145., 145.], 400., 75., 85.),
        Row("Z", 'p', [0., 0., 325., 180.], 1., [0., 200.], 600., 100., 120.),
        Row("J4", 'r', [0., 0., 0., 0.], -1., [-360., 360.], 700., 10., 170.),
    ],
    masses: &[(11., [150., 0., 40.]), (9., [160., 0., 60.]), (1.6, [0., 0., -80.]), (0.5, [0., 0., 10.])],
    arm: [0, 1, 2],
};

const GANTRY: Entry = Entry {
    name: "Column machine ZYX-AB",
    modified: false,
    rows: &[
        Row("Z", 'p', [0., 0., 0., -90.], 1., [-200., 1200.], 600., 450., 450.),
        Row("Y", 'p', [90., 0., 0., 90.], 1., [-900., 900.], 900., 0., 1000.),
        Row("X", 'p', [0., 0., 0., 0.], -1., [-1300., 1300.], 900., 0., 1300.),
        Row("A", 'r', [0., -180., 0., 90.], 1., [-360., 360.], 200., 15., 160.),
        Row("B", 'r', [0., 0., 0., -90.], 1., [-115., 115.], 200., 25., 110.),
    ],
    masses: &[
        (420., [0., 300., 0.]),
        (150., [20., 0., 100.]),
        (80., [0., 0., 150.]),
        (25., [0., 40., 0.]),
        (12., [0., 0., -60.]),
    ],
    arm: [0, 1, 2],
};

/// Draws one robot; six-axis arms most of the time, a SCARA or a gantry in one case of seven.
pub fn draw(rng: &mut ChaCha8Rng) -> Robot {
    let entry = match rng.random_range(0..14) {
        0..=2 => &KUKA,
        3..=5 => &ABB,
        6..=8 => &UR,
        9..=10 => &FANUC,
        11 => &STAUBLI,
        12 => &SCARA,
        _ => &GANTRY,
    };
    perturbed(entry, rng)
}

/// Every machine of the catalogue, perturbed.
pub fn each(rng: &mut ChaCha8Rng) -> Vec<Robot> {
    [&KUKA, &ABB, &UR, &FANUC, &STAUBLI, &SCARA, &GANTRY].into_iter().map(|e| perturbed(e, rng)).collect()
}

fn perturbed(entry: &Entry, rng: &mut ChaCha8Rng) -> Robot {
    let length = |mm: f64, rng: &mut ChaCha8Rng| {
        if mm == 0.0 { 0.0 } else { rounded(mm * (1.0 + rng.random_range(-0.03..0.03)), 3) * 1e-3 }
    };
    let joints = entry
        .rows
        .iter()
        .map(|&Row(name, kind, dh, direction, limits, speed, home, swing)| {
            let revolute = kind == 'r';
            let unit = if revolute { 1f64.to_radians() } else { 1e-3 };
            let room = 0.08 * swing;
            Joint {
                name: name.into(),
                revolute,
                theta_rad: dh[0].to_radians(),
                d_m: length(dh[1], rng),
                a_m: length(dh[2], rng),
                alpha_rad: dh[3].to_radians(),
                direction,
                limits: limits.map(|v| v * unit),
                max_speed: speed * unit,
                max_accel: if revolute { 300.0 * unit } else { 4.0 },
                lead_m: if revolute { 0.0 } else { 0.02 },
                home: (home + rng.random_range(-room..room)) * unit,
                swing: swing * rng.random_range(0.85..1.15) * unit,
            }
        })
        .collect();
    let links = entry
        .masses
        .iter()
        .map(|&(mass, com)| Link {
            mass_kg: rounded(mass * (1.0 + rng.random_range(-0.12..0.12)), 3),
            com_m: Vector3::from(com.map(|c| rounded(c + rng.random_range(-20.0..20.0), 2) * 1e-3)),
        })
        .collect();
    let side = |rng: &mut ChaCha8Rng| rng.random_range(15.0..155.0) * if rng.random_bool(0.5) { 1.0 } else { -1.0 };
    let xyz = [side(rng), side(rng), rng.random_range(60.0..180.0)];
    Robot {
        name: entry.name.into(),
        modified: entry.modified,
        joints,
        links,
        tool_xyz_m: xyz.map(|v| rounded(v, 3) * 1e-3),
        tool_rpy_rad: [0; 3].map(|_: i32| rounded(rng.random_range(-18.0..18.0), 3).to_radians()),
        arm: entry.arm,
    }
}

impl Robot {
    /// Flange to TCP.
    pub fn tool(&self) -> Pose {
        translation(self.tool_xyz_m) * rpy(self.tool_rpy_rad)
    }

    /// Position of a joint in the list, by name.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.joints.iter().position(|j| j.name.eq_ignore_ascii_case(name))
    }

    /// The robot file.
    pub fn yaml(&self) -> String {
        let deg = |v: f64| rounded(v.to_degrees(), 6);
        let mm = |v: f64| rounded(v * 1e3, 3);
        let mut s = format!(
            "schema: lostmotion/robot/1\nname: {}\nconvention: {}\njoints:\n",
            self.name,
            if self.modified { "dh-modified" } else { "dh-standard" }
        );
        for j in &self.joints {
            let (u, x) = (j.unit(), j.suffix());
            let kind = if j.revolute { "revolute" } else { "prismatic" };
            let lead = if j.revolute { String::new() } else { format!(", lead_mm_per_rev: {}", mm(j.lead_m)) };
            let _ = writeln!(
                s,
                "  - {{name: \"{}\", kind: {kind}, theta_deg: {}, d_mm: {}, a_mm: {}, alpha_deg: {}, direction: {},\n     \
                 limits_{x}: [{}, {}], max_speed_{x}_s: {}, max_accel_{x}_s2: {}{lead}}}",
                j.name,
                deg(j.theta_rad),
                mm(j.d_m),
                mm(j.a_m),
                deg(j.alpha_rad),
                j.direction,
                rounded(j.limits[0] / u, 6),
                rounded(j.limits[1] / u, 6),
                rounded(j.max_speed / u, 6),
                rounded(j.max_accel / u, 6),
            );
        }
        s.push_str("links:\n");
        for l in &self.links {
            let c = [0, 1, 2].map(|k| rounded(l.com_m[k] * 1e3, 3));
            let _ = writeln!(s, "  - {{mass_kg: {}, com_mm: [{}, {}, {}]}}", l.mass_kg, c[0], c[1], c[2]);
        }
        let (t, r) = (self.tool_xyz_m.map(mm), self.tool_rpy_rad.map(deg));
        let _ = writeln!(
            s,
            "base: {{xyz_mm: [0, 0, 0], rpy_deg: [0, 0, 0]}}\ntool: {{xyz_mm: [{}, {}, {}], rpy_deg: [{}, {}, {}]}}\n\
             gravity_m_s2: [0, 0, -9.80665]",
            t[0], t[1], t[2], r[0], r[1], r[2]
        );
        s
    }

    /// Reads a robot file of the form that the cases use.
    pub fn parse(text: &str) -> Robot {
        let doc: Value = serde_yaml::from_str(text).expect("robot.yaml is YAML");
        let num = |v: &Value, key: &str| v.get(key).and_then(Value::as_f64).unwrap_or(0.0);
        let three =
            |v: Option<&Value>| [0usize, 1, 2].map(|k| v.and_then(|v| v.get(k)).and_then(Value::as_f64).unwrap_or(0.0));
        let list = |key: &str| doc.get(key).and_then(Value::as_sequence).cloned().unwrap_or_default();
        let joints: Vec<Joint> = list("joints")
            .iter()
            .map(|j| {
                let revolute = j.get("kind").and_then(Value::as_str) != Some("prismatic");
                let (unit, x) = if revolute { (1f64.to_radians(), "deg") } else { (1e-3, "mm") };
                let limit = j.get(format!("limits_{x}").as_str()).cloned().unwrap_or(Value::Null);
                let limits = [0usize, 1].map(|k| limit.get(k).and_then(Value::as_f64).unwrap_or(0.0) * unit);
                Joint {
                    name: j.get("name").and_then(Value::as_str).unwrap_or("?").into(),
                    revolute,
                    theta_rad: num(j, "theta_deg").to_radians(),
                    d_m: num(j, "d_mm") * 1e-3,
                    a_m: num(j, "a_mm") * 1e-3,
                    alpha_rad: num(j, "alpha_deg").to_radians(),
                    direction: j.get("direction").and_then(Value::as_f64).unwrap_or(1.0),
                    limits,
                    max_speed: num(j, &format!("max_speed_{x}_s")) * unit,
                    max_accel: num(j, &format!("max_accel_{x}_s2")) * unit,
                    lead_m: num(j, "lead_mm_per_rev") * 1e-3,
                    home: 0.5 * (limits[0] + limits[1]),
                    swing: 0.2 * (limits[1] - limits[0]),
                }
            })
            .collect();
        let links = list("links")
            .iter()
            .map(|l| Link { mass_kg: num(l, "mass_kg"), com_m: Vector3::from(three(l.get("com_mm"))) * 1e-3 })
            .collect();
        let tool = doc.get("tool").cloned().unwrap_or(Value::Null);
        Robot {
            name: doc.get("name").and_then(Value::as_str).unwrap_or("?").into(),
            modified: doc.get("convention").and_then(Value::as_str) == Some("dh-modified"),
            joints,
            links,
            tool_xyz_m: three(tool.get("xyz_mm")).map(|v| v * 1e-3),
            tool_rpy_rad: three(tool.get("rpy_deg")).map(f64::to_radians),
            arm: [0, 1, 2],
        }
    }
}
