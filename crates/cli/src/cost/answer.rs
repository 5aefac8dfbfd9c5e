//! The budget solver's answer, in a sentence and on the page.

use super::budget::{Answer, Candidate, Lack, Use};
use super::short;
use crate::report::{Section, Table};

/// What to take, what it leaves over, and what a better preset lacks; or what is missing for any.
#[must_use]
pub fn sentence(answer: &Answer) -> String {
    let Some((preset, used)) = answer.preset.as_ref().zip(answer.used.as_ref()) else {
        return match &answer.binds {
            Some(lack) => format!(
                "nothing fits; the least demanding preset, `{}`, {}",
                lack.preset,
                lacking(lack)
            ),
            None => "nothing fits: there is no preset".to_owned(),
        };
    };
    let next = match &answer.binds {
        Some(lack) => format!(
            "what binds: the next better preset, `{}`, {}",
            lack.preset,
            lacking(lack)
        ),
        None => "nothing binds".to_owned(),
    };
    format!(
        "preset `{}`: RMSE {:.2} expected, {} samples/s, N = {}; {}; {next}",
        preset.preset,
        preset.rmse,
        short(preset.rate),
        short(preset.samples),
        uses(answer, preset, used),
    )
}

/// How much of each budget goes.
fn uses(answer: &Answer, preset: &Candidate, used: &Use) -> String {
    let time = match (preset.mean, preset.worst) {
        (Some(mean), Some(worst)) if answer.budget.core.is_some() => format!(
            "the dearest refresh takes {:.2} million instructions (a mean one {:.2}) of {:.2}, {:.0} %",
            1e-6 * worst.total(),
            1e-6 * mean.total(),
            1e-6 * answer.budget.instructions(),
            100.0 * used.time.unwrap_or(f64::NAN)
        ),
        _ => format!(
            "it takes {:.0} % of a core here",
            100.0 * used.time.unwrap_or(f64::NAN)
        ),
    };
    format!(
        "{time}; {:.0} kB/s, {:.0} % of the link; {} bytes of RAM, {:.0} %",
        1e-3 * preset.bytes_per_second,
        100.0 * used.link,
        preset.ram_bytes,
        100.0 * used.ram
    )
}

fn lacking(lack: &Lack) -> String {
    let mut text = format!("needs {}", lack.of.join(", "));
    let mut fits = Vec::new();
    if let Some((width, height)) = lack.panel {
        fits.push(format!("on {width}x{height} pixels"));
    }
    if let Some(refresh) = lack.refresh {
        fits.push(format!("at {refresh} Hz"));
    }
    if !fits.is_empty() {
        text += &format!("; it would fit {}", fits.join(", or "));
    }
    text
}

/// A paragraph and a table for each budget.
#[must_use]
pub fn section(answers: &[Answer]) -> Section {
    let mut section = Section::new("Budgets");
    for answer in answers {
        let b = &answer.budget;
        let core = match b.core {
            Some(core) => format!(
                "{} at {:.0} MHz, {} cycles an instruction",
                core.name(),
                b.hertz / 1e6,
                b.cpi
            ),
            None => "One core of this machine".to_owned(),
        };
        section.paragraph(&format!(
            "{core}, link {:.1} Mbit/s, RAM {:.0} kB, {}x{} at {} Hz: {}.",
            b.link / 1e6,
            b.ram / 1e3,
            b.width,
            b.height,
            b.refresh,
            sentence(answer)
        ));
        let heads = [
            "preset",
            "RMSE",
            "million instructions, mean",
            "dearest",
            "time, %",
            "kB/s",
            "link, %",
            "RAM, bytes",
            "RAM, %",
            "",
        ];
        let mut table = Table::new(heads);
        for (candidate, used) in &answer.all {
            let share = |v: f64| format!("{:.0}", 100.0 * v);
            let million = |effort: Option<super::effort::Effort>| {
                effort.map_or_else(|| "–".to_owned(), |e| format!("{:.2}", 1e-6 * e.total()))
            };
            table.row([
                candidate.preset.to_owned(),
                format!("{:.2}", candidate.rmse),
                million(candidate.mean),
                million(candidate.worst),
                used.time.map_or_else(|| "–".to_owned(), share),
                format!("{:.0}", candidate.bytes_per_second / 1e3),
                share(used.link),
                candidate.ram_bytes.to_string(),
                share(used.ram),
                if used.fits() { "✓ fits" } else { "✗" }.to_owned(),
            ]);
        }
        section.table(&table);
    }
    section.paragraph(
        "Instructions are predicted from the work of this panel's own refreshes, counted here, and \
         from what each piece of work takes on the emulated core; both while everything that moves \
         in the scenes moves. A view at rest costs far less. Emulators count instructions, not \
         cycles: say cpi= in the budget where you know better than one cycle an instruction. RAM is \
         the static storage and 16 KiB of stack; RMSE is that of the report's panel.",
    );
    section
}
