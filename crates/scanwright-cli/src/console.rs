//! What the user sees while a run goes on, how long each stage took, and Ctrl-C.

use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use scanwright::par;
use scanwright::progress::Stage;

use crate::exit::{Code, Failure};

/// Progress bars on a terminal, and a clock per stage.
pub struct Console {
    quiet: bool,
    bar: ProgressBar,
    clock: Mutex<Clock>,
}

struct Clock {
    started: Instant,
    last: Instant,
    stages: Vec<(Stage, Duration)>,
    shown: Option<Stage>,
}

/// Runs `work` on so many threads with a console that shows how far it is, and Ctrl-C that stops it.
pub fn watched<T: Send>(quiet: bool, threads: Option<usize>, work: impl FnOnce(&Console) -> T + Send) -> T {
    handle_interrupts();
    let console = Console::new(quiet);
    let outcome = par::with_threads(threads, || work(&console));
    console.finish();
    outcome
}

impl Console {
    /// A console; `quiet` hides all but errors.
    pub fn new(quiet: bool) -> Self {
        let visible = !quiet && std::io::stderr().is_terminal();
        let target = if visible { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let style = ProgressStyle::with_template("{msg:10} {bar:30} {percent:>3} %  {elapsed}");
        let bar = ProgressBar::with_draw_target(Some(1000), target)
            .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        if visible {
            bar.enable_steady_tick(Duration::from_millis(200));
        }
        let now = Instant::now();
        let clock = Clock { started: now, last: now, stages: Vec::new(), shown: None };
        Self { quiet, bar, clock: Mutex::new(clock) }
    }

    /// Notes that `stage` is `fraction` done; the time since the last note is its. Returns whether to go on.
    pub fn note(&self, stage: Stage, fraction: f64) -> bool {
        let mut clock = self.clock();
        let now = Instant::now();
        let spent = now - clock.last;
        clock.last = now;
        match clock.stages.iter_mut().find(|(s, _)| *s == stage) {
            Some((_, total)) => *total += spent,
            None => clock.stages.push((stage, spent)),
        }
        if clock.shown != Some(stage) {
            clock.shown = Some(stage);
            self.bar.set_message(stage.name());
        }
        self.bar.set_position((1000.0 * fraction.clamp(0.0, 1.0)) as u64);
        !cancelled()
    }

    /// Seconds of every stage so far, in order, and of the whole run.
    pub fn timings(&self) -> (Vec<(&'static str, f64)>, f64) {
        let clock = self.clock();
        let stages = clock.stages.iter().map(|(stage, time)| (stage.name(), time.as_secs_f64())).collect();
        (stages, clock.started.elapsed().as_secs_f64())
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    /// A line for people, on stderr.
    pub fn log(&self, line: &str) {
        if !self.quiet {
            self.bar.suspend(|| eprintln!("{line}"));
        }
    }

    fn clock(&self) -> MutexGuard<'_, Clock> {
        self.clock.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

static CANCELLED: AtomicBool = AtomicBool::new(false);
static WRITING: Mutex<bool> = Mutex::new(false);

/// From here on Ctrl-C ends the process with nothing left behind: at once while nothing is on disk, after the
/// temporary files are gone while outputs are being written.
pub fn handle_interrupts() {
    static INSTALLED: OnceLock<()> = OnceLock::new();
    INSTALLED.get_or_init(|| {
        // Without a handler the system's own takes effect, which may leave a temporary file: no reason to refuse.
        let _ = ctrlc::set_handler(|| {
            CANCELLED.store(true, Ordering::SeqCst);
            let writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
            if !*writing {
                eprintln!("\nscanwright: {}", Failure::Cancelled);
                std::process::exit(Code::Cancelled as i32);
            }
        });
    });
}

/// Whether Ctrl-C was pressed.
pub fn cancelled() -> bool {
    CANCELLED.load(Ordering::SeqCst)
}

/// Announces that files are about to be written: from now on Ctrl-C only sets [`cancelled`].
pub fn begin_writing() -> Result<(), Failure> {
    let mut writing = WRITING.lock().unwrap_or_else(PoisonError::into_inner);
    *writing = true;
    if cancelled() { Err(Failure::Cancelled) } else { Ok(()) }
}
