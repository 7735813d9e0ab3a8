#!/usr/bin/env bash
# Make docs/results.md: score beliefs, run the sweeps, report. A second call goes on after a stop.
#
# Run: bash benchmarks/results.sh "DESCRIPTIONS/*.jsonl" RUNS [SLOOP]
#   RUNS   folder for the runs and the fits; about 20 MB
#   SLOOP  the command, .venv/bin/sloop unless told otherwise
# Takes some 20 minutes of processor time beyond the fits. The environment variable STARTS (8) says
# how many starts the comparison of planners shares.
set -euo pipefail
files=($1)
runs=$2
sloop=${3:-.venv/bin/sloop}
cv=(--cv city --fits "$runs/fits.json")
few=(--models sloop,sloop-m4,bayes --ranges 3 --starts "${STARTS:-8}")
mkdir -p "$runs"

"$sloop" eval describe "${files[@]}"
"$sloop" eval quality "${files[@]}" "${cv[@]}" --json >"$runs/quality.json"
"$sloop" eval search "${files[@]}" "${cv[@]}" --out "$runs/gold"
"$sloop" eval search "${files[@]}" "${cv[@]}" --parsed --out "$runs/parsed"
"$sloop" eval search "${files[@]}" "${cv[@]}" "${few[@]}" --rollout published --out "$runs/pouct"
"$sloop" eval search "${files[@]}" "${cv[@]}" "${few[@]}" --planner greedy --out "$runs/greedy"
"$sloop" eval search "${files[@]}" "${cv[@]}" "${few[@]}" --out "$runs/fast1000"
"$sloop" eval search "${files[@]}" "${cv[@]}" "${few[@]}" --sims 10000 --out "$runs/fast10000"
for run in gold parsed; do
  "$sloop" eval report "$runs/$run"
done
"$sloop" eval report "$runs"/{gold,parsed,pouct,greedy,fast1000,fast10000} \
  --quality "$runs/quality.json" --docs docs/results.md
