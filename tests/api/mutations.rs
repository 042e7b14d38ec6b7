//! Bodies nobody meant to send: the examples of the description and programs of our own, changed at random places.
//! The service answers every one, never with a fault of its own, and a program it gives back keeps its tolerance.
//!
//! The changes follow from the number of the attempt alone. `TRUNNION_MUTATIONS` sets how many there are, and
//! `TRUNNION_MUTATION` (one number) repeats one of them.

use std::sync::Arc;

use reqwest::Response;
use serde_json::Value;
use trunnion::jobs::CutterContactCompensator;

use crate::support::{App, description, spawn_real_with};

/// Attempts, unless asked otherwise: seconds.
const ATTEMPTS: u64 = 400;
/// Half a unit of four decimals of an inch on three axes.
const WORST_ROUNDING_UM: f64 = 2.5;
/// Attempts on one service, whose store then goes.
const ATTEMPTS_PER_SERVICE: u64 = 1000;

const PROGRAM: &str = "%
O1001 (BLADE)
N10 G90 G21 G94 G17
N20 G0 X0.000 Y0.000 Z50.000 A0.000 C0.000
N30 G1 X0.000 Y0.000 Z0.000 A10.000 C10.000 F1000
N40 X20.000 Y5.000 Z-2.000 A25.000 C60.000
N50 G93 X40.000 Y0.000 Z0.000 A30.000 C95.000 F12.5
N60 G94 G2 X50.000 Y10.000 I5. J5. F800
/N70 G43.4 H1
N80 G1 x60 y.5 z-.25 a31. c+100 ; tail
N90 G49
N100 #100=[1+2]
N110 G91 G1 X1. C1.
N120 M30
%
";
const CONTACTS: &str = "G90 G21 G94\nG1 X10.000 Y0.000 Z5.000 A10.000 C20.000 U9.000 V0.000 W1.000 F1000\nG1 X20.000 Y0.000 Z5.000 A25.000 C60.000 U19.000 V0.500 W1.000\nM30\n";
/// Turns, increments, inches, arcs across the axis, a rest, and blocks that lack words.
const WORN: &str = "%
G90 G21 G94 G17
G0 X0.000 Y0.000 Z50.000 A0.000 C0.000
G1 Z0.000 F900
G2 X10.000 Y10.000 I10. J0.
G1 X20. A-25. C10.
C40.
C40.
G91 X3. Y-1. A2.
G90 G20 X1.1 Y.4 Z.2 F40.
G21 G93 X40.000 Y0.000 Z0.000 A-30.000 C95.000 F12.5
G94 X41. F#3
G91 G28 Z0
G90 G0 Z60.
M30
%
";
const TABLE: &str = "X,Y,Z,A,C,nx,ny,nz\n10.000,0.000,5.000,10.000,20.000,0,0,1\n20.000,0.000,5.000,25.000,60.000,0,0.1,0.99\n";

const ENTRIES: &str = r#"[{"measured_at": "2025-03-14T09:26:53Z", "parts_cut": 120, "radius_wear_um": 14.0, "note": "a"},
    {"measured_at": "2025-03-15T09:26:53Z", "parts_cut": 140, "radius_wear_um": 16.0, "edge": "2", "standard_uncertainty_um": 1}]"#;

/// What is put into texts.
const SCRAPS: &[&str] = &[
    "",
    "0",
    "-0",
    "-1",
    "1e308",
    "1e999",
    "-1e-320",
    "NaN",
    "9007199254740993",
    "99999999999999999999",
    "0.1",
    ".",
    "-",
    "+",
    "\u{0}",
    "\n",
    "\r",
    "\r\n",
    " ",
    "\t",
    ",",
    ";",
    "(",
    ")",
    "%",
    "/",
    "\"",
    "\\",
    "{",
    "}",
    "[",
    "]",
    ":",
    "null",
    "true",
    "\u{e9}",
    "\u{fe}\u{ff}",
    "G0",
    "G1",
    "G2",
    "G3",
    "G20",
    "G41",
    "G43.4",
    "G49",
    "G53",
    "G68.2",
    "G90",
    "G91",
    "G93",
    "G94",
    "M2",
    "M30",
    "M98 P1",
    "X",
    "A1e3",
    "C36000",
    "F0",
    "F-1",
    "U1 V2 W3",
    "N1",
    "#1=2",
    "GOTO 10",
    "IF[1EQ1]",
];
/// What is put in the place of JSON values.
const VALUES: &[&str] = &[
    "null",
    "true",
    "\"\"",
    "\"x\"",
    "[]",
    "{}",
    "[[]]",
    "0",
    "-0.0",
    "-1",
    "1e308",
    "-1e308",
    "5e-324",
    "1e-9",
    "0.5",
    "7",
    "361",
    "1e6",
    "4294967296",
    "18446744073709551616",
    "[1]",
    "[0,0,0]",
    "[1e308,1e308,1e308]",
    "{\"a\":1}",
];

/// `SplitMix64`: enough to choose places with.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `end`, which may be 0 for 0.
    fn below(&mut self, end: usize) -> usize {
        usize::try_from(self.roll() % (end.max(1) as u64)).unwrap()
    }

    fn one_of<'a, T>(&mut self, all: &'a [T]) -> &'a T {
        &all[self.below(all.len())]
    }
}

/// One change of the text.
fn change(dice: &mut Dice, text: &mut Vec<u8>) {
    let (a, b) = (dice.below(text.len() + 1), dice.below(text.len() + 1));
    let (from, to) = (a.min(b), a.max(b));
    let near = to.min(from + dice.below(12));
    match dice.below(8) {
        0 => drop(text.splice(from..near, dice.one_of(SCRAPS).bytes())),
        1 => drop(text.splice(from..from, dice.one_of(SCRAPS).bytes())),
        2 => drop(text.drain(from..near)),
        3 => text.truncate(to),
        4 => {
            let part = text[from..to.min(from + 200)].to_vec();
            let at = dice.below(text.len() + 1);
            drop(text.splice(at..at, part));
        }
        5 => {
            if let Some(byte) = text.get_mut(from) {
                *byte ^= 1 << dice.below(8);
            }
        }
        // Another digit: the text stays what it is, the number does not.
        6 => {
            let digits: Vec<_> = (0..text.len()).filter(|at| text[*at].is_ascii_digit()).collect();
            if !digits.is_empty() {
                text[*dice.one_of(&digits)] = b'0' + u8::try_from(dice.below(10)).unwrap();
            }
        }
        _ => {
            let mut lines: Vec<_> = text.split_inclusive(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
            let (a, b) = (dice.below(lines.len()), dice.below(lines.len()));
            if !lines.is_empty() {
                lines.swap(a, b);
            }
            *text = lines.concat();
        }
    }
}

/// Another value somewhere in a document.
fn replace(dice: &mut Dice, value: &mut Value) {
    let inner = match value {
        Value::Array(items) if !items.is_empty() => {
            let at = dice.below(items.len());
            if dice.below(6) == 0 {
                let copy = items[at].clone();
                items.push(copy);
                return;
            }
            Some(&mut items[at])
        }
        Value::Object(members) if !members.is_empty() => {
            let at = dice.below(members.len());
            let name = members.keys().nth(at).unwrap().clone();
            match dice.below(12) {
                0 => drop(members.remove(&name)),
                1 => drop(members.insert(format!("{name}_"), Value::Null)),
                _ => return replace(dice, &mut members[&name]),
            }
            return;
        }
        _ => None,
    };
    match inner {
        Some(inner) if dice.below(8) > 0 => replace(dice, inner),
        _ => {
            let text: &&str = dice.one_of(VALUES);
            *value = serde_json::from_str(text).unwrap();
        }
    }
}

/// One request to begin with.
#[derive(Debug, Clone)]
struct Seed {
    method: reqwest::Method,
    path: String,
    kind: String,
    body: Vec<u8>,
}

/// Every example that stands on its own, and programs.
fn seeds() -> Vec<Seed> {
    let document = description();
    let mut seeds = Vec::new();
    for (path, item) in document["paths"].as_object().unwrap() {
        for (method, operation) in item.as_object().unwrap() {
            for (kind, content) in operation["requestBody"]["content"].as_object().into_iter().flatten() {
                if kind == "multipart/form-data" {
                    continue;
                }
                let named = content["examples"].as_object().and_then(|examples| examples.values().next());
                let example = named.map_or(&content["example"], |named| &named["value"]);
                assert!(!example.is_null(), "{path} has no example of a request as {kind}");
                let text = example.as_str().map_or_else(|| example.to_string(), str::to_owned);
                let method = method.to_uppercase().parse().unwrap();
                let path = path.replace("{machine_id}", "example-ac-table");
                let path = path.replace("{tool_id}", "T12").replace("{id}", "none");
                seeds.push(Seed { method, path, kind: kind.clone(), body: text.into_bytes() });
            }
        }
    }
    let path = "/v1/machines/example-ac-table/cc-compensation";
    for (query, kind, text) in [
        ("tool_radius_mm=5", "text/plain", PROGRAM),
        ("contact=tip&output=interpolated", "text/plain", PROGRAM),
        ("tool_radius_mm=5&corner_radius_mm=1&correction=foot", "text/plain", CONTACTS),
        ("tool_radius_mm=5&correction=seed&work_offset_mm=10,-20,30", "text/plain", CONTACTS),
        ("tool_radius_mm=5&contact=normals&feed_mm_per_min=1000", "text/csv", TABLE),
    ] {
        let method = reqwest::Method::POST;
        seeds.push(Seed {
            method,
            path: format!("{path}?{query}"),
            kind: kind.to_owned(),
            body: text.into(),
        });
    }
    seeds.push(Seed {
        method: reqwest::Method::POST,
        path: "/v1/machines/example-ac-table/tools/T12/wear-entries".to_owned(),
        kind: "application/json".to_owned(),
        body: ENTRIES.into(),
    });
    let path = "/v1/machines/example-ac-table/wear-compensation?nominal_tool.radius_mm=5";
    let lengths = "nominal_tool.length_mm=80&actual_tool.length_mm=79.8";
    for (query, kind, text) in [
        ("actual_tool.radius_mm=4.75".to_owned(), "text/plain", WORN),
        ("actual_tool.radius_mm=4.75".to_owned(), "text/plain", PROGRAM),
        (format!("actual_tool.radius_mm=4&interpolation=tcp&{lengths}"), "text/plain", WORN),
        (format!("actual_tool.radius_mm=5&{lengths}"), "text/plain", PROGRAM),
        ("actual_tool.radius_mm=4.5&actual_tool.corner_radius_mm=1".to_owned(), "text/plain", CONTACTS),
        ("wear_table.contact_angle_deg=0,90&wear_table.deviation_um=0,-70".to_owned(), "text/csv", TABLE),
    ] {
        let method = reqwest::Method::POST;
        seeds.push(Seed {
            method,
            path: format!("{path}&{query}"),
            kind: kind.to_owned(),
            body: text.into(),
        });
    }
    assert!(seeds.len() >= 12, "only {} seeds", seeds.len());
    seeds
}

fn mutated(attempt: u64, seeds: &[Seed]) -> Seed {
    let mut dice = Dice(attempt.wrapping_mul(0x2545_f491_4f6c_dd1d));
    let mut seed = dice.one_of(seeds).clone();
    if seed.kind == "application/json" && dice.below(4) > 0 {
        let mut value: Value = serde_json::from_slice(&seed.body).unwrap();
        for _ in 0..=dice.below(3) {
            replace(&mut dice, &mut value);
        }
        seed.body = value.to_string().into_bytes();
    } else {
        for _ in 0..=dice.below(4) {
            change(&mut dice, &mut seed.body);
        }
    }
    seed
}

/// What is wrong with an answer.
async fn wrong(app: &App, response: Response) -> Option<String> {
    let (status, headers) = (response.status(), response.headers().clone());
    let text = response.text().await.unwrap_or_default();
    if status.is_server_error() {
        return Some(format!("{status}: {text}"));
    }
    if status.is_client_error() {
        let problem: Value = serde_json::from_str(&text).unwrap_or_default();
        let whole =
            headers["content-type"] == "application/problem+json" && problem["status"] == status.as_u16();
        return (!whole).then(|| format!("{status} without a problem: {text}"));
    }
    // A job's program has been checked: what its report says of the written text keeps the tolerance.
    let job = headers.get("location")?.to_str().unwrap().to_owned();
    if !job.starts_with("/v1/jobs/") {
        return None;
    }
    let document: Value = app.get(&job).await.json().await.unwrap();
    let tolerance_um = match document["operation"].as_str().unwrap() {
        "cc-compensation" => document["parameters"]["tolerance_um"].as_f64().unwrap(),
        "wear-compensation" => WORST_ROUNDING_UM,
        _ => return None,
    };
    let report: Value = app.get(&format!("{job}/report")).await.json().await.unwrap();
    let after_um = report["after"]["max_um"].as_f64().unwrap();
    let program = app.get(&format!("{job}/program")).await.text().await.unwrap();
    // A lone carriage return ends a line too.
    let lines = program.split(['\n', '\r']).count() as u64;
    // The seed correction may leave more, and says so.
    let said = document["parameters"]["correction"] == "seed"
        && report["warnings"].to_string().contains("tolerance_not_reached");
    let counted = report["blocks_out"].as_u64().is_some_and(|blocks| blocks <= lines);
    let sound = counted && (after_um <= tolerance_um || said);
    (!sound).then(|| format!("{report}\n{program}"))
}

#[tokio::test]
async fn no_body_breaks_the_service() {
    let number = |name| std::env::var(name).ok().map(|text| text.parse::<u64>().unwrap());
    let attempts = match number("TRUNNION_MUTATION") {
        Some(one) => one..one + 1,
        None => 0..number("TRUNNION_MUTATIONS").unwrap_or(ATTEMPTS),
    };
    let seeds = seeds();
    let start = || {
        let small = |settings: &mut trunnion::config::Settings| settings.max_cost_s = 0.2;
        spawn_real_with(small, Arc::new(CutterContactCompensator::default()))
    };
    let mut app = start().await;
    // A body that makes the first key would close the service to all that come after it.
    app.close().await;
    let (mut answered, mut refused) = (0, 0);
    for attempt in attempts.clone() {
        if attempt % ATTEMPTS_PER_SERVICE == ATTEMPTS_PER_SERVICE - 1 {
            app.stop().await;
            app = start().await;
            app.close().await;
        }
        let seed = mutated(attempt, &seeds);
        let said = format!(
            "TRUNNION_MUTATION={attempt}: {} {} {}\n{}",
            seed.method,
            seed.path,
            seed.kind,
            String::from_utf8_lossy(&seed.body)
        );
        let mut requests = vec![(seed.method, seed.path, seed.kind, seed.body)];
        if requests[0].0 == reqwest::Method::PUT && requests[0].1.contains("/tools/") {
            // A tool of its own; when it is taken, the table has to be read.
            requests[0].1 = format!("/v1/machines/example-ac-table/tools/m{attempt}");
            requests.push((
                reqwest::Method::GET,
                "/v1/machines/example-ac-table/tools".to_owned(),
                String::new(),
                Vec::new(),
            ));
        } else if requests[0].0 == reqwest::Method::PUT {
            // A profile of a machine of its own; when it is taken, the machine has to work.
            let machine = format!("/v1/machines/m{attempt}");
            requests[0].1.clone_from(&machine);
            for (path, kind, body) in [
                ("cc-compensation?tool_radius_mm=5", "text/plain", PROGRAM),
                ("inverse-kinematics", "text/csv", "x,y,z,i,j,k\n1,2,3,0.1,0.2,1\n0,0,0,0,0,1\n"),
                (
                    "inverse-kinematics?selection=all",
                    "text/csv",
                    "x,y,z,i,j,k\n1,2,3,0.1,0.2,1\n0,0,0,0,0,1\n",
                ),
            ] {
                let path = format!("{machine}/{path}");
                requests.push((reqwest::Method::POST, path, kind.to_owned(), body.into()));
            }
        }
        for (method, path, kind, body) in requests {
            let request = app.client.request(method, app.url(&path)).header("content-type", kind).body(body);
            let response = request.send().await.unwrap_or_else(|fault| panic!("{said}\n{fault}"));
            if response.status().is_success() {
                answered += 1;
            } else {
                refused += 1;
            }
            if let Some(wrong) = wrong(&app, response).await {
                panic!("{said}\n{path}: {wrong}");
            }
        }
    }
    assert_eq!(app.files().1, 0, "an upload was left half written");
    // Changes that are always refused, or never, would try nothing.
    let tried = attempts.end - attempts.start;
    assert!(
        tried < 100 || (answered > tried / 20 && refused > tried / 20),
        "{answered} answered, {refused} refused"
    );
}
