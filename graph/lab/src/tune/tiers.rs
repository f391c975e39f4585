//! The tiers for a list of goals, without those that save too little.

use afterimage_gpu::FrameTime;
use afterimage_graph::check::Graph;

use super::measurer::Confirmed;
use super::target::{Measured, TuneTarget};
use super::tuner::Tuner;
use crate::LabError;
use crate::measure::{Errors, beats};

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
    /// All errors, the visible differences among them.
    pub errors: Errors,
    /// The name of the display of the visible differences.
    pub display: &'static str,
    /// The conditions of all figures, and the margin that a claim adds to the errors.
    pub conditions: String,
}

/// A tier takes at most this share of the time of the one before.
const MAX_SHARE: f64 = 0.75;
/// Rounds in which several tiers are timed by turns.
const ROUNDS: u32 = 2;

/// A goal, and what was found for it.
#[derive(Clone)]
struct Found<'g> {
    goal: &'g Goal,
    choice: Vec<usize>,
    measured: Measured,
    /// The picture of its largest error.
    worst: String,
}

/// The most steps after a search for so many goals.
pub(super) fn last_steps(goals: usize) -> u64 {
    let turns = if goals > 1 { goals as u64 * u64::from(ROUNDS) } else { 0 };
    turns + goals as u64
}

/// The tiers for these goals, and why others have none.
pub(super) fn tiers(tuner: &mut Tuner<'_>, goals: &[Goal]) -> Result<(Vec<Tier>, Vec<String>), LabError> {
    let (mut found, mut left_out): (Vec<Found<'_>>, Vec<String>) = (Vec::new(), Vec::new());
    tuner.measure_singles(goals.iter().map(|goal| goal.target))?;
    for goal in goals {
        let (choice, Confirmed { measured, worst }) = tuner.find(goal.target)?;
        if !goal.target.is_met(&measured) {
            let problem = unreachable_target(goal.target, &measured);
            if goals.len() == 1 {
                return Err(problem);
            }
            left_out.push(format!("`{}`: {problem}", goal.name));
        } else if let Some(same) = found.iter().find(|known| known.choice == choice) {
            left_out.push(format!("`{}`: it would be `{}`", goal.name, same.goal.name));
        } else {
            found.push(Found { goal, choice, measured, worst });
        }
    }
    let before = tuner.steps.done();
    if found.len() > 1 {
        time_by_turns(tuner, &mut found)?;
        found = worth_having(&found, &mut left_out);
    }
    // What is left of the last steps is the visible difference of each tier.
    tuner.steps.end_part(before, last_steps(goals.len()) - found.len() as u64);
    let mut tiers = Vec::new();
    for Found { goal, choice, measured, worst } in found {
        let Tuner { measurer, steps, .. } = tuner;
        let errors = steps.run(&format!("errors of {}", goal.name), || measurer.all_errors(&choice))?;
        let (graph, conditions, display) =
            (measurer.graph(&choice), measurer.conditions(&worst), measurer.display.name);
        tiers.push(Tier { name: goal.name.clone(), graph, measured, errors, display, conditions });
    }
    Ok((tiers, left_out))
}

/// Replaces the times by those of two rounds in opposite order, so that a drift is not taken for a difference.
fn time_by_turns(tuner: &mut Tuner<'_>, found: &mut [Found<'_>]) -> Result<(), LabError> {
    let count = found.len();
    let mut times: Vec<Option<FrameTime>> = vec![None; count];
    for round in 0..ROUNDS {
        for step in 0..count {
            let at = if round % 2 == 0 { step } else { count - 1 - step };
            let Found { goal, choice, .. } = &found[at];
            let Tuner { measurer, steps, .. } = tuner;
            let time = steps.run(&format!("time of {}", goal.name), || measurer.time(choice, ROUNDS))?;
            times[at] = Some(times[at].map_or(time, |before| before.joined(time)));
        }
    }
    for (tier, time) in found.iter_mut().zip(times) {
        tier.measured.ms = time.expect("each is timed in each round").ms();
    }
    Ok(())
}

fn unreachable_target(target: TuneTarget, best: &Measured) -> LabError {
    let reached = format!("the closest takes {:.3} ms and would claim {:.3} codes", best.ms, best.claimed_p999());
    LabError::request(format!("no choice of the quality switches stays {target}: {reached}")).hint(match target {
        TuneTarget::Budget(_) => "allow more time, or change what the pipeline does: fewer levels, a smaller image",
        _ => "allow more error; what is left comes from half-float intermediates",
    })
}

/// Those that are a quarter cheaper than the next better one; the first is. One that another beats is none of them.
fn worth_having<'g>(found: &[Found<'g>], left_out: &mut Vec<String>) -> Vec<Found<'g>> {
    let mut kept: Vec<Found<'g>> = Vec::new();
    for tier in found {
        let (name, measured) = (&tier.goal.name, &tier.measured);
        if let Some(better) = found.iter().find(|other| beats(other.measured.point(), measured.point())) {
            left_out.push(format!("`{name}`: `{}` is no slower and no less accurate", better.goal.name));
            continue;
        }
        match kept.last() {
            Some(before) if measured.ms > MAX_SHARE * before.measured.ms => {
                let share = 100.0 * measured.ms / before.measured.ms;
                left_out.push(format!("`{name}`: it takes {share:.0} % of the time of `{}`", before.goal.name));
            }
            _ => kept.push(tier.clone()),
        }
    }
    kept
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The names of the tiers that are kept of `a`, `b` and so on, with these times and errors, and the reasons of the
    /// others.
    fn kept(figures: &[(f64, f64)]) -> (String, Vec<String>) {
        let goal = |at: usize| Goal { name: ["a", "b", "c", "d"][at].to_owned(), target: TuneTarget::MostAccurate };
        let goals: Vec<Goal> = (0..figures.len()).map(goal).collect();
        let mut found = Vec::new();
        for (goal, (ms, p999)) in goals.iter().zip(figures) {
            let measured = Measured { ms: *ms, p999: *p999, ..Measured::default() };
            found.push(Found { goal, choice: vec![], measured, worst: String::new() });
        }
        let mut left_out = Vec::new();
        let names = worth_having(&found, &mut left_out).iter().map(|tier| tier.goal.name.clone()).collect();
        (names, left_out)
    }

    #[test]
    fn a_tier_is_a_quarter_cheaper_than_the_next_better_one() {
        assert_eq!(kept(&[(4.0, 0.0), (3.0, 1.0), (2.0, 4.0), (1.0, 9.0)]).0, "abcd");
        // `c` is cheaper than `b`, which does not exist, and not than `a`.
        let (names, left_out) = kept(&[(4.0, 0.0), (3.9, 1.0), (3.1, 4.0), (2.9, 9.0)]);
        assert_eq!(names, "ad");
        assert_eq!(left_out, ["`b`: it takes 98 % of the time of `a`", "`c`: it takes 78 % of the time of `a`"]);
        assert_eq!(kept(&[(1.0, 0.5); 4]).0, "a");
    }

    #[test]
    fn a_tier_that_another_beats_does_not_exist() {
        // `c` is faster than `b` and more accurate, by more than a quarter or less.
        for ms in [1.0, 2.9] {
            let (names, left_out) = kept(&[(4.0, 0.0), (3.0, 1.0), (ms, 0.9), (0.5, 9.0)]);
            assert_eq!(names, "acd");
            assert_eq!(left_out, ["`b`: `c` is no slower and no less accurate"]);
        }
        // The first can be beaten as well.
        assert_eq!(kept(&[(4.0, 0.3), (3.9, 0.3), (2.0, 4.0)]).0, "bc");
        assert_eq!(kept(&[(1.0, 0.0), (2.0, 1.0), (3.0, 4.0), (4.0, 9.0)]).0, "a");
    }
}
