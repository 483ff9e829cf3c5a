//! `empirical`: a smooth curve without a physical name, over position, direction, speed, acceleration, torque or time.
//!
//! What a log shows and no effect describes. On a joint it adds the curve's value to the joint's position; with `times: direction`
//! the value changes its sign with the direction of movement (the odd part of a hysteresis), with `times: A2` it is multiplied by the
//! position of another joint (rad or m). On the TCP it adds a vector over time or over the position of one joint (`of: A1`). The curve is
//! a natural cubic spline through its knots (de Boor 1978, A Practical Guide to Splines), constant beyond them: linear in its values, so
//! that a fit of them is, too.
//!
//! Arguments: position deg or mm, direction -1 to +1 (0 before the first movement), speed deg/s or mm/s of the joint's command, its
//! acceleration deg/s2 or mm/s2, torque Nm (N) as logged, else of gravity, time s since the first row. Parameters: the values at the knots,
//! of either sign, at most 0.1 rad (10 mm); their 95 % intervals `ci95` are carried along. `rewrite` undoes a curve over position point by
//! point, one over direction or times direction as a gap; the others are no function of the program's positions. Its trials:
//! `crate::diagnose::search::unnamed`.

use super::common::*;
use super::effect;
use super::site::within;
use super::spline::Spline;
use nalgebra::Vector3;
use serde_yaml::{Mapping, Value};

/// Name in the catalogue.
pub const NAME: &str = "empirical";

/// How the catalogue describes this effect.
pub static INFO: EffectInfo = EffectInfo {
    name: NAME,
    heading: "empirical",
    stage: Stage::Link,
    family: Family::Empirical,
    acts_on: ActsOn::JointOrTcp,
    adds: "a smooth curve without a physical name",
    equation: "natural cubic spline through the knots over position, direction, speed, acceleration, torque or time, constant beyond",
    reference: "de Boor (1978), A Practical Guide to Splines",
    parameters: &[
        ("over", "position, direction, speed, acceleration, torque or time; on the TCP time or position"),
        ("of", "on the TCP over position: the joint"),
        (
            "times",
            "`direction`: the value changes its sign with the direction of movement; or the name of another joint: the value is per rad or m of that joint",
        ),
        ("knots", "[[argument, value_deg], ...], arguments rising; on the TCP [[argument, x_mm, y_mm, z_mm], ...]"),
        ("ci95", "95 % intervals of the curve, for information only"),
    ],
    confused_with: &["transmission_error", "backlash_position", "thermal_growth", "gravity_compliance"],
    decide_by: "repeat the log: a curve that appears again belongs to the machine; move at two speeds and with two loads",
    action: "see where it occurs and what it depends on; compensate it as it is, and diagnose again with a log that excites it",
    undone: "a curve over position point by point; a curve over direction, or times direction, as a gap; otherwise nothing",
    special: Special::NONE,
    example: (
        "{effect: empirical, joint: A1, over: position, knots: [[-20, 0.001], [-8, -0.002], [5, 0.003], [20, 0]]}",
        View::JointOverCommand,
    ),
    read,
    typical: |size| {
        if size.has("knots") || size.has("over") {
            return Vec::new();
        }
        let [lo, hi] = size.window;
        let tcp = size.target.eq_ignore_ascii_case("tcp");
        let (from, to) = if tcp { (0.0, size.duration_s.max(1.0)) } else { (lo, hi) };
        let knot = |x: f64, v: f64| {
            let values = if tcp { vec![x, 10.0 * v, -5.0 * v, 5.0 * v] } else { vec![x, v] };
            Value::Sequence(values.into_iter().map(Value::from).collect())
        };
        let knots = vec![knot(from, 0.0), knot(0.5 * (from + to), size.gap), knot(to, -size.gap)];
        let over = if tcp { "time" } else { "position" };
        vec![("over".into(), over.into()), ("knots".into(), Value::Sequence(knots))]
    },
    candidates: |_, _| {},
};

/// What a curve is a function of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Over {
    /// The position of the joint, rad or m.
    Position,
    /// The direction of movement, -1 or +1.
    Direction,
    /// The speed of the joint, rad/s or m/s.
    Speed,
    /// The acceleration of the joint, rad/s^2 or m/s^2.
    Acceleration,
    /// The torque of its drive, Nm or N.
    Torque,
    /// Time since the first row, s.
    Time,
}

impl Over {
    const ALL: [(Self, &'static str); 6] = [
        (Self::Position, "position"),
        (Self::Direction, "direction"),
        (Self::Speed, "speed"),
        (Self::Acceleration, "acceleration"),
        (Self::Torque, "torque"),
        (Self::Time, "time"),
    ];

    /// As a model file has it.
    pub fn text(self) -> &'static str {
        Self::ALL.iter().find(|o| o.0 == self).map_or("", |o| o.1)
    }
}

/// What the value of a curve is multiplied by.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Times {
    /// Nothing.
    One,
    /// The direction of movement.
    Direction,
    /// The position of another axis, rad or m.
    Position(usize),
}

/// A curve of one value (rad or m of a joint) or of three (m, the TCP in the base frame) over one argument, SI.
#[derive(Debug, Clone, PartialEq)]
pub struct Empirical {
    /// The argument of the curve.
    pub over: Over,
    /// What the value is multiplied by.
    pub times: Times,
    /// On the TCP over position: the axis.
    pub of: Option<usize>,
    curves: Vec<Spline>,
    ci95: Option<Value>,
}

impl Empirical {
    /// A curve of a joint through knots `[argument, value]`; `None` where they cannot be joined.
    pub fn of_joint(over: Over, times: Times, knots: &[[f64; 2]]) -> Option<Self> {
        let (x, y): (Vec<f64>, Vec<f64>) = knots.iter().map(|k| (k[0], k[1])).unzip();
        Some(Self { over, times, of: None, curves: vec![Spline::new(x, y)?], ci95: None })
    }

    /// A curve of the TCP through knots `(argument, vector)`; over position that of the axis `of`.
    pub fn of_tcp(over: Over, of: Option<usize>, knots: &[(f64, Vector3<f64>)]) -> Option<Self> {
        let x: Vec<f64> = knots.iter().map(|k| k.0).collect();
        let curve = |c: usize| Spline::new(x.clone(), knots.iter().map(|k| k.1[c]).collect());
        Some(Self { over, times: Times::One, of, curves: vec![curve(0)?, curve(1)?, curve(2)?], ci95: None })
    }

    /// Attaches the 95 % intervals of the values, in the units of the file.
    pub fn with_ci95(mut self, ci95: Option<Value>) -> Self {
        self.ci95 = ci95;
        self
    }

    /// The argument at a row, and what the value is multiplied with.
    fn argument(&self, axis: Option<usize>, inputs: &dyn Inputs, row: usize) -> Option<(f64, f64)> {
        let at = |column: &[f64]| column.get(row).copied();
        let direction = || axis.map_or(0.0, |a| inputs.direction(a).get(row).copied().unwrap_or(0.0));
        let x = match self.over {
            Over::Position => at(inputs.command(axis?))?,
            Over::Direction => direction(),
            Over::Speed => at(inputs.speed(axis?))?,
            Over::Acceleration => acceleration(inputs, axis?, row)?,
            Over::Torque => at(inputs.measured_torque(axis?).unwrap_or(inputs.gravity_torque(axis?)))?,
            Over::Time => at(inputs.t_s())? - inputs.t_s().first()?,
        };
        let times = match self.times {
            Times::One => 1.0,
            Times::Direction => direction(),
            Times::Position(other) => at(inputs.command(other))?,
        };
        Some((x, times))
    }

    /// It moves the TCP, not a joint.
    pub fn is_of_tcp(&self) -> bool {
        self.curves.len() == 3
    }

    /// Units of the argument per SI unit.
    fn user_units_per_argument(&self, site: &Site) -> f64 {
        let kind = self.of.map_or(site.kind(), |a| site.robot.axis(a).kind);
        match self.over {
            Over::Position | Over::Speed | Over::Acceleration => 1.0 / kind.si_per_user_unit(),
            Over::Direction | Over::Torque | Over::Time => 1.0,
        }
    }

    /// Units of the values per SI unit: mm on the TCP.
    fn user_units_per_value(&self, site: &Site) -> f64 {
        if self.is_of_tcp() { 1e3 } else { 1.0 / site.si_per_user_unit() }
    }
}

fn read(f: &mut Fields) -> Result<Effect> {
    let site = f.site();
    let tcp = site.target == Target::Tcp;
    let named = f.take("over");
    let over = named.as_ref().and_then(Value::as_str).and_then(|n| Over::ALL.iter().find(|o| o.1 == n)).map(|o| o.0);
    let allowed = |o: &Over| !tcp || matches!(o, Over::Position | Over::Time);
    let Some(over) = over.filter(allowed) else {
        let names: Vec<&str> = Over::ALL.iter().filter(|o| allowed(&o.0)).map(|o| o.1).collect();
        return Err(f.bad("over", "no `over`, or an unknown one", &format!("one of {}", names.join(", "))));
    };
    let times = match f.take("times").as_ref().map(Value::as_str) {
        None => Some(Times::One),
        Some(Some("direction")) if !tcp && over != Over::Direction => Some(Times::Direction),
        Some(Some(name)) if !tcp => {
            site.robot.axis_named(name).filter(|a| site.target != Target::Joint(*a)).map(Times::Position)
        }
        Some(_) => None,
    };
    let Some(times) = times else {
        let expected = "`times: direction` or another joint, of a joint, or none";
        return Err(f.bad("times", "a `times` that is none", expected));
    };
    let of = match f.take("of") {
        None => None,
        Some(name) => match name.as_str().and_then(|n| site.robot.axis_named(n)) {
            Some(axis) if tcp => Some(axis),
            _ => return Err(f.bad("of", "an `of` that is none", "the name of a joint, for the TCP over position")),
        },
    };
    if tcp && (over == Over::Position) != of.is_some() {
        return Err(f.bad(
            "of",
            "a TCP over position without `of`, or the reverse",
            "`of: JOINT` with `over: position`",
        ));
    }
    let ci95 = f.take("ci95");
    let empty = Empirical { over, times, of, curves: Vec::new(), ci95 };
    let width = if tcp { 4 } else { 2 };
    let knots = f.take("knots").and_then(|v| serde_yaml::from_value::<Vec<Vec<f64>>>(v).ok());
    let Some(knots) = knots.filter(|k| k.iter().all(|k| k.len() == width)) else {
        let expected =
            if tcp { "`knots: [[argument, x_mm, y_mm, z_mm], ...]`" } else { "`knots: [[argument, value], ...]`" };
        return Err(f.bad("knots", "no knots, or knots of another form", expected));
    };
    let per_argument = if tcp && of.is_none() { 1.0 } else { empty.user_units_per_argument(&site) };
    let per_value = if tcp { 1e3 } else { 1.0 / site.si_per_user_unit() };
    let x: Vec<f64> = knots.iter().map(|k| k[0] / per_argument).collect();
    let curve = |c: usize| Spline::new(x.clone(), knots.iter().map(|k| k[c] / per_value).collect());
    let curves: Option<Vec<Spline>> = (1..width).map(curve).collect();
    match curves {
        Some(curves) => Ok(Empirical { curves, ..empty }.into()),
        None => Err(f.bad("knots", "knots that cannot be joined", "two or more finite knots, arguments rising")),
    }
}

/// Time on either side over which an acceleration is taken at least, s: rounded commands say nothing about less.
const ACCELERATION_OVER_S: f64 = 0.02;

/// Acceleration of an axis' command at a row, by the rows on either side.
fn acceleration(inputs: &dyn Inputs, axis: usize, row: usize) -> Option<f64> {
    let (t, p) = (inputs.t_s(), inputs.command(axis));
    let last = t.len().min(p.len()).checked_sub(1)?;
    let row = row.min(last);
    let before = (0..row).rev().find(|&k| t[row] - t[k] >= ACCELERATION_OVER_S);
    let after = (row + 1..=last).find(|&k| t[k] - t[row] >= ACCELERATION_OVER_S);
    let (Some(a), Some(b)) = (before, after) else { return Some(0.0) };
    let (h0, h1) = (t[row] - t[a], t[b] - t[row]);
    Some(2.0 * ((p[b] - p[row]) / h1 - (p[row] - p[a]) / h0) / (h0 + h1))
}

impl EffectType for Empirical {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn nature(&self) -> Nature {
        Nature::Unnamed
    }

    /// The values at the knots; on the TCP x, y, z of each.
    fn values(&self) -> Vec<f64> {
        let knots = self.curves.first().map_or(0, |c| c.knots());
        (0..knots).flat_map(|k| self.curves.iter().map(move |c| c.value(k))).collect()
    }

    fn with(&self, v: &[f64]) -> Effect {
        let n = self.curves.len();
        let curve = |(c, old): (usize, &Spline)| {
            let y = v.iter().skip(c).step_by(n).copied().collect();
            old.with_values(y).unwrap_or_else(|| old.clone())
        };
        Self { curves: self.curves.iter().enumerate().map(curve).collect(), ..self.clone() }.into()
    }

    fn parameters(&self, site: &Site) -> Vec<Parameter> {
        let per_si = self.user_units_per_value(site);
        let (most, typical) =
            if self.is_of_tcp() { (0.01, 10e-6) } else { (site.most_lost(), site.typical(1e-3, 5e-3)) };
        let knots = self.curves.first().map_or(0, |c| c.knots());
        let one = |k: usize, c: usize| Parameter::new(&format!("knots[{k}][{}]", c + 1), per_si, within(most), typical);
        (0..knots).flat_map(|k| (0..self.curves.len()).map(move |c| (k, c))).map(|(k, c)| one(k, c)).collect()
    }

    fn write(&self, site: &Site, entry: &mut Mapping) {
        let mut put = |key: &str, value: Value| entry.insert(key.into(), value);
        put("over", self.over.text().into());
        if let Some(axis) = self.of {
            put("of", site.robot.axis(axis).name.clone().into());
        }
        match self.times {
            Times::One => {}
            Times::Direction => put("times", "direction".into()).map_or((), |_| ()),
            Times::Position(other) => put("times", site.robot.axis(other).name.clone().into()).map_or((), |_| ()),
        }
        let (per_argument, per_value) = (self.user_units_per_argument(site), self.user_units_per_value(site));
        let knots = self.curves.first().map_or(0, |c| c.knots());
        let knot = |k: usize| {
            let values = self.curves.iter().map(|c| Value::from(c.value(k) * per_value));
            Value::Sequence(std::iter::once((self.curves[0].place(k) * per_argument).into()).chain(values).collect())
        };
        put("knots", Value::Sequence((0..knots).map(knot).collect()));
        if let Some(ci95) = &self.ci95 {
            put("ci95", ci95.clone());
        }
    }

    fn brief(&self, site: &Site) -> String {
        let largest = self.values().iter().fold(0.0f64, |m, v| m.max(v.abs())) * self.user_units_per_value(site);
        let unit = if self.is_of_tcp() { "mm" } else { site.unit() };
        let times = match self.times {
            Times::One => String::new(),
            Times::Direction => " times direction".into(),
            Times::Position(other) => format!(" times position of {}", site.robot.axis(other).name),
        };
        format!("over {}{times}, at most {} {unit}", self.over.text(), effect::short(largest))
    }

    fn stage(&self) -> Stage {
        if self.is_of_tcp() { Stage::Tcp } else { Stage::Link }
    }

    fn add_to_joint(&self, target: Target, inputs: &dyn Inputs, joint: &mut [f64]) {
        let Some(curve) = self.curves.first() else { return };
        for (row, q) in joint.iter_mut().enumerate() {
            if let Some((x, times)) = self.argument(target.axis(), inputs, row) {
                *q += times * curve.at(x);
            }
        }
    }

    fn displacement_m(&self, _target: Target, row: &Row, _point_m: &Vector3<f64>) -> Vector3<f64> {
        match (self.argument(self.of, row.inputs, row.index), self.curves.as_slice()) {
            (Some((x, _)), [a, b, c]) => Vector3::new(a.at(x), b.at(x), c.at(x)),
            _ => Vector3::zeros(),
        }
    }

    fn displaces(&self) -> bool {
        self.is_of_tcp()
    }

    fn has_memory(&self) -> bool {
        self.times == Times::Direction || self.over == Over::Direction
    }

    fn magnitude(&self) -> f64 {
        largest_size(self.values())
    }

    fn idle(&self, _site: &Site, settled_poses: bool) -> Option<&'static str> {
        let timed = matches!(self.over, Over::Time | Over::Speed | Over::Acceleration);
        (settled_poses && timed).then_some("settled poses have no time")
    }

    fn undo(&self, _context: &UndoContext) -> Undo {
        let Some(curve) = self.curves.first().filter(|_| !self.is_of_tcp()) else {
            return Undo::nothing("it moves the TCP, not a joint");
        };
        match (self.over, self.times) {
            (Over::Position, Times::One | Times::Position(_)) => Undo::point_by_point(),
            // an error of v times the direction is a gap of -v
            (Over::Position, Times::Direction) => curve.sampled(-1.0).map_or_else(Undo::default, Undo::gap),
            // its mean, which is taken off point by point, and half its change
            (Over::Direction, Times::One) => {
                let half = 0.5 * (curve.at(1.0) - curve.at(-1.0));
                Undo { point_by_point: true, ..Undo::gap(GapCurve::Constant(-half)) }
            }
            _ => Undo::nothing("it is no function of the program's positions"),
        }
    }
}
