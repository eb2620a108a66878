"""Prints the summary of a benchmark run for docs/benchmark.md: recall by width, parameter errors by type.

    python scripts/summary.py BENCH OUT

BENCH is the folder with evaluate.py and the cases, OUT that of the results. Runs in the benchmark's environment.
"""

import json
import pathlib
import statistics
import sys

import numpy
import plyfile

GRADES = ("clean", "scan", "rough")
WIDTHS = (3, 4, 5, 7, 10, float("inf"))
TYPES = ("plane", "cylinder", "cone", "sphere", "torus")


def percentile(values, share):
    """The value below which `share` of the values lie, linear between neighbours."""
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = int(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def cell(values, form):
    return " / ".join(format(v, form) for v in (statistics.median(values), percentile(values, 0.95)))


def recall_by_width(bench, out):
    """Lists of found or not per grade and range of width (in grid spacings) of all surfaces asked for."""
    sys.path.insert(0, str(bench))
    import evaluate

    found_in = {}
    for case in sorted((bench / "cases").iterdir()):
        result = out / case.name
        if not (result / "segments.ply").exists():
            continue
        truth = json.loads((case / "truth.json").read_text())
        true = numpy.load(case / "truth.npz")["surface"].astype(int)
        primitives = json.loads((result / "part.json").read_text())["primitives"]
        faces = plyfile.PlyData.read(str(result / "segments.ply"))["face"]
        made = numpy.asarray(faces["primitive"]).astype(int)
        _, found = evaluate.segmentation(true, made, truth["surfaces"], primitives, truth["diagonal"])
        for i, surface in enumerate(truth["surfaces"]):
            if surface["asked"]:
                to = next(w for w in WIDTHS[1:] if surface["width"] < w)
                found_in.setdefault((truth["grade"], to), []).append(i in found)
    return found_in


def print_widths(found_in):
    print("Recall by width of the face in grid spacings (number of faces):\n")
    ranges = [f"{low} to {high}" if high < WIDTHS[-1] else f"from {low}" for low, high in zip(WIDTHS, WIDTHS[1:])]
    print("| |", " | ".join(ranges), "|")
    print("|---" * len(WIDTHS) + "|")
    for grade in GRADES:
        lists = [found_in.get((grade, to), []) for to in WIDTHS[1:]]
        cells = [f"{statistics.mean(f):.2f} ({len(f)})" if f else "" for f in lists]
        print(f"| {grade} |", " | ".join(cells), "|")


def print_parameters(rows):
    print("\nErrors of all matched surfaces, median / 95th percentile:\n")
    print("| | n | axis, degrees | position / diagonal | size, % |")
    print("|---|---|---|---|---|")
    for grade in GRADES:
        for kind in TYPES:
            errors = [e for r in rows if r["case"].endswith(grade) for e in r.get("parameter_errors", {}).get(kind, [])]
            if not errors:
                continue
            axis = "" if kind == "sphere" else cell([e[0] for e in errors], ".2f")
            size = "" if kind == "plane" else cell([100 * e[2] for e in errors], ".2f")
            print(f"| {grade}: {kind} | {len(errors)} | {axis} | {cell([e[1] for e in errors], '.1e')} | {size} |")


def main():
    bench, out = (pathlib.Path(argument) for argument in sys.argv[1:])
    print_widths(recall_by_width(bench, out))
    print_parameters(json.loads((out / "bench.json").read_text())["rows"])


if __name__ == "__main__":
    main()
