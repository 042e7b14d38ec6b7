//! The calls of the C library that change files, taken by this executable in place of the library's own: the standard
//! library and the `SQLite` that is linked into it both come through here. What is not below the recorded folder, or
//! comes while nothing is recorded, goes straight on.
//!
//! Two more are taken: the clock that never goes back stands still while a run is recorded, so that no timer ends but
//! when the scheduler lets time pass; random bytes come from the seed.

#![expect(unsafe_code, reason = "symbols of the C library are defined and called here, and nowhere else")]

use std::ffi::{CStr, CString, c_char, c_int, c_long, c_uint, c_void};
use std::slice;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::recorder::{self, CALLBACK_PORT, Verdict, is_on, receiver_port, recorder, standing_ns};
use crate::world::BEGINS_S;

/// `RTLD_NEXT` of Linux.
const NEXT: *mut c_void = -1_isize as *mut c_void;
const SEEK_CUR: c_int = 1;
/// Flags of `open` on Linux.
const O_CREAT: c_int = 0o100;
const O_TRUNC: c_int = 0o1000;
const CLOCK_MONOTONIC: c_int = 1;
const AF_INET: u16 = 2;

unsafe extern "C" {
    fn dlsym(handle: *mut c_void, symbol: *const c_char) -> *mut c_void;
    fn __errno_location() -> *mut c_int;
    fn lseek64(file: c_int, offset: i64, whence: c_int) -> i64;
}

#[repr(C)]
pub(crate) struct Slice {
    base: *const c_void,
    length: usize,
}

#[repr(C)]
pub(crate) struct Time {
    seconds: i64,
    nanoseconds: c_long,
}

#[repr(C)]
#[derive(Clone, Copy)]
struct Address {
    family: u16,
    port: [u8; 2],
    host: [u8; 4],
    zero: [u8; 8],
}

/// The library's own function of this name.
fn next(cell: &AtomicUsize, name: &CStr) -> usize {
    let known = cell.load(Ordering::Relaxed);
    if known != 0 {
        return known;
    }
    // SAFETY: the name ends with a zero byte, and the handle is the constant that Linux names.
    let found = unsafe { dlsym(NEXT, name.as_ptr()) } as usize;
    cell.store(found, Ordering::Relaxed);
    found
}

/// The library's own function, called.
macro_rules! real {
    ($name:literal, fn($($kind:ty),*) -> $result:ty, $($argument:expr),*) => {{
        static CELL: AtomicUsize = AtomicUsize::new(0);
        let found = next(&CELL, $name);
        // SAFETY: the C library declares the function of this name with these types.
        unsafe {
            let function: unsafe extern "C" fn($($kind),*) -> $result = std::mem::transmute(found);
            function($($argument),*)
        }
    }};
}

fn fail(errno: c_int) {
    // SAFETY: the library gives a valid place of this thread's own.
    unsafe { *__errno_location() = errno };
}

fn text(path: *const c_char) -> Option<String> {
    // SAFETY: callers of the C library hand over a text that ends with a zero byte.
    unsafe { CStr::from_ptr(path) }.to_str().ok().map(str::to_owned)
}

/// The clock that never goes back, as it is \[ns\].
pub(crate) fn real_monotonic_ns() -> i64 {
    let mut now = Time { seconds: 0, nanoseconds: 0 };
    real!(c"clock_gettime", fn(c_int, *mut Time) -> c_int, CLOCK_MONOTONIC, &raw mut now);
    now.seconds * 1_000_000_000 + now.nanoseconds
}

fn open_with(path: *const c_char, flags: c_int, open: impl FnOnce() -> c_int) -> c_int {
    if !is_on() {
        return open();
    }
    let mut held = recorder();
    let Some((recorder, below)) = held.as_mut().zip(text(path)).and_then(|(recorder, path)| {
        let below = recorder.below(&path)?;
        Some((recorder, below))
    }) else {
        drop(held);
        return open();
    };
    let makes = flags & O_CREAT != 0 && !recorder.is_there(&below);
    if makes && let Verdict::Fails(errno) = recorder.making() {
        fail(errno);
        return -1;
    }
    let file = open();
    if file >= 0 {
        recorder.opened(file, &below, flags & O_TRUNC != 0);
    }
    file
}

/// Where `SQLite` draws its random bytes from while a run is recorded.
fn seeded_instead_of(path: *const c_char) -> Option<CString> {
    // SAFETY: callers of the C library hand over a text that ends with a zero byte.
    let asked = unsafe { CStr::from_ptr(path) };
    if asked != c"/dev/urandom" {
        return None;
    }
    recorder().as_ref().and_then(|recorder| CString::new(recorder.random_file()).ok())
}

#[unsafe(no_mangle)]
extern "C" fn open(path: *const c_char, flags: c_int, mode: c_uint) -> c_int {
    let seeded = is_on().then(|| seeded_instead_of(path)).flatten();
    let path = seeded.as_ref().map_or(path, |seeded| seeded.as_ptr());
    open_with(path, flags, || real!(c"open", fn(*const c_char, c_int, c_uint) -> c_int, path, flags, mode))
}

#[unsafe(no_mangle)]
extern "C" fn open64(path: *const c_char, flags: c_int, mode: c_uint) -> c_int {
    let seeded = is_on().then(|| seeded_instead_of(path)).flatten();
    let path = seeded.as_ref().map_or(path, |seeded| seeded.as_ptr());
    open_with(path, flags, || real!(c"open64", fn(*const c_char, c_int, c_uint) -> c_int, path, flags, mode))
}

#[unsafe(no_mangle)]
extern "C" fn close(file: c_int) -> c_int {
    let really = || real!(c"close", fn(c_int) -> c_int, file);
    if !is_on() {
        return really();
    }
    let mut held = recorder();
    if let Some(recorder) = held.as_mut() {
        recorder.closing(file);
    }
    // Within the lock: the number may be given to another file as soon as it is free.
    really()
}

/// Writes as far as the disk lets it; `write` is given how many bytes.
fn write_with(
    file: c_int,
    from: *const c_void,
    bytes: usize,
    at: Option<i64>,
    write: impl Fn(usize) -> isize,
) -> isize {
    if !is_on() {
        return write(bytes);
    }
    let mut held = recorder();
    let Some(recorder) = held.as_mut().filter(|recorder| recorder.node(file).is_some()) else {
        drop(held);
        return write(bytes);
    };
    // SAFETY: a seek by nothing changes nothing.
    let at = at.unwrap_or_else(|| unsafe { lseek64(file, 0, SEEK_CUR) });
    let (allowed, errno) = match recorder.writing(bytes) {
        Verdict::Well => (bytes, None),
        Verdict::Part(part) => (part, None),
        Verdict::BreaksOff(part, errno) => (part, Some(errno)),
        Verdict::Fails(errno) => (0, Some(errno)),
    };
    let written = if allowed == 0 && bytes > 0 { 0 } else { write(allowed) };
    if let Ok(count) = usize::try_from(written)
        && count > 0
    {
        // SAFETY: the library has just read these bytes from the same place.
        let bytes = unsafe { slice::from_raw_parts(from.cast::<u8>(), count) };
        recorder.wrote(file, u64::try_from(at).unwrap_or(0), bytes);
    }
    match errno {
        Some(errno) => {
            fail(errno);
            -1
        }
        None => written,
    }
}

#[unsafe(no_mangle)]
extern "C" fn write(file: c_int, from: *const c_void, bytes: usize) -> isize {
    write_with(file, from, bytes, None, |allowed| {
        real!(c"write", fn(c_int, *const c_void, usize) -> isize, file, from, allowed)
    })
}

#[unsafe(no_mangle)]
extern "C" fn writev(file: c_int, from: *const Slice, count: c_int) -> isize {
    if is_on() && recorder().as_ref().is_some_and(|recorder| recorder.node(file).is_some()) {
        // One part after the other; that only the first is taken is what the call allows.
        let parts = usize::try_from(count).unwrap_or(0);
        // SAFETY: the caller hands over so many parts.
        let parts = unsafe { slice::from_raw_parts(from, parts) };
        return parts
            .iter()
            .find(|part| part.length > 0)
            .map_or(0, |part| write(file, part.base, part.length));
    }
    real!(c"writev", fn(c_int, *const Slice, c_int) -> isize, file, from, count)
}

#[unsafe(no_mangle)]
extern "C" fn pwrite64(file: c_int, from: *const c_void, bytes: usize, at: i64) -> isize {
    write_with(file, from, bytes, Some(at), |allowed| {
        real!(c"pwrite64", fn(c_int, *const c_void, usize, i64) -> isize, file, from, allowed, at)
    })
}

#[unsafe(no_mangle)]
extern "C" fn pwrite(file: c_int, from: *const c_void, bytes: usize, at: i64) -> isize {
    pwrite64(file, from, bytes, at)
}

/// Cuts or extends a file, where it is recorded.
fn cut_with(file: c_int, length: i64, cut: impl FnOnce() -> c_int) -> c_int {
    if !is_on() {
        return cut();
    }
    let mut held = recorder();
    let Some(recorder) = held.as_mut().filter(|recorder| recorder.node(file).is_some()) else {
        drop(held);
        return cut();
    };
    if let Verdict::Fails(errno) = recorder.making() {
        fail(errno);
        return -1;
    }
    let done = cut();
    if done == 0 {
        recorder.cut(file, u64::try_from(length).unwrap_or(0));
    }
    done
}

#[unsafe(no_mangle)]
extern "C" fn ftruncate64(file: c_int, length: i64) -> c_int {
    cut_with(file, length, || real!(c"ftruncate64", fn(c_int, i64) -> c_int, file, length))
}

#[unsafe(no_mangle)]
extern "C" fn ftruncate(file: c_int, length: i64) -> c_int {
    cut_with(file, length, || real!(c"ftruncate", fn(c_int, i64) -> c_int, file, length))
}

/// Synchronises, where it is recorded: memory stands in for the disk, so that nothing is asked of the system.
fn sync_with(file: c_int, sync: impl FnOnce() -> c_int) -> c_int {
    if !is_on() {
        return sync();
    }
    let mut held = recorder();
    let Some(recorder) = held.as_mut().filter(|recorder| recorder.node(file).is_some()) else {
        drop(held);
        return sync();
    };
    let verdict = recorder.synchronising();
    recorder.synchronised(file, verdict == Verdict::Well);
    if let Verdict::Fails(errno) = verdict {
        fail(errno);
        return -1;
    }
    0
}

#[unsafe(no_mangle)]
extern "C" fn fsync(file: c_int) -> c_int {
    sync_with(file, || real!(c"fsync", fn(c_int) -> c_int, file))
}

#[unsafe(no_mangle)]
extern "C" fn fdatasync(file: c_int) -> c_int {
    sync_with(file, || real!(c"fdatasync", fn(c_int) -> c_int, file))
}

/// Does something to a name, and tells the recorder where it was done.
fn name_with(
    path: *const c_char,
    makes: bool,
    act: impl FnOnce() -> c_int,
    tell: impl FnOnce(&mut recorder::Recorder, &str),
) -> c_int {
    if !is_on() {
        return act();
    }
    let mut held = recorder();
    let Some((recorder, below)) = held.as_mut().zip(text(path)).and_then(|(recorder, path)| {
        let below = recorder.below(&path)?;
        Some((recorder, below))
    }) else {
        drop(held);
        return act();
    };
    if makes
        && !recorder.is_there(&below)
        && let Verdict::Fails(errno) = recorder.making()
    {
        fail(errno);
        return -1;
    }
    let done = act();
    if done == 0 {
        tell(recorder, &below);
    }
    done
}

#[unsafe(no_mangle)]
extern "C" fn mkdir(path: *const c_char, mode: c_uint) -> c_int {
    let act = || real!(c"mkdir", fn(*const c_char, c_uint) -> c_int, path, mode);
    name_with(path, true, act, recorder::Recorder::made)
}

#[unsafe(no_mangle)]
extern "C" fn unlink(path: *const c_char) -> c_int {
    let act = || real!(c"unlink", fn(*const c_char) -> c_int, path);
    name_with(path, false, act, recorder::Recorder::removed)
}

#[unsafe(no_mangle)]
extern "C" fn rmdir(path: *const c_char) -> c_int {
    let act = || real!(c"rmdir", fn(*const c_char) -> c_int, path);
    name_with(path, false, act, recorder::Recorder::removed)
}

#[unsafe(no_mangle)]
extern "C" fn rename(from: *const c_char, to: *const c_char) -> c_int {
    let act = || real!(c"rename", fn(*const c_char, *const c_char) -> c_int, from, to);
    let target = text(to);
    name_with(from, false, act, |recorder, from| {
        if let Some(to) = target.and_then(|to| recorder.below(&to)) {
            recorder.renamed(from, &to);
        }
    })
}

#[unsafe(no_mangle)]
extern "C" fn clock_gettime(clock: c_int, into: *mut Time) -> c_int {
    if clock == CLOCK_MONOTONIC
        && let Some(now) = standing_ns()
    {
        let time = Time { seconds: now / 1_000_000_000, nanoseconds: now % 1_000_000_000 };
        // SAFETY: the caller gives a place for a time.
        unsafe { *into = time };
        return 0;
    }
    real!(c"clock_gettime", fn(c_int, *mut Time) -> c_int, clock, into)
}

/// `SQLite` and nobody else asks for the wall clock so: it stands still while a run is recorded.
#[unsafe(no_mangle)]
extern "C" fn gettimeofday(into: *mut Time, zone: *mut c_void) -> c_int {
    if is_on() {
        // SAFETY: the caller gives a place for a time.
        unsafe { *into = Time { seconds: BEGINS_S, nanoseconds: 0 } };
        return 0;
    }
    real!(c"gettimeofday", fn(*mut Time, *mut c_void) -> c_int, into, zone)
}

#[unsafe(no_mangle)]
extern "C" fn getrandom(into: *mut c_void, bytes: usize, flags: c_uint) -> isize {
    if is_on() {
        let mut held = recorder();
        if let Some(recorder) = held.as_mut() {
            // SAFETY: the caller gives a place for so many bytes.
            recorder.random(unsafe { slice::from_raw_parts_mut(into.cast::<u8>(), bytes) });
            return isize::try_from(bytes).unwrap_or(isize::MAX);
        }
    }
    real!(c"getrandom", fn(*mut c_void, usize, c_uint) -> isize, into, bytes, flags)
}

#[unsafe(no_mangle)]
extern "C" fn connect(socket: c_int, to: *const c_void, length: c_uint) -> c_int {
    let mut led = None;
    if is_on()
        && length as usize >= size_of::<Address>()
        && let Some(port) = receiver_port()
    {
        // SAFETY: the caller gives an address of this length, and those of this family look so.
        let address = unsafe { to.cast::<Address>().read_unaligned() };
        if address.family == AF_INET && u16::from_be_bytes(address.port) == CALLBACK_PORT {
            led = Some(Address { port: port.to_be_bytes(), ..address });
        }
    }
    let to = led.as_ref().map_or(to, |address| (&raw const *address).cast());
    real!(c"connect", fn(c_int, *const c_void, c_uint) -> c_int, socket, to, length)
}

unsafe extern "C" {
    /// Of the `SQLite` that is linked in: asked for nothing, it draws a new seed when it next needs random bytes.
    fn sqlite3_randomness(bytes: c_int, into: *mut c_void);
    /// Sets it up, before its first use.
    fn sqlite3_config(option: c_int, ...) -> c_int;
}

/// `SQLITE_CONFIG_MEMSTATUS`.
const COUNTS_MEMORY: c_int = 9;

/// `SQLite` does not count its memory: the count has one lock, for which the threads of all points would wait.
pub(crate) fn sqlite_counts_no_memory() {
    // SAFETY: the option takes one number. Used later, it changes nothing and says so.
    let said = unsafe { sqlite3_config(COUNTS_MEMORY, 0 as c_int) };
    assert_eq!(said, 0, "SQLite is in use already");
}

/// `SQLite` draws its random bytes anew, from the seed of the run.
pub(crate) fn forget_randomness_of_sqlite() {
    // SAFETY: asked for nothing it writes nothing.
    unsafe { sqlite3_randomness(0, std::ptr::null_mut()) };
}
