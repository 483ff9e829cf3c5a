//! A robot from a URDF file: the chain from the root link to a tip, as Denavit-Hartenberg parameters.
//!
//! Method: every joint's axis is placed at the zero configuration by multiplying the joints' origins; [`super::dh`] finds the
//! frames of Denavit and Hartenberg (1955) on these lines; what remains before the first and after the last frame becomes
//! `base` and `tool`. The result is compared with the URDF's own chain at random joint positions.
//!
//! Numbers of a URDF are often rounded: `1.5708` for a quarter turn. An angle that is a multiple of 45 degrees to its written
//! digits is taken as that multiple, and reported.
//!
//! Refused: joints of kind `floating` and `planar`, a chain that branches without `--tip`, xacro that was not expanded.

use super::dh;
use super::{Follow, Joint, JointKind, Link, Robot};
use crate::error::{Error, Place, Result};
use nalgebra::{Isometry3, Point3, Translation3, Unit, UnitQuaternion, Vector3};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use roxmltree::{Document, Node};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;

/// A robot from a URDF and what the reader did on the way.
#[derive(Debug)]
pub struct FromUrdf {
    pub robot: Robot,
    /// Link at the end of the chain: its frame is the TCP.
    pub tip: String,
    /// Angles that were taken as a multiple of 45 deg: as written.
    pub snapped: Vec<String>,
    /// Largest distance between the URDF's chain and the robot's, m, and between their orientations, rad, at random positions.
    pub largest_error: (f64, f64),
}

/// Mass, kg, and centre of mass in the link's own frame, m.
type Inertia = (f64, Vector3<f64>);

/// One joint of the URDF on the chain.
struct Element {
    name: String,
    kind: Option<JointKind>,
    origin: Isometry3<f64>,
    axis: Unit<Vector3<f64>>,
    limits: Option<[f64; 2]>,
    max_speed: Option<f64>,
    /// Driving joint, ratio, offset.
    mimic: Option<(String, f64, f64)>,
    child: String,
}

/// Reads a URDF.
///
/// # Errors
/// [`Error::BadInput`] with line and column: not XML, no chain, a joint that cannot be expressed.
pub fn read(name: &str, text: &str, tip: Option<&str>) -> Result<FromUrdf> {
    let doc = Document::parse(text).map_err(|e| {
        let at = e.pos();
        Error::bad(
            Place::field(name, u64::from(at.row), u64::from(at.col)),
            format!("no XML here: {e}"),
            "a URDF file (XML; expand xacro files first)",
        )
    })?;
    let mut reader = Reader { name, doc: &doc, snapped: Vec::new() };
    let root = doc.root_element();
    if root.tag_name().name() != "robot" {
        let found = format!("<{}>", root.tag_name().name());
        return Err(reader.bad(root, found, "a <robot> element"));
    }
    let chain = reader.chain(root, tip)?;
    let tip = chain.last().map(|e| e.child.clone()).unwrap_or_default();
    let masses = reader.masses(root, &chain)?;
    let title = root.attribute("name").unwrap_or("robot");
    let robot = build(title, &chain, &masses)
        .map_err(|what| reader.bad(root, what, "a chain of revolute and prismatic joints"))?;
    let largest_error = compare(&robot, &chain);
    Ok(FromUrdf { robot, tip, snapped: reader.snapped, largest_error })
}

struct Reader<'a> {
    name: &'a str,
    doc: &'a Document<'a>,
    snapped: Vec<String>,
}

impl Reader<'_> {
    fn bad(&self, node: Node, found: impl Into<String>, expected: impl Into<String>) -> Error {
        let at = self.doc.text_pos_at(node.range().start);
        Error::bad(Place::field(self.name, u64::from(at.row), u64::from(at.col)), found, expected)
    }

    /// The joints from the root link to `tip`, in order.
    fn chain(&mut self, root: Node, tip: Option<&str>) -> Result<Vec<Element>> {
        let joints: Vec<Node> = children(root, "joint").collect();
        let parent_of = |j: &Node| link_of(j, "parent");
        let child_of = |j: &Node| link_of(j, "child");
        let tip = match tip {
            Some(t) => t.to_string(),
            None => {
                let moves = |j: &Node| j.attribute("type") != Some("fixed");
                let ends: Vec<String> = ends_of(&joints, moves);
                match ends.as_slice() {
                    [one] => one.clone(),
                    [] => return Err(self.bad(root, "no chain of joints", "joints that link a base to a tool")),
                    several => {
                        let found = format!("a chain that ends in {} places: {}", several.len(), several.join(", "));
                        return Err(self.bad(root, found, "--tip with the link that is the TCP"));
                    }
                }
            }
        };
        let mut chain = Vec::new();
        let mut at = tip.clone();
        while let Some(j) = joints.iter().find(|j| child_of(j).as_deref() == Some(&at)) {
            if chain.len() > joints.len() {
                return Err(self.bad(*j, "joints that go round in a circle", "a chain"));
            }
            let Some(parent) = parent_of(j) else {
                return Err(self.bad(*j, "a joint without <parent link=...>", "a parent link"));
            };
            chain.push(self.element(*j)?);
            at = parent;
        }
        if chain.iter().all(|e| e.kind.is_none()) {
            let found = format!("no joint that moves before link `{tip}`");
            return Err(self.bad(root, found, "a link of the URDF behind at least one moving joint"));
        }
        chain.reverse();
        Ok(chain)
    }

    fn element(&mut self, j: Node) -> Result<Element> {
        let name = j.attribute("name").unwrap_or_default().to_string();
        let kind = match j.attribute("type") {
            Some("revolute" | "continuous") => Some(JointKind::Revolute),
            Some("prismatic") => Some(JointKind::Prismatic),
            Some("fixed") => None,
            other => {
                let found = format!("joint `{name}` of type `{}`", other.unwrap_or(""));
                return Err(self.bad(j, found, "revolute, continuous, prismatic or fixed"));
            }
        };
        let axis = match child(j, "axis") {
            Some(a) => Vector3::from(self.numbers(a, "xyz", [1.0, 0.0, 0.0])?),
            None => Vector3::x(),
        };
        let axis = match Unit::try_new(axis, 1e-9) {
            Some(axis) => axis,
            // exporters write 0 0 0 for a joint that does not move
            None if kind.is_none() => Vector3::x_axis(),
            None => return Err(self.bad(j, format!("an axis of length 0 at joint `{name}`"), "a direction")),
        };
        let limit = child(j, "limit").filter(|_| j.attribute("type") != Some("continuous"));
        let (limits, max_speed) = match limit {
            Some(l) => (self.range(l)?, self.number(l, "velocity")?.filter(|v| *v > 0.0)),
            None => (None, None),
        };
        let mimic = match child(j, "mimic") {
            Some(m) => {
                let driver = m.attribute("joint").unwrap_or_default().to_string();
                Some((driver, self.number(m, "multiplier")?.unwrap_or(1.0), self.number(m, "offset")?.unwrap_or(0.0)))
            }
            None => None,
        };
        let Some(child) = link_of(&j, "child") else {
            return Err(self.bad(j, "a joint without <child link=...>", "a child link"));
        };
        Ok(Element { name, kind, origin: self.origin(j)?, axis, limits, max_speed, mimic, child })
    }

    fn range(&self, l: Node) -> Result<Option<[f64; 2]>> {
        let (lower, upper) = (self.number(l, "lower")?.unwrap_or(0.0), self.number(l, "upper")?.unwrap_or(0.0));
        Ok((lower < upper).then_some([lower, upper]))
    }

    fn origin(&mut self, node: Node) -> Result<Isometry3<f64>> {
        let Some(o) = child(node, "origin") else { return Ok(Isometry3::identity()) };
        let xyz = self.numbers(o, "xyz", [0.0; 3])?;
        let rpy = self.numbers(o, "rpy", [0.0; 3])?;
        let words: Vec<&str> = o.attribute("rpy").unwrap_or("0 0 0").split_whitespace().collect();
        let mut turns = [0.0; 3];
        for ((turn, value), word) in turns.iter_mut().zip(rpy).zip(words) {
            *turn = multiple_of_45_deg(value, word).unwrap_or(value);
            if *turn != value {
                self.snapped.push(word.to_string());
            }
        }
        let [r, p, y] = turns;
        Ok(Isometry3::from_parts(Translation3::from(Vector3::from(xyz)), UnitQuaternion::from_euler_angles(r, p, y)))
    }

    fn numbers(&self, node: Node, key: &str, default: [f64; 3]) -> Result<[f64; 3]> {
        let Some(text) = node.attribute(key) else { return Ok(default) };
        let values: Option<Vec<f64>> =
            text.split_whitespace().map(|w| w.parse::<f64>().ok().filter(|v| v.is_finite())).collect();
        match values.as_deref() {
            Some(&[a, b, c]) => Ok([a, b, c]),
            _ => Err(self.bad(node, format!("{key}=\"{text}\""), "three finite numbers (expand xacro files first)")),
        }
    }

    fn number(&self, node: Node, key: &str) -> Result<Option<f64>> {
        let Some(text) = node.attribute(key) else { return Ok(None) };
        match text.trim().parse::<f64>() {
            Ok(v) if v.is_finite() => Ok(Some(v)),
            _ => Err(self.bad(node, format!("{key}=\"{text}\""), "a finite number (expand xacro files first)")),
        }
    }

    /// Mass and centre of mass (in the link's own frame) of the child of each element.
    fn masses(&mut self, root: Node, chain: &[Element]) -> Result<Vec<Option<Inertia>>> {
        let mut out = Vec::with_capacity(chain.len());
        for e in chain {
            let link = children(root, "link").find(|l| l.attribute("name") == Some(&e.child));
            let inertial = link.and_then(|l| child(l, "inertial"));
            let found = match inertial {
                Some(i) => {
                    let mass = match child(i, "mass") {
                        Some(m) => self.number(m, "value")?.filter(|m| *m >= 0.0),
                        None => None,
                    };
                    let com = self.origin(i)?.translation.vector;
                    mass.map(|m| (m, com))
                }
                None => None,
            };
            out.push(found);
        }
        Ok(out)
    }
}

/// A multiple of 45 deg, in rad, of which `word` is the rounding to the digits that it has (two decimals at least).
fn multiple_of_45_deg(value: f64, word: &str) -> Option<f64> {
    let (mantissa, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len() as i32) - exponent.parse::<i32>().unwrap_or(0);
    let multiple = (value / FRAC_PI_4).round() * FRAC_PI_4;
    let digit = 10f64.powi(-decimals);
    // rounded to its digits, or cut off behind them
    let written = |m: f64| (m - value).abs() < 1e-6 * digit;
    let near = written((multiple / digit).round() * digit) || written((multiple / digit).trunc() * digit);
    (decimals >= 2 && near && multiple != 0.0).then_some(multiple)
}

fn children<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'i>> {
    node.children().filter(move |n| n.is_element() && n.tag_name().name() == tag)
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &'static str) -> Option<Node<'a, 'i>> {
    children(node, tag).next()
}

fn link_of(joint: &Node, tag: &'static str) -> Option<String> {
    child(*joint, tag).and_then(|n| n.attribute("link")).map(str::to_string)
}

/// Links in which a chain ends that has a moving joint; beyond the last moving joint, fixed joints that do not branch are followed.
fn ends_of(joints: &[Node], moves: impl Fn(&Node) -> bool) -> Vec<String> {
    let below = |link: &str| -> Vec<usize> {
        (0..joints.len()).filter(|&k| link_of(&joints[k], "parent").as_deref() == Some(link)).collect()
    };
    let child_of = |k: usize| link_of(&joints[k], "child").unwrap_or_default();
    // links with a moving joint somewhere below them: from the moving joints up
    let mut carries: BTreeSet<String> = BTreeSet::new();
    for j in joints.iter().filter(|j| moves(j)) {
        let mut at = link_of(j, "parent");
        while let Some(link) = at.filter(|l| carries.insert(l.clone())) {
            at = joints
                .iter()
                .find(|j| link_of(j, "child").as_deref() == Some(&link))
                .and_then(|j| link_of(j, "parent"));
        }
    }
    let mut ends = Vec::new();
    for k in (0..joints.len()).filter(|&k| moves(&joints[k])) {
        let mut link = child_of(k);
        if carries.contains(&link) {
            continue;
        }
        for _ in 0..joints.len() {
            let [only] = below(&link)[..] else { break };
            link = child_of(only);
        }
        ends.push(link);
    }
    ends
}

/// Motion of a joint.
fn motion(e: &Element, q: f64) -> Isometry3<f64> {
    match e.kind {
        None => Isometry3::identity(),
        Some(JointKind::Revolute) => {
            Isometry3::from_parts(Translation3::identity(), UnitQuaternion::from_axis_angle(&e.axis, q))
        }
        Some(JointKind::Prismatic) => {
            Isometry3::from_parts(Translation3::from(e.axis.into_inner() * q), UnitQuaternion::identity())
        }
    }
}

/// Position of a joint of the chain where the driving joints stand at `q` (one per moving joint without mimic).
fn positions(chain: &[Element], q: &[f64]) -> Vec<f64> {
    let mut drivers = q.iter();
    let own: Vec<Option<f64>> = chain
        .iter()
        .map(|e| if e.kind.is_some() && e.mimic.is_none() { drivers.next().copied() } else { None })
        .collect();
    let of = |name: &str| chain.iter().position(|e| e.name == name).and_then(|k| own[k]).unwrap_or(0.0);
    (chain.iter().zip(&own))
        .map(|(e, own)| match &e.mimic {
            Some((driver, ratio, offset)) => ratio * of(driver) + offset,
            None => own.unwrap_or(0.0),
        })
        .collect()
}

/// The URDF's own chain.
fn forward(chain: &[Element], q: &[f64]) -> Isometry3<f64> {
    chain.iter().zip(positions(chain, q)).fold(Isometry3::identity(), |t, (e, q)| t * e.origin * motion(e, q))
}

fn build(title: &str, chain: &[Element], masses: &[Option<Inertia>]) -> std::result::Result<Robot, String> {
    let moving: Vec<usize> = (0..chain.len()).filter(|&k| chain[k].kind.is_some()).collect();
    // frames at the zero configuration: before each joint's motion (its axis), and behind it (its link)
    let at_zero = positions(chain, &vec![0.0; moving.len()]);
    let (mut lines, mut links, mut t) = (Vec::new(), Vec::new(), Isometry3::identity());
    for (e, q) in chain.iter().zip(at_zero) {
        t *= e.origin;
        if e.kind.is_some() {
            lines.push(dh::Line { point: t.translation.vector, direction: t.rotation * e.axis });
        }
        t *= motion(e, q);
        links.push(t);
    }
    let table = dh::of_lines(&lines, &t);
    let mut joints = Vec::with_capacity(moving.len());
    for (row, &k) in table.rows.iter().zip(&moving) {
        let e = &chain[k];
        let follows = match &e.mimic {
            Some((driver, ratio, _)) => {
                let joint = moving.iter().position(|&m| chain[m].name == *driver && chain[m].mimic.is_none());
                let joint =
                    joint.ok_or_else(|| format!("joint `{}` mimics `{driver}`, which is not on the chain", e.name))?;
                Some(Follow { joint, ratio: *ratio })
            }
            None => None,
        };
        joints.push(Joint {
            name: e.name.clone(),
            kind: e.kind.unwrap_or(JointKind::Revolute),
            theta_rad: row.theta_rad,
            d_m: row.d_m,
            a_m: row.a_m,
            alpha_rad: row.alpha_rad,
            beta_rad: 0.0,
            direction: 1.0,
            limits: e.limits,
            max_speed: e.max_speed,
            max_accel: None,
            lead_m_per_rev: None,
            pulses: None,
            follows,
        });
    }
    let mut robot = Robot::new(title.to_string(), super::Convention::Standard, joints, table.base, table.tool);
    robot.links = link_masses(chain, &moving, &links, masses, &table.frames);
    Ok(robot)
}

/// Mass and centre of mass of what moves with each joint, in the joint's link frame; none where a mass is not given.
fn link_masses(
    chain: &[Element],
    moving: &[usize],
    links: &[Isometry3<f64>],
    masses: &[Option<Inertia>],
    frames: &[Isometry3<f64>],
) -> Vec<Link> {
    let mut out = Vec::with_capacity(moving.len());
    for (i, &k) in moving.iter().enumerate() {
        let last = moving.get(i + 1).copied().unwrap_or(chain.len());
        let (mut mass_kg, mut moment) = (0.0, Vector3::zeros());
        for m in k..last {
            if let Some((kg, com)) = masses[m] {
                mass_kg += kg;
                moment += (links[m] * Point3::from(com)).coords * kg;
            }
        }
        if mass_kg <= 0.0 {
            return Vec::new();
        }
        let com_m = frames[i].inverse_transform_point(&Point3::from(moment / mass_kg)).coords;
        out.push(Link { mass_kg, com_m });
    }
    out
}

/// Largest distance and angle between the two chains at positions within the limits, of a fixed sequence.
fn compare(robot: &Robot, chain: &[Element]) -> (f64, f64) {
    const POSITIONS: usize = 200;
    // mobile bases have limits of kilometres, where rounding alone is larger than any error
    const FAR_M: f64 = 10.0;
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (mut distance_m, mut angle_rad) = (0.0f64, 0.0f64);
    for _ in 0..POSITIONS {
        let q: Vec<f64> = robot
            .axis_joints()
            .map(|j| {
                let far = if j.kind == JointKind::Revolute { std::f64::consts::PI } else { FAR_M };
                let [lo, hi] = j.limits.map_or([-far, far], |[lo, hi]| [lo.max(-far), hi.min(far)]);
                let [lo, hi] = if lo < hi { [lo, hi] } else { [-far, far] };
                rng.random_range(lo..hi)
            })
            .collect();
        let (theirs, ours) = (forward(chain, &q), robot.forward(&q));
        distance_m = distance_m.max((ours.position - theirs.translation.vector).norm());
        let rotation = theirs.rotation.to_rotation_matrix();
        angle_rad = angle_rad.max((rotation.matrix() - ours.rotation.matrix()).norm());
    }
    (distance_m, angle_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SCARA: &str = r#"<robot name="scara">
      <link name="base"/><link name="a"><inertial><mass value="2"/><origin xyz="0.1 0 0"/></inertial></link>
      <link name="b"><inertial><mass value="1"/><origin xyz="0.1 0 0"/></inertial></link>
      <link name="quill"><inertial><mass value="0.5"/></inertial></link><link name="tcp"/>
      <joint name="J1" type="revolute"><parent link="base"/><child link="a"/><origin xyz="0 0 0.4"/><axis xyz="0 0 1"/>
        <limit lower="-2" upper="2" velocity="3" effort="1"/></joint>
      <joint name="J2" type="continuous"><parent link="a"/><child link="b"/><origin xyz="0.3 0 0"/><axis xyz="0 0 1"/></joint>
      <joint name="J3" type="prismatic"><parent link="b"/><child link="quill"/><origin xyz="0.25 0 0" rpy="3.1416 0 0"/>
        <axis xyz="0 0 1"/><limit lower="0" upper="0.2" velocity="1" effort="1"/></joint>
      <joint name="flange" type="fixed"><parent link="quill"/><child link="tcp"/><origin xyz="0 0 0.05"/></joint>
    </robot>"#;

    #[test]
    fn a_scara_moves_as_its_urdf_says() {
        let found = read("scara.urdf", SCARA, None).unwrap();
        assert_eq!(found.tip, "tcp");
        assert_eq!(found.snapped, ["3.1416"]);
        assert!(found.largest_error.0 < 1e-12 && found.largest_error.1 < 1e-9, "{:?}", found.largest_error);
        // by hand: at zero the TCP hangs 0.05 m below the quill's origin, at the arm's end
        let tcp = found.robot.tcp_m(&[0.0, 0.0, 0.1]);
        assert!((tcp - Vector3::new(0.55, 0.0, 0.4 - 0.15)).norm() < 1e-12, "{tcp}");
        assert_eq!(found.robot.links.len(), 3);
    }

    #[test]
    fn an_angle_is_snapped_only_where_it_is_that_angle_to_its_digits() {
        for (word, snaps) in
            [("1.57", true), ("1.5708", true), ("-3.14159", true), ("1.58", false), ("1.5", false), ("0.7853", true)]
        {
            assert_eq!(multiple_of_45_deg(word.parse().unwrap(), word).is_some(), snaps, "{word}");
        }
    }

    #[test]
    fn what_is_no_chain_is_refused_with_its_place() {
        let refusal = |text: &str| read("x.urdf", text, None).unwrap_err().to_string();
        assert!(refusal("<robot").contains("x.urdf:1:"), "{}", refusal("<robot"));
        assert!(refusal("<robot/>").contains("no chain"));
        assert!(refusal(&SCARA.replace("0.3 0 0", "${a2} 0 0")).contains("xacro"));
        assert!(refusal(&SCARA.replace("continuous", "planar")).contains("planar"));
    }
}
