//! Options that every command takes: how much is printed, colours, threads.

use std::path::PathBuf;
use std::process::{Command, Output};

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn run(args: &[&str], env: &[(&str, &str)]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lostmotion"));
    command.current_dir(root()).env_remove("NO_COLOR").env_remove("RAYON_NUM_THREADS");
    command.args(args).envs(env.iter().copied()).output().unwrap()
}

fn words(out: &Output) -> String {
    String::from_utf8_lossy(&out.stderr).into_owned()
}

const FOUND: [&str; 7] = [
    "identify",
    "static",
    "--robot",
    "configs/kuka-kr120-r2500-pro.yaml",
    "--log",
    "samples/static/single_axis_A1.csv.gz",
    "--output=-",
];

#[test]
fn quiet_leaves_results_and_refusals_and_nothing_else() {
    let loud = run(&FOUND, &[]);
    assert!(words(&loud).contains("A1"), "{}", words(&loud));
    for place in [0, FOUND.len()] {
        let mut args = FOUND.to_vec();
        args.insert(place, "-q");
        let quiet = run(&args, &[]);
        assert_eq!((words(&quiet).as_str(), quiet.stdout), ("", loud.stdout.clone()), "{args:?}");
    }
    let refused = run(&["-q", "robot", "check", "nothing.yaml"], &[]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(words(&refused).starts_with("lostmotion: nothing.yaml"), "{}", words(&refused));
}

#[test]
fn verbose_says_what_was_read_and_how_long_it_took() {
    let out = run(&[&["-v"], &FOUND[..]].concat(), &[]);
    let text = words(&out);
    let sum = lostmotion::io::input::sha256(&std::fs::read(root().join(FOUND[5])).unwrap());
    assert!(text.contains("samples/static/single_axis_A1.csv.gz: ") && text.contains(&sum), "{text}");
    assert!(text.starts_with(concat!("lostmotion ", env!("CARGO_PKG_VERSION"), ", ")), "{text}");
    assert!(text.lines().last().unwrap().contains(" s"), "{text}");
    assert_eq!(run(&["-q", "-v", "demo"], &[]).status.code(), Some(2), "one of the two");
}

#[test]
fn jobs_set_the_threads_and_change_no_byte() {
    let one = run(&[&["-v", "--jobs", "1"], &FOUND[..]].concat(), &[]);
    let three = run(&[&["-v", "-j3"], &FOUND[..]].concat(), &[]);
    assert!(words(&one).contains(", 1 thread\n") && words(&three).contains(", 3 threads"), "{}", words(&three));
    assert_eq!(one.stdout, three.stdout);
    assert_eq!(run(&["--jobs", "0", "demo"], &[]).status.code(), Some(2));
}

#[test]
fn a_wrong_command_line_bears_the_prefix_of_all_errors_and_colours_only_where_asked_for() {
    let wrong = ["identify", "static", "--nonsense"];
    let plain = run(&wrong, &[]);
    assert_eq!(plain.status.code(), Some(2));
    assert!(words(&plain).starts_with("lostmotion: unexpected argument '--nonsense'"), "{}", words(&plain));
    let escape = '\u{1b}';
    assert!(!words(&plain).contains(escape), "no terminal, no colours");
    for always in [&["--color", "always"][..], &["--color=always"]] {
        let colored = run(&[always, &wrong].concat(), &[("NO_COLOR", "1")]);
        assert!(words(&colored).contains(escape) && words(&colored).contains("lostmotion:"), "{}", words(&colored));
    }
    let help = run(&["--color", "always", "identify", "--help"], &[]);
    assert!(String::from_utf8_lossy(&help.stdout).contains(escape));
    let help = run(&["--color", "never", "identify", "--help"], &[]);
    assert!(help.status.success() && !String::from_utf8_lossy(&help.stdout).contains(escape));
}

#[test]
fn the_page_names_every_option_of_every_command() {
    let page = std::fs::read_to_string(root().join("docs/command-line.md")).unwrap();
    let cli = lostmotion::cli::help::command();
    let global: Vec<&str> = cli.get_arguments().filter(|a| a.is_global_set()).filter_map(|a| a.get_long()).collect();
    assert!(global.len() >= 4, "{global:?}");
    for option in global {
        assert!(page.contains(&format!("`--{option}")) || page.contains(&format!("--{option} ")), "--{option}");
    }
}
