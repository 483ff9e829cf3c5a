//! The chain of a URDF: its joints from the root link to the tip, the masses of its links, and the controller's world.

use super::{Element, Inertia};
use crate::error::{Error, Place, Result};
use crate::robot::JointKind;
use nalgebra::{Isometry3, Translation3, Unit, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};
use std::collections::BTreeSet;
use std::f64::consts::FRAC_PI_4;

/// Reads elements of one document.
pub(super) struct Reader<'a> {
    pub name: &'a str,
    pub doc: &'a Document<'a>,
    pub snapped: Vec<String>,
}

impl Reader<'_> {
    pub fn bad(&self, node: Node, found: impl Into<String>, expected: impl Into<String>) -> Error {
        let at = self.doc.text_pos_at(node.range().start);
        Error::bad(Place::field(self.name, u64::from(at.row), u64::from(at.col)), found, expected)
    }

    /// The joints from the root link to `tip`, in order.
    pub fn chain(&mut self, root: Node, tip: Option<&str>) -> Result<Vec<Element>> {
        let joints: Vec<Node> = children(root, "joint").collect();
        let parent_of = |j: &Node| link_of(j, "parent");
        let child_of = |j: &Node| link_of(j, "child");
        let tip = match tip {
            Some(t) => t.to_string(),
            None => {
                let moves = |j: &Node| j.attribute("type") != Some("fixed");
                let ends: Vec<String> = ends_of(&joints, moves);
                match (only_flange(&joints, &ends), ends.as_slice()) {
                    (Some(flange), _) => flange,
                    (None, [one]) => flange_below(&joints, one).unwrap_or_else(|| one.clone()),
                    (None, []) => {
                        return Err(self.bad(root, "no chain of joints", "joints that link a base to a tool"));
                    }
                    (None, several) => {
                        let found = format!("a chain that ends in {} places: {}", several.len(), several.join(", "));
                        return Err(self.bad(root, found, "the link that is the TCP").mended_by(&["tip"]));
                    }
                }
            }
        };
        let mut chain = Vec::new();
        let mut at = tip.clone();
        while let Some(j) = joints.iter().find(|j| child_of(j).as_deref() == Some(&at)) {
            if chain.len() > joints.len() {
                return Err(self.bad(*j, "joints that form a loop", "a chain"));
            }
            let Some(parent) = parent_of(j) else {
                return Err(self.bad(*j, "a joint without <parent link=...>", "a parent link"));
            };
            chain.push(self.element(*j)?);
            at = parent;
        }
        if chain.iter().all(|e| e.kind.is_none()) {
            let found = format!("no joint that moves before link `{tip}`");
            return Err(self.bad(root, found, "a link of the URDF after at least one moving joint"));
        }
        chain.reverse();
        Ok(chain)
    }

    /// The controller's world: a link `base` that is fixed to `base_link` (REP 199), by name, and where it stands in the root link.
    pub fn world(&mut self, root: Node, chain: &[Element]) -> Result<Option<(String, Isometry3<f64>)>> {
        let Some(first) = chain.first() else { return Ok(None) };
        let mut at = Isometry3::identity();
        let still = chain.iter().take_while(|e| e.kind.is_none()).map(Some).chain([None]);
        let mut link = first.parent.clone();
        for next in still {
            for j in children(root, "joint").filter(|j| j.attribute("type") == Some("fixed")) {
                let child = link_of(&j, "child").unwrap_or_default();
                let named = link.strip_suffix("base_link").is_some_and(|prefix| child == format!("{prefix}base"));
                if named && link_of(&j, "parent").as_deref() == Some(&link) {
                    return Ok(Some((child, at * self.origin(j)?)));
                }
            }
            if let Some(e) = next {
                at *= e.origin;
                link = e.child.clone();
            }
        }
        Ok(None)
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
        // the ends of a continuous joint's range mean nothing; its speed is one
        let endless = j.attribute("type") == Some("continuous");
        let (limits, max_speed) = match child(j, "limit") {
            Some(l) => (if endless { None } else { self.range(l)? }, self.number(l, "velocity")?.filter(|v| *v > 0.0)),
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
        let parent = link_of(&j, "parent").unwrap_or_default();
        Ok(Element { name, kind, origin: self.origin(j)?, axis, limits, max_speed, mimic, parent, child })
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
    pub fn masses(&mut self, root: Node, chain: &[Element]) -> Result<Vec<Option<Inertia>>> {
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
pub(super) fn multiple_of_45_deg(value: f64, word: &str) -> Option<f64> {
    let (mantissa, exponent) = word.split_once(['e', 'E']).unwrap_or((word, "0"));
    let decimals = mantissa.split_once('.').map_or(0, |(_, d)| d.len() as i32) - exponent.parse::<i32>().unwrap_or(0);
    let multiple = (value / FRAC_PI_4).round() * FRAC_PI_4;
    let digit = 10f64.powi(-decimals);
    // rounded to its digits, or cut off after them
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

/// The only link `tool0` that an arm carries, where the chain also ends elsewhere: in the fingers of a gripper after it, or in wheels.
fn only_flange(joints: &[Node], ends: &[String]) -> Option<String> {
    let moves = |j: &&Node| j.attribute("type") != Some("fixed");
    let links = joints.iter().filter_map(|j| link_of(j, "child"));
    let mut flanges = links.filter(|l| l.ends_with("tool0") && above(joints, l).iter().any(|j| moves(&j)));
    let flange = flanges.next().filter(|_| flanges.next().is_none())?;
    let parent_is_flange = |j: &Node| link_of(j, "parent").as_ref() == Some(&flange);
    // a moving joint somewhere below it
    let carries = |end: &String| {
        let way = above(joints, end);
        let at = way.iter().position(parent_is_flange);
        at.is_some_and(|at| way[..=at].iter().any(|j| moves(&j)))
    };
    (ends.len() > 1 || ends.iter().any(carries)).then_some(flange)
}

/// The joints from a link up to the root.
fn above<'a, 'i>(joints: &[Node<'a, 'i>], link: &str) -> Vec<Node<'a, 'i>> {
    let (mut way, mut at) = (Vec::new(), Some(link.to_string()));
    while let Some(link) = at.filter(|_| way.len() <= joints.len()) {
        let joint = joints.iter().find(|j| link_of(j, "child").as_deref() == Some(&link));
        at = joint.and_then(|j| link_of(j, "parent"));
        way.extend(joint.copied());
    }
    way
}

/// The link `tool0` that fixed joints connect to `link`, through any number of links: what a controller calls its flange.
fn flange_below(joints: &[Node], link: &str) -> Option<String> {
    let mut open = vec![link.to_string()];
    for k in 0..joints.len() {
        let at = open.get(k)?.clone();
        for j in joints.iter().filter(|j| j.attribute("type") == Some("fixed")) {
            if link_of(j, "parent").as_deref() == Some(&at) {
                open.extend(link_of(j, "child"));
            }
        }
        if let Some(flange) = open.iter().find(|l| l.ends_with("tool0")) {
            return Some(flange.clone());
        }
    }
    None
}
