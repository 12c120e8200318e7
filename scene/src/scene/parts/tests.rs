use super::*;

/// The instances of a text, and what is left.
fn cut(text: &str) -> (Vec<String>, String, usize) {
    let parts = Parts::of(text).expect("there is memory");
    (parts.instances().map(|part| part.text.into_owned()).collect(), parts.rest().into_owned(), parts.count)
}

#[test]
fn an_instance_ends_where_the_next_table_starts() {
    let text =
        "a = 1\n\n[[instance]]\nx = 1\n\n [[ 'instance' ]] # two\nx.y = 2\n[[species]]\ny = 1\n[[instance]]";
    let (instances, rest, count) = cut(text);
    assert_eq!(instances, ["[[instance]]\nx = 1\n\n ", "[[ 'instance' ]] # two\nx.y = 2\n", "[[instance]]"]);
    assert_eq!((rest.as_str(), count), ("a = 1\n\n[[species]]\ny = 1\n", 3));
    let parts = Parts::of(text).expect("there is memory");
    for at in 0..rest.len() {
        assert_eq!(rest.as_bytes()[at], text.as_bytes()[parts.place(at)], "byte {at}");
    }
}

#[test]
fn what_only_looks_like_an_instance_is_none() {
    for text in [
        "a = \"\"\"\n[[instance]]\n\"\"\"\n",
        "a = '''\n[[instance]]\n'''\n",
        "a = [\n[[\"instance\"]]\n]\n",
        "a = {\n b = [\n[[1]]] }\n",
        "# [[instance]]\n",
        "[[instances]]\n",
        "[species]\ninstance = [{}]\n",
        "instance.x = [{}]\n",
        "[instance]\nx = 1\n",
    ] {
        assert_eq!(cut(text), (Vec::new(), text.to_owned(), 0), "{text}");
    }
}

#[test]
fn tables_of_an_instance_stay_with_it() {
    let text =
        "[[instance]]\n[instance.a]\n[[\"inst\\u0061nce\".b]]\n[ instance . c ]\n[other]\n[instance.d]\n";
    let (instances, rest, _) = cut(text);
    assert_eq!(instances, [text.split_once("[other]").expect("it is there").0]);
    assert_eq!(rest, "[other]\n[instance.d]\n");
}

#[test]
fn elements_of_an_array_are_cut_at_its_commas() {
    let text = "instance = [ {a = [1, 2]}, # one, two\n \"x,y\" , [[3], {b = 1, c = 2}],\n] # end\nz = 1\n";
    let (instances, rest, count) = cut(text);
    assert_eq!(
        instances,
        [
            "instance=[ {a = [1, 2]},]",
            "instance=[ # one, two\n \"x,y\" ,]",
            "instance=[ [[3], {b = 1, c = 2}],]",
            "instance=[\n]"
        ]
    );
    assert_eq!((rest.as_str(), count), ("instance = [] # end\nz = 1\n", 3));
    let parts = Parts::of(text).expect("there is memory");
    for part in parts.instances() {
        for at in 10..part.text.len() - 1 {
            assert_eq!(
                part.text.as_bytes()[at],
                text.as_bytes()[part.place(at)],
                "byte {at} of {}",
                part.text
            );
        }
    }
}

#[test]
fn the_largest_part_is_measured_in_tokens_and_in_bytes() {
    let parts = Parts::of("a = 1\n[[instance]]\n# a long comment\n[[instance]]\nx=1\ny=[1,2,3]\n")
        .expect("there is memory");
    // A key, a space, a sign, a space, a value, a line's end.
    assert_eq!(parts.rest_size, Size { tokens: 6, bytes: 6 });
    assert_eq!(parts.most, Size { tokens: 6 + 4 + 10 + 1, bytes: 30 });
}

#[test]
fn places_are_kept_for_as_many_instances_as_there_may_be_and_one_more() {
    let kept = |text: &str| {
        let parts = Parts::of(text).expect("there is memory");
        (parts.ranges.len(), parts.ranges.capacity() <= 2 * (MAX_INSTANCES + 1), parts.count)
    };
    let commas = format!("instance=[{}", ",".repeat(4 * MAX_INSTANCES));
    assert_eq!(kept(&commas), (MAX_INSTANCES + 1, true, 0));
    let elements = format!("instance=[{}]", "1,".repeat(2 * MAX_INSTANCES));
    assert_eq!(kept(&elements), (MAX_INSTANCES + 1, true, 2 * MAX_INSTANCES));
    let tables = "[[instance]]\n".repeat(MAX_INSTANCES + 9);
    assert_eq!(kept(&tables), (MAX_INSTANCES + 1, true, MAX_INSTANCES + 9));
    let most = format!("instance=[{}]", "1,".repeat(MAX_INSTANCES));
    assert_eq!(kept(&most), (MAX_INSTANCES + 1, true, MAX_INSTANCES), "the last is what is behind the comma");
    assert!(crate::scene::Scene::parse("a.toml", std::path::Path::new(""), &commas).is_err());
}
