//! Time that a piece of work took on its thread's core, whatever else the machine was doing.

/// A stopwatch of this thread's own time.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(f64);

impl Stopwatch {
    /// Starts.
    #[must_use]
    pub fn start() -> Self {
        Self(now())
    }

    /// Seconds of this thread's work since the start; waiting and other threads do not count.
    #[must_use]
    pub fn seconds(self) -> f64 {
        now() - self.0
    }
}

#[cfg(unix)]
fn now() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Elsewhere the time that passed: the machine should do nothing else.
#[cfg(not(unix))]
fn now() -> f64 {
    static BEGIN: std::sync::OnceLock<std::time::Instant> = std::sync::OnceLock::new();
    BEGIN
        .get_or_init(std::time::Instant::now)
        .elapsed()
        .as_secs_f64()
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn work_counts_and_waiting_does_not() {
        let watch = Stopwatch::start();
        std::thread::sleep(std::time::Duration::from_millis(30));
        let waited = watch.seconds();
        assert!(waited < 0.02, "{waited}");
        let mut sum = 0u64;
        while watch.seconds() < waited + 0.005 {
            sum = std::hint::black_box(sum + 1);
        }
        assert!(sum > 0);
    }
}
