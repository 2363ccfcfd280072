#!/usr/bin/env bash
# A simulation in one request, its metrics, spectrum and plot, then a study with its table; with curl (7.84 or later) alone.
# Run: examples/curl.sh [URL]   (default http://127.0.0.1:8080; a token, where the service wants one, in RACEWAY_TOKEN)
set -euo pipefail
api=${1:-http://127.0.0.1:8080}

# --fail-with-body: an error ends the script and is printed, a problem that says what is wrong. --retry: after 429 and
# 503, as long as Retry-After says.
ask() {
    local token=()
    [ -z "${RACEWAY_TOKEN:-}" ] || token=(-H "Authorization: Bearer $RACEWAY_TOKEN")
    curl -sS --fail-with-body --retry 5 --compressed "${token[@]}" "$@"
}

# Submit, and wait up to a minute for the end: the answer has the metrics, the header Location the job's path.
job=$(ask -o metrics.json -w '%header{location}' -H 'Content-Type: application/json' -H 'Prefer: wait=60' "$api/v1/jobs" -d '{
  "kind": "simulation", "labels": ["curl.sh"],
  "scene": { "bearing": "6205", "operation": { "speed_rpm": 6000, "radial_load_y_n": 500 } } }')
echo "the job is at $job"
grep -o '"level_db":[^,}]*' metrics.json

# The metrics again, and alone.
ask -o metrics.json "$api$job/metrics"

# A spectrum as a table, up to 5 kHz, and the picture.
ask -o spectrum.csv -H 'Accept: text/csv' "$api$job/spectrum?channel=spindle.y.acceleration&max_frequency_hz=5000"
head -n 3 spectrum.csv
ask -o spectrum.svg "$api$job/plots/spectrum.svg"

# A study: the same scene over five curvatures.
study=$(ask -o study.json -w '%header{location}' -H 'Content-Type: application/json' "$api/v1/jobs" -d '{
  "kind": "study", "labels": ["curl.sh"],
  "scene": { "bearing": "6205", "operation": { "speed_rpm": 6000, "radial_load_y_n": 500 } },
  "axes": [ { "path": "/bearing/inner_groove_curvature", "from": 0.51, "to": 0.53, "count": 5 } ] }')
until ask "$api$study" | grep -qE '"status":"(succeeded|failed|cancelled)"'; do sleep 1; done
ask -o table.csv -H 'Accept: text/csv' "$api$study/table"
cut -d , -f 1-3 table.csv
ask -o trend.svg "$api$study/plots/trend.svg"

# What this script has submitted.
ask "$api/v1/jobs?label=curl.sh&status=succeeded" | grep -o '"kind":"[a-z]*","status":"[a-z]*"'
