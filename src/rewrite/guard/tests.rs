//! Notes: whole, damaged, found beside programs.

use super::*;

fn hash(c: char) -> String {
    c.to_string().repeat(64)
}

fn note(companions: usize) -> Note {
    Note {
        schema: SCHEMA.into(),
        output: "p.src".into(),
        sha256_out: hash('a'),
        companions: (0..companions).map(|_| Companion { sha256_out: hash('b'), ..Companion::default() }).collect(),
        ..Note::default()
    }
}

#[test]
fn a_note_comes_back_and_one_whose_bytes_were_changed_does_not() {
    let text = note_text(&note(1)).unwrap();
    assert_eq!(parse_note(text.as_bytes()), Some(note(1)));
    for at in 0..text.len() {
        for flip in [1, 2, 0x20] {
            let mut damaged = text.clone().into_bytes();
            damaged[at] ^= flip;
            // the name of the check may be lost, and white space after it: what is read stays the same
            assert!(parse_note(&damaged).is_none_or(|n| n == note(1)), "byte {at}");
        }
        // cut short, but for the newline at its end
        assert_eq!(parse_note(&text.as_bytes()[..at]), (at + 1 == text.len()).then(|| note(1)), "{at}");
    }
}

#[test]
fn a_note_without_a_check_is_read_if_it_is_one_of_ours_with_whole_hashes() {
    let plain = |n: &Note| serde_json::to_string(n).unwrap().into_bytes();
    assert_eq!(parse_note(&plain(&note(2))), Some(note(2)));
    let other = Note { schema: "lostmotion/rewrite/1".into(), ..note(0) };
    let short = Note { sha256_out: "a".repeat(63), ..note(0) };
    let no_hex = Note { sha256_out: "g".repeat(64), ..note(0) };
    let mut bad_companion = note(2);
    bad_companion.companions[1].sha256_out = String::new();
    for bad in [other, short, no_hex, bad_companion] {
        assert_eq!(parse_note(&plain(&bad)), None);
        assert_eq!(parse_note(note_text(&bad).unwrap().as_bytes()), None);
    }
    // its check was taken away in part
    let mut cut: serde_json::Value = serde_json::from_slice(&plain(&note(0))).unwrap();
    cut["check"] = "".into();
    assert_eq!(parse_note(cut.to_string().as_bytes()), None);
}

#[test]
fn a_note_stands_beside_its_file_and_a_damaged_one_is_an_error() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("p.src");
    assert_eq!(note_path(&file), dir.path().join("p.src.lostmotion.json"));
    assert!(is_note(&note_path(&file)) && !is_note(&file) && !is_note(&dir.path().join("p.lostmotion.json.src")));
    assert_eq!(read_note(&file).unwrap(), None);
    std::fs::write(note_path(&file), note_text(&note(0)).unwrap()).unwrap();
    assert_eq!(read_note(&file).unwrap(), Some(note(0)));
    std::fs::write(note_path(&file), "{}").unwrap();
    let damaged = read_note(&file).unwrap_err();
    assert!(damaged.to_string().contains("a note that is damaged") && damaged.is_bad_input(), "{damaged}");
    // what is there and cannot be read is no missing note
    std::fs::remove_file(note_path(&file)).unwrap();
    std::fs::create_dir(note_path(&file)).unwrap();
    assert!(matches!(read_note(&file), Err(Error::Io { .. })));
}

#[test]
fn the_notes_of_a_folder_are_read_once_and_damaged_ones_are_left_out() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    std::fs::write(note_path(&at("p.src")), note_text(&note(2)).unwrap()).unwrap();
    std::fs::write(note_path(&at("q.src")), "{}").unwrap();
    std::fs::write(at("r.json"), note_text(&note(0)).unwrap()).unwrap();
    let notes = Notes::default();
    let found = notes.beside(&at("any.src")).unwrap();
    assert_eq!(*found, [format!("{}+{}+{}", hash('a'), hash('b'), hash('b'))]);
    std::fs::write(note_path(&at("s.src")), note_text(&note(0)).unwrap()).unwrap();
    assert!(Arc::ptr_eq(&found, &notes.beside(&at("other.src")).unwrap()));
    assert_eq!(Notes::default().beside(&at("any.src")).unwrap().len(), 2);
    // standard input has no folder, a name alone stands in the folder of the process, and a folder that is not there is an error
    assert!(notes.beside(Path::new("-")).unwrap().is_empty());
    assert!(notes.beside(Path::new("Cargo.toml")).unwrap().is_empty());
    assert!(notes.beside(&at("none/p.src")).is_err());
    // a folder of such a name is no note
    std::fs::create_dir(note_path(&at("t.src"))).unwrap();
    assert_eq!(Notes::default().beside(&at("any.src")).unwrap().len(), 2);
}

#[test]
fn the_files_of_a_program_have_one_word_and_a_refusal_says_how_it_is_known() {
    let (a, b) = ("a".to_string(), "b".to_string());
    assert_eq!((together([&a].into_iter()), together([&a, &b].into_iter())), ("a".into(), "a+b".into()));
    let Error::RewrittenAlready(why) = already("p.src", "its note is there") else { panic!() };
    assert_eq!((why.place.file.as_str(), why.expected.as_str()), ("p.src", "the original program"));
    assert!(why.found.contains("already (its note is there)"));
}

#[cfg(unix)]
#[test]
fn a_note_stands_beside_the_file_that_a_link_leads_to_and_is_found_by_both_names() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| std::fs::canonicalize(dir.path()).unwrap().join(name);
    std::fs::create_dir(at("real")).unwrap();
    std::fs::write(at("real/p.src"), "").unwrap();
    std::os::unix::fs::symlink("real/p.src", at("p.src")).unwrap();
    assert_eq!(note_path(&at("p.src")), at("real/p.src.lostmotion.json"));
    assert_eq!(note_name(&at("p.src")), at("p.src.lostmotion.json"));
    std::fs::write(note_path(&at("p.src")), note_text(&note(0)).unwrap()).unwrap();
    assert!(read_note(&at("p.src")).unwrap().is_some() && read_note(&at("real/p.src")).unwrap().is_some());
    assert_eq!(Notes::default().beside(&at("p.src")).unwrap().len(), 1);
    // as earlier versions left it
    std::fs::rename(note_path(&at("p.src")), note_name(&at("p.src"))).unwrap();
    assert_eq!(find_note(&at("p.src")), at("p.src.lostmotion.json"));
    assert!(read_note(&at("p.src")).unwrap().is_some());
}

#[cfg(unix)]
#[test]
fn names_like_those_of_notes_that_stand_for_no_file_keep_no_program_waiting() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    assert!(std::process::Command::new("mkfifo").arg(note_path(&at("f.src"))).status().unwrap().success());
    std::os::unix::fs::symlink("nowhere", note_path(&at("l.src"))).unwrap();
    std::fs::create_dir(note_path(&at("d.src"))).unwrap();
    assert!(Notes::default().beside(&at("any.src")).unwrap().is_empty());
    assert!(matches!(read_note(&at("f.src")), Err(Error::Io { .. })), "its own note is no missing one");
    assert_eq!(read_note(&at("l.src")).unwrap(), None);
    assert_eq!(read_note(&at(&"n".repeat(250))).unwrap(), None, "too long a name");
}
