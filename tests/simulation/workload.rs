//! What the clients of a run ask, one request at a time, in an order that the seed decides.

use std::path::Path;
use std::sync::Arc;

use serde_json::{Value, json};
use trunnion::store::sha256_hex;

use crate::chance::Chance;
use crate::ledger::{Fact, Ledger, Line};
use crate::receiver::Receiver;
use crate::recorder::{self, CALLBACK_PORT};
use crate::world::{Answer, Ask, Gate, Ids, Opening, RETENTION_S, Wall, World};

const SECOND_MS: i64 = 1000;
const DAY_MS: i64 = 86_400 * SECOND_MS;

/// The clients of a run and what they remember.
pub(crate) struct Clients {
    world: Option<World>,
    data: std::path::PathBuf,
    receiver: Receiver,
    chance: Chance,
    pub(crate) ledger: Ledger,
    number: u64,
    machines: Vec<(String, bool)>,
    tools: Vec<(String, String, bool)>,
    calibrations: Vec<String>,
    wear: Vec<String>,
    keys: Vec<String>,
    /// Jobs that are not known to have ended.
    jobs: Vec<String>,
    /// Jobs that have ended and whose end was to be told.
    told: Vec<String>,
    ended: Vec<String>,
}

/// A calibration run, with a remark of its own so that it is told from every other.
fn ballbar(note: &str, number: u64) -> Value {
    let mut run: Value = serde_json::from_str(include_str!("../../docs/examples/ballbar.json")).unwrap();
    run["note"] = note.into();
    run["setup_error_um"] = json!({"e_xs": number as f64 / 1000.0, "e_ys": -0.4});
    run
}

impl Clients {
    /// Clients of a folder, with what they know already.
    pub(crate) async fn of(data: &Path, seed: u64, known: Option<&Ledger>) -> Self {
        let receiver = Receiver::listen(seed).await;
        let mut clients = Self {
            world: None,
            data: data.to_owned(),
            receiver,
            chance: Chance::of(seed, 2),
            ledger: known.cloned().unwrap_or_default(),
            number: 1 + seed % 1000 * 1000,
            machines: ["m0", "m1"].map(|name| (name.to_owned(), false)).into(),
            tools: Vec::new(),
            calibrations: Vec::new(),
            wear: Vec::new(),
            keys: Vec::new(),
            jobs: Vec::new(),
            told: Vec::new(),
            ended: Vec::new(),
        };
        clients.open(0.0).await;
        clients
    }

    async fn open(&mut self, retention_s: f64) {
        let opening = || Opening {
            data: self.data.clone(),
            wall: Wall::at(self.ledger.shown_ms, 0),
            ids: Ids::from(self.ledger.next_id),
            gate: Arc::default(),
            turns: Arc::clone(&self.receiver.turns),
            retention_s,
        };
        let mut tries = 0;
        self.world = Some(loop {
            match World::open(opening()).await {
                Ok(world) => break world,
                // The disk is ill; whoever starts the service tries again.
                Err(fault) => {
                    tries += 1;
                    assert!(tries < 200, "the service does not start: {fault}");
                }
            }
        });
        self.world().settle().await;
        self.show_the_key().await;
    }

    /// The first use of a key is written down beside the request: not beside one that writes something itself.
    async fn show_the_key(&self) {
        let Some(admin) = self.ledger.admin.as_deref() else { return };
        let _machines = self.world().ask(&Ask::new("GET", "/v1/machines"), Some(admin)).await;
        self.world().settle().await;
    }

    fn world(&self) -> &World {
        self.world.as_ref().unwrap()
    }

    fn next(&mut self) -> u64 {
        self.number += 1;
        self.number
    }

    /// Asks until there is an answer that says what happened: a service that cannot at the moment is asked again, and
    /// one answer in eight is lost on its way, or comes twice.
    async fn ask(
        &mut self,
        ask: Ask,
        about: Vec<String>,
        facts: impl Fn(&Answer) -> Vec<Fact>,
    ) -> Option<Answer> {
        self.world().wall.pass_ms(7);
        let line = self.ledger.lines.len();
        let sent = recorder::now();
        let shown_ms = self.world().wall.shown_ms();
        let line_of_it = Line { about, sent, answered: None, facts: Vec::new(), shown_ms, repeat: None };
        self.ledger.lines.push(line_of_it);
        let admin = self.ledger.admin.clone();
        let mut lost = ask.key.is_some() && self.chance.one_in(8);
        let mut certain = true;
        for _try in 0..12 {
            let answer = self.world().ask(&ask, admin.as_deref()).await;
            let heard = recorder::now();
            if std::mem::take(&mut lost) {
                certain = false;
                self.world().settle().await;
                continue;
            }
            if answer.is_done() {
                let found = facts(&answer);
                let kept = &mut self.ledger.lines[line];
                kept.answered = Some(heard);
                kept.facts = found;
                if ask.key.is_some() && !answer.text("id").is_empty() {
                    kept.repeat = Some((ask, answer.text("id")));
                }
                self.world().settle().await;
                return Some(answer);
            }
            self.world().settle().await;
            assert!(answer.status != 500, "{} {} is answered 500: {}", ask.method, ask.path, answer.document);
            match answer.status {
                503 | 599 => {
                    certain = false;
                    recorder::pass_ns(1_000_000_000);
                }
                // Refused: nothing has happened, unless an earlier try did all the same.
                _ => {
                    self.ledger.lines[line].answered = certain.then_some(heard);
                    return Some(answer);
                }
            }
        }
        None
    }

    /// The first thing that is done with a new service.
    pub(crate) async fn close_the_service(&mut self) {
        let every =
            json!({"name": "the first", "scopes": ["admin", "calibrations", "compute", "machines", "read"]});
        for number in 0..12 {
            // Sent anew each time: the secret is answered once.
            let body = json!({"name": format!("the first {number}"), "scopes": every["scopes"]});
            let about = vec![format!("key the first {number}")];
            let made = self.ask(Ask::new("POST", "/v1/keys").json(&body), about, key_facts).await;
            if let Some(made) = made.filter(Answer::is_done) {
                self.ledger.admin = Some(made.text("key"));
                self.show_the_key().await;
                return;
            }
        }
        assert!(self.ledger.admin.is_some(), "no first key");
    }

    /// So many requests.
    pub(crate) async fn work(&mut self, requests: usize) {
        for _ in 0..requests {
            match self.chance.below(20) {
                0 | 1 => self.put_machine().await,
                2 => self.delete_machine().await,
                3 => self.tool().await,
                4 => self.calibrate().await,
                5 | 6 => self.wear().await,
                7 => self.key().await,
                8..=11 => self.post_job().await,
                12 | 13 => self.release().await,
                14 => self.cancel().await,
                15 => self.answer_at_once().await,
                16 => self.rotate().await,
                17 => self.restart().await,
                18 => self.jump(),
                _ => self.tell_again().await,
            }
        }
    }

    /// Lets everything end, looks at the ends, and stops.
    pub(crate) async fn finish(mut self) -> Ledger {
        recorder::cure();
        while self.world().gate.holds_one() {
            self.release().await;
        }
        self.look_at_jobs().await;
        self.close().await;
        self.ledger
    }

    async fn close(&mut self) {
        let world = self.world.take().unwrap();
        self.ledger.shown_ms = world.wall.shown_ms();
        self.ledger.next_id = world.ids.reached();
        world.stop().await;
    }

    async fn put_machine(&mut self) {
        let (at, number) = (self.chance.below(self.machines.len()), self.next());
        let (id, there) = self.machines[at].clone();
        let name = format!("machine {number}");
        let body = json!({"name": name, "kinematics": {"rotary_axes": [
            {"name": "A", "side": "table", "direction": [1, 0, 0], "point_mm": [0, 0, number as f64 / 1000.0]},
            {"name": "C", "side": "table", "direction": [0, 0, 1], "point_mm": [0, 0, 0]}]}});
        let path = format!("/v1/machines/{id}");
        let fact = |answer: &Answer| {
            let revision = answer.document["revision"].as_i64().unwrap();
            vec![Fact::Machine { machine: id.clone(), revision, name: Some(name.clone()) }]
        };
        let about = vec![format!("machine {id}"), format!("profile {name}")];
        let ask = Ask::new("PUT", path).json(&body);
        for if_match in [there, !there] {
            let answer = self.ask(ask.clone().matching(if_match), about.clone(), fact).await;
            if answer.is_some_and(|answer| answer.is_done()) {
                self.machines[at].1 = true;
                return;
            }
        }
    }

    async fn delete_machine(&mut self) {
        let at = self.chance.below(self.machines.len());
        let (id, there) = self.machines[at].clone();
        if !there || self.chance.one_in(2) {
            return;
        }
        let gone = id.clone();
        let tools = self.tools.iter().filter(|(machine, ..)| *machine == id);
        let mut about: Vec<String> = tools.map(|(_, tool, _)| format!("tool {id} {tool}")).collect();
        about.push(format!("machine {id}"));
        let fact = move |_: &Answer| vec![Fact::MachineGone { machine: gone.clone() }];
        let ask = Ask::new("DELETE", format!("/v1/machines/{id}")).matching(true);
        let answer = self.ask(ask, about, fact).await;
        if answer.is_some_and(|answer| answer.is_done()) {
            self.machines[at].1 = false;
            self.tools.iter_mut().filter(|(machine, ..)| *machine == id).for_each(|tool| tool.2 = false);
        }
    }

    async fn tool(&mut self) {
        let (tool, number) = (format!("T{}", self.chance.below(3)), self.next());
        let id = "example-ac-table".to_owned();
        let known = self.tools.iter().position(|(machine, name, _)| *machine == id && *name == tool);
        let at = known.unwrap_or_else(|| {
            self.tools.push((id.clone(), tool.clone(), false));
            self.tools.len() - 1
        });
        let there = self.tools[at].2;
        let path = format!("/v1/machines/{id}/tools/{tool}");
        let about = vec![format!("tool {id} {tool}"), format!("number {number}")];
        if there && self.chance.one_in(3) {
            let fact = |_: &Answer| vec![Fact::ToolGone { machine: id.clone(), tool: tool.clone() }];
            let answer = self.ask(Ask::new("DELETE", path).matching(true), about, fact).await;
            if answer.is_some_and(|answer| answer.is_done()) {
                self.tools[at].2 = false;
            }
            return;
        }
        let body = json!({"number": number, "kind": "ball", "radius_mm": 5});
        for if_match in [there, !there] {
            let fact = |answer: &Answer| {
                let revision = answer.document["revision"].as_i64().unwrap();
                let number = i64::try_from(number).unwrap();
                vec![Fact::Tool { machine: id.clone(), tool: tool.clone(), revision, number }]
            };
            let ask = Ask::new("PUT", path.clone()).json(&body).matching(if_match);
            if self.ask(ask, about.clone(), fact).await.is_some_and(|answer| answer.is_done()) {
                self.tools[at].2 = true;
                return;
            }
        }
    }

    async fn calibrate(&mut self) {
        let machine = "/v1/machines/example-ac-table";
        if self.world().gate.holds_one() {
            // There is one place to compute at.
            return;
        }
        if let Some(id) = self.calibrations.pop() {
            let key = format!("apply-{}", self.next());
            let ask = Ask::new("POST", format!("{machine}/calibrations/{id}/apply"));
            let fact = |answer: &Answer| {
                let revision = answer.document["revision"].as_i64().unwrap();
                vec![Fact::Machine { machine: "example-ac-table".to_owned(), revision, name: None }]
            };
            let about = vec!["machine example-ac-table".to_owned(), format!("applied {id}")];
            let _answer = self.ask(ask.keyed(key).matching(true), about, fact).await;
            return;
        }
        let number = self.next();
        let note = format!("run {number}");
        let ask = Ask::new("POST", format!("{machine}/calibrations")).json(&ballbar(&note, number));
        let fact = |answer: &Answer| vec![Fact::Calibration { id: answer.text("id"), note: note.clone() }];
        let answer = self.ask(ask.keyed(note.clone()), vec![note.clone()], fact).await;
        if let Some(answer) = answer.filter(Answer::is_done) {
            self.calibrations.push(answer.text("id"));
        }
    }

    async fn wear(&mut self) {
        let path = "/v1/machines/example-ac-table/tools/T12/wear-entries";
        if self.chance.one_in(3)
            && let Some(id) = self.wear.pop()
        {
            let about = vec![format!("withdrawal {id}")];
            let fact = |answer: &Answer| {
                let at = answer.document["withdrawn"]["withdrawn_at"].as_str().unwrap().to_owned();
                vec![Fact::Withdrawn { id: id.clone(), at }]
            };
            let ask = Ask::new("POST", format!("{path}/{id}/withdraw"));
            let _answer = self.ask(ask.json(&json!({"reason": "the wrong flute"})), about, fact).await;
            return;
        }
        let number = self.next();
        let note = format!("wear {number}");
        let entry = |parts: u64| {
            json!({"measured_at": "2025-03-10T08:00:00Z", "parts_cut": parts, "radius_wear_um": 24.5,
                "note": note.clone()})
        };
        let body = json!([entry(10 * number), entry(10 * number + 1)]);
        let fact = |answer: &Answer| {
            let entries = answer.document.as_array().unwrap();
            let ids = entries.iter().map(|entry| entry["id"].as_str().unwrap().to_owned()).collect();
            vec![Fact::Wear { ids, note: note.clone() }]
        };
        let ask = Ask::new("POST", path).json(&body).keyed(note.clone());
        let answer = self.ask(ask, vec![note.clone()], fact).await;
        if let Some(answer) = answer.filter(Answer::is_done) {
            self.wear.push(answer.document[0]["id"].as_str().unwrap().to_owned());
        }
    }

    async fn key(&mut self) {
        if self.chance.one_in(2)
            && let Some(id) = self.keys.pop()
        {
            let about = vec![format!("revoked {id}")];
            let fact = |_: &Answer| vec![Fact::Revoked { id: id.clone() }];
            let _answer = self.ask(Ask::new("DELETE", format!("/v1/keys/{id}")), about, fact).await;
            return;
        }
        let name = format!("client {}", self.next());
        let scopes: &[&str] = if self.chance.one_in(2) { &["read"] } else { &["compute", "read"] };
        let ask = Ask::new("POST", "/v1/keys").json(&json!({"name": name, "scopes": scopes}));
        let about = vec![format!("key {name}")];
        let answer = self.ask(ask.keyed(name.clone()), about, key_facts).await;
        if let Some(answer) = answer.filter(Answer::is_done) {
            self.keys.push(answer.text("id"));
        }
    }

    async fn post_job(&mut self) {
        let (number, told) = (self.next(), self.chance.one_in(2));
        let name = format!("job-{number}");
        let kind = *self.chance.pick(&["HOLD", "g1 x1", "g1 x2", "REFUSE"]);
        let program = format!("{kind} {number}\n{}", "g1 x1 y2\n".repeat(self.chance.below(40)));
        let ask = job(&name, "example-ac-table", &program, told);
        let input_sha256 = sha256_hex(program.as_bytes());
        let fact = |answer: &Answer| {
            vec![Fact::Job {
                id: answer.text("id"),
                name: name.clone(),
                input_sha256: input_sha256.clone(),
                told,
            }]
        };
        let answer = self.ask(ask, vec![name.clone()], fact).await;
        if let Some(answer) = answer.filter(Answer::is_done) {
            self.jobs.push(answer.text("id"));
            if told {
                self.told.push(answer.text("id"));
            }
        }
        self.look_at_jobs().await;
    }

    /// Notes what has ended.
    async fn look_at_jobs(&mut self) {
        for id in std::mem::take(&mut self.jobs) {
            let path = format!("/v1/jobs/{id}");
            let sent = recorder::now();
            let answer = self.world().ask(&Ask::new("GET", path.clone()), self.ledger.admin.as_deref()).await;
            let state = answer.text("state");
            if !["succeeded", "failed", "cancelled"].contains(&state.as_str()) {
                if answer.status != 404 {
                    self.jobs.push(id);
                }
                continue;
            }
            let output_sha256 = answer.document["output_sha256"].as_str().map(str::to_owned);
            let finished_at = answer.text("finished_at");
            let mut facts = vec![Fact::Ended { id: id.clone(), state, finished_at, output_sha256 }];
            let deliveries = self
                .world()
                .ask(&Ask::new("GET", format!("{path}/deliveries")), self.ledger.admin.as_deref())
                .await;
            if deliveries.document["delivery"]["state"] == "delivered" {
                facts.push(Fact::Told { id: id.clone() });
            }
            let answered = Some(recorder::now());
            let shown_ms = self.world().wall.shown_ms();
            self.ledger.lines.push(Line { about: Vec::new(), sent, answered, facts, shown_ms, repeat: None });
            self.ended.push(id);
        }
        self.world().settle().await;
    }

    async fn release(&mut self) {
        // The one that waited goes, and the next may come.
        self.world().gate.let_go();
        self.world().settle().await;
        // Those whose time has come are told again.
        self.world().wall.pass_ms(6 * SECOND_MS);
        recorder::pass_ns(31_000_000_000);
        self.world().settle().await;
        self.look_at_jobs().await;
    }

    async fn cancel(&mut self) {
        if self.jobs.is_empty() {
            return;
        }
        let id = self.jobs[self.chance.below(self.jobs.len())].clone();
        let about = vec![format!("cancel {id}")];
        let fact = |_: &Answer| vec![Fact::Cancelled { id: id.clone() }];
        let _answer = self.ask(Ask::new("DELETE", format!("/v1/jobs/{id}")), about, fact).await;
        self.look_at_jobs().await;
    }

    async fn answer_at_once(&mut self) {
        if self.world().gate.holds_one() {
            // There is one place to compute at.
            return;
        }
        let number = self.next();
        let program = format!("g1 x{number}\n");
        let path =
            "/v1/machines/example-ac-table/cc-compensation?tool_radius_mm=5&contact=tip&work_offset_mm=1,2,3";
        let mut ask = Ask::new("POST", path).keyed(format!("direct-{number}"));
        (ask.kind, ask.body) = ("text/plain", program.clone().into_bytes());
        let input_sha256 = sha256_hex(program.as_bytes());
        let fact = |answer: &Answer| {
            let place = answer.location.clone().unwrap();
            let id = place.trim_start_matches("/v1/jobs/").to_owned();
            vec![Fact::Answered { id, input_sha256: input_sha256.clone() }]
        };
        let _answer = self.ask(ask, vec![format!("input {input_sha256}")], fact).await;
    }

    async fn rotate(&mut self) {
        let key = format!("secret-{}", self.next());
        let fact = |answer: &Answer| vec![Fact::Secret { secret: answer.text("secret") }];
        let ask = Ask::new("POST", "/v1/webhooks/secret/rotation").keyed(key);
        let _answer = self.ask(ask, vec!["secret".to_owned()], fact).await;
    }

    async fn tell_again(&mut self) {
        let ended: Vec<&String> = self.told.iter().filter(|id| self.ended.contains(id)).collect();
        let Some(id) = ended.get(self.chance.below(ended.len().max(1))).map(|id| (*id).clone()) else {
            return;
        };
        let key = format!("again-{}", self.next());
        let fact = |_: &Answer| vec![Fact::ToldAgain { id: id.clone() }];
        let ask = Ask::new("POST", format!("/v1/jobs/{id}/deliveries")).keyed(key);
        let _answer = self.ask(ask, vec![format!("told {id}")], fact).await;
    }

    fn jump(&mut self) {
        let by = *self.chance.pick(&[-400 * DAY_MS, -DAY_MS, -3 * SECOND_MS, 5 * SECOND_MS, DAY_MS]);
        self.world().wall.jump_ms(by);
    }

    /// An orderly stop and a new start, which forgets old jobs at times.
    async fn restart(&mut self) {
        let forgets = self.chance.one_in(2);
        if forgets {
            // Alone: who forgets and who computes write in an order that is theirs.
            while self.world().gate.holds_one() {
                self.release().await;
            }
            self.world().wall.pass_ms(3 * DAY_MS);
        }
        self.close().await;
        if forgets {
            self.ledger.forgets_from.get_or_insert(recorder::now());
        }
        self.open(if forgets { RETENTION_S } else { 0.0 }).await;
    }
}

fn key_facts(answer: &Answer) -> Vec<Fact> {
    let scopes = answer.document["scopes"].to_string();
    vec![Fact::Key { id: answer.text("id"), name: answer.text("name"), scopes }]
}

/// A job under a key and an id of the client's own.
pub(crate) fn job(name: &str, machine: &str, program: &str, told: bool) -> Ask {
    let mut job = json!({"machine_id": machine, "operation": "cc-compensation", "external_id": name,
        "parameters": {"tool_radius_mm": 5, "contact": "tip", "work_offset_mm": [1, 2, 3]}});
    if told {
        job["callback_url"] = format!("http://127.0.0.1:{CALLBACK_PORT}/ends").into();
    }
    let part = |head: &str, text: &str| {
        format!("--bound\r\nContent-Disposition: form-data; {head}\r\n\r\n{text}\r\n")
    };
    let body = part("name=\"job\"", &job.to_string())
        + &part("name=\"program\"; filename=\"part.nc\"", program)
        + "--bound--\r\n";
    let mut ask = Ask::new("POST", "/v1/jobs").keyed(name);
    (ask.kind, ask.body) = ("multipart/form-data; boundary=bound", body.into_bytes());
    ask
}

/// Nothing waits at its gate.
pub(crate) fn no_gate() -> Arc<Gate> {
    Gate::wide_open()
}
