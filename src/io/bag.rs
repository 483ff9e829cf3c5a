//! One topic of a ROS 2 recording (MCAP) as CSV, so that it is read like any other table.
//!
//! Which messages: `sensor_msgs/JointState` (`position.<joint>`, `velocity.<joint>`, `effort.<joint>`, SI),
//! `geometry_msgs/PoseStamped`, `TransformStamped` and `PointStamped` (`x,y,z` in metres, `qx,qy,qz,qw`). `t_s` is the stamp of the
//! message's header, else, where that is zero, the recorder's; it counts from the first row. Message n is line n + 1.
//! Source: mcap.dev/spec, and the message definitions of ROS 2 (common_interfaces).
//!
//! Several devices may report on one topic (an arm and its gripper on `/joint_states`): messages with no name in common are those of
//! several devices, and the device is read that has most of the columns that are sought.
//!
//! How it fails: a damaged file, no topic of these messages, several of them and none chosen, a message that is cut short, joints
//! that change on the way, several devices of which none is the one that is sought.

use super::input::{self, Input};
use super::memory;
use crate::error::{Error, Place, Result};
use byteorder::{BigEndian, LittleEndian};
use mcap::read::ChannelAccumulator;
use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use serde::Deserialize;
use std::collections::{BTreeMap, BTreeSet};

/// Bytes of a chunk or a record at most, packed or not.
const LARGEST_RECORD: usize = 256 << 20;
/// Bytes that come out of all chunks at most.
const LARGEST: u64 = 4 << 30;

/// Which topics of a recording are sought.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TopicChoice<'a> {
    /// The only topic with positions.
    Any,
    /// What a controller reports.
    Joints,
    /// What a tracker reports.
    Places,
    /// The topic of this name.
    Topic(&'a str),
}

/// What a message holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Joints,
    Pose,
    Transform,
    Point,
}

impl Kind {
    fn of_schema(name: &str) -> Option<Self> {
        Some(match name {
            "sensor_msgs/msg/JointState" => Self::Joints,
            "geometry_msgs/msg/PoseStamped" => Self::Pose,
            "geometry_msgs/msg/TransformStamped" => Self::Transform,
            "geometry_msgs/msg/PointStamped" => Self::Point,
            _ => return None,
        })
    }
}

#[derive(Deserialize)]
struct Stamp {
    seconds: i32,
    nanoseconds: u32,
}

#[derive(Deserialize)]
struct Header {
    stamp: Stamp,
    _frame: String,
}

#[derive(Deserialize)]
struct JointState {
    header: Header,
    name: Vec<String>,
    position: Vec<f64>,
    velocity: Vec<f64>,
    effort: Vec<f64>,
}

#[derive(Deserialize)]
struct Pose {
    header: Header,
    place: [f64; 3],
    turn: [f64; 4],
}

#[derive(Deserialize)]
struct Transform {
    header: Header,
    _child: String,
    place: [f64; 3],
    turn: [f64; 4],
}

#[derive(Deserialize)]
struct Point {
    header: Header,
    place: [f64; 3],
}

/// A topic that can be read.
struct Topic {
    kind: Kind,
    rows: Vec<Row>,
}

/// A message: its time in nanoseconds, its names and values.
struct Row {
    nanoseconds: i128,
    values: Vec<(String, f64)>,
}

/// Whether these are the first bytes of such a recording.
pub fn is_one(bytes: &[u8]) -> bool {
    bytes.starts_with(mcap::MAGIC)
}

/// Refuses the other store of ROS 2, which needs SQLite to be read.
///
/// # Errors
/// Where the bytes are those of such a file.
pub fn refuse_sqlite(input: &Input) -> Result<()> {
    if !input.bytes.starts_with(b"SQLite format 3\0") {
        return Ok(());
    }
    let expected = "MCAP: `ros2 bag convert` writes it (`storage_id: mcap` in its output options)";
    Err(Error::bad(Place::file(&input.name), "a recording in SQLite (.db3)", expected))
}

/// The rows of one topic as CSV. The checksum stays that of the file.
pub fn unpacked(input: Input, wanted: TopicChoice) -> Result<Input> {
    unpacked_for(input, wanted, |_| true)
}

/// The same of the device that reports most of the columns that are sought, where several report on the topic.
pub fn unpacked_for(input: Input, wanted: TopicChoice, sought: impl Fn(&str) -> bool) -> Result<Input> {
    let Input { name, bytes, sha256 } = input;
    let mut topics = topics(&name, &bytes)?;
    let topic = chosen(&name, &topics, wanted)?.to_string();
    let rows = topics.remove(&topic).map_or_else(Vec::new, |t| t.rows);
    let bytes = text(&name, &of_device(&name, rows, sought)?)?;
    memory::require_size(&name, bytes.len() as u64, input::LARGEST)?;
    Ok(Input { name, bytes, sha256 })
}

/// The messages of the device that is sought, of those with no name in common; all, where names are shared.
fn of_device(name: &str, rows: Vec<Row>, sought: impl Fn(&str) -> bool) -> Result<Vec<Row>> {
    let names = |row: &Row| -> BTreeSet<String> { row.values.iter().map(|v| v.0.clone()).collect() };
    let mut devices: Vec<BTreeSet<String>> = Vec::new();
    for row in &rows {
        let is = |device: &BTreeSet<String>| {
            device.len() == row.values.len() && row.values.iter().all(|(name, _)| device.contains(name))
        };
        if !devices.iter().any(is) {
            devices.push(names(row));
        }
    }
    let apart = |k: usize| devices[k + 1..].iter().all(|other| devices[k].is_disjoint(other));
    if devices.len() < 2 || !(0..devices.len()).all(apart) {
        return Ok(rows);
    }
    let count = |device: &BTreeSet<String>| device.iter().filter(|name| sought(name)).count();
    let most = devices.iter().map(count).max().unwrap_or(0);
    let mut best = devices.iter().filter(|d| count(d) == most);
    match (best.next().filter(|_| most > 0), best.next()) {
        (Some(device), None) => {
            Ok(rows.into_iter().filter(|row| row.values.first().is_some_and(|v| device.contains(&v.0))).collect())
        }
        _ => {
            let listed: Vec<String> =
                devices.iter().map(|d| d.iter().map(String::as_str).collect::<Vec<_>>().join(", ")).collect();
            let found = format!("messages of several devices on one topic: {}", listed.join("; "));
            Err(Error::bad(
                Place::file(name),
                found,
                "columns of one of them, through a column map or the joints of the robot file",
            ))
        }
    }
}

fn chosen<'a>(name: &str, topics: &'a BTreeMap<String, Topic>, wanted: TopicChoice) -> Result<&'a str> {
    let fits = |topic: &str, kind: Kind| match wanted {
        TopicChoice::Any => true,
        TopicChoice::Joints => kind == Kind::Joints,
        TopicChoice::Places => kind != Kind::Joints,
        TopicChoice::Topic(asked) => topic == asked,
    };
    let fitting: Vec<(&String, &Topic)> = topics.iter().filter(|(n, t)| fits(n, t.kind)).collect();
    match fitting.as_slice() {
        [(topic, _)] => Ok(topic),
        [] => {
            let there: Vec<&str> = topics.keys().map(String::as_str).collect();
            let found = match there.as_slice() {
                [] => "no topic that can be read".to_string(),
                there => format!("topics {}", there.join(", ")),
            };
            let expected = match wanted {
                TopicChoice::Topic(topic) => format!("topic {topic}"),
                TopicChoice::Joints => "a topic of JointState".into(),
                TopicChoice::Places => "a topic of PoseStamped, TransformStamped or PointStamped".into(),
                TopicChoice::Any => "a topic of JointState, PoseStamped, TransformStamped or PointStamped".into(),
            };
            Err(Error::bad(Place::file(name), found, expected))
        }
        several => {
            let names: Vec<&str> = several.iter().map(|(n, _)| n.as_str()).collect();
            let expected = "one of them: `topic: NAME` in a column map chooses it";
            Err(Error::bad(Place::file(name), format!("topics {}", names.join(", ")), expected))
        }
    }
}

/// Every topic that can be read, by name.
fn topics(name: &str, bytes: &[u8]) -> Result<BTreeMap<String, Topic>> {
    let damaged = |e: mcap::McapError| {
        Error::bad(Place::file(name), format!("a recording that is damaged or cut short ({e})"), "a whole MCAP file")
    };
    let options = LinearReaderOptions::default().with_record_length_limit(LARGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let mut channels = ChannelAccumulator::default();
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let (mut rest, mut total) = (bytes, 0u64);
    while let Some(event) = reader.next_event() {
        match event.map_err(damaged)? {
            LinearReadEvent::ReadRequest(need) => {
                let (now, later) = rest.split_at(need.min(rest.len()));
                reader.insert(now.len()).copy_from_slice(now);
                reader.notify_read(now.len());
                rest = later;
            }
            LinearReadEvent::Record { data, opcode } => {
                total += data.len() as u64;
                memory::require_size(name, total, LARGEST)?;
                // no other record concerns a message, and the parser of attachments fails on one that is cut short
                if !matches!(opcode, op::SCHEMA | op::CHANNEL | op::MESSAGE) {
                    continue;
                }
                match mcap::parse_record(opcode, data).map_err(damaged)? {
                    Record::Schema { header, data } => {
                        channels.add_schema(header, data.into_owned().into()).map_err(damaged)?;
                    }
                    Record::Channel(channel) => channels.add_channel(channel).map_err(damaged)?,
                    Record::Message { header, data } => {
                        let Some(channel) = channels.get(header.channel_id) else { continue };
                        let kind = channel.schema.as_ref().and_then(|s| Kind::of_schema(&s.name));
                        let Some(kind) = kind.filter(|_| channel.message_encoding == "cdr") else { continue };
                        let topic =
                            topics.entry(channel.topic.clone()).or_insert_with(|| Topic { kind, rows: Vec::new() });
                        let place = || Place::line(format!("{name} ({})", channel.topic), topic.rows.len() as u64 + 1);
                        let row = row(kind, &data, header.log_time).ok_or_else(|| {
                            Error::bad(place(), "a message that is cut short", format!("a {kind:?} message in CDR"))
                        })?;
                        topic.rows.push(row);
                    }
                    _ => {}
                }
            }
        }
    }
    Ok(topics)
}

/// A message; `None`: it does not fit its schema.
fn row(kind: Kind, data: &[u8], log_time: u64) -> Option<Row> {
    let (header, values) = match kind {
        Kind::Joints => {
            let m: JointState = decoded(data)?;
            let columns = [("position", &m.position), ("velocity", &m.velocity), ("effort", &m.effort)];
            // a list without values is one that the robot does not report
            if columns.iter().any(|(_, v)| !v.is_empty() && v.len() != m.name.len()) {
                return None;
            }
            let of = |(what, values): (&str, &Vec<f64>)| -> Vec<(String, f64)> {
                m.name.iter().zip(values).map(|(name, v)| (format!("{what}.{name}"), *v)).collect()
            };
            let values = columns.into_iter().flat_map(of).collect();
            (m.header, values)
        }
        Kind::Pose => {
            let m: Pose = decoded(data)?;
            (m.header, of_place(m.place, Some(m.turn)))
        }
        Kind::Transform => {
            let m: Transform = decoded(data)?;
            (m.header, of_place(m.place, Some(m.turn)))
        }
        Kind::Point => {
            let m: Point = decoded(data)?;
            (m.header, of_place(m.place, None))
        }
    };
    let stamp = i128::from(header.stamp.seconds) * 1_000_000_000 + i128::from(header.stamp.nanoseconds);
    let nanoseconds = if stamp == 0 { i128::from(log_time) } else { stamp };
    Some(Row { nanoseconds, values })
}

fn of_place(place: [f64; 3], turn: Option<[f64; 4]>) -> Vec<(String, f64)> {
    let names = ["x", "y", "z", "qx", "qy", "qz", "qw"];
    names.into_iter().map(String::from).zip(place.into_iter().chain(turn.into_iter().flatten())).collect()
}

/// A value in CDR after its header of four bytes, whose second says how bytes are ordered.
fn decoded<'a, T: Deserialize<'a>>(data: &'a [u8]) -> Option<T> {
    let body = data.get(4..)?;
    match data.get(1)? {
        0 => cdr_encoding::from_bytes::<T, BigEndian>(body).ok().map(|v| v.0),
        1 => cdr_encoding::from_bytes::<T, LittleEndian>(body).ok().map(|v| v.0),
        _ => None,
    }
}

/// A header and a row per message.
fn text(name: &str, rows: &[Row]) -> Result<Vec<u8>> {
    let Some(first) = rows.first() else { return Ok(Vec::new()) };
    let mut writer = csv::Writer::from_writer(Vec::new());
    let cut = |e: csv::Error| Error::bad(Place::file(name), e.to_string(), "names that CSV can hold");
    let header = std::iter::once("t_s").chain(first.values.iter().map(|v| v.0.as_str()));
    writer.write_record(header).map_err(cut)?;
    for (n, row) in rows.iter().enumerate() {
        let named = |row: &Row| row.values.iter().map(|v| v.0.clone()).collect::<Vec<_>>();
        if row.values.len() != first.values.len() || row.values.iter().zip(&first.values).any(|(a, b)| a.0 != b.0) {
            let found = format!("a message with {}", named(row).join(", "));
            return Err(Error::bad(Place::line(name, n as u64 + 2), found, named(first).join(", ")));
        }
        let since = row.nanoseconds - first.nanoseconds;
        let sign = if since < 0 { "-" } else { "" };
        let t = format!("{sign}{}.{:09}", since.abs() / 1_000_000_000, since.abs() % 1_000_000_000);
        writer.write_record(std::iter::once(t).chain(row.values.iter().map(|v| v.1.to_string()))).map_err(cut)?;
    }
    writer.flush().map_err(|e| Error::io_of(name, "read", e))?;
    writer.into_inner().map_err(|e| Error::internal("make rows of a recording", e.into_error()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(nanoseconds: i128, names: &[&str]) -> Row {
        Row { nanoseconds, values: names.iter().map(|n| (format!("position.{n}"), 0.5)).collect() }
    }

    /// What a robot with a gripper writes on `/joint_states`.
    #[test]
    fn of_two_devices_on_one_topic_the_one_with_the_columns_that_are_sought_is_read() {
        let rows = || vec![row(0, &["a1", "a2"]), row(3, &["finger"]), row(20, &["a1", "a2"]), row(23, &["finger"])];
        let sought = |of: &'static str| move |name: &str| name.starts_with(of);
        let read = |device: Result<Vec<Row>>| String::from_utf8(text("r.mcap", &device.unwrap()).unwrap()).unwrap();
        let arm = read(of_device("r.mcap", rows(), sought("position.a")));
        assert_eq!(arm, "t_s,position.a1,position.a2\n0.000000000,0.5,0.5\n0.000000020,0.5,0.5\n");
        let gripper = read(of_device("r.mcap", rows(), sought("position.f")));
        assert!(gripper.starts_with("t_s,position.finger\n"), "{gripper}");
        let said = of_device("r.mcap", rows(), sought("x")).map(|_| ()).unwrap_err().to_string();
        assert!(said.contains("several devices on one topic: position.a1, position.a2; position.finger"), "{said}");
        // a device that leaves out a joint is no second one
        let changing = of_device("r.mcap", vec![row(0, &["a1", "a2"]), row(1, &["a1"])], |_| true).unwrap();
        assert!(
            text("r.mcap", &changing).unwrap_err().to_string().contains("r.mcap:3: found a message with position.a1")
        );
    }
}
