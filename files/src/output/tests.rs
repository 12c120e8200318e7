use super::*;

fn folder() -> tempfile::TempDir {
    tempfile::tempdir().expect("a temporary folder")
}

#[test]
fn an_output_that_is_an_input_is_refused_under_any_name() {
    let folder = folder();
    let path = folder.path().join("a.flb");
    fs::write(&path, b"old").expect("writable");
    let detour = folder.path().join("../").join(folder.path().file_name().expect("a name")).join("a.flb");
    let error = check_output(&detour, &[&path], Existing::Replace).expect_err("the same file");
    assert!(error.to_string().contains("is the input"), "{error}");
    check_output(&folder.path().join("b.flb"), &[&path], Existing::Keep).expect("another file");
}

#[test]
fn two_outputs_that_are_one_file_are_refused_by_way_of_links_too() {
    let folder = folder();
    let [a, b] = ["a.flb", "b.flb"].map(|name| folder.path().join(name));
    check_distinct(&a, &b).expect("two names");
    check_distinct(&a, &folder.path().join(".").join("a.flb")).expect_err("one name");
    fs::write(&a, b"old").expect("writable");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&a, &b).expect("links work");
        let error = check_distinct(&a, &b).expect_err("one file").to_string();
        assert_eq!(
            error,
            format!("{} is the file {}, named as two outputs at once", b.display(), a.display())
        );
        let other = folder.path().join("other");
        std::os::unix::fs::symlink(folder.path(), &other).expect("links work");
        check_distinct(&folder.path().join("new"), &other.join("new")).expect_err("one file");
    }
}
