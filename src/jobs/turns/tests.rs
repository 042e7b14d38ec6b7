//! Turns by a clock of the tests' own.

use std::sync::atomic::AtomicU64;

use futures::FutureExt;

use super::*;

fn key(name: &str) -> Who {
    Who::Key(name.into())
}

const MS_NS: u64 = 1_000_000;

/// Numbers of computing and of begun computations.
fn under_way(turns: &Turns) -> (usize, usize) {
    let state = turns.state();
    (state.active, state.begun)
}

/// Places, and the clock they go by \[ns\].
fn turns(places: usize) -> (Turns, Arc<AtomicU64>) {
    let clock = Arc::new(AtomicU64::new(0));
    let told = Arc::clone(&clock);
    (Turns::with_clock(places, move || told.load(Ordering::SeqCst)), clock)
}

/// A place that is free.
fn at_once(turns: &Turns, who: &Who) -> Place {
    turns.take(who).now_or_never().expect("a free place").expect("a place")
}

#[test]
fn one_alone_has_every_place_and_others_are_served_in_turn() {
    let (turns, clock) = turns(2);
    let (greedy, one, other) = (key("greedy"), key("one"), key("other"));
    let places = [at_once(&turns, &greedy), at_once(&turns, &greedy)];
    assert!(turns.lend(&greedy).is_none());
    let mut third = Box::pin(turns.take(&greedy));
    assert!(third.as_mut().now_or_never().is_none());
    clock.fetch_add(100 * MS_NS, Ordering::SeqCst);
    // A caller without a computation begins at once, beside the callers that have two places.
    let first = at_once(&turns, &one);
    assert!(places.iter().all(|place| place.must_give_way(&turns.state())));
    assert!(!first.must_give_way(&turns.state()));
    let second = at_once(&turns, &other);
    // The places of these two go to the one that waits when they have ended.
    drop((first, second));
    assert!(third.as_mut().now_or_never().is_none());
    drop(places);
    assert!(third.now_or_never().is_some());
}

#[test]
fn a_computation_of_whom_was_served_more_rests_until_the_other_has_ended() {
    let (turns, clock) = turns(1);
    let long = at_once(&turns, &key("long"));
    let who = key("short");
    let mut short = Box::pin(turns.take(&who));
    assert!(short.as_mut().now_or_never().is_none(), "both have had nothing");
    std::thread::scope(|scope| {
        let worked = scope.spawn(|| {
            // Looks at its stop until the other has had its turn.
            while clock.load(Ordering::SeqCst) < 1000 * MS_NS {
                clock.fetch_add(MS_NS, Ordering::SeqCst);
                long.give_way(|| false);
            }
        });
        let place = loop {
            if let Some(place) = short.as_mut().now_or_never() {
                break place.expect("a place");
            }
            std::thread::yield_now();
        };
        // The long one rests: time stands still, and it is not before the end.
        let then_ns = clock.load(Ordering::SeqCst);
        assert!(then_ns <= SLICE_NS + 3 * MS_NS, "{then_ns}");
        std::thread::sleep(3 * REST_LOOK);
        assert_eq!(clock.load(Ordering::SeqCst), then_ns);
        drop(place);
        worked.join().expect("the long one goes on");
    });
    assert_eq!(turns.state().active, 1);
    drop(long);
    let state = turns.state();
    assert_eq!((state.active, state.begun, state.woken.len()), (0, 0, 0));
    assert!(!turns.0.crowded.load(Ordering::SeqCst));
}

#[test]
fn whoever_rests_and_is_stopped_ends() {
    let (turns, clock) = turns(1);
    let long = at_once(&turns, &key("long"));
    clock.fetch_add(100 * MS_NS, Ordering::SeqCst);
    let place = turns.take(&key("short")).now_or_never();
    assert!(place.is_none(), "the long one has not looked yet");
    drop(place);
    // Nobody waits any more, so there is nothing to give way to.
    long.give_way(|| panic!("it rests"));
    let other = key("other");
    let mut waits = Box::pin(turns.take(&other));
    assert!(waits.as_mut().now_or_never().is_none());
    clock.fetch_add(100 * MS_NS, Ordering::SeqCst);
    // The other computes, and this one is told to stop.
    long.give_way(|| true);
    let runs = waits.now_or_never().expect("a place");
    assert_eq!(turns.state().active, 2);
    drop((runs, long));
    assert_eq!(under_way(&turns), (0, 0));
}

#[test]
fn a_caller_that_was_away_has_not_saved_up_time_and_one_that_comes_and_goes_has_not_lost_it() {
    let (turns, clock) = turns(1);
    let (steady, coming) = (key("steady"), key("coming"));
    let long = at_once(&turns, &steady);
    clock.fetch_add(500 * MS_NS, Ordering::SeqCst);
    let mut waits = Box::pin(turns.take(&coming));
    assert!(waits.as_mut().now_or_never().is_none());
    let served = |who: &Who| turns.state().parties.get(who).map_or(0, |party| party.served_ns / MS_NS);
    assert_eq!((served(&steady), served(&coming)), (500, 500));
    drop(waits);
    // Short works one after the other count together, as long as somebody else is there.
    for _ in 0..3 {
        turns.state().arrive(&coming).active += 1;
        clock.fetch_add(100 * MS_NS, Ordering::SeqCst);
        turns.state().arrive(&coming).active -= 1;
    }
    assert_eq!((served(&steady), served(&coming)), (800, 800));
    drop(long);
    // Nobody is remembered once all is quiet.
    drop(at_once(&turns, &key("last")));
    assert_eq!(turns.state().parties.len(), 1);
}

#[test]
fn of_many_callers_each_has_as_much_time_as_another() {
    let (turns, clock) = turns(1);
    let callers: Vec<Who> = ["greedy", "a", "b", "c"].map(key).into();
    let mut had_ms = [0_u64; 4];
    let first = key("first");
    let place = at_once(&turns, &first);
    let mut waiting: Vec<_> = callers.iter().map(|who| Some(Box::pin(turns.take(who)))).collect();
    for one in waiting.iter_mut().flatten() {
        assert!(one.as_mut().now_or_never().is_none());
    }
    drop(place);
    for _ in 0..400 {
        let next = waiting.iter_mut().enumerate().find_map(|(at, one)| {
            let place = one.as_mut()?.as_mut().now_or_never()??;
            Some((at, place))
        });
        let (at, place) = next.expect("somebody's turn");
        // The greedy one's works are longer.
        let ms = if at == 0 { 50 } else { 10 };
        clock.fetch_add(ms * MS_NS, Ordering::SeqCst);
        had_ms[at] += ms;
        waiting[at] = None;
        let again = callers.get(at).map(|who| Box::pin(turns.take(who)));
        waiting[at] = again;
        if let Some(one) = waiting[at].as_mut() {
            assert!(one.as_mut().now_or_never().is_none());
        }
        drop(place);
    }
    let (most, least) = (had_ms.iter().max().unwrap(), had_ms.iter().min().unwrap());
    assert!(most - least <= 60, "{had_ms:?}");
}

#[tokio::test]
async fn one_that_is_to_be_alone_waits_for_the_others_to_rest_and_lets_them_go_on() {
    let turns = Turns::new(2);
    let (one, other) = (turns.take(&key("one")).await.unwrap(), turns.take(&key("other")).await.unwrap());
    // The wait for a computation that does not check its stop is short.
    assert!(one.alone(Duration::from_millis(10)).await.is_none());
    assert!(turns.state().alone.is_none());
    let over = Arc::new(AtomicBool::new(false));
    let told = Arc::clone(&over);
    let works = std::thread::spawn(move || {
        while !told.load(Ordering::SeqCst) {
            other.give_way(|| false);
        }
    });
    let alone = one.alone(Duration::from_secs(30)).await.expect("alone");
    assert_eq!(turns.state().active, 1);
    let newcomer = turns.clone();
    let mut waits = Box::pin(async move { newcomer.take(&key("newcomer")).await });
    assert!(waits.as_mut().now_or_never().is_none(), "somebody is alone");
    assert!(one.alone(Duration::ZERO).await.is_none(), "it is alone already");
    over.store(true, Ordering::SeqCst);
    drop(alone);
    drop(waits.await.expect("a place"));
    works.join().unwrap();
    drop(one);
    assert_eq!(under_way(&turns), (0, 0));
}
