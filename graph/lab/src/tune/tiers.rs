//! From goals to tiers: those that are worth having.

use afterimage_gpu::FrameTime;
use afterimage_graph::check::Graph;

use super::search::{Candidate, Measured, TuneTarget};
use super::tuner::Tuner;
use crate::LabError;

/// A tier to search.
#[derive(Clone, Debug, PartialEq)]
pub struct Goal {
    pub name: String,
    pub target: TuneTarget,
}

/// A tier that was found.
#[derive(Clone, Debug)]
pub struct Tier {
    pub name: String,
    /// The graph with the chosen values.
    pub graph: Graph,
    /// Of several tiers, the time is that of turns on the largest image.
    pub measured: Measured,
    /// The visible difference FLIP, from 0 to 1.
    pub flip: f64,
}

/// A tier takes at most this share of the time of the one before.
const MAX_SHARE: f64 = 0.75;
/// How often each of several tiers is timed, by turns.
const ROUNDS: u32 = 2;

/// A goal, and what was found for it.
type Found<'g> = (&'g Goal, Candidate);

/// The most steps after a search for so many goals.
pub(super) fn last_steps(goals: usize) -> u64 {
    let turns = if goals > 1 { goals as u64 * u64::from(ROUNDS) } else { 0 };
    turns + goals as u64
}

/// The tiers for these goals, and why others have none.
pub(super) fn tiers(tuner: &mut Tuner<'_>, goals: &[Goal]) -> Result<(Vec<Tier>, Vec<String>), LabError> {
    let (mut found, mut left_out): (Vec<Found<'_>>, Vec<String>) = (Vec::new(), Vec::new());
    for goal in goals {
        let (choice, measured) = tuner.find(goal.target)?;
        if !goal.target.is_met(&measured) {
            let problem = unreachable_target(goal.target, &measured);
            if goals.len() == 1 {
                return Err(problem);
            }
            left_out.push(format!("`{}`: {problem}", goal.name));
        } else if let Some((same, _)) = found.iter().find(|(_, (known, _))| *known == choice) {
            left_out.push(format!("`{}`: it would be `{}`", goal.name, same.name));
        } else {
            found.push((goal, (choice, measured)));
        }
    }
    if found.len() > 1 {
        time_by_turns(tuner, &mut found)?;
        found = worth_having(found, &mut left_out);
    }
    tuner.steps.expect_last(found.len() as u64);
    let mut tiers = Vec::new();
    for (goal, (choice, measured)) in found {
        let Tuner { measurer, steps, .. } = tuner;
        let flip = steps.run_last(&format!("FLIP of {}", goal.name), 0, || measurer.flip(&choice))?;
        tiers.push(Tier { name: goal.name.clone(), graph: measurer.graph(&choice), measured, flip });
    }
    Ok((tiers, left_out))
}

/// Replaces the times by those of two rounds in opposite order, so that a drift is not taken for a difference.
fn time_by_turns(tuner: &mut Tuner<'_>, found: &mut [Found<'_>]) -> Result<(), LabError> {
    let count = found.len();
    tuner.steps.expect_last(last_steps(count));
    let mut times: Vec<Option<FrameTime>> = vec![None; count];
    for round in 0..ROUNDS {
        for step in 0..count {
            let at = if round % 2 == 0 { step } else { count - 1 - step };
            let (goal, (choice, _)) = &found[at];
            let Tuner { measurer, steps, .. } = tuner;
            let time = steps.run_last(&format!("time of {}", goal.name), 0, || measurer.time(choice, ROUNDS))?;
            times[at] = Some(times[at].map_or(time, |before| before.joined(time)));
        }
    }
    for ((_, (_, measured)), time) in found.iter_mut().zip(times) {
        measured.ms = time.expect("each is timed in each round").ms();
    }
    Ok(())
}

fn unreachable_target(target: TuneTarget, best: &Measured) -> LabError {
    let reached = format!("the closest choice takes {:.3} ms and has an error of {:.3} codes", best.ms, best.p999);
    LabError::request(format!("no choice of the quality switches stays {target}: {reached}")).hint(match target {
        TuneTarget::Budget(_) => "allow more time, or change what the pipeline does: fewer levels, a smaller image",
        _ => "allow more error; what is left comes from half-float intermediates",
    })
}

/// Those that are a quarter cheaper than the next better one; the first is.
fn worth_having<'g>(found: Vec<Found<'g>>, left_out: &mut Vec<String>) -> Vec<Found<'g>> {
    let mut kept: Vec<Found<'g>> = Vec::new();
    for (goal, (choice, measured)) in found {
        match kept.last() {
            Some((better, (_, than))) if measured.ms > MAX_SHARE * than.ms => {
                let share = 100.0 * measured.ms / than.ms;
                left_out.push(format!("`{}`: it takes {share:.0} % of the time of `{}`", goal.name, better.name));
            }
            _ => kept.push((goal, (choice, measured))),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tier_is_a_quarter_cheaper_than_the_next_better_one() {
        let goals = ["a", "b", "c", "d"].map(|name| Goal { name: name.to_owned(), target: TuneTarget::Error(1.0) });
        let found = |times: [f64; 4]| {
            let measured = times.map(|ms| Measured {
                ms,
                p999: 0.0,
                p999_without_worst: None,
                max: 0.0,
                bytes: 0,
                is_predicted: false,
            });
            let all = goals.iter().zip(measured).map(|(goal, measured)| (goal, (vec![], measured))).collect();
            let mut left_out = Vec::new();
            let kept: Vec<String> =
                worth_having(all, &mut left_out).iter().map(|(goal, _)| goal.name.clone()).collect();
            (kept.concat(), left_out)
        };
        assert_eq!(found([4.0, 3.0, 2.0, 1.0]).0, "abcd");
        // `c` is cheaper than `b`, which does not exist, and not than `a`.
        let (kept, left_out) = found([4.0, 3.9, 3.1, 2.9]);
        assert_eq!(kept, "ad");
        assert_eq!(left_out, ["`b`: it takes 98 % of the time of `a`", "`c`: it takes 78 % of the time of `a`"]);
        assert_eq!(found([1.0, 2.0, 3.0, 4.0]).0, "a");
    }
}
