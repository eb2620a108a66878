"""Prints the summary of a benchmark run for docs/benchmark.md: means and gates, recall by width, parameter errors, surfaces
in the STEP, facets.

    python scripts/summary.py BENCH OUT

BENCH is the folder with evaluate.py and the cases, OUT that of the results. Runs in the benchmark's environment.
"""

import json
import statistics
import sys

import cases

WIDTHS = (3, 4, 5, 7, 10, float("inf"))
# What is asked of the means per grade: name, key in bench.json, gates for clean, scan and rough.
GATES = (
    ("segIoU", "seg_iou", (0.94, 0.90, 0.80)),
    ("recall", "recall", (0.94, 0.90, 0.80)),
    ("precision", "precision", (0.94, 0.90, 0.80)),
    ("type", "type_accuracy", (0.98, 0.96, 0.90)),
    ("STEP valid", "step_valid", (1.0, 1.0, 0.97)),
    ("solid", "step_solid", (0.95, 0.90, 0.75)),
    ("usable", "usable", (0.85, 0.75, 0.50)),
)
# Medians over the cases' medians: name, key, format.
MEDIANS = (("axis, degrees", "axis_deg_median", ".3f"), ("position / diagonal", "position_median", ".1e"))
NEAR = 0.1  # how far the number of surfaces may be from the true one


def percentile(values, share):
    """The value below which `share` of the values lie, linear between neighbours."""
    ordered = sorted(values)
    at = share * (len(ordered) - 1)
    low = int(at)
    high = min(low + 1, len(ordered) - 1)
    return ordered[low] + (at - low) * (ordered[high] - ordered[low])


def cell(values, form):
    return " / ".join(format(v, form) for v in (statistics.median(values), percentile(values, 0.95)))


def print_means(rows):
    """Only closable cases have `usable`."""
    print("Means per grade (gate), met where bold; of parameters the medians over the cases' medians:\n")
    print("| |", " | ".join(cases.GRADES), "|")
    print("|---" * (1 + len(cases.GRADES)) + "|")
    of_grade = lambda grade, key: [r[key] for r in rows if r["case"].endswith(grade) and key in r]
    for name, key, gates in GATES:
        means = [statistics.mean(of_grade(grade, key)) for grade in cases.GRADES]
        marks = ["**" if mean >= gate else "" for mean, gate in zip(means, gates)]
        cells = [f"{mark}{mean:.3f}{mark} ({gate:.2f})" for mean, gate, mark in zip(means, gates, marks)]
        print(f"| {name} |", " | ".join(cells), "|")
    for name, key, form in MEDIANS:
        print(f"| {name} |", " | ".join(format(statistics.median(of_grade(g, key)), form) for g in cases.GRADES), "|")


def print_facets(bench, out):
    """The text of a W_FACETS begins with their number."""
    found = {}
    for folder in cases.case_folders(bench):
        part = out / folder.name / "part.json"
        warnings = json.loads(part.read_text())["warnings"] if part.exists() else []
        n = sum(int(w["text"].split()[0]) for w in warnings if w["code"] == "W_FACETS")
        if n:
            found[folder.name] = n
    listed = ", ".join(f"{name} {n}" for name, n in sorted(found.items(), key=lambda item: -item[1]))
    print(f"\nParts with facets (flat faces, one per triangle of the scan), and how many: {listed or 'none'}.")


def recall_by_width(bench, out):
    """Lists of found or not per grade and range of width (in grid spacings) of all surfaces asked for."""
    found_in = {}
    for folder in cases.case_folders(bench):
        if not (out / folder.name / "segments.ply").exists():
            continue
        truth, _, found = cases.found_in(folder, out / folder.name)
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
    for grade in cases.GRADES:
        lists = [found_in.get((grade, to), []) for to in WIDTHS[1:]]
        cells = [f"{statistics.mean(f):.2f} ({len(f)})" if f else "" for f in lists]
        print(f"| {grade} |", " | ".join(cells), "|")


def print_parameters(rows):
    print("\nErrors of all matched surfaces, median / 95th percentile:\n")
    print("| | n | axis, degrees | position / diagonal | size, % |")
    print("|---|---|---|---|---|")
    for grade in cases.GRADES:
        for kind in cases.TYPES:
            errors = [e for r in rows if r["case"].endswith(grade) for e in r.get("parameter_errors", {}).get(kind, [])]
            if not errors:
                continue
            axis = "" if kind == "sphere" else cell([e[0] for e in errors], ".2f")
            size = "" if kind == "plane" else cell([100 * e[2] for e in errors], ".2f")
            print(f"| {grade}: {kind} | {len(errors)} | {axis} | {cell([e[1] for e in errors], '.1e')} | {size} |")


def print_surfaces(rows):
    """`step_surfaces` of the benchmark counts the halves of one surface once, and every facet."""
    print("\nSurfaces in the STEP over the true number:\n")
    print(f"| | n | median | median of deviations | within {NEAR:.0%} | outside |")
    print("|---|---|---|---|---|---|")
    for grade in (*cases.GRADES, ""):
        some = [r for r in rows if r["case"].endswith(grade) and r.get("true_surfaces")]
        ratios = {r["case"]: r["step_surfaces"] / r["true_surfaces"] for r in some}
        outside = sorted((name for name, ratio in ratios.items() if abs(ratio - 1) > NEAR), key=lambda name: -ratios[name])
        listed = ", ".join(f"{name.removesuffix('-' + grade)} {ratios[name]:.2f}" for name in outside) if grade else ""
        deviation = statistics.median(abs(ratio - 1) for ratio in ratios.values())
        middle = f"{statistics.median(ratios.values()):.2f} | {deviation:.2f}"
        print(f"| {grade or 'all'} | {len(some)} | {middle} | {len(some) - len(outside)} | {listed} |")


def main():
    bench, out = cases.folders(sys.argv[1:], 2)
    cases.use_bench(bench)
    rows = json.loads((out / "bench.json").read_text())["rows"]
    print_means(rows)
    print()
    print_widths(recall_by_width(bench, out))
    print_parameters(rows)
    print_surfaces(rows)
    print_facets(bench, out)


if __name__ == "__main__":
    main()
