# Sourced by the scripts that measure: sets `python` to one with what the benchmark in the folder $bench requires.
venv="${BENCH_VENV:-target/bench-venv}"
python="$venv/bin/python"
if ! "$python" -c 'import OCP, numpy, scipy' 2>/dev/null; then
    python3 -m venv --clear "$venv"
    "$python" -m pip install --quiet --requirement "$bench/requirements.txt"
fi
