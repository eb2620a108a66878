#!/usr/bin/env bash
# Installs what the tests need (Rust packages, and Open CASCADE and build123d in the Python environment .venv) and runs
# them all.
# Arguments go to `cargo test`.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"

if ! .venv/bin/python -c 'import OCP.STEPControl, build123d, numpy' 2>/dev/null; then
    echo "installing Open CASCADE and build123d into .venv"
    # Debian keeps venv in a package of its own.
    python3 -m venv --clear .venv || { apt-get install -y python3-venv && python3 -m venv --clear .venv; }
    .venv/bin/python -m pip install --quiet --requirement scripts/test-requirements.txt
fi
export SCANWRIGHT_PYTHON="$PWD/.venv/bin/python"

exec cargo test --workspace "$@"
