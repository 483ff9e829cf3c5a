//! A store in memory: what is brought to disk, what is put back.

use super::*;
use object_store::memory::InMemory;
use std::sync::Arc;

const XHOME: &str = "DEFDAT $CONFIG\nE6AXIS XHOME={A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}\nENDDAT\n";
const ROWS: &str = "a1_deg\n1\n";

/// A store with these objects, which shows those below `cell`, and one on the same objects that shows those below `done`.
fn stores(objects: &[(&str, &str)]) -> (Store, Store) {
    let memory = Arc::new(InMemory::new());
    let of = |prefix: &str| Store::of(memory.clone(), "memory:///", prefix).unwrap();
    put(&of(""), objects);
    (of("/cell/"), of("done"))
}

fn put(store: &Store, objects: &[(&str, &str)]) {
    let dir = tempfile::tempdir().unwrap();
    let file = |(k, (location, text)): (usize, &(&str, &str))| {
        let path = dir.path().join(k.to_string());
        std::fs::write(&path, text).unwrap();
        (path, (*location).to_string())
    };
    store.put(&objects.iter().enumerate().map(file).collect::<Vec<_>>()).unwrap();
}

/// Text of an object; `None`: there is none.
fn object(store: &Store, location: &str) -> Option<String> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("object");
    match store.get(&[(location.to_string(), path.clone())]).unwrap().remove(0) {
        Fetched::Whole(()) => Some(std::fs::read_to_string(path).unwrap()),
        Fetched::Not(why) => {
            assert_eq!(why, "there is no such object");
            None
        }
    }
}

#[test]
fn a_store_is_listed_as_a_folder_would_be() {
    let (cell, done) = stores(&[
        ("cell/b.csv", ROWS),
        ("cell/a/p.src", "DEF p( )\nEND\n"),
        ("cell/a/p.src.lostmotion.json", "{}"),
        ("cell/a/p.dat", "DEFDAT p\nENDDAT\n"),
        ("cell/list.json", "{}"),
        ("cell/plan.json", "{\"joint_names\": [\"A1\"], \"points\": []}"),
        ("cell/picture.png", "no program"),
        ("other/c.csv", ROWS),
        ("cellar/c.csv", ROWS),
    ]);
    let found = entries(&cell, None).unwrap();
    let told = |e: &Entry| (e.key.clone(), e.size, e.format.clone().unwrap());
    let of = |key: &str, size, format: &str| (key.to_string(), size, format.to_string());
    assert_eq!(
        found.iter().map(told).collect::<Vec<_>>(),
        [of("a/p.src", 13, "krl"), of("b.csv", 9, "csv"), of("plan.json", 37, "trajectory")]
    );
    let rows = &found[1];
    assert_eq!(
        (rows.state, rows.sha256.as_deref()),
        (State::Ready, Some(crate::io::input::sha256(ROWS.as_bytes()).as_str()))
    );
    assert_eq!(entries(&cell, formats::named("csv")).unwrap().len(), 1);
    assert!(entries(&done, None).unwrap_err().to_string().starts_with("memory:///done: found no program"));
}

#[test]
fn a_part_is_on_disk_with_what_readers_look_at_beside_its_programs_and_nothing_else() {
    let (cell, _) = stores(&[
        ("cell/R1/System/$config.dat", XHOME),
        ("cell/R1/Program/a.src", "DEF a( )\nEND\n"),
        ("cell/R1/Program/a.dat", "DEFDAT a\nENDDAT\n"),
        ("cell/R1/Program/b.src", "DEF b( )\nEND\n"),
        ("cell/R1/Program/photo.jpg", "a photo"),
        ("cell/R1/Mada/list.dat", "DEFDAT list PUBLIC\nENDDAT\n"),
        ("cell/abb/PROGMOD/main.mod", "MODULE m\nENDMODULE\n"),
        ("cell/abb/SYSMOD/user.sys", "MODULE u\nENDMODULE\n"),
        ("cell/rows/x 1%.csv", ROWS),
        ("cell/rows/y.csv", ROWS),
        ("cell/rows/y.csv.lostmotion.json", "{}"),
        ("cell/far/z.src", "DEF z( )\nEND\n"),
    ]);
    let programs = [
        ("R1/Program/a.src", "krl"),
        ("abb/PROGMOD/main.mod", "rapid"),
        ("rows/x 1%.csv", "csv"),
        ("rows/gone.csv", "csv"),
    ];
    let staged = Staged::of(&cell, &programs.map(|(p, f)| (PathBuf::from(p), f))).unwrap();
    let size = |name: &str| std::fs::metadata(staged.folder().join(name)).ok().map(|m| m.len());
    for (name, bytes) in [
        ("R1/System/$config.dat", Some(XHOME.len() as u64)),
        ("R1/Program/a.src", Some(13)),
        ("R1/Program/a.dat", Some(16)),
        ("R1/Program/b.src", Some(13)),
        ("R1/Program/photo.jpg", Some(0)), // counted, never read
        ("R1/Mada/list.dat", Some(26)),
        ("abb/PROGMOD/main.mod", Some(19)),
        ("abb/SYSMOD/user.sys", Some(19)),
        ("rows/x 1%.csv", Some(9)),
        ("rows/y.csv", None),
        ("rows/y.csv.lostmotion.json", Some(2)),
        ("far/z.src", None),
    ] {
        assert_eq!(size(name), bytes, "{name}");
    }
    assert!(
        staged.missing(Path::new("rows/gone.csv")).is_some() && staged.missing(Path::new("rows/x 1%.csv")).is_none()
    );
    let copy = shown(&staged.folder().join("R1/Program/a.src"));
    assert_eq!(staged.in_words(&cell, &format!("{copy}:2: found")), "memory:///cell/R1/Program/a.src:2: found");
    // nothing that lies above the temporary folder is looked at
    assert!(staged.folder().ancestors().take(LEVELS + 1).all(|a| a.starts_with(staged._dir.path())));
}

#[test]
fn results_are_put_when_they_are_new_or_changed_and_taken_away_when_they_are_gone() {
    let note = |hash: char| {
        let note = guard::Note {
            schema: guard::SCHEMA.into(),
            output: "p.src".into(),
            sha256_out: hash.to_string().repeat(64),
            companions: vec![guard::Companion {
                output: "p.dat".into(),
                sha256_out: "b".repeat(64),
                ..Default::default()
            }],
            ..Default::default()
        };
        guard::note_text(&note).unwrap()
    };
    let first = note('a');
    let (_, done) = stores(&[
        ("done/a/p.src", "old"),
        ("done/a/p.dat", "same"),
        ("done/a/p.src.lostmotion.json", &first),
        ("done/a/other.src", "not ours"),
        ("done/q.csv.lostmotion.json", "damaged"),
    ]);
    let programs = [PathBuf::from("a/p.src"), PathBuf::from("q.csv"), PathBuf::from("new/r.csv")];
    let results = Results::of(&done, &programs, Path::new("/nowhere")).unwrap();
    let at = |name: &str| results.folder().join(name);
    for (name, there) in [("a/p.src", true), ("a/p.dat", true), ("a/other.src", false), ("q.csv", false)] {
        assert_eq!(at(name).exists(), there, "{name}");
    }
    std::fs::write(at("a/p.src"), "new").unwrap();
    std::fs::write(at("a/p.src.lostmotion.json"), note('c')).unwrap();
    std::fs::write(at("new/r.csv"), "r").unwrap();
    std::fs::write(at("new/.lostmotion-x.part"), "half").unwrap();
    std::fs::remove_file(at("q.csv.lostmotion.json")).unwrap();
    results.put(&done).unwrap();
    for (location, text) in [
        ("done/a/p.src", Some("new")),
        ("done/a/p.dat", Some("same")),
        ("done/a/p.src.lostmotion.json", Some(note('c').as_str())),
        ("done/a/other.src", Some("not ours")),
        ("done/new/r.csv", Some("r")),
        ("done/q.csv.lostmotion.json", None),
        ("done/new/.lostmotion-x.part", None),
    ] {
        assert_eq!(object(&done, location).as_deref(), text, "{location}");
    }
}

#[test]
fn an_object_of_many_parts_comes_back_whole() {
    let (cell, _) = stores(&[]);
    // a whole number of parts, and one byte more
    for bytes in [16 << 20, (16 << 20) + 1] {
        let text: String = (0..bytes).map(|k| char::from(b'a' + (k / 1000 % 26) as u8)).collect();
        put(&cell, &[("cell/large.csv", &text)]);
        assert_eq!(object(&cell, "cell/large.csv").as_ref(), Some(&text));
        let Fetched::Whole(digest) = cell.digests(&["cell/large.csv".into()], 5).unwrap().remove(0) else { panic!() };
        assert_eq!((digest.size, digest.head), (bytes as u64, b"aaaaa".to_vec()));
        assert_eq!(digest.sha256, crate::io::input::sha256(text.as_bytes()));
    }
}

#[test]
fn prefixes_that_hold_each_other_overlap_and_addresses_that_cannot_be_used_are_refused() {
    let memory = Arc::new(InMemory::new());
    let of = |prefix: &str| Store::of(memory.clone(), "memory:///", prefix).unwrap();
    for (a, b, overlap) in
        [("a", "a", true), ("a", "a/b", true), ("a/b", "a", true), ("", "a", true), ("a", "ab", false)]
    {
        assert_eq!(of(a).overlaps(&of(b)), overlap, "{a} {b}");
    }
    assert!(!of("a").overlaps(&Store::of(memory.clone(), "s3://b/", "a").unwrap()));
    assert_eq!(
        (of("a").location(Path::new("b/c")), of("").location(Path::new("c"))),
        (Some("a/b/c".into()), Some("c".into()))
    );
    for bad in ["s3:///a", "file://a", "file://", "ftp://a/b"] {
        assert!(Store::open(Path::new(bad)).is_err(), "{bad}");
    }
    assert!(Store::of(memory, "memory:///", "a//b").is_err());
}

#[test]
fn the_fellows_of_a_task_and_the_folders_above_a_project_are_found() {
    assert_eq!(fellow("t/PROGMOD"), Some("t/SYSMOD".into()));
    assert_eq!(fellow("sysmod"), Some("PROGMOD".into()));
    assert_eq!(fellow("t/modules"), None);
    let deep = "1/2/3/4/5/6/7/8";
    let (cell, _) =
        stores(&[("a/System/$CONFIG.DAT", XHOME), ("1/SYSTEM/$config.dat", XHOME), ("1/2/System/other.dat", "")]);
    let found = |folder: &str| projects(&cell, [folder].into_iter()).unwrap().into_iter().collect::<Vec<_>>();
    assert_eq!(found("a/Program/x"), ["a"]);
    assert_eq!(found(deep), ["1"]);
    assert_eq!(found(&format!("{deep}/9")), [""; 0]);
}

#[test]
fn a_store_on_disk_keeps_names_with_signs_of_addresses() {
    let dir = tempfile::tempdir().unwrap();
    let name = "a 1%20/x#?.csv";
    std::fs::create_dir_all(dir.path().join("cell/a 1%20")).unwrap();
    std::fs::write(dir.path().join("cell").join(name), ROWS).unwrap();
    let open = |folder: &str| Store::open(Path::new(&format!("file://{}/{folder}", dir.path().display()))).unwrap();
    let found = entries(&open("cell"), None).unwrap();
    assert_eq!(found.iter().map(|e| e.key.as_str()).collect::<Vec<_>>(), [name]);
    let staged = Staged::of(&open("cell"), &[(PathBuf::from(name), "csv")]).unwrap();
    assert_eq!(std::fs::read_to_string(staged.folder().join(name)).unwrap(), ROWS);
    let results = Results::of(&open("done"), &[PathBuf::from(name)], staged.folder()).unwrap();
    std::fs::write(results.folder().join(name), "rewritten").unwrap();
    results.put(&open("done")).unwrap();
    assert_eq!(std::fs::read_to_string(dir.path().join("done").join(name)).unwrap(), "rewritten");
}
