use super::print::{ROOM, fixed};
use super::*;
use proptest::prelude::*;

/// Operations and their results by Python's `decimal` (`samples` of every size and sign; see the head of the file).
const TABLE: &str = include_str!("table.txt");

fn decimal(text: &str) -> Decimal {
    Decimal::read(text.as_bytes()).unwrap_or_else(|| panic!("{text}"))
}

fn show(number: Option<Decimal>) -> String {
    number.map_or("none".into(), |n| n.to_string())
}

#[test]
fn decimals_are_those_of_another_implementation() {
    let mut lines = 0;
    for line in TABLE.lines().filter(|l| !l.starts_with('#')) {
        let cells: Vec<&str> = line.split(' ').collect();
        let [operation, a, b, want] = cells[..] else { panic!("{line}") };
        let same = |got: Option<Decimal>| got.is_some_and(|g| g.to_string() == want);
        let right = match operation {
            "value" => decimal(a).value().to_bits() == want.parse::<f64>().unwrap().to_bits(),
            "compare" => format!("{:?}", decimal(a).cmp(&decimal(b))) == want,
            "round" => same(decimal(a).rounded(b.parse().unwrap())),
            "floor" => same(decimal(a).floor(b.parse().unwrap())),
            "ceil" => same(decimal(a).ceil(b.parse().unwrap())),
            // the offset as a double, and digits after the point
            "offset" => {
                let (by, decimals) = b.split_once('/').unwrap();
                same(decimal(a).offset(by.parse().unwrap(), decimals.parse().unwrap()))
            }
            _ => panic!("{line}"),
        };
        assert!(right, "{line}: {}", show(Decimal::read(a.as_bytes())));
        lines += 1;
    }
    assert!(lines >= 2000, "{lines}");
}

proptest! {
    #[test]
    fn what_is_read_is_written_again(sign in "-?", whole in "0|[1-9][0-9]{0,9}", fraction in "(\\.[0-9]{1,8})?") {
        let text = format!("{sign}{whole}{fraction}");
        prop_assert_eq!(decimal(&text).to_string(), text);
    }

    #[test]
    fn values_are_those_of_the_standard_library(sign in "[+-]?", whole in "[0-9]{0,10}", fraction in "[0-9]{1,8}") {
        let text = format!("{sign}{whole}.{fraction}");
        prop_assert_eq!(decimal(&text).value().to_bits(), text.parse::<f64>().unwrap().to_bits());
    }

    #[test]
    fn an_offset_there_and_back_is_nothing(
        mantissa in -9_999_999_999i64..10_000_000_000, d in 0u8..8, by in -9_999_999i64..10_000_000
    ) {
        let own = Decimal::new(mantissa, d).unwrap();
        let by = by as f64 / 1e7;
        // with the digits of the offset every sum is exact
        let there = own.offset(by, 7).unwrap();
        let back = there.offset(-by, 7).unwrap();
        prop_assert_eq!(back, own);
        prop_assert_eq!(i128::from(there.mantissa()), i128::from(mantissa) * 10i128.pow(7 - u32::from(d)) + (by * 1e7).round() as i128);
    }

    #[test]
    fn any_bytes_are_a_decimal_or_none(bytes in "[0-9.+-]{0,24}|\\PC{0,12}") {
        if let Some(number) = Decimal::read(bytes.as_bytes()) {
            prop_assert_eq!(number.value().to_bits(), bytes.parse::<f64>().unwrap().to_bits());
        } else if let Ok(value) = bytes.parse::<f64>() {
            let digits = bytes.bytes().filter(u8::is_ascii_digit).count();
            prop_assert!(digits > 18 || !value.is_finite() || bytes.contains(['e', 'E', 'i', 'n', 'N', 'I']));
        }
    }

    #[test]
    fn fixed_numbers_are_written_as_the_standard_library_writes_them(
        n in 0u64..100_000_000, small in 0u64..100_000, d in 0u32..8, negative: bool
    ) {
        for n in [n, small, small / 1000] {
            let mut out = [0u8; ROOM];
            let len = fixed(&mut out, negative, n, d);
            let sign = if negative && n != 0 { "-" } else { "" };
            let unit = 10u64.pow(d);
            let want = match d {
                0 => format!("{sign}{n}"),
                _ => format!("{sign}{}.{:0width$}", n / unit, n % unit, width = d as usize),
            };
            prop_assert_eq!(std::str::from_utf8(&out[..len]).unwrap(), want);
        }
    }
}

#[test]
fn halves_go_away_from_zero_and_noise_of_doubles_does_not_count() {
    // 0.00285 is no double; the sum is a tie all the same
    for (own, by, want) in [
        ("12.3456", 0.00285, "12.3485"),
        ("-12.3456", -0.00285, "-12.3485"),
        ("-12.3456", 0.00285, "-12.3428"),
        ("0.0000", -0.00005, "-0.0001"),
    ] {
        assert_eq!(decimal(own).offset(by, 4).unwrap().to_string(), want, "{own} {by}");
    }
    // the same by way of radians, as the offset of a joint comes
    let own = 118.6345f64.to_radians();
    let by = ((own + 0.00285f64.to_radians()) - own).to_degrees();
    assert_eq!(decimal("118.6345").offset(by, 4).unwrap().to_string(), "118.6374");
}

#[test]
fn what_does_not_fit_is_no_decimal() {
    assert!(Decimal::read(b"1234567890123456789").is_none());
    assert!(Decimal::read(b"0.0000000000000000001").is_none());
    assert!(decimal("999999999999999999").offset(1.0, 0).is_none());
    assert!(decimal("999999999999999999").rounded(1).is_none());
    for text in ["", "-", ".", "+.", "1.2.3", "1e5", "--1", "1 ", " 1", "0x1", "nan", "inf", "١"] {
        assert!(Decimal::read(text.as_bytes()).is_none(), "{text}");
    }
}
