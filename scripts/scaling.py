"""Scans one shape at three sizes and prints what converting it costs.

    python scripts/scaling.py BENCH BIN OUT

BENCH is the folder with make_cases.py and the cases, BIN our program, OUT a folder for scans and results.
Scans made before are kept. Two threads, one size after the other, the largest last. Wall time counts only on an idle machine.
"""

import json
import math
import os
import shutil
import sys

import cases

SHAPE, GRADE = "bushing-1", "scan"
SIZES = (20_000, 200_000, 2_000_000)
THREADS = 2
MOST_GROWTH, MOST_GIB, MOST_SECONDS = 12, 4, 120


def scan(bench, out, size):
    """The folder of the shape's case with about this many triangles."""
    import make_cases

    folder = out / str(size) / f"{SHAPE}-{GRADE}"
    if not (folder / "truth.json").exists():
        model = out / f"{SHAPE}.step"
        out.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(bench / "cases" / f"{SHAPE}-{GRADE}" / "truth.step", model)
        make_cases.make(model, folder.parent, GRADE, size)
    return folder


def measure(binary, folder):
    result = folder.parent / "result"
    load = os.getloadavg()[0]
    cost = cases.convert(binary, folder / "scan.ply", result, "--threads", THREADS)
    stages = json.loads((result / "timings.json").read_text())["seconds"]
    n_triangles = json.loads((result / "part.json").read_text())["scan"]["triangles"]
    return cost | {"triangles": n_triangles, "stages": stages, "load": load}


def decades(rows, key):
    """Growth per tenfold number of triangles, from each size to the next."""
    steps = [(math.log10(b["triangles"] / a["triangles"]), b[key] / a[key]) for a, b in zip(rows, rows[1:])]
    return [ratio ** (1 / step) for step, ratio in steps]


def print_table(rows):
    stages = [stage for stage in rows[-1]["stages"] if rows[-1]["stages"][stage] > 0.01 * rows[-1]["wall"]]
    print("| triangles | CPU s | growth per decade | wall s | MiB |", " | ".join(f"{stage}, s" for stage in stages), "|")
    print("|---" * (5 + len(stages)) + "|")
    for row, growth in zip(rows, ["", *(f"{g:.1f}" for g in decades(rows, "cpu"))]):
        seconds = " | ".join(f"{row['stages'][stage]:.1f}" for stage in stages)
        print(f"| {row['triangles']:,} | {row['cpu']:.1f} | {growth} | {row['wall']:.1f} | {row['mib']:.0f} | {seconds} |")
    print(f"\nAsked: at most {MOST_GROWTH} per decade; the largest under {MOST_GIB} GiB and {MOST_SECONDS} s.")
    print(f"The load of the machine was {rows[-1]['load']:.1f} when the largest run began; wall time counts only near 0.")


def main():
    bench, binary, out = cases.folders(sys.argv[1:], 3)
    cases.use_bench(bench)
    rows = [measure(binary, scan(bench, out, size)) for size in SIZES]
    (out / "scaling.json").write_text(json.dumps(rows, indent=1))
    print_table(rows)


if __name__ == "__main__":
    main()
