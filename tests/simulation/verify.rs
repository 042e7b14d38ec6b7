//! What must hold after every crash: the folder is opened again as the service opens it, a little work is done, and
//! all that is stored is compared with all that was answered.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection, SqliteRow};
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, Row};
use trunnion::store::{
    DATABASE_NAME, Deep, Depth, Examination, JobState, StoreError, examine_to, sha256_hex,
};

use crate::ledger::{Fact, Ledger};
use crate::workload::no_gate;
use crate::world::{Ask, Ids, Opening, Wall, World};

/// What does not hold, a sentence each.
pub(crate) type Findings = Vec<String>;

/// Rows of a table, each as its columns in the order asked for.
type Rows = Vec<Vec<Value>>;

/// What the job after a crash is called.
const AFTER: &str = "after";
/// Every 16th length of a log a request comes again through the router, which costs more to make than all else; at the
/// others the rows of all keys are compared.
const ROUTER_AT: usize = 16;
/// Longest wait for what was accepted to end.
const PATIENCE: Duration = Duration::from_secs(20);
/// Ids of a process that starts again are none that were given before.
const FAR_AHEAD: u64 = 1 << 32;

/// Who does what between a crash and the look at it, for planted faults.
pub(crate) type Meddle<'a> = &'a (dyn Fn(&Path) + Sync);

/// The folder as `trunnion doctor --deep` examines it: every file and every row is read.
pub(crate) async fn examined(data: &Path) -> Result<Examination, StoreError> {
    examine_to(data, &Depth { files: true, rows: true, known_head: None }).await
}

/// Opens the folder again, works, and says what does not hold of what was answered when the log was `length` long.
pub(crate) async fn look(
    data: &Path,
    ledger: &Ledger,
    length: usize,
    meddle: Option<Meddle<'_>>,
) -> Findings {
    let mut findings = Findings::new();
    let wall = Wall::at(ledger.shown_ms_at(length) + 1000, 0);
    let ids = Ids::from(ledger.next_id + FAR_AHEAD);
    let opening = Opening {
        data: data.to_owned(),
        wall,
        ids,
        gate: no_gate(),
        turns: Arc::default(),
        retention_s: 0.0,
    };
    let world = match World::open(opening).await {
        Ok(world) => world,
        Err(fault) => return vec![format!("the service does not start: {fault}")],
    };
    work(&world, ledger, length, &mut findings).await;
    world.app.queue.stop(Duration::from_secs(5)).await;
    world.app.store.close().await;
    if let Some(meddle) = meddle {
        meddle(data);
    }
    match examined(data).await {
        Ok(found) => {
            findings.extend(found.structural_faults.iter().map(|fault| format!("structure: {fault}")));
            findings.extend(found.deep.iter().flat_map(Deep::faults).map(|fault| format!("rows: {fault}")));
            let files = &found.files;
            let wrong = [
                (usize::try_from(found.broken_references).unwrap(), "broken references"),
                (files.missing.len(), "files that are named and missing"),
                (files.changed.len(), "files with other bytes than their names say"),
                (files.orphans, "files that no row names"),
                (files.incomplete, "files left in the spool"),
            ];
            let some = wrong.into_iter().filter(|(count, _)| *count > 0);
            findings.extend(some.map(|(count, what)| format!("{count} {what}")));
        }
        Err(fault) => findings.push(format!("the database cannot be examined: {fault}")),
    }
    match Stored::read(data).await {
        Ok(stored) => stored.compare(ledger, length, &mut findings),
        Err(fault) => findings.push(format!("the database cannot be read: {fault}")),
    }
    findings
}

/// A new job is accepted and ends, as do all others, and a request that comes again is answered as before.
async fn work(world: &World, ledger: &Ledger, length: usize, findings: &mut Findings) {
    let posted = match world.accept(AFTER, "g1 x3\n").await {
        Ok(row) => row.document.id,
        Err(fault) => {
            findings.push(format!("a new job is not accepted: {fault}"));
            return;
        }
    };
    let mut changes = world.app.queue.changes();
    let ended = tokio::time::timeout(PATIENCE, async {
        loop {
            match world.app.store.queue_depth().await {
                Ok(depth) if depth.queued + depth.running == 0 => break,
                _ => drop(tokio::time::timeout(Duration::from_millis(2), changes.recv()).await),
            }
        }
    });
    if ended.await.is_err() {
        findings.push("jobs that were accepted do not end".to_owned());
    }
    match world.app.store.job(&posted).await {
        Ok(Some(job)) if job.document.state == JobState::Succeeded => {}
        other => findings.push(format!("the new job has ended so: {other:?}")),
    }
    if length.is_multiple_of(ROUTER_AT) {
        ask_again(world, ledger, length, findings).await;
    }
}

/// The last request under a key comes once more, through the router.
async fn ask_again(world: &World, ledger: &Ledger, length: usize, findings: &mut Findings) {
    let Some(admin) = ledger.admin.as_deref().filter(|_| {
        ledger
            .facts_by(length)
            .any(|fact| matches!(fact, Fact::Key { scopes, .. } if scopes.contains("admin")))
    }) else {
        return;
    };
    let answered = ledger.lines.iter().filter(|line| line.answered.is_some_and(|at| at <= length));
    let forgot = ledger.forgets_from.is_some_and(|from| from <= length);
    let last = answered.filter_map(|line| line.repeat.as_ref()).next_back().filter(|_| !forgot);
    if let Some((ask, id)) = last {
        let answer = world.ask(ask, Some(admin)).await;
        let of = format!("{} {} under the key {:?}", ask.method, ask.path, ask.key);
        if !answer.is_done() || answer.text("id") != *id {
            findings.push(format!("{of}, answered with {id} before, is answered {answer:?}"));
        }
    }
}

/// All that a database holds.
#[derive(Debug)]
struct Stored {
    machines: Rows,
    revisions: Rows,
    tools: Rows,
    tool_revisions: Rows,
    calibrations: Rows,
    wear: Rows,
    keys: Rows,
    secrets: Rows,
    jobs: Rows,
    remembered: Rows,
    deliveries: Rows,
    audit: Rows,
}

async fn rows(connection: &mut SqliteConnection, query: &'static str) -> Result<Rows, sqlx::Error> {
    let whole = format!("SELECT json_array({}", query.replacen(" FROM", ") FROM", 1));
    let found: Vec<SqliteRow> = sqlx::query(AssertSqlSafe(whole)).fetch_all(connection).await?;
    Ok(found.iter().map(|row| serde_json::from_str(row.get(0)).unwrap()).collect())
}

fn text(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}

impl Stored {
    async fn read(data: &Path) -> Result<Self, sqlx::Error> {
        let options = SqliteConnectOptions::new().filename(data.join(DATABASE_NAME)).read_only(true);
        let mut database = options.connect().await?;
        let read = Self {
            machines: rows(&mut database, "machine_id, last_revision, deleted FROM machines").await?,
            revisions: rows(
                &mut database,
                "machine_id, revision, json_extract(profile, '$.name'), calibration_id FROM machine_revisions
                 ORDER BY machine_id, revision",
            )
            .await?,
            tools: rows(&mut database, "machine_id, tool_id, deleted FROM tools").await?,
            tool_revisions: rows(
                &mut database,
                "machine_id, tool_id, revision, json_extract(document, '$.number') FROM tool_revisions",
            )
            .await?,
            calibrations: rows(&mut database, "id, json_extract(run, '$.note') FROM calibrations").await?,
            wear: rows(
                &mut database,
                "id, note, posted_with, withdrawn_at FROM wear_entries LEFT JOIN wear_withdrawals ON entry_seq = seq
                 ORDER BY seq",
            )
            .await?,
            keys: rows(&mut database, "id, name, json(scopes), machines, revoked_at FROM api_keys").await?,
            secrets: rows(&mut database, "secret, signs_until FROM webhook_secrets").await?,
            jobs: rows(
                &mut database,
                "id, external_id, state, input_sha256, output_sha256, finished_at, cancel_requested, lease, callback_url,
                 attempts, problem FROM jobs ORDER BY seq",
            )
            .await?,
            remembered: rows(&mut database, "idempotency_key, coalesce(job_id, calibration_id) FROM idempotency_keys").await?,
            deliveries: rows(&mut database, "job_id, state, round FROM deliveries").await?,
            audit: rows(
                &mut database,
                "seq, action, machine_id, resource, revision_before, revision_after FROM audit ORDER BY seq",
            )
            .await?,
        };
        database.close().await?;
        Ok(read)
    }

    fn compare(&self, ledger: &Ledger, length: usize, findings: &mut Findings) {
        for fact in ledger.facts_by(length) {
            if let Some(wrong) = self.against(fact, ledger, length) {
                findings.push(format!("answered, and not so: {fact:?}: {wrong}"));
            }
        }
        self.keys_stand(ledger, length, findings);
        self.last_words(ledger, length, findings);
        self.nothing_unasked(ledger, length, findings);
        self.ends(ledger, length, findings);
        self.log(findings);
    }

    /// Every key of a job or of a calibration stands for what it was answered with.
    fn keys_stand(&self, ledger: &Ledger, length: usize, findings: &mut Findings) {
        if ledger.forgets_from.is_some_and(|from| from <= length) {
            return;
        }
        for line in ledger.lines.iter().filter(|line| line.answered.is_some_and(|at| at <= length)) {
            let Some((Ask { key: Some(key), path, .. }, id)) = &line.repeat else { continue };
            if path == "/v1/keys" {
                continue;
            }
            let own = sha256_hex(key.as_bytes());
            let stands = |row: &Vec<Value>| text(&row[0]).ends_with(&own) && row[1] == **id;
            if !self.remembered.iter().any(stands) {
                findings.push(format!("the key {key:?} does not stand for {id} any more"));
            }
        }
    }

    fn job(&self, id: &str) -> Option<&Vec<Value>> {
        self.jobs.iter().find(|job| job[0] == id)
    }

    fn logged(&self, action: &str, resource: &str) -> usize {
        self.audit.iter().filter(|row| row[1] == action && row[3] == resource).count()
    }

    /// What is wrong of a fact, if anything is.
    fn against(&self, fact: &Fact, ledger: &Ledger, length: usize) -> Option<String> {
        let unless = |holds: bool, what: &str| (!holds).then(|| what.to_owned());
        match fact {
            Fact::Machine { machine, revision, name } => {
                let row = self.revisions.iter().find(|row| row[0] == **machine && row[1] == *revision);
                unless(
                    row.is_some_and(|row| name.as_ref().is_none_or(|name| row[2] == **name)),
                    "no such revision",
                )
            }
            Fact::Tool { machine, tool, revision, number } => {
                let rows = &self.tool_revisions;
                let same = |row: &Vec<Value>| {
                    row[0] == **machine && row[1] == **tool && row[2] == *revision && row[3] == *number
                };
                unless(rows.iter().any(same), "no such revision")
            }
            Fact::Calibration { id, note } => {
                unless(self.calibrations.iter().any(|row| row[0] == **id && row[1] == **note), "no such run")
            }
            Fact::Wear { ids, note } => {
                let found: Vec<&str> =
                    self.wear.iter().filter(|row| row[1] == **note).map(|row| text(&row[0])).collect();
                unless(found == *ids, "other entries")
            }
            Fact::Withdrawn { id, at } => {
                unless(self.wear.iter().any(|row| row[0] == **id && row[3] == **at), "not withdrawn then")
            }
            Fact::Key { id, name, scopes } => {
                let same = |row: &Vec<Value>| {
                    row[0] == **id
                        && row[1] == **name
                        && serde_json::from_str::<Value>(scopes).is_ok_and(|scopes| scopes == row[2])
                };
                let narrow = |row: &&Vec<Value>| row[3].is_null();
                unless(self.keys.iter().filter(narrow).any(same), "no such key, or it allows another thing")
            }
            Fact::Revoked { id } => unless(
                self.keys.iter().any(|row| row[0] == **id && !row[4].is_null()),
                "it opens the service",
            ),
            Fact::Job { id, name, input_sha256, .. } => match self.job(id) {
                Some(row) => unless(row[1] == **name && row[3] == **input_sha256, "another job"),
                None => self.forgotten(id, ledger, length),
            },
            Fact::Answered { id, input_sha256 } => match self.job(id) {
                Some(row) => unless(row[3] == **input_sha256 && row[2] == "succeeded", "another job"),
                None => self.forgotten(id, ledger, length),
            },
            Fact::Ended { id, state, finished_at, output_sha256 } => match self.job(id) {
                Some(row) => unless(
                    row[2] == **state
                        && row[5] == **finished_at
                        && row[4].as_str() == output_sha256.as_deref(),
                    "it ended again, or otherwise",
                ),
                None => self.forgotten(id, ledger, length),
            },
            Fact::Cancelled { id } => match self.job(id) {
                Some(row) => unless(row[2] == "cancelled" && row[6] == 1, "it was not cancelled"),
                None => self.forgotten(id, ledger, length),
            },
            Fact::Told { id } => match self.job(id) {
                Some(_) => {
                    let row = self.deliveries.iter().find(|row| row[0] == **id);
                    let again = ledger.lines.iter().any(|line| line.about == [format!("told {id}")]);
                    unless(row.is_some_and(|row| row[1] == "delivered" || again), "it is told once more")
                }
                None => self.forgotten(id, ledger, length),
            },
            Fact::ToldAgain { id } => match self.job(id) {
                Some(_) => {
                    let row = self.deliveries.iter().find(|row| row[0] == **id);
                    unless(row.is_some_and(|row| row[2].as_i64() > Some(1)), "nobody asked")
                }
                None => self.forgotten(id, ledger, length),
            },
            Fact::Secret { .. } | Fact::MachineGone { .. } | Fact::ToolGone { .. } => None,
        }
    }

    /// A job that is not there went where old ones go, after somebody said so, and the log says it.
    fn forgotten(&self, id: &str, ledger: &Ledger, length: usize) -> Option<String> {
        let may = ledger.forgets_from.is_some_and(|from| from <= length);
        let said = self.logged("job-removed", &format!("/v1/jobs/{id}")) == 1;
        (!may || !said).then(|| "it is lost".to_owned())
    }

    /// Of what may be changed over and over, the last answer counts, unless something was under way.
    fn last_words(&self, ledger: &Ledger, length: usize, findings: &mut Findings) {
        let doubtful = ledger.doubtful_at(length);
        let mut there: BTreeMap<String, (bool, &Fact)> = BTreeMap::new();
        let mut secret = None;
        for fact in ledger.facts_by(length) {
            let (name, is_there) = match fact {
                Fact::Machine { machine, .. } => (format!("machine {machine}"), true),
                Fact::MachineGone { machine } => {
                    let tools = format!("tool {machine} ");
                    there
                        .iter_mut()
                        .filter(|(name, _)| name.starts_with(&tools))
                        .for_each(|entry| entry.1.0 = false);
                    (format!("machine {machine}"), false)
                }
                Fact::Tool { machine, tool, .. } => (format!("tool {machine} {tool}"), true),
                Fact::ToolGone { machine, tool } => (format!("tool {machine} {tool}"), false),
                Fact::Secret { secret: newest } => {
                    secret = Some(newest);
                    continue;
                }
                _ => continue,
            };
            there.insert(name, (is_there, fact));
        }
        for (name, (expected, fact)) in there {
            if doubtful.contains(name.as_str()) {
                continue;
            }
            let machines = self.machines.iter().map(|row| (format!("machine {}", text(&row[0])), &row[2]));
            let tools =
                self.tools.iter().map(|row| (format!("tool {} {}", text(&row[0]), text(&row[1])), &row[2]));
            let found = machines.chain(tools).find(|(known, _)| *known == name);
            if found.is_some_and(|(_, deleted)| *deleted == 0) != expected {
                findings.push(format!("the last word on {name} was {fact:?}, and it is not so"));
            }
        }
        if let Some(secret) = secret.filter(|_| !doubtful.contains("secret"))
            && !self.secrets.iter().any(|row| row[0] == **secret && row[1].is_null())
        {
            findings.push("the newest secret of webhooks is another than was answered".to_owned());
        }
    }

    /// Every row was asked for, and made one thing.
    fn nothing_unasked(&self, ledger: &Ledger, length: usize, findings: &mut Findings) {
        let asked = |name: &str| {
            ledger
                .lines
                .iter()
                .any(|line| line.sent <= length && line.about.iter().any(|about| about == name))
        };
        let named = [
            ("calibration", self.calibrations.iter().map(|row| text(&row[1]).to_owned()).collect::<Vec<_>>()),
            ("key", self.keys.iter().map(|row| format!("key {}", text(&row[1]))).collect()),
            (
                "job",
                self.jobs
                    .iter()
                    .filter(|row| row[1] != AFTER)
                    .map(|row| match row[1].as_str() {
                        Some(name) => name.to_owned(),
                        None => format!("input {}", text(&row[3])),
                    })
                    .collect(),
            ),
            (
                "profile",
                self.revisions
                    .iter()
                    .filter(|row| row[3].is_null() && row[0] != "example-ac-table")
                    .map(|row| format!("profile {}", text(&row[2])))
                    .collect(),
            ),
            (
                "wear",
                self.wear.iter().filter(|row| row[0] == row[2]).map(|row| text(&row[1]).to_owned()).collect(),
            ),
        ];
        for (what, names) in named {
            let mut seen = BTreeSet::new();
            for name in names {
                if !asked(&name) {
                    findings.push(format!("{what} {name:?} is there, and nobody asked for it"));
                }
                // Nobody is asked twice for the same first key, so that its name is its own too.
                if !seen.insert(name.clone()) {
                    findings.push(format!("{what} {name:?} is there twice"));
                }
            }
        }
        for job in &self.jobs {
            let keyed = self.remembered.iter().filter(|row| row[1] == job[0]).count();
            if job[1] != AFTER && keyed == 0 && ledger.forgets_from.is_none_or(|from| from > length) {
                findings.push(format!("job {} has lost its idempotency key", job[0]));
            }
        }
        if self.secrets.iter().filter(|row| row[1].is_null()).count() != 1 {
            findings.push("there is not one newest secret of webhooks".to_owned());
        }
        let machines: BTreeSet<&str> = self.machines.iter().map(|row| text(&row[0])).collect();
        if !machines.contains("example-ac-table") {
            findings.push("the example machine is missing".to_owned());
        }
    }

    /// Every job has ended, once, as its program says, and whoever was to be told is told.
    fn ends(&self, ledger: &Ledger, length: usize, findings: &mut Findings) {
        let cancels: BTreeSet<&str> = ledger
            .lines
            .iter()
            .filter(|line| line.sent <= length)
            .flat_map(|line| &line.about)
            .filter_map(|about| about.strip_prefix("cancel "))
            .collect();
        for job in &self.jobs {
            let (id, state) = (text(&job[0]), text(&job[2]));
            if !["succeeded", "failed", "cancelled"].contains(&state) || !job[7].is_null() || job[5].is_null()
            {
                findings.push(format!("job {id} is {state} at the end, under the lease {}", job[7]));
            }
            if state == "cancelled" && !cancels.contains(id) {
                findings.push(format!("job {id} was cancelled by nobody"));
            }
            if job[6] == 1 && state != "cancelled" {
                findings.push(format!("job {id} is {state} although it was cancelled"));
            }
            // On a disk that was ill a job may have met it too often, or not have been given back at a stop.
            let mut reasons = vec!["told to refuse"];
            if ledger.ill {
                reasons.extend(["storage-unavailable", "process-died"]);
            }
            if state == "failed" && !reasons.iter().any(|reason| text(&job[10]).contains(reason)) {
                findings.push(format!("job {id} failed, which its program does not: {}", job[10]));
            }
            // The crash ends one computation. On a disk that was ill the end of another one may not have been written.
            let most_begun = if ledger.ill { 3 } else { 2 };
            if job[9].as_i64() > Some(most_begun) {
                findings.push(format!("job {id} was begun {} times", job[9]));
            }
            let told = self.deliveries.iter().filter(|row| row[0] == id).count();
            if told != usize::from(!job[8].is_null()) {
                findings.push(format!("the end of job {id} is told {told} times"));
            }
        }
    }

    /// The audit log is whole: every change has its row, every row its change, and machines lead from revision to
    /// revision.
    fn log(&self, findings: &mut Findings) {
        for (at, row) in (1_i64..).zip(&self.audit) {
            if row[0] != at {
                findings.push(format!("row {at} of the audit log is missing: there is {}", row[0]));
                break;
            }
        }
        let resources = |actions: &[&str]| {
            let mut found: Vec<&str> = self
                .audit
                .iter()
                .filter(|row| actions.contains(&text(&row[1])))
                .map(|row| text(&row[3]))
                .collect();
            found.sort_unstable();
            found
        };
        let mut expect = |what: &str, actions: &[&str], mut expected: Vec<String>| {
            expected.sort_unstable();
            let found = resources(actions);
            if found != expected {
                let missing: Vec<_> = expected.iter().filter(|one| !found.contains(&one.as_str())).collect();
                let over: Vec<_> =
                    found.iter().filter(|one| !expected.iter().any(|known| known == *one)).collect();
                findings.push(format!(
                    "the audit log has {} {what} and {} are stored; missing {missing:?}, over {over:?}",
                    found.len(),
                    expected.len()
                ));
            }
        };
        let of = |rows: &Rows, head: &str| {
            rows.iter().map(|row| format!("{head}{}", text(&row[0]))).collect::<Vec<_>>()
        };
        let removed: Vec<String> = resources(&["job-removed"]).into_iter().map(str::to_owned).collect();
        let mut jobs = of(&self.jobs, "/v1/jobs/");
        jobs.extend(removed.iter().cloned());
        expect("jobs", &["job-created"], jobs);
        expect("keys", &["key-created"], of(&self.keys, "/v1/keys/"));
        let revoked = self.keys.iter().filter(|row| !row[4].is_null()).cloned().collect();
        expect("revocations", &["key-revoked"], of(&revoked, "/v1/keys/"));
        let below =
            |row: &Vec<Value>| format!("/v1/machines/example-ac-table/calibrations/{}", text(&row[0]));
        expect("calibrations", &["calibration-created"], self.calibrations.iter().map(below).collect());
        let below = |row: &Vec<Value>| {
            format!("/v1/machines/example-ac-table/tools/T12/wear-entries/{}", text(&row[0]))
        };
        let first = self.wear.iter().filter(|row| row[0] == row[2]).map(below).collect();
        expect("postings of wear", &["wear-entries-created"], first);
        let withdrawn = self.wear.iter().filter(|row| !row[3].is_null()).map(below).collect();
        expect("withdrawals", &["wear-entry-withdrawn"], withdrawn);
        let cancelled = self
            .jobs
            .iter()
            .filter(|row| row[6] == 1 && !removed.contains(&format!("/v1/jobs/{}", text(&row[0]))));
        let mut cancelled: Vec<String> = cancelled.map(|row| format!("/v1/jobs/{}", text(&row[0]))).collect();
        // Of jobs that went, the log alone still knows that they were cancelled.
        let gone =
            resources(&["job-cancelled"]).into_iter().filter(|one| removed.iter().any(|known| known == one));
        cancelled.extend(gone.map(str::to_owned));
        expect("cancelled jobs", &["job-cancelled"], cancelled);
        for machine in &self.machines {
            self.log_of(text(&machine[0]), machine, findings);
        }
    }

    fn log_of(&self, id: &str, machine: &[Value], findings: &mut Findings) {
        let mut current: Option<i64> = None;
        let mut last = 0;
        let about = ["machine-created", "machine-replaced", "machine-deleted", "calibration-applied"];
        let of_it = |row: &&Vec<Value>| row[2] == id && about.contains(&text(&row[1]));
        for row in self.audit.iter().filter(of_it) {
            let (before, after) = (row[4].as_i64(), row[5].as_i64());
            let follows = before == current && after.is_none_or(|after| after == last + 1);
            if !follows {
                findings
                    .push(format!("the audit log of {id} leads from {current:?} to {before:?} → {after:?}"));
            }
            current = after;
            last = after.unwrap_or(last);
        }
        let revisions = self.revisions.iter().filter(|row| row[0] == id).count();
        let stored = (machine[1].as_i64(), machine[2] == 1);
        if stored != (Some(last), current.is_none()) || i64::try_from(revisions).ok() != Some(last) {
            findings.push(format!(
                "{id} has {revisions} revisions and is {machine:?}; the audit log ends with revision {last}, now {current:?}"
            ));
        }
    }
}
