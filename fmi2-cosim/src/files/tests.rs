use std::fs;

use super::*;

#[test]
fn files_appear_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/deep/a.txt");
    let mut file = NewFile::create(&path).unwrap();
    file.write_all(b"half").unwrap();
    drop(file);
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "not even the folders made for it");

    write(&path, "old").unwrap();
    write(&path, "new").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "new");
    assert_eq!(fs::read_dir(path.parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn errors_name_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let error = write(folder.path(), "x").unwrap_err().to_string();
    assert!(error.contains("it is a folder") && error.contains(folder.path().to_str().unwrap()), "{error}");
    write(folder.path().join("file"), "x").unwrap();
    let error = write(folder.path().join("file/below"), "x").unwrap_err().to_string();
    assert!(error.starts_with("cannot write"), "{error}");
}

#[test]
fn a_set_appears_together_or_leaves_everything_as_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write(path("b"), "old").unwrap();
    let set = FileSet::new();
    for name in ["a", "b", "deep/c"] {
        set.write(path(name), "new").unwrap();
    }
    assert!(!path("a").exists() && fs::read_to_string(path("b")).unwrap() == "old");
    // Somebody puts a folder where the last file was to be.
    fs::create_dir(path("deep/c")).unwrap();
    assert_eq!(set.appear().unwrap_err().path, path("deep/c"));
    assert!(!path("a").exists() && fs::read_to_string(path("b")).unwrap() == "old");

    fs::remove_dir_all(path("deep")).unwrap();
    let set = FileSet::new();
    for name in ["a", "b", "deep/c"] {
        set.write(path(name), "new").unwrap();
    }
    set.appear().unwrap();
    for name in ["a", "b", "deep/c"] {
        assert_eq!(fs::read_to_string(path(name)).unwrap(), "new");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "nothing else is left");
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};

    use super::*;

    #[test]
    fn links_stay_and_what_they_point_to_is_renewed() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::create_dir_all(path("real/place")).unwrap();
        fs::write(path("real/place/target"), "old").unwrap();
        symlink("real/place/target", path("first")).unwrap();
        symlink(path("first"), path("second")).unwrap();
        symlink("real/place/missing", path("dangling")).unwrap();
        for (link, target) in [("second", "real/place/target"), ("dangling", "real/place/missing")] {
            write(path(link), "new").unwrap();
            assert!(fs::symlink_metadata(path(link)).unwrap().is_symlink(), "{link}");
            assert_eq!(fs::read_to_string(path(target)).unwrap(), "new");
        }
        symlink(path("circle"), path("circle")).unwrap();
        assert!(write(path("circle"), "x").unwrap_err().to_string().contains("symbolic links"));
    }

    #[test]
    fn one_file_is_known_under_all_its_names() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        fs::write(path("a"), "").unwrap();
        fs::write(path("b"), "").unwrap();
        fs::hard_link(path("a"), path("hard")).unwrap();
        symlink("a", path("soft")).unwrap();
        for name in ["a", "hard", "soft", "./a"] {
            assert!(are_same(&path("a"), &path(name)), "{name}");
        }
        assert!(!are_same(&path("a"), &path("b")) && !are_same(&path("missing"), &path("missing")));
    }

    #[test]
    fn permissions_and_further_names_stay() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        for mode in [0o600, 0o640, 0o666, 0o755] {
            fs::write(path("a"), "old").unwrap();
            fs::set_permissions(path("a"), fs::Permissions::from_mode(mode)).unwrap();
            write(path("a"), "new").unwrap();
            assert_eq!(fs::metadata(path("a")).unwrap().mode() & 0o7777, mode);
        }
        fs::hard_link(path("a"), path("same")).unwrap();
        write(path("a"), "newer").unwrap();
        assert_eq!(fs::read_to_string(path("same")).unwrap(), "newer");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
    }

    #[test]
    fn what_others_do_to_the_file_meanwhile_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let mut file = NewFile::create(folder.path().join("a")).unwrap();
        file.write_all(b"rows").unwrap();
        file.flush().unwrap();
        let part = fs::read_dir(folder.path()).unwrap().next().unwrap().unwrap().path();
        fs::write(part, "").unwrap();
        assert!(file.finish().unwrap_err().to_string().contains("0 of 4 bytes"));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn devices_are_written_to_and_never_replaced() {
    let error = write("/dev/full", "x").unwrap_err().to_string();
    assert!(error.contains("/dev/full: No space left"), "{error}");
    assert!(!fs::metadata("/dev/full").unwrap().is_file());
    let folder = tempfile::tempdir().unwrap();
    let link = folder.path().join("link");
    std::os::unix::fs::symlink("/dev/null", &link).unwrap();
    write(&link, "x").unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    for name in ["/dev/stdout", "/dev/fd/1", "/proc/self/fd/1", "/proc/thread-self/fd/1"] {
        assert!(is_standard_output(Path::new(name)), "{name}");
    }
    assert!(!is_standard_output(Path::new("/dev/stderr")) && !is_standard_output(&link));
}
