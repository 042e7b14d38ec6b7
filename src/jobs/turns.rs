//! The order in which callers compute. There is a number of places, and callers share them by the time that they have
//! had: the caller that was served least is next. A computation checks its stop every few milliseconds. There, a
//! computation of a caller that was served more gives way to one of a caller that was served less, and rests until
//! its turn comes again. So no caller waits for the end of another's long work, and a single caller has every place.

use std::collections::{HashMap, HashSet, VecDeque};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;

use crate::shares::Who;

/// How much longer one caller must have computed than another before it gives way: long compared with the change,
/// short compared with a short program \[ns\].
const SLICE_NS: u64 = 5_000_000;
/// Time between two checks of whether another computation is next: a computation that polls its stop all the time
/// must not keep the others from the lock \[ns\].
const BETWEEN_LOOKS_NS: u64 = 500_000;
/// How long a resting computation sleeps between two checks of its stop.
const REST_LOOK: Duration = Duration::from_millis(20);
/// How often a computation checks whether it is alone.
const ALONE_LOOK: Duration = Duration::from_millis(2);
/// Largest number of remembered callers without running or waiting computations.
const MOST_REMEMBERED: usize = 4096;
/// Computations for each place that have begun and not ended, including resting ones. Each keeps a thread and its
/// memory. Further computations wait for the end of one.
const BEGUN_PER_PLACE: usize = 4;

/// The places; clones share them.
#[derive(Debug, Clone)]
pub(super) struct Turns(Arc<Shared>);

struct Shared {
    places: usize,
    /// The time \[ns\], counted from any moment.
    clock: Box<dyn Fn() -> u64 + Send + Sync>,
    state: Mutex<State>,
    /// A computation waits, rests or is alone, or more compute than there are places: the computing ones must check
    /// more closely.
    crowded: AtomicBool,
    /// A resting computation may continue.
    resumed: Condvar,
}

impl fmt::Debug for Shared {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Shared")
            .field("places", &self.places)
            .field("state", &self.state)
            .finish_non_exhaustive()
    }
}

#[derive(Debug, Default)]
struct State {
    parties: HashMap<Who, Party>,
    /// The last number given to a computation that waits or computes.
    last_number: u64,
    /// Time until which the computing time is counted \[ns\].
    counted_ns: u64,
    /// Number of computing computations; lent places count.
    active: usize,
    /// Number of computations that have begun and not ended, including resting ones.
    begun: usize,
    /// The resting computations that may continue.
    woken: HashSet<u64>,
    /// The computation beside which no other computes.
    alone: Option<u64>,
}

/// The computations of one caller.
#[derive(Debug, Default)]
struct Party {
    /// How long it has computed, as far as that counts against others \[ns\].
    served_ns: u64,
    active: usize,
    resting: VecDeque<u64>,
    waiting: VecDeque<Waiter>,
}

#[derive(Debug)]
struct Waiter {
    number: u64,
    start: oneshot::Sender<Place>,
}

impl Party {
    fn is_idle(&self) -> bool {
        self.active == 0 && self.resting.is_empty() && self.waiting.is_empty()
    }
}

/// A place that computes. It is free when this is dropped.
#[derive(Debug)]
pub(super) struct Place {
    turns: Turns,
    who: Who,
    number: u64,
    /// Time of the last check of whose turn it is.
    looked_ns: AtomicU64,
    /// Whether it must still be given back.
    is_held: bool,
}

/// A place that nobody needed, lent to a computation that can use more than one.
#[derive(Debug)]
pub(super) struct Lent<'a> {
    turns: &'a Turns,
    who: &'a Who,
}

/// One computation is alone as long as this lives.
#[derive(Debug)]
pub(super) struct Alone {
    turns: Turns,
    number: u64,
}

/// A computation that waits for a place, until it has one or leaves.
struct Waiting<'a> {
    turns: &'a Turns,
    who: &'a Who,
    number: u64,
}

impl Turns {
    /// This many places.
    pub(super) fn new(places: usize) -> Self {
        let began = Instant::now();
        Self::with_clock(places, move || u64::try_from(began.elapsed().as_nanos()).unwrap_or(u64::MAX))
    }

    fn with_clock(places: usize, clock: impl Fn() -> u64 + Send + Sync + 'static) -> Self {
        Self(Arc::new(Shared {
            places,
            clock: Box::new(clock),
            state: Mutex::default(),
            crowded: AtomicBool::new(false),
            resumed: Condvar::new(),
        }))
    }

    /// Largest number of computations that have begun and not ended at this many places: as many threads are needed.
    pub(super) const fn most_begun(places: usize) -> usize {
        BEGUN_PER_PLACE * places
    }

    /// Waits for a place. A caller that leaves before it has one is removed.
    pub(super) async fn take(&self, who: &Who) -> Option<Place> {
        let (_waiting, started) = self.stand_in_line(who);
        started.await.ok()
    }

    fn stand_in_line<'a>(&'a self, who: &'a Who) -> (Waiting<'a>, oneshot::Receiver<Place>) {
        let (start, started) = oneshot::channel();
        let mut state = self.state();
        let number = state.next_number();
        state.arrive(who).waiting.push_back(Waiter { number, start });
        self.hand_on(&mut state);
        self.let_a_newcomer_begin(&mut state, who);
        (Waiting { turns: self, who, number }, started)
    }

    /// A place beside that of `who`, if nobody needs it.
    pub(super) fn lend<'a>(&'a self, who: &'a Who) -> Option<Lent<'a>> {
        let mut state = self.state();
        let is_wanted =
            state.parties.values().any(|party| !party.waiting.is_empty() || !party.resting.is_empty());
        if is_wanted || state.active >= self.0.places {
            return None;
        }
        state.active += 1;
        state.arrive(who).active += 1;
        Some(Lent { turns: self, who })
    }

    /// The state, with the time counted until now.
    fn state(&self) -> MutexGuard<'_, State> {
        // The state is consistent at every moment, even after a panic.
        let mut state = self.0.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.count_until((self.0.clock)());
        state
    }

    /// Gives free places to the callers whose turn it is.
    fn hand_on(&self, state: &mut State) {
        while state.alone.is_none() && state.active < self.0.places {
            let may_begin = state.begun < Self::most_begun(self.0.places);
            let Some(who) = state.next(may_begin, None) else { break };
            if !self.put_on(state, &who, may_begin) {
                break;
            }
        }
        self.look_round(state);
    }

    /// The next computation of a caller starts: the one that rests longest, or else the one that waits longest.
    fn put_on(&self, state: &mut State, who: &Who, may_begin: bool) -> bool {
        let Some(party) = state.parties.get_mut(who) else { return false };
        if let Some(number) = party.resting.pop_front() {
            party.active += 1;
            state.active += 1;
            state.woken.insert(number);
            self.0.resumed.notify_all();
            return true;
        }
        if !may_begin {
            return false;
        }
        let Some(Waiter { number, start }) = party.waiting.pop_front() else { return false };
        party.active += 1;
        state.active += 1;
        state.begun += 1;
        let place = Place {
            turns: self.clone(),
            who: who.clone(),
            number,
            looked_ns: AtomicU64::new(0),
            is_held: true,
        };
        if let Err(mut place) = start.send(place) {
            // A caller that leaves is first taken out of the line, under the lock that is held here.
            place.is_held = false;
            state.end(who);
        }
        true
    }

    /// A caller without a begun computation does not wait for callers that were served more: it begins beside them,
    /// and one of them gives way at its next check.
    fn let_a_newcomer_begin(&self, state: &mut State, who: &Who) {
        let most = Self::most_begun(self.0.places);
        let Some(party) = state.parties.get(who) else { return };
        let is_new = party.active == 0 && party.resting.is_empty() && !party.waiting.is_empty();
        if state.alone.is_some() || !is_new || state.active.max(state.begun) >= most {
            return;
        }
        let served_ns = party.served_ns;
        let had_more = state.parties.iter().any(|(other, party)| {
            other != who
                && (party.active > 1 || (party.active == 1 && party.served_ns > served_ns + SLICE_NS))
        });
        if had_more {
            self.put_on(state, who, true);
            self.look_round(state);
        }
    }

    /// Sets whether the computing ones must check more closely.
    fn look_round(&self, state: &State) {
        let crowded = state.alone.is_some()
            || state.active > self.0.places
            || state.parties.values().any(|party| !party.waiting.is_empty() || !party.resting.is_empty());
        self.0.crowded.store(crowded, Ordering::Relaxed);
    }
}

impl State {
    fn next_number(&mut self) -> u64 {
        self.last_number += 1;
        self.last_number
    }

    /// Counts the time of the computing callers.
    fn count_until(&mut self, now_ns: u64) {
        let passed_ns = now_ns.saturating_sub(self.counted_ns);
        self.counted_ns = now_ns.max(self.counted_ns);
        for party in self.parties.values_mut().filter(|party| party.active > 0) {
            let times = u64::try_from(party.active).unwrap_or(u64::MAX);
            party.served_ns = party.served_ns.saturating_add(passed_ns.saturating_mul(times));
        }
    }

    /// One computation of a caller stops computing.
    fn stand_down(&mut self, who: &Who) -> Option<&mut Party> {
        self.active = self.active.saturating_sub(1);
        let party = self.parties.get_mut(who)?;
        party.active = party.active.saturating_sub(1);
        Some(party)
    }

    /// One computation of a caller has ended.
    fn end(&mut self, who: &Who) {
        self.begun = self.begun.saturating_sub(1);
        self.stand_down(who);
    }

    /// The entry of a caller that has a computation from now on. A caller that was away has not saved up time: it
    /// starts with the time of those that were served least.
    fn arrive(&mut self, who: &Who) -> &mut Party {
        let is_idle = self.parties.get(who).is_none_or(Party::is_idle);
        if is_idle {
            let least = self.least_served();
            if least.is_none() || self.parties.len() > MOST_REMEMBERED {
                self.parties.retain(|_, party| !party.is_idle());
            }
            let party = self.parties.entry(who.clone()).or_default();
            party.served_ns = party.served_ns.max(least.unwrap_or(0));
        }
        self.parties.entry(who.clone()).or_default()
    }

    /// The least time of the callers with a computation.
    fn least_served(&self) -> Option<u64> {
        self.parties.values().filter(|party| !party.is_idle()).map(|party| party.served_ns).min()
    }

    /// Among the callers that need a place: the one that was served least, and among equals the one that came first.
    fn next(&self, may_begin: bool, but: Option<&Who>) -> Option<Who> {
        let first = |party: &Party| {
            let rests = party.resting.front().copied();
            rests.or_else(|| party.waiting.front().filter(|_| may_begin).map(|waiter| waiter.number))
        };
        let wanting = self.parties.iter().filter(|(who, _)| Some(*who) != but);
        let wanting = wanting.filter_map(|(who, party)| Some((party.served_ns, first(party)?, who)));
        wanting.min_by_key(|(served_ns, number, _)| (*served_ns, *number)).map(|(_, _, who)| who.clone())
    }
}

impl Place {
    /// The caller of the place.
    pub(super) fn who(&self) -> &Who {
        &self.who
    }

    /// Whether another computation may be next.
    pub(super) fn is_crowded(&self) -> bool {
        self.turns.0.crowded.load(Ordering::Relaxed)
    }

    /// A computation calls this at every check of its stop, on the thread that has the place. If another computation
    /// is next, it rests here until its turn comes or `is_stopped`.
    pub(super) fn give_way(&self, is_stopped: impl Fn() -> bool) {
        let now_ns = (self.turns.0.clock)();
        let looked_ns = self.looked_ns.load(Ordering::Relaxed);
        if !self.is_crowded() || now_ns.saturating_sub(looked_ns) < BETWEEN_LOOKS_NS {
            return;
        }
        self.looked_ns.store(now_ns, Ordering::Relaxed);
        let mut state = self.turns.state();
        if !self.must_give_way(&state) {
            return;
        }
        if let Some(party) = state.stand_down(&self.who) {
            party.resting.push_back(self.number);
        }
        self.turns.hand_on(&mut state);
        while !state.woken.remove(&self.number) {
            if is_stopped() {
                // It ends now, and takes its place again for as long as that takes.
                state.active += 1;
                if let Some(party) = state.parties.get_mut(&self.who) {
                    party.resting.retain(|number| *number != self.number);
                    party.active += 1;
                }
                break;
            }
            let waited = self.turns.0.resumed.wait_timeout(state, REST_LOOK);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
            state.count_until((self.turns.0.clock)());
        }
        self.turns.look_round(&state);
    }

    /// Waits until no other computation runs, for `within` at most. `None` if one runs during all that time, or is
    /// already alone.
    pub(super) async fn alone(&self, within: Duration) -> Option<Alone> {
        let end = Instant::now() + within;
        let mut alone: Option<Alone> = None;
        loop {
            if self.is_alone(&mut alone) {
                return alone;
            }
            if Instant::now() >= end {
                return None;
            }
            tokio::time::sleep(ALONE_LOOK).await;
        }
    }

    /// Whether no other computation runs; from now on none begins.
    fn is_alone(&self, alone: &mut Option<Alone>) -> bool {
        let mut state = self.turns.state();
        if alone.is_none() && state.alone.is_none() {
            state.alone = Some(self.number);
            self.turns.look_round(&state);
            *alone = Some(Alone { turns: self.turns.clone(), number: self.number });
        }
        alone.is_some() && state.active <= 1
    }

    fn must_give_way(&self, state: &State) -> bool {
        if let Some(alone) = state.alone {
            return alone != self.number;
        }
        let had = |party: &Party| (party.served_ns, party.active);
        let own = state.parties.get(&self.who).map_or((0, 0), had);
        if state.active > self.turns.0.places {
            // Among callers that were served alike, the one that has more places.
            let active = state.parties.values().filter(|party| party.active > 0);
            return active.map(had).max().is_none_or(|most| own >= most);
        }
        let served_ns = own.0;
        let may_begin = state.begun < Turns::most_begun(self.turns.0.places);
        let next = state.next(may_begin, Some(&self.who)).and_then(|who| state.parties.get(&who));
        next.is_some_and(|party| party.served_ns.saturating_add(SLICE_NS) < served_ns)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        if self.is_held {
            let mut state = self.turns.state();
            state.end(&self.who);
            self.turns.hand_on(&mut state);
        }
    }
}

impl Drop for Lent<'_> {
    fn drop(&mut self) {
        let mut state = self.turns.state();
        state.stand_down(self.who);
        self.turns.hand_on(&mut state);
    }
}

impl Drop for Alone {
    fn drop(&mut self) {
        let mut state = self.turns.state();
        if state.alone == Some(self.number) {
            state.alone = None;
        }
        self.turns.hand_on(&mut state);
    }
}

impl Drop for Waiting<'_> {
    fn drop(&mut self) {
        let mut state = self.turns.state();
        if let Some(party) = state.parties.get_mut(self.who) {
            party.waiting.retain(|waiter| waiter.number != self.number);
        }
        self.turns.look_round(&state);
    }
}

#[cfg(test)]
mod tests;
