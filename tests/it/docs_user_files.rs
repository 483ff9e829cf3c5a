//! The commands of pages that name a user's files (`robot.yaml`, `weld.src`) run, too: in a folder that holds such files.

use crate::support::{self, WorkFolder, bundled, root};
use std::path::Path;
use std::process::Command;

/// Files that several pages name.
const KUKA: &str = r#"
cp "$ROOT/configs/kuka-kr120-r2500-pro.yaml" robot.yaml
cp "$ROOT/samples/circle/circle_program.csv" program.csv
sed 's|../../configs/kuka-kr120-r2500-pro.yaml|robot.yaml|' "$ROOT/samples/models/kuka-figure5.model.yaml" > model.yaml
cp "$ROOT/samples/programs/krl/spline-forms.src" weld.src
cp "$ROOT/samples/programs/krl/spline-forms.dat" weld.dat
cp "$ROOT/samples/programs/inform/ANGLE.JBI" weld.JBI
mkdir cell
cp "$ROOT"/samples/programs/krl/spline-forms.* cell/
sed 's/spline.forms/weld/I' weld.src > cell/weld.src
cp weld.dat cell/weld.dat
"#;

/// A machine whose logs are short enough for a test.
const ARM: &str = r#"
A="$ROOT/tests/data/machines/arm"
cp "$A/robot.yaml" robot.yaml
for j in 1 2; do cp "$A/static_J$j.csv.gz" axis$j.csv; cp "$A/static_J$j.csv.gz" static_A$j.csv; done
cp "$A/circle.csv.gz" circle.csv
cp "$A/excitation.csv.gz" excitation.csv
cp "$A/program_circle.csv" program.csv
"#;

/// Page, blocks of it by number of its first (those with a command are counted), and what makes the files that they name.
fn pages() -> Vec<(&'static str, usize, usize, String)> {
    let comp =
        "lostmotion fit --robot robot.yaml --gaps gaps.yaml --output compensator.yaml; cp compensator.yaml comp.yaml\n";
    let gaps = "lostmotion identify static --robot robot.yaml --log \"$ROOT/samples/static/single_axis_A1.csv.gz\" --output gaps.yaml\n";
    let kuka = format!("{KUKA}{gaps}{comp}");
    let logs = r#"lostmotion simulate --model model.yaml --input program.csv --output whole.csv --rate-hz 40
head -n 3000 whole.csv > log.csv
cp log.csv slow.csv
lostmotion simulate --model model.yaml --input program.csv --output fast.csv --rate-hz 40 --speed-mm-s 40 --seed 5
sed '/^effects:/,$d' model.yaml > machine.yaml
printf 'schema: lostmotion/columns/1\ncolumns: {x_mm: x_mm}\n' > map.yaml
"#;
    let diagnosis = "lostmotion diagnose --model machine.yaml --log log.csv --json > diagnosis.json\n";
    let shards = "lostmotion manifest cell/ --output plan.jsonl; for k in 1 2 4 5 6 7 8; do lostmotion rewrite --robot robot.yaml \
        --compensator comp.yaml cell/ --manifest plan.jsonl --shard $k/8 --output-dir done/ --summary part-$k.jsonl; done; \
        lostmotion rewrite --robot robot.yaml --compensator comp.yaml program.csv --output golden.csv; rm -rf done; mkdir done\n";
    vec![
        ("README.md", 0, 1, format!("{ARM}cp circle.csv before.csv; cp circle.csv after.csv\n")),
        ("README.md", 1, 2, kuka.clone()),
        ("README.md", 2, 3, "cp \"$ROOT/samples/bidirectional/irb1600_y.csv\" readings.csv\n".into()),
        ("README.md", 3, 4, format!("{KUKA}{logs}")),
        ("docs/identify.md", 0, 9, ARM.into()),
        ("docs/diagnose.md", 0, 9, format!("{KUKA}{logs}")),
        ("docs/plan-experiment.md", 0, 9, format!("{KUKA}{logs}{diagnosis}")),
        ("docs/rewrite.md", 0, 9, format!("{kuka}cp model.yaml machine.yaml\n{shards}")),
    ]
}

/// Blocks without a language that hold commands.
fn commands(page: &str) -> Vec<String> {
    let text = std::fs::read_to_string(root().join(page)).unwrap();
    let parts: Vec<&str> = text.split("\n```").collect();
    let blocks = parts.iter().skip(1).step_by(2);
    blocks.filter_map(|b| b.strip_prefix('\n')).filter(|b| b.starts_with("lostmotion ")).map(String::from).collect()
}

#[cfg(unix)]
#[test]
#[ignore = "takes long: .ci/run runs it"]
fn commands_on_a_users_files_run_in_a_folder_that_holds_them() {
    let binary = support::binary().parent().unwrap();
    let path = std::env::var_os("PATH").unwrap();
    let path = std::iter::once(binary.to_path_buf()).chain(std::env::split_paths(&path));
    let path = std::env::join_paths(path).unwrap();
    let run = |script: &str, folder: &Path| {
        let out = Command::new("sh")
            .args(["-euc", script])
            .env("PATH", &path)
            .env("ROOT", root())
            .current_dir(folder)
            .output()
            .unwrap();
        assert!(out.status.success(), "{script}\n{}", String::from_utf8_lossy(&out.stderr));
    };
    std::thread::scope(|scope| {
        for (page, from, to, files) in pages() {
            let run = &run;
            scope.spawn(move || {
                let blocks = commands(page);
                let blocks = &blocks[from..to.min(blocks.len())];
                assert!(!blocks.is_empty(), "{page}: no block {from}");
                let work = WorkFolder::new();
                run(&files, work.path());
                for block in blocks {
                    run(block, work.path());
                }
            });
        }
    });
}

/// Every page with a command is run by this test or by `docs_commands`.
#[test]
fn no_page_with_commands_is_left_out() {
    let covered: Vec<&str> = pages().iter().map(|p| p.0).collect();
    let mut all = vec!["README.md".to_string()];
    all.extend(std::fs::read_dir(bundled("docs")).unwrap().filter_map(|e| {
        let name = e.unwrap().file_name().into_string().unwrap();
        name.ends_with(".md").then(|| format!("docs/{name}"))
    }));
    for page in all {
        assert!(
            commands(&page).is_empty() || covered.contains(&page.as_str()),
            "{page} has commands that no test runs"
        );
    }
    assert_eq!(commands("README.md").len(), 4, "blocks of README.md in pages()");
}
