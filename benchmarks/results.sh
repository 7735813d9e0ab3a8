#!/usr/bin/env bash
# Make docs/results.md: score beliefs, run the sweeps, report. A second call goes on after a stop.
#
# Run: bash benchmarks/results.sh "DESCRIPTIONS/*.jsonl" RUNS [SLOOP] ["POINTS/*.jsonl" MAPS]
#   RUNS    folder for the runs and the fits; about 20 MB
#   SLOOP   the command, .venv/bin/sloop unless told otherwise
#   POINTS  description files of the second kind of data, meeting points, with the folder of their
#           maps: beliefs are learnt from both kinds, each city left out, and both are reported
# Takes some 20 minutes of processor time beyond the fits, of which there are two for each city. The
# environment variable STARTS (8) says how many starts the comparison of planners shares.
set -euo pipefail
files=($1)
runs=$2
sloop=${3:-.venv/bin/sloop}
points=(${4:-})
cv=(--cv city --fits "$runs/fits.json")
notes=tests/eval/data
for file in ${points[@]+"${points[@]}"}; do cv+=(--learn-from "$file"); done
if ((${#points[@]})); then
  cv+=(--maps "$5" --annotations $notes/meeting_points_gold.jsonl)
  cv+=(--annotations $notes/meeting_points_dev.jsonl)
fi
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
page=$(<docs/results.md)
cat >docs/results.md <<END
${page%%$'\n'*}

[Evaluation](evaluation.md) says what each figure means and how this page was made.
${page#*$'\n'}
END

((${#points[@]})) || exit 0
cv=(--cv city --fits "$runs/fits.json")
for file in "${files[@]}"; do cv+=(--learn-from "$file"); done
cv+=(--maps "$5" --annotations $notes/meeting_points_gold.jsonl)
cv+=(--annotations $notes/meeting_points_dev.jsonl)
"$sloop" eval quality "${points[@]}" "${cv[@]}" --parsed --json >"$runs/quality_points.json"
"$sloop" eval search "${points[@]}" "${cv[@]}" --parsed --ranges 3 --out "$runs/points" \
  --models keyword,sloop-m4,referent-gaussian,bayes
"$sloop" eval search "${points[@]}" --maps "$5" --parsed --ranges 3 --out "$runs/points_best" \
  --models bayes,tests/tools/best_reading.py:BEST_READING --primary bayes,tests/tools/best_reading.py:BEST_READING
"$sloop" eval report "$runs/points" --maps "$5" \
  --quality "$runs/quality_points.json" --docs docs/results_meeting_points.md
"$sloop" eval report "$runs/points_best" --maps "$5"
{
  echo
  echo "## Meeting points"
  echo
  echo "People say where they are, for somebody to meet them, in cities whose maps were imported as they"
  echo "are; the beliefs are of what the parser reads."
  sed '1d; s/^#/##/' docs/results_meeting_points.md
} >>docs/results.md
rm docs/results_meeting_points.md
