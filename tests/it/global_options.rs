//! Options that every command takes: how much is printed, colours, threads.

use crate::support::{self, Outcome, bundled, root};

fn run(args: &[&str], env: &[(&str, &str)]) -> Outcome {
    let mut command = support::command();
    command.current_dir(root()).env_remove("NO_COLOR").env_remove("RAYON_NUM_THREADS");
    support::outcome(command.args(args).envs(env.iter().copied()))
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
    assert!(loud.stderr.contains("A1"), "{}", loud.stderr);
    for place in [0, FOUND.len()] {
        let mut args = FOUND.to_vec();
        args.insert(place, "-q");
        let quiet = run(&args, &[]);
        assert_eq!((quiet.stderr.as_str(), quiet.stdout), ("", loud.stdout.clone()), "{args:?}");
    }
    let refused = run(&["-q", "robot", "check", "nothing.yaml"], &[]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.starts_with("lostmotion: nothing.yaml"), "{}", refused.stderr);
}

#[test]
fn verbose_says_what_was_read_and_how_long_it_took() {
    let out = run(&[&["-v"], &FOUND[..]].concat(), &[]);
    let text = out.stderr;
    let sum = lostmotion::io::input::sha256(&std::fs::read(root().join(FOUND[5])).unwrap());
    assert!(text.contains("samples/static/single_axis_A1.csv.gz: ") && text.contains(&sum), "{text}");
    assert!(text.starts_with(concat!("lostmotion ", env!("CARGO_PKG_VERSION"), ", ")), "{text}");
    assert!(text.lines().last().unwrap().contains(" s"), "{text}");
    assert_eq!(run(&["-q", "-v", "demo"], &[]).code, Some(2), "one of the two");
}

#[test]
fn jobs_set_the_threads_and_change_no_byte() {
    let one = run(&[&["-v", "--jobs", "1"], &FOUND[..]].concat(), &[]);
    let three = run(&[&["-v", "-j3"], &FOUND[..]].concat(), &[]);
    assert!(one.stderr.contains(", 1 thread\n") && three.stderr.contains(", 3 threads"), "{}", three.stderr);
    assert_eq!(one.stdout, three.stdout);
    for number in ["0", "1025", "1000000", "18446744073709551616", "-1", "two"] {
        let out = run(&[&format!("--jobs={number}"), "demo"], &[]);
        assert_eq!(out.code, Some(2), "{number}");
        assert!(out.stderr.contains("from 1 to 1024"), "{number}: {}", out.stderr);
    }
}

#[test]
fn a_wrong_command_line_bears_the_prefix_of_all_errors_and_colours_only_where_asked_for() {
    let wrong = ["identify", "static", "--nonsense"];
    let plain = run(&wrong, &[]);
    assert_eq!(plain.code, Some(2));
    assert!(plain.stderr.starts_with("lostmotion: unexpected argument '--nonsense'"), "{}", plain.stderr);
    let escape = '\u{1b}';
    assert!(!plain.stderr.contains(escape), "no terminal, no colours");
    for always in [&["--color", "always"][..], &["--color=always"]] {
        let colored = run(&[always, &wrong].concat(), &[("NO_COLOR", "1")]);
        assert!(colored.stderr.contains(escape) && colored.stderr.contains("lostmotion:"), "{}", colored.stderr);
    }
    let help = run(&["--color", "always", "identify", "--help"], &[]);
    assert!(help.text().contains(escape));
    let help = run(&["--color", "never", "identify", "--help"], &[]);
    assert!(help.succeeded() && !help.text().contains(escape));
}

#[test]
fn a_file_that_is_given_the_way_of_another_command_gets_a_tip() {
    let tip = |line: &[&str]| run(line, &[]).stderr;
    for (line, expected) in [
        (&["identify", "--robot", "robot.yaml", "static.csv"][..], "'--log FILE'"),
        (&["identify", "static", "logs/a1.csv"], "'--log FILE'"),
        (&["simulate", "--robot", "robot.yaml", "weld.src"], "'--input FILE'"),
        (&["fit", "gaps.yaml"], "'--gaps FILE'"),
        (&["rewrite", "--robot", "robot.yaml", "--input", "weld.src"], "<IN> is given without an option"),
    ] {
        let text = tip(line);
        assert!(text.contains(expected), "{line:?}: {text}");
    }
    for line in [&["identify", "static", "--nonsense"][..], &["robot", "check", "--robot", "a.yaml"]] {
        assert!(!tip(line).contains("tip:"), "{}", tip(line));
    }
}

#[test]
fn the_page_names_every_option_of_every_command() {
    let page = std::fs::read_to_string(bundled("docs/command-line.md")).unwrap();
    let cli = lostmotion::cli::help::command();
    let global: Vec<&str> = cli.get_arguments().filter(|a| a.is_global_set()).filter_map(|a| a.get_long()).collect();
    assert!(global.len() >= 4, "{global:?}");
    for option in global {
        assert!(page.contains(&format!("`--{option}")) || page.contains(&format!("--{option} ")), "--{option}");
    }
}
