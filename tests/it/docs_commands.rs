//! The commands that the pages print run as they stand, in the root of the repository.

use crate::support::{self, WorkFolder, bundled, root};
use std::process::Command;

/// Pages whose commands are run. Those of other pages name the files of a user.
const PAGES: [&str; 18] = [
    "assess-bidirectional",
    "assess-circle",
    "assess-impact",
    "assess-program",
    "choosing",
    "fit",
    "golden-files",
    "identify-deadzone",
    "identify-path",
    "identify-screw",
    "identify-static",
    "join",
    "learn",
    "model",
    "robot",
    "simulate",
    "track",
    "tutorial",
];

/// Blocks of a page by their language.
fn blocks(page: &str) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(bundled(&format!("docs/{page}.md"))).unwrap();
    let mut found = Vec::new();
    let mut open: Option<(String, String)> = None;
    for line in text.lines() {
        match (line.strip_prefix("```"), &mut open) {
            (Some(language), None) => open = Some((language.trim().into(), String::new())),
            (Some(_), Some(_)) => found.extend(open.take()),
            (None, Some((_, block))) => block.extend([line, "\n"]),
            (None, None) => {}
        }
    }
    assert!(open.is_none(), "{page}: a block that does not end");
    found
}

/// A folder that looks like the root of the repository to a command that reads samples and writes into `out`.
#[cfg(unix)]
fn checkout() -> WorkFolder {
    let work = WorkFolder::new();
    for folder in ["configs", "samples"] {
        std::os::unix::fs::symlink(root().join(folder), work.join(folder)).unwrap();
    }
    work
}

#[cfg(unix)]
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn every_printed_command_runs_as_it_stands() {
    let binary = support::binary().parent().unwrap();
    let path = std::env::join_paths(
        std::iter::once(binary.to_path_buf()).chain(std::env::split_paths(&std::env::var_os("PATH").unwrap())),
    )
    .unwrap();
    std::thread::scope(|scope| {
        for page in PAGES {
            let path = &path;
            scope.spawn(move || {
                let work = checkout();
                let mut commands = 0;
                for (_, block) in blocks(page).into_iter().filter(|(language, _)| language == "sh") {
                    commands += block.lines().filter(|l| l.starts_with("lostmotion ")).count();
                    let out = Command::new("sh")
                        .args(["-euc", &block])
                        .env("PATH", path)
                        .current_dir(work.path())
                        .output()
                        .unwrap();
                    assert!(out.status.success(), "{page}:\n{block}\n{}", String::from_utf8_lossy(&out.stderr));
                }
                assert!(commands >= 1, "{page} prints no command");
                if page == "tutorial" {
                    states_what_is_left(&work);
                }
                let written = std::fs::read_dir(work.path()).unwrap().map(|e| e.unwrap().file_name());
                let stray: Vec<_> = written.filter(|n| !["configs", "samples", "out"].iter().any(|k| n == k)).collect();
                assert!(stray.is_empty(), "{page} writes {stray:?} beside `out`");
            });
        }
    });
}

/// The tutorial's figures of what is left are those of its own commands.
#[cfg(unix)]
fn states_what_is_left(work: &WorkFolder) {
    let text = std::fs::read_to_string(bundled("docs/tutorial.md")).unwrap().replace('\n', " ");
    let model = "--model samples/models/kuka-figure5.model.yaml --before samples/circle/circle_program.csv";
    for (after, sentence) in
        [("circle", "The largest remaining errors are "), ("all-circle", "With this compensator the largest ")]
    {
        let line = format!("assess program {model} --after out/{after}.csv --json");
        let result: serde_json::Value = work.run(&line).success().json();
        let stated = text.split(sentence).nth(1).unwrap().split("Stiction causes").next().unwrap();
        for joint in ["A1", "A3"] {
            let words: Vec<&str> = stated.split(&format!(" um at {joint}")).next().unwrap().split(' ').collect();
            let [.., lo, "to", hi] = words.as_slice() else { panic!("{joint}: no range in {stated}") };
            let range = lo.parse::<f64>().unwrap()..=hi.parse::<f64>().unwrap();
            let of_joint = result["reversals"].as_array().unwrap().iter().filter(|r| r["joint"] == joint);
            for um in of_joint.map(|r| r["after_um"].as_f64().unwrap()) {
                assert!(range.contains(&um), "{after}, {joint}: {um} um, the tutorial states {range:?}");
            }
        }
        let rms = format!("{:.1}", result["rms_um"]["after"].as_f64().unwrap());
        assert!(text.contains(&format!("{rms} um rms")) || text.contains(&format!("({rms} um with")), "{after}: {rms}");
    }
}

#[test]
fn no_command_of_these_pages_stands_in_a_block_that_is_not_run() {
    for page in PAGES {
        for (language, block) in blocks(page) {
            let command = block.lines().find(|l| l.starts_with("lostmotion "));
            assert!(language == "sh" || command.is_none(), "{page}: {}", command.unwrap_or_default());
        }
    }
}
