#!/usr/bin/env bash
# Which faults do the tests notice? tests/mutants.sh sample FIRST COUNT
# `weave FIRST COUNT` and `run FIRST` are the two halves of `sample`: another machine, with the same files at the same
# places, may run what one has compiled.
#
# `sample` takes mutants of the pure crates (base, wgsl, graph, plan) as cargo-mutants lists them, in an order with a
# fixed seed: `sample 0 300` and `sample 300 400` have none in common. Results are kept in
# target/mutants/sample/results-*.tsv: a run that was stopped goes on where it was, and a run that was finished prints
# its table again. Remove the file to begin anew. It ends with the share of the mutants that a test notices, its 95 %
# interval, and the mutants that no test notices.
set -euo pipefail
cd "$(dirname "$0")/.."

case "${1:-}" in
sample | weave)
    cargo mutants --version >/dev/null 2>&1 || { echo "first: cargo install cargo-mutants --locked" >&2; exit 2; }
    exec cargo run --quiet -p afterimage-mutants -- "$1" "${2:-0}" "${3:-400}"
    ;;
run) exec cargo run --quiet -p afterimage-mutants -- run "${2:-0}" ;;
*) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 2 ;;
esac
