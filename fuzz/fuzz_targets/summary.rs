//! Summaries of shards, as `merge` reads them: each line is that of one program of the manifest.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lostmotion::rewrite::manifest::{Entry, Merged, parse};
use std::sync::LazyLock;

static ENTRIES: LazyLock<Vec<Entry>> = LazyLock::new(|| {
    let line = |k: u8| format!("{{\"key\":\"p{k}.src\",\"size\":1,\"sha256\":\"00\",\"state\":\"ready\"}}\n");
    let text: String = (0..4).map(line).collect();
    parse("manifest.jsonl", text.as_bytes(), &|_| true).expect("a manifest of ours")
});

fuzz_target!(|data: &[u8]| {
    if let Ok(merged) = Merged::parse(&ENTRIES, "summary.jsonl", data) {
        assert_eq!(merged.lines.len(), ENTRIES.len());
        let counts = merged.counts(&ENTRIES, None);
        assert_eq!(counts.done + counts.refused + counts.failed + counts.left, counts.programs);
    }
});
