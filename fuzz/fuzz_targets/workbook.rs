//! Workbooks (`.xlsx`, `.ods`, `.xls`): what is unpacked is bounded.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::io::input::Input;
use lostmotion::io::workbook::unpacked;

fuzz_target!(|data: &[u8]| {
    let _ = unpacked(Input { name: "log.xlsx".into(), bytes: data.to_vec(), sha256: String::new() });
});
