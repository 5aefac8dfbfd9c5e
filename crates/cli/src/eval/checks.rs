//! What must be shown, as rows that hold or do not.

use super::methods::EvalMethod;
use super::page::short;
use super::probes::{RECOVERED, STILL_SECONDS};
use super::store::slug;
use super::table::{Found, OVERHEAD_LIMIT};

/// Whether a claim holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It does.
    Holds,
    /// It does not.
    Fails,
    /// It does not, but was hoped for and not promised.
    Missed,
}

/// A claim and what was found.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// The scene, short.
    pub scene: String,
    /// What is claimed.
    pub claim: String,
    /// What was found, with the limit.
    pub found: String,
    /// Whether it holds.
    pub outcome: Outcome,
}

impl Check {
    /// For readers.
    #[must_use]
    pub fn mark(&self) -> &'static str {
        match self.outcome {
            Outcome::Holds => "✓ holds",
            Outcome::Fails => "✗ DOES NOT HOLD",
            Outcome::Missed => "– not reached (hoped for)",
        }
    }
}

fn check(scene: &str, claim: String, found: String, holds: bool) -> Check {
    Check {
        scene: slug(scene),
        claim,
        found,
        outcome: if holds {
            Outcome::Holds
        } else {
            Outcome::Fails
        },
    }
}

/// All claims of which the numbers were measured.
#[must_use]
pub fn checks(found: &Found) -> Vec<Check> {
    let mut checks = Vec::new();
    for v in &found.verdicts {
        let claim = format!("adaptive {} / {}", short(v.rate), v.against);
        let text = format!("{:.3} (at most {:.2})", v.ratio, v.limit);
        let mut row = check(&v.scene, claim, text, v.holds);
        if !v.holds && v.moonshot {
            row.outcome = Outcome::Missed;
        }
        checks.push(row);
    }
    for v in found.verdicts.iter().filter(|v| !v.moonshot) {
        if v.flip_ratio.is_none() && v.cvvdp_gain.is_none() {
            continue;
        }
        let flip = v.flip_ratio.map(|ratio| format!("FLIP × {ratio:.2}"));
        let jod = v.cvvdp_gain.map(|gain| format!("{gain:+.2} JOD"));
        let text: Vec<String> = flip.into_iter().chain(jod).collect();
        let claim = format!("same rank by eye: {} {}", v.against, short(v.rate));
        checks.push(check(&v.scene, claim, text.join(", "), v.metrics_agree));
    }
    for row in &found.rows {
        if let Some(overhead) = row.overhead
            && row.method == EvalMethod::Adaptive.name()
            && row.rate == 400_000
        {
            let text = format!(
                "{:.1} % (at most {:.0})",
                100.0 * overhead,
                100.0 * OVERHEAD_LIMIT
            );
            let claim = "control's share of host time at 400k".to_owned();
            checks.push(check(&row.scene, claim, text, overhead <= OVERHEAD_LIMIT));
        }
    }
    let adaptive = EvalMethod::Adaptive.name();
    for still in found.stills.iter().filter(|s| s.method == adaptive) {
        let claim = format!(
            "RMSE falls within {STILL_SECONDS} s at {}",
            short(still.rate)
        );
        let text = format!("{:.2} (below {})", still.last_rmse, still.limit);
        checks.push(check(&still.scene, claim, text, still.holds));
    }
    for cut in found.cuts.iter().filter(|c| c.method == adaptive) {
        // Three readings of what is steady; the first is the promise.
        let promise = cut.animation_rmse.map(|_| cut.of_animation);
        let readings = [
            ("the animation's RMSE", promise, true),
            ("this second's RMSE", Some(cut.of_steady), false),
            ("the same refresh", Some(cut.of_same), false),
        ];
        for (level, back, promised) in readings {
            let Some(back) = back else { continue };
            let holds = back.is_some_and(|ms| ms <= cut.limit);
            let claim = format!("cut: back to {RECOVERED} × {level} at {}", short(cut.rate));
            let text = match back {
                Some(ms) => format!("{ms:.0} ms (at most {:.0})", cut.limit),
                None => format!("never (at most {:.0} ms)", cut.limit),
            };
            let mut row = check(&cut.scene, claim, text, holds);
            if !holds && !promised {
                row.outcome = Outcome::Missed;
            }
            checks.push(row);
        }
    }
    checks
}
