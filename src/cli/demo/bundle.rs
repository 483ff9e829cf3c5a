//! What the demo brings with it. All logs are simulated by an independent program (`samples/README.md`); nothing was measured.

use crate::error::Result;
use crate::io::input::{Input, from_bytes};
use crate::log::Log;
use crate::model::Model;
use crate::robot::Robot;

const ROBOT: &str = include_str!("../../../configs/kuka-kr120-r2500-pro.yaml");
const MACHINE: &str = include_str!("../../../samples/models/kuka-table3.model.yaml");
pub const PROGRAM: &[u8] = include_bytes!("../../../samples/circle/circle_program.csv");
const CIRCLE: (&str, &[u8]) = (
    "circle_uncompensated_table3.csv.gz",
    include_bytes!("../../../samples/circle/circle_uncompensated_table3.csv.gz"),
);

macro_rules! static_logs {
    ($($name:literal),*) => {
        [$(($name, include_bytes!(concat!("../../../samples/static/", $name)) as &[u8])),*]
    };
}

const STATIC: [(&str, &[u8]); 6] = static_logs![
    "single_axis_A1.csv.gz",
    "single_axis_A2.csv.gz",
    "single_axis_A3.csv.gz",
    "single_axis_A4.csv.gz",
    "single_axis_A5.csv.gz",
    "single_axis_A6.csv.gz"
];

pub fn robot() -> Result<Robot> {
    Robot::parse("the bundled robot", ROBOT)
}

/// The machine on which the programs are run: gaps and stiction of Zhang (2023) Table 3.
pub fn machine() -> Result<Model> {
    Model::parse("the bundled machine", MACHINE, &|_| robot())
}

fn input((name, bytes): (&str, &[u8])) -> Result<Input> {
    from_bytes(name.to_string(), bytes.to_vec())
}

pub fn circle_log(robot: &Robot) -> Result<Log> {
    Log::parse(input(CIRCLE)?, robot)
}

pub fn static_logs(robot: &Robot) -> Result<Vec<Log>> {
    STATIC.into_iter().map(|one| Log::parse(input(one)?, robot)).collect()
}
