#!/usr/bin/env bash
# Measures what the table of the benchmark does not show, and puts it into docs/benchmark.md.
#
#   scripts/measure.sh BENCH floor      errors against a least-squares floor, on the results of scripts/benchmark.sh
#   scripts/measure.sh BENCH peer       faces and CPU time beside CGAL; needs g++ libcgal-dev libgmp-dev libmpfr-dev
#   scripts/measure.sh BENCH gallery    sheets of scan, regions and solid in docs/images
#   scripts/measure.sh BENCH seeds      whether five seeds give the same faces
#   scripts/measure.sh BENCH scaling    cost at three sizes of one shape
#   scripts/measure.sh BENCH            all of these
#
# BENCH is the folder with bench.py and its cases. BIN names a program that is built already, OUT where results go (out).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
bench="${1:?the folder with bench.py is needed}"
shift
. scripts/bench_env.sh
# Numerical libraries of Python would take more than one core.
export OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1

bin="${BIN:-target/release/scanwright}"
[ -n "${BIN:-}" ] || cargo build --release --package scanwright-cli
out="${OUT:-out}"
mkdir -p "$out"

for what in ${@:-floor peer gallery seeds scaling}; do
    case "$what" in
        floor) arguments=("$out/bench") ;;
        gallery) arguments=("$bin" "$out/gallery" docs/images) ;;
        peer | seeds | scaling) arguments=("$bin" "$out/$what") ;;
        *) echo "no measurement is called $what" >&2; exit 2 ;;
    esac
    "$python" "scripts/$what.py" "$bench" "${arguments[@]}" > "$out/$what.md"
    python3 scripts/insert_table.py docs/benchmark.md "$what" "$out/$what.md"
done
