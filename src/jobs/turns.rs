//! Whose turn it is to compute. There are so many places, and callers share them by the time that they have had: whoever was served
//! least is next. A computation looks at its stop every few milliseconds; one of a caller that was served more gives way there to
//! one of a caller that was served less, and rests until its turn comes again. So nobody waits for the end of another's long work,
//! and one who is alone has every place.

use std::collections::{HashMap, HashSet, VecDeque};
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use tokio::sync::oneshot;

use crate::shares::Who;

/// By how much longer one caller must have computed than another before it gives way: long against the change, short against what
/// a short program takes \[ns\].
const SLICE_NS: u64 = 5_000_000;
/// Time between two looks at whether somebody else is to compute first: who asks for its stop all the time does not keep the others
/// from the line \[ns\].
const BETWEEN_LOOKS_NS: u64 = 500_000;
/// How long a computation that rests sleeps between two looks at its stop.
const REST_LOOK: Duration = Duration::from_millis(20);
/// How often it is looked whether a computation is alone.
const ALONE_LOOK: Duration = Duration::from_millis(2);
/// Callers remembered that have nothing under way.
const MOST_REMEMBERED: usize = 4096;
/// Computations for each place that have begun and not ended, those that rest among them. Each keeps a thread and its memory; who
/// comes when so many have begun waits for the end of one.
const BEGUN_PER_PLACE: usize = 4;

/// The places; a clone is the same.
#[derive(Debug, Clone)]
pub(super) struct Turns(Arc<Shared>);

struct Shared {
    places: usize,
    /// The time \[ns\], from any moment on.
    clock: Box<dyn Fn() -> u64 + Send + Sync>,
    state: Mutex<State>,
    /// Somebody waits, rests or is alone, or more compute than there are places: whoever computes is to look closer.
    crowded: AtomicBool,
    /// Somebody who rests may go on.
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
    /// Numbers of those who wait or compute.
    last_number: u64,
    /// Until when the time of those who compute is counted \[ns\].
    counted_ns: u64,
    /// Who compute; places that were lent count.
    active: usize,
    /// Who have begun and not ended: those who rest too.
    begun: usize,
    /// Of those who rest, the ones that may go on.
    woken: HashSet<u64>,
    /// The one beside which nobody computes.
    alone: Option<u64>,
}

/// What one caller has under way.
#[derive(Debug, Default)]
struct Party {
    /// For how long it has computed, as far as that counts against others \[ns\].
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

/// A place that computes. It is free when this goes.
#[derive(Debug)]
pub(super) struct Place {
    turns: Turns,
    who: Who,
    number: u64,
    /// When it was last looked whose turn it is.
    looked_ns: AtomicU64,
    /// Whether it is still to be given back.
    is_held: bool,
}

/// A place that nobody wanted, lent to a computation that can use more than one.
#[derive(Debug)]
pub(super) struct Lent<'a> {
    turns: &'a Turns,
    who: &'a Who,
}

/// As long as this lives, one computation is alone.
#[derive(Debug)]
pub(super) struct Alone {
    turns: Turns,
    number: u64,
}

/// Who waits for a place, until it has it or leaves.
struct Waiting<'a> {
    turns: &'a Turns,
    who: &'a Who,
    number: u64,
}

impl Turns {
    /// So many places.
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

    /// Most computations that have begun and not ended at so many places: so many threads are needed.
    pub(super) const fn most_begun(places: usize) -> usize {
        BEGUN_PER_PLACE * places
    }

    /// Waits for a place. Whoever leaves before it has one is forgotten.
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

    /// A place beside that of `who`, where nobody wants it.
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
        // What is held is whole at every moment, whoever panicked with it.
        let mut state = self.0.state.lock().unwrap_or_else(PoisonError::into_inner);
        state.count_until((self.0.clock)());
        state
    }

    /// Gives free places to those whose turn it is.
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

    /// The next of a caller computes: the one that rests longest, or else the one that waits longest.
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
            // Whoever leaves is taken out of the line first, under the lock that is held here.
            place.is_held = false;
            state.end(who);
        }
        true
    }

    /// A caller of whom nothing has begun does not wait for those who have had more than it: it begins beside them, and one of
    /// them gives way at its next look.
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

    /// Whether those who compute are to look closer.
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

    /// Counts the time of those who compute.
    fn count_until(&mut self, now_ns: u64) {
        let passed_ns = now_ns.saturating_sub(self.counted_ns);
        self.counted_ns = now_ns.max(self.counted_ns);
        for party in self.parties.values_mut().filter(|party| party.active > 0) {
            let times = u64::try_from(party.active).unwrap_or(u64::MAX);
            party.served_ns = party.served_ns.saturating_add(passed_ns.saturating_mul(times));
        }
    }

    /// One of a caller's computes no more.
    fn stand_down(&mut self, who: &Who) -> Option<&mut Party> {
        self.active = self.active.saturating_sub(1);
        let party = self.parties.get_mut(who)?;
        party.active = party.active.saturating_sub(1);
        Some(party)
    }

    /// One of a caller's has ended.
    fn end(&mut self, who: &Who) {
        self.begun = self.begun.saturating_sub(1);
        self.stand_down(who);
    }

    /// The party of a caller that has something under way from now on. Whoever was away has not saved up time: it begins with as
    /// much as those who were served least.
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

    /// The least time of those who have something under way.
    fn least_served(&self) -> Option<u64> {
        self.parties.values().filter(|party| !party.is_idle()).map(|party| party.served_ns).min()
    }

    /// Of those who want a place, the one that was served least; of those who were served alike, the one that came first.
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
    /// Whose it is.
    pub(super) fn who(&self) -> &Who {
        &self.who
    }

    /// Whether somebody else may have to compute first.
    pub(super) fn is_crowded(&self) -> bool {
        self.turns.0.crowded.load(Ordering::Relaxed)
    }

    /// Asked by a computation at every look at its stop, on the thread that has the place: where somebody else is to compute first,
    /// it rests here until its turn comes or `is_stopped`.
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

    /// Waits until nobody else computes, for `within` at most. None where somebody does all that time, or is alone already.
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

    /// Whether nobody else computes, and from now on nobody else begins.
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
            // Of those who were served alike, the one that has more places.
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
