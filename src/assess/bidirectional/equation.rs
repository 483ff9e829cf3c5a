//! The fitted equation as the paper prints it (Slamani (2012) equations 26 and 27): `ŷ = 33.83 − 0.0914x + 0.0001x² + 42.6D`,
//! micrometres over millimetres along the line.

use super::digits::digits;
use super::model::{Block, Model};

/// Significant digits of a coefficient, as many as the paper prints of its first.
const DIGITS: usize = 4;

/// The coefficient of a power of the position in micrometres over millimetres to that power.
pub fn um_per_mm(si: f64, power: usize) -> f64 {
    si * 1e6 * 1e-3_f64.powi(power as i32)
}

/// Its unit.
pub fn unit(power: usize) -> String {
    match power {
        0 => "um".into(),
        1 => "um/mm".into(),
        k => format!("um/mm^{k}"),
    }
}

/// Letter of an indicator variable: D where there is one, else D₁, D₂, ...
pub fn indicator(k: usize, of: usize) -> String {
    if of == 1 { "D".into() } else { format!("D{}", small(k + 1, '₀')) }
}

fn small(number: usize, zero: char) -> String {
    const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let lowered = |d: usize| char::from_u32(zero as u32 + d as u32).unwrap_or('?');
    let digit = |b: u8| usize::from(b - b'0');
    number.to_string().bytes().map(|b| if zero == '⁰' { RAISED[digit(b)] } else { lowered(digit(b)) }).collect()
}

fn power(k: usize) -> String {
    match k {
        0 => String::new(),
        1 => "x".into(),
        k => format!("x{}", small(k, '⁰')),
    }
}

/// The equation of a model.
pub fn of(model: &Model) -> String {
    let letters = model.blocks.len() - 1;
    let mut text = String::from("ŷ =");
    let mut first = true;
    for (b, block) in model.blocks.iter().enumerate() {
        let letter = if b == 0 { String::new() } else { indicator(b - 1, letters) };
        for (k, c) in coefficients(block).into_iter().enumerate() {
            let sign = match (first, c < 0.0) {
                (true, false) => " ",
                (true, true) => " −",
                (false, false) => " + ",
                (false, true) => " − ",
            };
            text.push_str(sign);
            text.push_str(&format!("{}{letter}{}", digits(c.abs(), DIGITS), power(k)));
            first = false;
        }
    }
    text
}

/// Coefficients of a block in the paper's units.
pub fn coefficients(block: &Block) -> Vec<f64> {
    block.powers.iter().enumerate().map(|(k, c)| um_per_mm(*c, k)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_as_the_paper_writes_them() {
        let written: Vec<String> =
            [33.83, -0.0914, 0.0001, 42.6, 0.000_102_34, 1234.56, 0.0, 1.5e-12].iter().map(|v| digits(*v, 4)).collect();
        assert_eq!(written, ["33.83", "-0.0914", "0.0001", "42.6", "0.0001023", "1235", "0", "1.5e-12"]);
        assert_eq!([power(0), power(1), power(2), power(12)], ["", "x", "x²", "x¹²"]);
        assert_eq!([indicator(0, 1), indicator(1, 3)], ["D", "D₂"]);
    }
}
