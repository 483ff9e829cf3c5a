//! From the tree to trajectories: mappings with `joint_names` and `points`, wherever they stand.

use super::spline::Order;
use super::tree::{Kind, Node, Tree};
use crate::error::Result;
use crate::script::{Span, Text, number};

/// Known keys of a point; any other belongs to another program.
const KEYS: [&str; 5] = ["positions", "velocities", "accelerations", "effort", "time_from_start"];

/// A number as it is written.
#[derive(Debug, Clone, Copy)]
pub struct Num {
    pub value: f64,
    pub span: Span,
    pub style: number::Style,
}

/// `time_from_start`.
#[derive(Debug, Clone)]
pub enum Time {
    /// Seconds in one number.
    Seconds(Num),
    /// Seconds and nanoseconds; one of them may be left out, which is 0. Names as they are written, and whether they stand in braces.
    Parts { sec: Option<Num>, nano: Option<Num>, braces: bool, ros1: bool, quote: Option<u8> },
}

#[derive(Debug, Clone)]
pub struct Point {
    /// The bytes of its mapping, without the dash or comma around it.
    pub span: Span,
    /// Empty: it gives none.
    pub positions: List,
    pub velocities: List,
    pub accelerations: List,
    pub effort: List,
    pub time: Time,
    pub t_s: f64,
    /// A key that is not the message's: a copy would repeat it.
    pub foreign: Option<Box<str>>,
}

/// Which numbers of a trajectory a point has.
#[derive(Debug, Clone, Copy, Default)]
pub struct List(Span);

impl List {
    pub fn is_empty(self) -> bool {
        self.0.range().is_empty()
    }
}

/// One message.
#[derive(Debug, Clone)]
pub struct Trajectory {
    pub start: usize,
    pub names: Vec<String>,
    /// First byte of the names.
    pub names_at: usize,
    pub points: Vec<Point>,
    /// Of all points, one after the other.
    numbers: Vec<Num>,
    /// The points stand in `[...]`.
    pub brackets: bool,
}

/// What a text holds: its trajectories, and places of what is left alone, with the reason.
#[derive(Debug, Default)]
pub struct Content {
    pub trajectories: Vec<Trajectory>,
    pub left: Vec<(usize, String)>,
}

impl Trajectory {
    /// The numbers of a list of one of its points.
    pub fn numbers(&self, of: List) -> &[Num] {
        self.numbers.get(of.0.range()).unwrap_or_default()
    }
}

impl Point {
    /// How a controller joins this point to the one before it.
    pub fn order_from(&self, before: &Self) -> Order {
        let both = |a: List, b: List| !a.is_empty() && !b.is_empty();
        if !both(self.velocities, before.velocities) {
            Order::Linear
        } else if both(self.accelerations, before.accelerations) {
            Order::Quintic
        } else {
            Order::Cubic
        }
    }
}

/// Every trajectory of the documents, in the order of the text.
///
/// Takes the documents of the tree: what a trajectory is read from is given up point by point.
pub fn content(text: &Text, tree: &mut Tree) -> Result<Content> {
    let mut content = Content::default();
    for mut document in std::mem::take(&mut tree.documents) {
        search(text, tree, &mut document, "", None, &mut content)?;
    }
    Ok(content)
}

/// Goes down to the mappings that are trajectories. `shared`: an outer node that an alias repeats.
///
/// `message = {"joint_names" ":" joint_names | "points" ":" points | key ":" message} | "[" {message} "]" | word`
fn search(
    text: &Text,
    tree: &Tree,
    node: &mut Node,
    key: &str,
    shared: Option<usize>,
    content: &mut Content,
) -> Result<()> {
    let shared = shared.or_else(|| tree.is_shared(node).then_some(node.at()));
    if node.kind == Kind::List {
        for item in &mut node.items[..] {
            search(text, tree, item, key, shared, content)?;
        }
    }
    let value = |name: &str| node.entries().position(|(k, _)| k.word(text) == name).map(|entry| 2 * entry + 1);
    if let (Some(names), Some(points)) = (value("joint_names"), value("points")) {
        only_once(text, node)?;
        let items = &node.items;
        let (Some(names), Some(list)) = (items.get(names), items.get(points)) else { return Ok(()) };
        let nothing = |n: &Node| n.is_null(text) || (n.kind == Kind::List && n.items.is_empty());
        if nothing(names) && nothing(list) {
            return Ok(());
        }
        if key.starts_with("multi_dof") {
            content.left.push((node.at(), "joints of several degrees of freedom are left as they are".into()));
            return Ok(());
        }
        if let Some(at) = shared {
            return Err(text.bad(
                at,
                "an anchor that an alias repeats",
                "a trajectory that stands alone: an edit would change the other one, too",
            ));
        }
        let names = joints(text, names, list)?;
        let start = node.at();
        if let Some(points) = node.items.get_mut(points) {
            content.trajectories.push(trajectory(text, start, names, points)?);
        }
        return Ok(());
    }
    if node.kind == Kind::Map {
        for entry in node.items.chunks_exact_mut(2) {
            if let [k, v] = entry {
                search(text, tree, v, &k.word(text), shared, content)?;
            }
        }
    }
    Ok(())
}

/// Keys of a mapping that are compared one with the other.
const FEW: usize = 8;

/// Refuses a key that stands twice.
fn only_once(text: &Text, map: &Node) -> Result<()> {
    let mut seen = std::collections::BTreeSet::new();
    let few = map.items.len() <= 2 * FEW;
    for (n, (k, _)) in map.entries().enumerate() {
        let again = match few {
            true => map.entries().take(n).any(|(other, _)| other.word(text) == k.word(text)),
            false => !seen.insert(k.word(text)),
        };
        if again {
            return Err(text.bad(k.at(), format!("`{}` a second time", k.word(text)), "every key once"));
        }
    }
    Ok(())
}

/// The names of the joints, and where they stand; `points`: the list of the points.
///
/// `joint_names = list of name`
fn joints(text: &Text, names: &Node, points: &Node) -> Result<(Vec<String>, usize)> {
    alone(text, names)?;
    alone(text, points)?;
    if names.kind != Kind::List {
        return Err(text.bad(names.at(), found(text, names), "a list of joint names"));
    }
    let mut joints = Vec::with_capacity(names.items.len());
    for name in &names.items[..] {
        alone(text, name)?;
        if !matches!(name.kind, Kind::Scalar { .. }) || name.is_null(text) {
            return Err(text.bad(name.at(), found(text, name), "the name of a joint"));
        }
        let word = name.word(text).into_owned();
        if joints.iter().any(|n: &String| n.eq_ignore_ascii_case(&word)) {
            return Err(text.bad(name.at(), format!("joint `{word}` a second time"), "every joint once"));
        }
        joints.push(word);
    }
    Ok((joints, names.at()))
}

/// A trajectory by its names and its points, whose nodes go one after the other.
///
/// `points = list of point`
fn trajectory(
    text: &Text,
    start: usize,
    (names, names_at): (Vec<String>, usize),
    points: &mut Node,
) -> Result<Trajectory> {
    let mut list: Vec<Point> = Vec::new();
    let mut numbers = Vec::with_capacity(text.likely_numbers().min(points.items.len() * names.len()));
    if points.kind != Kind::List && !points.is_null(text) {
        return Err(text.bad(points.at(), found(text, points), "a list of points"));
    }
    for item in std::mem::take(&mut points.items) {
        let (point, time_at) = point(text, &item, names.len(), &mut numbers)?;
        if let Some(before) = list.last()
            && point.t_s <= before.t_s
        {
            return Err(text.bad(
                time_at,
                format!("time {} s after {} s", point.t_s, before.t_s),
                "times that rise from point to point",
            ));
        }
        list.push(point);
    }
    let brackets = text.bytes.get(points.at()) == Some(&b'[');
    Ok(Trajectory { start, names, names_at, points: list, numbers, brackets })
}

fn found(text: &Text, node: &Node) -> String {
    match node.kind {
        Kind::Scalar { .. } if node.is_null(text) => "nothing".into(),
        Kind::Scalar { .. } => format!("`{}`", node.word(text)),
        Kind::List => "a list".into(),
        Kind::Map => "a mapping".into(),
        Kind::Alias => format!("the alias `{}`", node.word(text)),
    }
}

/// Refuses what stands for another place, or is read in another way than it is written.
fn alone(text: &Text, node: &Node) -> Result<()> {
    let expected = "numbers and names that are written out";
    if node.kind == Kind::Alias {
        return Err(text.bad(node.at(), found(text, node), expected));
    }
    if node.anchor != 0 {
        return Err(text.bad(node.at(), "an anchor", expected));
    }
    if node.tagged {
        return Err(text.bad(node.at(), "a tag", expected));
    }
    Ok(())
}

/// A point, and the place of its time.
///
/// `point = {("positions" | "velocities" | "accelerations" | "effort") ":" numbers | "time_from_start" ":" time | key ":" ...}`
fn point(text: &Text, node: &Node, joints: usize, all: &mut Vec<Num>) -> Result<(Point, usize)> {
    alone(text, node)?;
    if matches!(node.kind, Kind::Scalar { .. }) && node.word(text) == "..." {
        let expected = "every point: print the message with --full-length";
        return Err(text.bad(node.at(), "`...`", expected));
    }
    if node.kind != Kind::Map {
        return Err(text.bad(node.at(), found(text, node), "a point: a mapping with positions and time_from_start"));
    }
    only_once(text, node)?;
    let value = |name: &str| node.entries().find(|(k, _)| k.word(text) == name).map(|(_, v)| v);
    let mut numbers = |name: &str| match value(name) {
        Some(list) => list_of(text, list, name, joints, all),
        None => Ok(List::default()),
    };
    let Some(time) = value("time_from_start") else {
        return Err(text.bad(node.at(), "a point without time_from_start", "the time of every point"));
    };
    let (time, t_s) = self::time(text, time).map(|t| (t.0, (t.1, time.at())))?;
    let mut foreign = node.entries().map(|(k, _)| k.word(text)).find(|k| !KEYS.contains(&k.as_ref()));
    let point = Point {
        span: node.span().into(),
        positions: numbers("positions")?,
        velocities: numbers("velocities")?,
        accelerations: numbers("accelerations")?,
        effort: numbers("effort")?,
        time,
        t_s: t_s.0,
        foreign: foreign.take().map(Box::from),
    };
    Ok((point, t_s.1))
}

/// Numbers of a point, none or one per joint; they go to `all`.
///
/// `numbers = null | list of number`
fn list_of(text: &Text, list: &Node, what: &str, joints: usize, all: &mut Vec<Num>) -> Result<List> {
    alone(text, list)?;
    if list.is_null(text) {
        return Ok(List::default());
    }
    if list.kind != Kind::List {
        return Err(text.bad(list.at(), found(text, list), format!("{what} as a list")));
    }
    let first = all.len();
    for n in &list.items[..] {
        all.push(num(text, n)?);
    }
    let count = all.len() - first;
    if count > 0 && count != joints {
        return Err(text.bad(list.at(), format!("{count} {what}"), format!("{joints}, one per name in joint_names")));
    }
    Ok(List((first..all.len()).into()))
}

/// A number as it is written.
///
/// `number = ["+" | "-"] digits`, without quotes
fn num(text: &Text, node: &Node) -> Result<Num> {
    alone(text, node)?;
    let bytes = text.slice(node.span());
    let digits = bytes.strip_prefix(b"-").or_else(|| bytes.strip_prefix(b"+")).unwrap_or(bytes);
    // 010 is eight for a reader of YAML 1.1 and ten for one of YAML 1.2
    let octal = digits.len() > 1 && digits.starts_with(b"0") && digits.iter().all(u8::is_ascii_digit);
    let read = if node.kind == (Kind::Scalar { plain: true }) && !octal { number::read(bytes) } else { None };
    let (value, style) =
        read.ok_or_else(|| text.bad(node.at(), found(text, node), "a finite decimal number without quotes"))?;
    Ok(Num { value, span: node.span().into(), style })
}

/// A whole number, also as `2.0`.
fn whole(text: &Text, node: &Node, most: f64) -> Result<Num> {
    let n = num(text, node)?;
    let plain = !n.style.exponent && !n.style.plus && n.value.fract() == 0.0;
    if plain && (0.0..=most).contains(&n.value) {
        return Ok(n);
    }
    Err(text.bad(node.at(), found(text, node), format!("one whole number from 0 to {most}")))
}

/// A time as it is written, and in seconds.
///
/// `time = number | "[" seconds "," nanoseconds "]" | {("sec" | "secs") ":" seconds | ("nanosec" | "nsecs") ":" nanoseconds}`
fn time(text: &Text, node: &Node) -> Result<(Time, f64)> {
    alone(text, node)?;
    if node.kind == Kind::List {
        let parts: Vec<&Node> = node.items.iter().collect();
        let &[sec, nano] = parts.as_slice() else {
            return Err(text.bad(node.at(), format!("a list of {}", parts.len()), "seconds and nanoseconds"));
        };
        let (sec, nano) = (whole(text, sec, 1e9)?, whole(text, nano, 999_999_999.0)?);
        let t_s = sec.value + nano.value * 1e-9;
        return Ok((Time::Parts { sec: Some(sec), nano: Some(nano), braces: true, ros1: true, quote: None }, t_s));
    }
    if node.kind != Kind::Map {
        let t = num(text, node)?;
        if t.value < 0.0 {
            return Err(text.bad(node.at(), found(text, node), "a time from 0"));
        }
        return Ok((Time::Seconds(t), t.value));
    }
    only_once(text, node)?;
    let (mut sec, mut nano, mut ros1, mut quote) = (None, None, false, None);
    for (k, v) in node.entries() {
        let (slot, most) = match k.word(text).as_ref() {
            "sec" | "secs" => (&mut sec, 1e9),
            "nanosec" | "nsecs" => (&mut nano, 999_999_999.0),
            other => {
                return Err(text.bad(
                    k.at(),
                    format!("`{other}`"),
                    "sec and nanosec (ROS 2) or secs and nsecs (ROS 1)",
                ));
            }
        };
        if slot.is_some() {
            return Err(text.bad(v.at(), found(text, v), "it once"));
        }
        *slot = Some(whole(text, v, most)?);
        ros1 |= k.word(text).ends_with('s');
        quote = text.bytes.get(k.at()).copied().filter(|b| matches!(b, b'"' | b'\''));
    }
    if sec.is_none() && nano.is_none() {
        return Err(text.bad(node.at(), "an empty time", "sec and nanosec (ROS 2) or secs and nsecs (ROS 1)"));
    }
    let braces = text.bytes.get(node.at()) == Some(&b'{');
    let of = |n: Option<Num>| n.map_or(0.0, |n| n.value);
    let t_s = of(sec) + of(nano) * 1e-9;
    Ok((Time::Parts { sec, nano, braces, ros1, quote }, t_s))
}
