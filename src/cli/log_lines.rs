//! Lines of the log on their way to standard error. Every request has a line. One system call for each line costs a
//! tenth of a small request. So lines are collected for a moment, and a thread writes them together.
//!
//! Warnings and errors are written at once, with all lines before them. A panic and the end of the process write all
//! lines. If lines come faster than they can be written, their writers wait. A killed process (SIGKILL) loses the lines
//! of the last 10 ms, except warnings and errors.

use std::io::{self, Write};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tracing::{Level, Metadata};
use tracing_subscriber::fmt::MakeWriter;

/// Time for which lines are collected.
const GATHERED_FOR: Duration = Duration::from_millis(10);
/// From this length on, the thread that adds a line also writes all lines \[bytes\].
const MOST_WAITING: usize = 1 << 20;

/// At most this much memory is kept after a write, for the next lines \[bytes\].
const MOST_KEPT: usize = 512 << 10;

/// Lines that wait. Clones share them.
#[derive(Debug)]
pub(super) struct LogLines<W>(Arc<Shared<W>>);

impl<W> Clone for LogLines<W> {
    fn clone(&self) -> Self {
        Self(Arc::clone(&self.0))
    }
}

#[derive(Debug)]
struct Shared<W> {
    waiting: Mutex<Vec<u8>>,
    /// The first line has come.
    begun: Condvar,
    /// The lock keeps the order: it is taken before the lines that are written with it.
    out: Mutex<Out<W>>,
}

/// Where lines are written, and memory for them.
#[derive(Debug)]
struct Out<W> {
    to: W,
    /// Empty between two writes. A write swaps it with the lines that wait, so that their memory is used again: new
    /// memory comes from the system page by page.
    spare: Vec<u8>,
}

/// Writes all lines when it is dropped.
#[derive(Debug)]
pub(super) struct WrittenAtEnd<W: Write + Send + 'static>(LogLines<W>);

impl<W: Write + Send + 'static> Drop for WrittenAtEnd<W> {
    fn drop(&mut self) {
        self.0.write_out();
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Only whole lines are added and taken.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<W: Write + Send + 'static> LogLines<W> {
    /// Lines for `out`, written by a thread of their own.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(super) fn new(out: W) -> io::Result<Self> {
        let lines = Self(Arc::new(Shared {
            waiting: Mutex::default(),
            begun: Condvar::new(),
            out: Mutex::new(Out { to: out, spare: Vec::new() }),
        }));
        let writer = lines.clone();
        std::thread::Builder::new().name("log".to_owned()).spawn(move || writer.keep_writing())?;
        Ok(lines)
    }

    /// A panic writes all lines, before it is reported.
    pub(super) fn written_before_panics(&self) {
        let (lines, before) = (self.clone(), std::panic::take_hook());
        std::panic::set_hook(Box::new(move |panic| {
            lines.write_out();
            before(panic);
        }));
    }

    /// Writes all lines at the end of the process.
    pub(super) fn written_at_end(&self) -> WrittenAtEnd<W> {
        WrittenAtEnd(self.clone())
    }

    fn keep_writing(&self) {
        loop {
            let waiting = locked(&self.0.waiting);
            drop(
                self.0
                    .begun
                    .wait_while(waiting, |waiting| waiting.is_empty())
                    .unwrap_or_else(PoisonError::into_inner),
            );
            std::thread::sleep(GATHERED_FOR);
            self.write_out();
        }
    }

    /// Writes all lines that wait.
    fn write_out(&self) {
        let mut out = locked(&self.0.out);
        let Out { to, spare } = &mut *out;
        std::mem::swap(spare, &mut *locked(&self.0.waiting));
        // A failed write cannot be reported anywhere.
        let _written = to.write_all(spare).and_then(|()| to.flush());
        spare.clear();
        spare.shrink_to(MOST_KEPT);
    }

    fn add(&self, line: &[u8]) {
        let mut waiting = locked(&self.0.waiting);
        if waiting.is_empty() {
            self.0.begun.notify_one();
        }
        waiting.extend_from_slice(line);
        let full = waiting.len() >= MOST_WAITING;
        drop(waiting);
        if full {
            self.write_out();
        }
    }
}

/// The writer of one line.
#[derive(Debug)]
pub(super) struct Line<'a, W: Write + Send + 'static> {
    lines: &'a LogLines<W>,
    at_once: bool,
}

impl<W: Write + Send + 'static> Write for Line<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.lines.add(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<W: Write + Send + 'static> Drop for Line<'_, W> {
    fn drop(&mut self) {
        if self.at_once {
            self.lines.write_out();
        }
    }
}

impl<'a, W: Write + Send + 'static> MakeWriter<'a> for LogLines<W> {
    type Writer = Line<'a, W>;

    fn make_writer(&'a self) -> Line<'a, W> {
        Line { lines: self, at_once: true }
    }

    fn make_writer_for(&'a self, event: &Metadata<'_>) -> Line<'a, W> {
        Line { lines: self, at_once: *event.level() <= Level::WARN }
    }
}

#[cfg(test)]
mod tests {
    use std::thread;

    use super::*;

    /// A file that can be read while it is written.
    #[derive(Debug, Clone, Default)]
    struct Paper(Arc<Mutex<Vec<u8>>>);

    impl Write for Paper {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            locked(&self.0).write(bytes)
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn no_line_is_lost_and_the_lines_of_a_thread_keep_their_order() {
        let paper = Paper::default();
        let lines = LogLines::new(paper.clone()).unwrap();
        let end = lines.written_at_end();
        thread::scope(|scope| {
            for thread in 0..4 {
                let lines = &lines;
                scope.spawn(move || {
                    for number in 0..20_000 {
                        let line = format!("{thread} {number} {:200}\n", "");
                        Line { lines, at_once: number % 997 == 0 }.write_all(line.as_bytes()).unwrap();
                    }
                });
            }
        });
        drop(end);
        let text = String::from_utf8(locked(&paper.0).clone()).unwrap();
        let mut next = [0; 4];
        for line in text.lines() {
            let mut words = line.split(' ').map(str::parse::<usize>);
            let (thread, number) = (words.next().unwrap().unwrap(), words.next().unwrap().unwrap());
            assert_eq!(next[thread], number);
            next[thread] += 1;
        }
        assert_eq!(next, [20_000; 4]);
    }

    #[test]
    fn a_line_is_written_soon_and_a_warning_at_once() {
        let paper = Paper::default();
        let lines = LogLines::new(paper.clone()).unwrap();
        Line { lines: &lines, at_once: false }.write_all(b"one\n").unwrap();
        Line { lines: &lines, at_once: true }.write_all(b"two\n").unwrap();
        assert_eq!(*locked(&paper.0), b"one\ntwo\n");
        Line { lines: &lines, at_once: false }.write_all(b"three\n").unwrap();
        while locked(&paper.0).len() < 14 {
            thread::yield_now();
        }
    }
}
