//! A program as a whole: what its text must say, and as many readings of it as its subprograms need.

use super::codes::AXES;
use super::read::Reader;
use super::statements::Program;
use super::survey::Survey;
use crate::axes::Axes;
use crate::error::{Error, Result};
use crate::script::Text;
use crate::script::lex::not_too_long;

/// Readings of a text whose subprograms stand in front of their calls, and call others that do.
const MOST_READINGS: usize = 4;

/// Reads a program.
pub(super) fn program(texts: Vec<Text>, robot: &Axes) -> Result<Program> {
    let Some(text) = texts.first() else {
        return Err(Error::bad(crate::error::Place::file(""), "no text", "a G-code program"));
    };
    not_too_long(text)?;
    let letters = letters(text, robot)?;
    let mut survey = Survey::of(text)?;
    let missing = missing_modes(&survey, robot);
    survey.codes.extend(robot.control.codes());
    survey.whole_units = robot.control.whole_units;
    let only_whole = survey.only_whole();
    let reader = settled(text, robot, &letters, survey)?;
    let marker = reader.survey.marker();
    let Reader { mut script, statements, waits, order, survey, .. } = reader;
    order.settle(&survey.around(), &mut script);
    let si = robot.axis_joints().map(|j| j.kind.si_per_user_unit()).collect();
    script.texts = texts;
    // without a move nothing depends on them
    if script.moves().next().is_some() {
        script.missing = missing;
        script.only_whole_numbers = only_whole;
    }
    Ok(Program { script, statements, letters, si, marker, waits })
}

/// Reads a text; where programs stand in front of their calls, again with the modes of these calls, until one reading finds the modes
/// with which it began.
fn settled<'a>(text: &'a Text, robot: &'a Axes, letters: &'a [u8], survey: Survey) -> Result<Reader<'a>> {
    let mut reader = Reader::new(text, robot, letters, survey);
    reader.whole()?;
    for _ in 1..MOST_READINGS {
        if !reader.precedes_calls || reader.foreseen == reader.called_in {
            return Ok(reader);
        }
        let (foreseen, survey) = (std::mem::take(&mut reader.called_in), std::mem::take(&mut reader.survey));
        reader = Reader { foreseen, ..Reader::new(text, robot, letters, survey) };
        reader.whole()?;
    }
    if reader.foreseen != reader.called_in {
        // by the calls above alone
        reader = Reader::new(text, robot, letters, reader.survey);
        reader.whole()?;
    }
    Ok(reader)
}

/// The letter of each axis; 0 where its name is no word of G-code.
fn letters(text: &Text, robot: &Axes) -> Result<Vec<u8>> {
    let letters: Vec<u8> = robot
        .axis_joints()
        .map(|j| match j.name.as_bytes() {
            [b] if AXES.contains(&b.to_ascii_uppercase()) => b.to_ascii_uppercase(),
            _ => 0,
        })
        .collect();
    if letters.iter().all(|&l| l == 0) {
        return Err(text.bad(
            0,
            format!("G-code for a robot with the axes {}", robot.axis_names().join(", ")),
            "axes named as G-code words: X, Y, Z, A, B, C, U, V, W",
        ));
    }
    Ok(letters)
}

/// Modes that neither the program nor the robot file gives.
fn missing_modes(survey: &Survey, robot: &Axes) -> Vec<&'static str> {
    let given = |codes: [u32; 2]| codes.iter().any(|c| survey.codes.contains(c));
    let mut missing = Vec::new();
    if robot.control.absolute.is_none() && !given([900, 910]) {
        missing.push("G90 or G91");
    }
    if robot.control.inch.is_none() && !given([200, 210]) {
        missing.push("G20 or G21");
    }
    missing
}
