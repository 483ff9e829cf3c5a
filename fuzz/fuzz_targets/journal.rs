//! Journals of interrupted runs: none names a file out of its folder.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::io::journal::Journal;

fuzz_target!(|data: &[u8]| {
    if let Some(journal) = Journal::parse(data) {
        let names = journal.files().iter().flat_map(|f| [Some(&f.target), f.new.as_ref(), f.old.as_ref()]);
        assert!(names.flatten().all(|n| !n.contains('/') && n != ".."), "a file out of the folder");
    }
});
