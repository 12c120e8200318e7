use http::HeaderValue;

use super::*;

fn headers(pairs: &[(HeaderName, &str)]) -> HeaderMap {
    let value = |text: &str| HeaderValue::from_str(text).expect("a header");
    pairs.iter().map(|(name, text)| (name.clone(), value(text))).collect()
}

fn judged(asked: Range<u64>, found: &str) -> Result<HeaderMap, Refused> {
    judge(&asked, StatusCode::PARTIAL_CONTENT, &headers(&[(CONTENT_RANGE, found)]), &Secrets::default())
}

#[test]
fn only_the_content_range_that_was_asked_for_is_taken() {
    for (asked, good) in [(0..1, "bytes 0-0/1"), (5..10, "bytes 5-9/10"), (5..100, "bytes 5-9/10")] {
        let kept = judged(asked.clone(), good).expect(good);
        assert_eq!(kept[CONTENT_LENGTH], (asked.end.min(10) - asked.start).to_string().as_str(), "{good}");
    }
    let most = u64::MAX;
    for bad in [
        "bytes 5-9/9",
        "bytes 9-5/10",
        "bytes 5-9/*",
        "bytes */10",
        "5-9/10",
        "bytes 5-9",
        "bytes -9/10",
        "bytes +5-9/10",
        "bytes 4-9/10",
        "bytes 5-8/10",
        "bytes 5-10/11",
        "bytes 5-18446744073709551615/18446744073709551615",
        "",
    ] {
        assert!(matches!(judged(5..10, bad), Err(Refused::ContentRange(_))), "{bad}");
    }
    assert!(judged(0..most, &format!("bytes 0-{}/{most}", most - 1)).is_err());
    assert!(judge(&(0..1), StatusCode::PARTIAL_CONTENT, &HeaderMap::new(), &Secrets::default()).is_err());
}

#[test]
fn headers_that_nothing_reads_go_no_further_and_a_length_cannot_lie() {
    let answer = headers(&[
        (CONTENT_RANGE, "bytes 0-9/10"),
        (CONTENT_LENGTH, "99999999999999999999999"),
        (ETAG, "\"a\""),
        (http::header::CONTENT_TYPE, "text/html"),
        (http::header::SET_COOKIE, "a=b"),
    ]);
    let kept = judge(&(0..10), StatusCode::PARTIAL_CONTENT, &answer, &Secrets::default()).expect("the range");
    assert_eq!((kept.len(), &kept[CONTENT_LENGTH], &kept[ETAG]), (3, &"10".parse().unwrap(), &answer[ETAG]));
}

#[test]
fn compressed_bodies_and_endless_tags_are_refused() {
    for (name, text, says) in [
        (CONTENT_ENCODING, "GZIP".to_owned(), "found the Content-Encoding \"GZIP\", expected the bytes"),
        (ETAG, "x".repeat(1025), "found an ETag of 1025 bytes, expected 1024 at most"),
    ] {
        let answer = headers(&[(CONTENT_RANGE, "bytes 0-9/10"), (name, &text)]);
        let refused = judge(&(0..10), StatusCode::PARTIAL_CONTENT, &answer, &Secrets::default())
            .expect_err(says)
            .to_string();
        assert!(refused.contains(says), "{refused}");
    }
}

#[test]
fn retry_after_is_read_in_both_forms() {
    let now = SystemTime::UNIX_EPOCH + Duration::from_secs(1_795_324_800); // Sun, 22 Nov 2026 05:20:00 GMT
    let wait = |pairs: &[(HeaderName, &str)]| wait_of(&headers(pairs), now).map(|wait| wait.as_secs());
    let after = |text| wait(&[(RETRY_AFTER, text)]);
    assert_eq!((after("0"), after("7"), after(" 90 ")), (Some(0), Some(7), Some(90)));
    assert_eq!(after("99999999999999999999999"), Some(u64::MAX));
    assert_eq!(after("Sun, 22 Nov 2026 05:20:30 GMT"), Some(30));
    assert_eq!(after("Sun, 22 Nov 2026 05:19:30 GMT"), Some(0), "it is over");
    let dates = [(RETRY_AFTER, "Sun, 22 Nov 2026 05:20:30 GMT"), (DATE, "Sun, 22 Nov 2026 05:20:20 GMT")];
    assert_eq!(wait(&dates), Some(10), "by the server's clock");
    for bad in ["", "-1", "1.5", "soon", "+3", "Mon, 99 Nov 2026 05:20:30 GMT"] {
        assert_eq!(after(bad), None, "{bad}");
    }
}

#[test]
fn what_a_server_sent_is_quoted_escaped_and_cut() {
    assert_eq!(quoted(b"a\x1b[31m\"b\"\n", &Secrets::default()), "\"a\\u{1b}[31m\\\"b\\\"\\n\"");
    assert_eq!(quoted("\u{202e}".as_bytes(), &Secrets::default()), "\"\\u{202e}\"");
    let long = quoted("é".repeat(100_000).as_bytes(), &Secrets::default());
    assert!(long.ends_with("é\"...") && long.chars().count() == MAX_SHOWN + 5, "{long}");
    assert_eq!(quoted(&[b'x'; MAX_SHOWN], &Secrets::default()).len(), MAX_SHOWN + 2);
}
