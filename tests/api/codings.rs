//! Compressed bodies: every member is read, and what is no member is refused, wherever a body is taken.

use std::io::Write;

use bytes::Bytes;
use flate2::Compression;
use flate2::write::GzEncoder;
use futures::stream;
use reqwest::{Body, Response};
use serde_json::json;
use zstd_safe::{CCtx, CParameter};

use crate::support::{App, problem, spawn, spawn_with};

const PROGRAM: &str = "(a pass)\nG21 G90 G94\nG1 X1 Y1 Z1 A0 C0 F100\nX2 Y2 Z2 A1 C1\nX3 Y2 Z2 A2 C3\nM30\n";
const COMPENSATE: &str = "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5";
const INVERSE: &str = "/v1/machines/example-ac-table/inverse-kinematics";
const FORM: &str = "multipart/form-data; boundary=part-of-the-form";

/// Where a body is taken: address, media type, the body before it is compressed.
fn places() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let form = format!(
        "--part-of-the-form\r\nContent-Disposition: form-data; name=\"parameters\"\r\n\r\n{{\"tool_radius_mm\": 5}}\r\n\
         --part-of-the-form\r\nContent-Disposition: form-data; name=\"program\"; filename=\"p.nc\"\r\n\r\n{PROGRAM}\r\n\
         --part-of-the-form--\r\n"
    );
    let poses = json!({"poses": [{"x": 10, "y": 0, "z": 5, "i": 0, "j": 0, "k": 1}]}).to_string();
    vec![
        (COMPENSATE, "text/plain", PROGRAM.into()),
        ("/v1/machines/example-ac-table/cc-compensation", FORM, form.into()),
        (INVERSE, "application/json", poses.into()),
        (INVERSE, "text/csv", b"x,y,z,i,j,k\n10,0,5,0,0,1\n11,0,5,0,0,1\n".to_vec()),
    ]
}

fn gzip(text: &[u8]) -> Vec<u8> {
    let mut writer = GzEncoder::new(Vec::new(), Compression::best());
    writer.write_all(text).unwrap();
    writer.finish().unwrap()
}

fn zstd(text: &[u8]) -> Vec<u8> {
    let mut writer = CCtx::create();
    writer.set_parameter(CParameter::ChecksumFlag(true)).unwrap();
    let mut packed = Vec::with_capacity(text.len() + 1024);
    writer.compress2(&mut packed, text).unwrap();
    packed
}

type Packer = fn(&[u8]) -> Vec<u8>;

/// The codings that have members, by every name they are known by.
const CODINGS: [(&str, Packer); 4] = [("gzip", gzip), ("x-gzip", gzip), ("zstd", zstd), ("ZSTD", zstd)];

async fn send(app: &App, place: (&str, &str), coding: &str, body: impl Into<Body>) -> Response {
    let request = app.client.post(app.url(place.0)).header("content-type", place.1);
    request.header("content-encoding", coding).body(body).send().await.unwrap()
}

/// A body that arrives byte by byte.
fn single_bytes(body: &[u8]) -> Body {
    let bytes: Vec<_> =
        body.iter().map(|byte| Ok::<_, std::io::Error>(Bytes::copy_from_slice(&[*byte]))).collect();
    Body::wrap_stream(stream::iter(bytes))
}

/// Refused in both ways of arriving.
async fn refused(app: &App, place: (&str, &str), coding: &str, body: &[u8], detail: &str) {
    for sent in [body.to_vec().into(), single_bytes(body)] {
        let problem = problem(send(app, place, coding, sent).await, "malformed-request").await;
        let found = problem["detail"].as_str().unwrap();
        assert!(found.contains(detail), "{coding} at {}: {found}", place.0);
    }
}

#[tokio::test]
async fn every_member_is_read_however_a_body_arrives() {
    let app = spawn().await;
    for (path, kind, content) in places() {
        let at = (path, kind);
        let plain = send(&app, at, "identity", content.clone()).await;
        assert_eq!(plain.status(), 200, "{path} {kind}");
        let plain = plain.bytes().await.unwrap();
        let slow = send(&app, at, "Identity", single_bytes(&content)).await;
        assert_eq!(slow.bytes().await.unwrap(), plain, "{path} {kind}");
        let (head, tail) = content.split_at(content.len() / 3);
        for (coding, pack) in CODINGS {
            let members = [pack(head), pack(b""), pack(tail)].concat();
            for body in [pack(&content), members] {
                for sent in [body.clone().into(), single_bytes(&body)] {
                    let answer = send(&app, at, coding, sent).await;
                    assert_eq!(answer.status(), 200, "{coding} at {path} {kind}");
                    assert_eq!(answer.bytes().await.unwrap(), plain, "{coding} at {path} {kind}");
                }
            }
        }
    }
}

#[tokio::test]
async fn frames_to_be_skipped_are_skipped() {
    let app = spawn().await;
    let skipped = [&0x184D_2A53_u32.to_le_bytes()[..], &5_u32.to_le_bytes(), b"notes"].concat();
    for (path, kind, content) in places() {
        let plain = send(&app, (path, kind), "identity", content.clone()).await.bytes().await.unwrap();
        let (head, tail) = content.split_at(content.len() / 2);
        let body = [&skipped[..], &zstd(head), &skipped, &skipped, &zstd(tail), &skipped].concat();
        for sent in [body.clone().into(), single_bytes(&body)] {
            let answer = send(&app, (path, kind), "zstd", sent).await;
            assert_eq!((answer.status().as_u16(), answer.bytes().await.unwrap()), (200, plain.clone()));
        }
        refused(&app, (path, kind), "zstd", &body[..body.len() - 1], "ends within a member").await;
    }
}

#[tokio::test]
async fn what_is_not_whole_or_no_member_is_refused_and_nothing_is_kept() {
    let app = spawn().await;
    for (path, kind, content) in places() {
        let at = (path, kind);
        let (head, tail) = content.split_at(content.len() / 3);
        for (coding, pack) in CODINGS {
            let members = [pack(head), pack(tail)].concat();
            let after = |junk: &[u8]| [&members, junk].concat();
            refused(&app, at, coding, &after(b"JUNKJUNK"), "do not belong to its coding").await;
            refused(&app, at, coding, &after(&[0; 16]), "do not belong to its coding").await;
            // So few that they could be the beginning of one of zstd.
            let few = if pack(b"")[0] == 0x1f { "do not belong to its coding" } else { "" };
            refused(&app, at, coding, &after(b"\0"), few).await;
            refused(&app, at, coding, &content, "do not belong to its coding").await;
            for missing in [1, 4, 7] {
                let cut = &members[..members.len() - missing];
                refused(&app, at, coding, cut, "ends within a member").await;
            }
            let first_cut = [&pack(head)[..pack(head).len() - 3], &pack(tail)].concat();
            refused(&app, at, coding, &first_cut, "").await;
            let mut wrong = members.clone();
            let last = wrong.len() - if few.is_empty() { 1 } else { 5 };
            wrong[last] ^= 0x40;
            refused(&app, at, coding, &wrong, "checksum").await;
        }
    }
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_length_that_does_not_fit_is_found() {
    let app = spawn().await;
    let mut wrong = gzip(PROGRAM.as_bytes());
    *wrong.last_mut().unwrap() = 1;
    refused(&app, (COMPENSATE, "text/plain"), "gzip", &wrong, "length does not match").await;
}

#[tokio::test]
async fn an_empty_body_is_what_it_is_without_a_coding() {
    let app = spawn().await;
    for (path, kind, _) in places() {
        let plain = app.post_text(path, kind, "").await;
        let plain = (plain.status(), plain.bytes().await.unwrap());
        for (coding, pack) in CODINGS.into_iter().chain([("identity", gzip as Packer)]) {
            let answer = send(&app, (path, kind), coding, "").await;
            assert_eq!((answer.status(), answer.bytes().await.unwrap()), plain, "{coding} at {path}");
            let answer = send(&app, (path, kind), coding, single_bytes(b"")).await;
            assert_eq!((answer.status(), answer.bytes().await.unwrap()), plain, "{coding} at {path}");
            if coding != "identity" {
                let answer = send(&app, (path, kind), coding, pack(b"")).await;
                assert_eq!((answer.status(), answer.bytes().await.unwrap()), plain, "{coding} at {path}");
            }
        }
    }
}

#[tokio::test]
async fn a_body_has_one_coding_that_is_known() {
    let app = spawn().await;
    for codings in [
        &["br"][..],
        &["deflate"],
        &["gzip, gzip"],
        &["gzip, identity"],
        &["gzip", "gzip"],
        &["gzip", "identity"],
        &["identity", "zstd"],
        &[""],
    ] {
        let mut request = app.client.post(app.url(COMPENSATE)).header("content-type", "text/plain");
        for coding in codings {
            request = request.header("content-encoding", *coding);
        }
        let answer = request.body(gzip(PROGRAM.as_bytes())).send().await.unwrap();
        assert_eq!(answer.headers()["accept-encoding"], "zstd,gzip", "{codings:?}");
        problem(answer, "unsupported-media-type").await;
    }
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn what_unpacks_to_far_more_than_programs_do_is_refused_with_both_numbers() {
    let app = spawn().await;
    let blank = vec![b' '; 4 << 20];
    for (path, kind, _) in places() {
        for (coding, pack) in CODINGS {
            if kind == FORM {
                continue;
            }
            let answer = send(&app, (path, kind), coding, pack(&blank)).await;
            // A line of a table may be shorter than that.
            if kind == "text/csv" {
                assert!(answer.status().is_client_error());
                continue;
            }
            let detail = problem(answer, "body-too-large").await["detail"].as_str().unwrap().to_owned();
            assert!(detail.contains("250 times") && detail.contains("without compression"), "{detail}");
        }
    }
    assert_eq!(app.files(), (0, 0));
    // A megabyte may be anything, and so may what is not compressed.
    let lines = format!("{}M30\n", "G1 X1 Y1 Z1 A0 C0 F100\n".repeat(40_000));
    assert!((900_000..1 << 20).contains(&lines.len()));
    for (coding, pack) in CODINGS {
        let answer = send(&app, (COMPENSATE, "text/plain"), coding, pack(lines.as_bytes())).await;
        assert_eq!(answer.status(), 200, "{coding}");
    }
    let longer = lines.repeat(3);
    assert_eq!(app.post_text(COMPENSATE, "text/plain", longer.clone()).await.status(), 200);
    problem(send(&app, (COMPENSATE, "text/plain"), "zstd", zstd(longer.as_bytes())).await, "body-too-large")
        .await;
}

#[tokio::test]
async fn a_wide_window_and_endless_nothing_are_refused() {
    let app = spawn_with(|settings| settings.max_body_bytes = 1 << 30).await;
    let at = (COMPENSATE, "text/plain");
    // A frame whose header asks for a window of 16 MiB and of 1 TiB (RFC 8878 §3.1.1.1.2).
    for exponent in [14_u8, 30] {
        let frame = [&[0x28, 0xB5, 0x2F, 0xFD, 0x00, exponent << 3][..], &[0x01, 0x00, 0x00]].concat();
        refused(&app, at, "zstd", &frame, "8 MiB").await;
    }
    let nothing = [&0x184D_2A50_u32.to_le_bytes()[..], &0_u32.to_le_bytes()].concat();
    for (coding, member) in [("zstd", nothing), ("gzip", gzip(b""))] {
        let many = member.repeat((3 << 20) / member.len());
        let detail = problem(send(&app, at, coding, many).await, "malformed-request").await;
        assert!(detail["detail"].as_str().unwrap().contains("empty members"), "{detail}");
    }
    assert_eq!(app.files(), (0, 0));
}

#[tokio::test]
async fn a_form_ends_with_its_last_boundary() {
    let app = spawn().await;
    let (path, kind, form) = places().remove(1);
    let long = [&form[..], &vec![b' '; 100_000]].concat();
    assert_eq!(app.post_text(path, kind, [&form[..], b"\r\nafterwards"].concat()).await.status(), 200);
    problem(app.post_text(path, kind, long).await, "malformed-request").await;
}
