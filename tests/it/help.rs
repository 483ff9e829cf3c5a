//! The help of every command as a user reads it, 100 columns wide, against the checked-in snapshots.
//!
//! After a change of a help text: `INSTA_UPDATE=always cargo test --test it help::`, then read the difference.

use clap::Command;

/// Renders the help of `command` and of every command below it, each under its own name.
fn visit(path: &str, command: &mut Command, seen: &mut dyn FnMut(&str, String)) {
    seen(path, command.render_long_help().to_string());
    let names: Vec<String> =
        command.get_subcommands().map(|c| c.get_name().to_string()).filter(|n| n != "help").collect();
    for name in names {
        let sub = command.find_subcommand_mut(&name).expect("a name that clap listed");
        visit(&format!("{path}-{name}"), sub, seen);
    }
}

/// Options of every command are shown once, with the first command.
fn own(help: &str) -> String {
    let Some(start) = help.find("Options of every command:") else { return help.to_string() };
    let end = help[start..].find("\n\nExamples:").map_or(help.len(), |at| start + at + 2);
    format!("{}{}", &help[..start], &help[end..])
}

#[test]
fn every_help_text_is_the_reviewed_one() {
    let mut all = lostmotion::cli::help::command().term_width(100);
    all.build();
    let mut settings = insta::Settings::clone_current();
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| {
        visit("lostmotion", &mut all, &mut |name, help| {
            let shown = if name == "lostmotion" { help } else { own(&help) };
            insta::assert_snapshot!(name, shown);
        });
    });
}

/// Words that the style guide forbids in texts for users.
#[test]
fn help_texts_use_standard_terms() {
    let mut all = lostmotion::cli::help::command().term_width(100);
    all.build();
    let banned =
        [" behind ", "rival", " is said", " is told", "account as", "in place of", "of its own", "says itself"];
    visit("lostmotion", &mut all, &mut |name, help| {
        for word in banned {
            assert!(!help.contains(word), "the help of {name} contains `{word}`");
        }
    });
}

/// Lines of the examples of a help text.
fn examples(help: &str) -> Vec<String> {
    let start = help.find("Examples:").map_or(help.len(), |at| at);
    help[start..].lines().take_while(|l| !l.is_empty()).map(str::to_string).collect()
}

#[test]
fn a_narrow_terminal_splits_no_example() {
    let shown = |width: usize| {
        let mut all = lostmotion::cli::help::command().term_width(width);
        all.build();
        let mut list = Vec::new();
        visit("lostmotion", &mut all, &mut |name, help| list.push((name.to_string(), examples(&help))));
        list
    };
    let (narrow, wide) = (shown(80), shown(200));
    assert!(wide.iter().filter(|e| e.1.len() > 1).count() > 20);
    for (narrow, wide) in narrow.iter().zip(&wide) {
        assert_eq!(narrow, wide);
    }
}
