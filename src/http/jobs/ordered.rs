//! A requested job on its way into the queue: everything that can be checked without reading its program is checked.

use std::collections::BTreeSet;
use std::sync::Arc;

use http::request::Parts;

use crate::http::AppState;
use crate::http::author::actor;
use crate::http::caller::Caller;
use crate::http::current_machine::current_machine;
use crate::http::problem::{Problem, ProblemType};
use crate::http::request_facts::RequestFacts;
use crate::jobs::{
    Besides, DrawnUp, JobFault, JobOrder, MachineUsed, ProgramJob, Sizes, steps_done, with_wear,
};
use crate::store::{Actor, Draft, KeyUse};
use crate::wire::Fault;

/// A fault of one place of the request.
pub(super) fn invalid(pointer: &str, detail: impl Into<String>) -> Problem {
    Problem::invalid(ProblemType::InvalidRequest, vec![Fault::new(pointer, detail)])
}

/// Reads an order, and checks the address of its webhook.
pub(super) fn read_order(app: &AppState, text: &[u8]) -> Result<JobOrder, Problem> {
    let order = JobOrder::read(text)?;
    let url = order.callback_url.as_deref().and_then(|url| url.parse().ok());
    if let Some(Err(fault)) = url.map(|url| app.courier.admit(&url)) {
        return Err(invalid("/callback_url", fault.to_string()));
    }
    Ok(order)
}

/// An order with what it is carried out with.
pub(super) struct Ordered {
    order: JobOrder,
    on: MachineUsed,
    /// The machines that the caller reaches; `None` for all.
    machines: Option<Arc<BTreeSet<String>>>,
    by: Actor,
    traceparent: Option<String>,
}

/// What was sent for one job.
pub(super) struct Sent {
    /// The program.
    pub(super) program: Draft,
    /// The part's surface.
    pub(super) surface: Option<Draft>,
    /// File name of the program.
    pub(super) file_name: String,
    /// The idempotency key of the job.
    pub(super) used: Option<KeyUse>,
}

impl Ordered {
    /// Looks up the machine as it is now, with the wear of its tools.
    pub(super) async fn new(
        app: &AppState,
        parts: &Parts,
        caller: &Caller,
        order: JobOrder,
    ) -> Result<Self, Problem> {
        let on = Arc::unwrap_or_clone(current_machine(app, &order.machine_id).await?);
        let on = with_wear(&app.store, &app.sources, on, order.cutter_id.as_deref()).await?;
        Ok(Self {
            order,
            on,
            machines: caller.machines.clone(),
            by: actor(parts)?,
            traceparent: RequestFacts::of(&parts.extensions).map(|request| request.trace.to_string()),
        })
    }

    /// The job of one program, ready to be accepted.
    pub(super) async fn draw_up(&self, app: &AppState, sent: Sent) -> Result<DrawnUp, Problem> {
        let Sent { program, surface, file_name, used } = sent;
        let JobOrder { machine_id, external_id, callback_url, .. } = self.order.clone();
        let steps_done = steps_done(&app.store, &program.sha256(), self.machines.as_deref()).await?;
        let repeats = self.order.steps.shared_with(steps_done);
        let sizes = Sizes::of_drafts(&program, surface.as_ref())?;
        let work = self.order.work(self.on.clone(), sizes, &app.means())?;
        // Work that can never have memory is refused now; work that has none at present waits.
        if let Some(facets) = sizes.surface_facets
            && let Err(fault) = app.compute.surface_memory(facets)
            && fault.is_too_large()
        {
            return Err(JobFault::PartSurface(fault).into());
        }
        let job = ProgramJob {
            machine_id,
            machine_revision: self.on.revision,
            work,
            repeats: repeats.map(|step| step.name().to_owned()),
            steps_done,
            program,
            surface,
            file_name,
            used,
            by: self.by.clone(),
        };
        let besides = Besides { external_id, callback_url, traceparent: self.traceparent.clone() };
        Ok(app.queue.draw_up(job, besides)?)
    }
}
