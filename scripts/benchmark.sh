#!/usr/bin/env bash
# Runs the benchmark and puts its table and summary into docs/benchmark.md.
#
#   scripts/benchmark.sh BENCH [OPTIONS OF bench.py]
#
# BENCH is the folder with bench.py and its cases. With `--only NAME` the table is printed but not committed to the page.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bench="${1:?the folder with bench.py is needed}"
shift

. scripts/bench_env.sh

cargo build --release --package scanwright-cli
out="out/bench"
mkdir -p "$out"
"$python" "$bench/bench.py" --bin target/release/scanwright --out "$out" "$@" | tee "$out/table.txt"

case " $* " in
    *" --only "*) ;;
    *)
        "$python" scripts/summary.py "$bench" "$out" > "$out/summary.md"
        python3 scripts/insert_table.py docs/benchmark.md table "$out/table.txt"
        python3 scripts/insert_table.py docs/benchmark.md summary "$out/summary.md"
        ;;
esac
