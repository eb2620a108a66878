"""Converts every clean and scan case with several seeds, and prints whether they give the same set of faces.

    python scripts/seeds.py BENCH BIN OUT

BENCH is the folder with the cases, BIN our program, OUT a folder for the results.
Faces of two runs are paired by the triangles they share. They are the same if most triangles are, the type is, and the
parameters differ by no more than twice the uncertainty that the two runs give for them.
"""

import sys

import cases
import numpy
from scipy.optimize import linear_sum_assignment

SEEDS = (1, 2, 3, 4, 5)
GRADES = ("clean", "scan")
OVERLAP = 0.5  # intersection over union of the triangles
DEVIATIONS = 2.0
# What may differ where no uncertainty is stated: a share of the diagonal, radians.
ROUNDING = 1e-6


def pairs(a, b):
    """Ids of faces of two labellings that share most triangles, and those of either side without a partner."""
    ids = [numpy.unique(labels[labels >= 0]) for labels in (a, b)]
    shared = numpy.zeros((len(ids[0]), len(ids[1])))
    for i, of_a in enumerate(ids[0]):
        mine = a == of_a
        inside, count = numpy.unique(b[mine & (b >= 0)], return_counts=True)
        columns = numpy.searchsorted(ids[1], inside)
        shared[i, columns] = count / (mine.sum() + (b[:, None] == inside).sum(axis=0) - count)
    rows, columns = linear_sum_assignment(-shared)
    paired = {int(ids[0][i]): int(ids[1][k]) for i, k in zip(rows, columns) if shared[i, k] >= OVERLAP}
    alone = [[int(i) for i in side if i not in taken] for side, taken in zip(ids, (paired.keys(), paired.values()))]
    return paired, alone


def uncertainty(primitive, middle, diagonal):
    """Standard uncertainties as the benchmark measures differences: degrees, position, share of the radius."""
    known = dict(zip(primitive["parameters"], primitive["uncertainty"]))
    largest = lambda *starts: max([u for name, u in known.items() if name.startswith(starts)], default=0.0)
    radius = primitive.get("radius") or primitive.get("major_radius")
    shape = largest("radius", "major_radius") / radius if radius else 0.0
    if primitive["type"] == "torus":
        shape = max(shape, largest("minor_radius") / primitive["minor_radius"])
    if primitive["type"] == "cone":
        along = (middle - numpy.array(primitive["apex"])) @ numpy.array(primitive["axis_direction"])
        shape = largest("radius") / abs(along * numpy.tan(primitive["half_angle"]))
    position = numpy.linalg.norm([u for name, u in known.items() if name.startswith(("offset", "center"))])
    return numpy.degrees(largest("tilt", "half_angle") + ROUNDING), position + ROUNDING * diagonal, shape + ROUNDING


def difference(a, b, middle, diagonal):
    """What differs between two paired faces, or None."""
    import truth

    if a["type"] != b["type"]:
        return f"{a['type']} or {b['type']}"
    if a["type"] == "freeform":
        return None
    if a["type"] == "plane":
        # Planes are compared at a point of the first one.
        normal = numpy.array(a["normal"])
        middle = middle - (middle - numpy.array(a["point"])) @ normal * normal
    moved = truth.differences(a, b, 1.0, middle)
    allowed = DEVIATIONS * numpy.hypot(uncertainty(a, middle, diagonal), uncertainty(b, middle, diagonal))
    worst = int(numpy.argmax(moved / allowed))
    if moved[worst] <= allowed[worst]:
        return None
    unit = ("degrees", "mm", "of the radius")[worst]
    return f"{a['type']} by {moved[worst]:.2g} {unit}, twice its uncertainty is {allowed[worst]:.2g}"


def differences(vertices, triangles, first, other):
    """(what differs, whether one of the runs calls it ambiguous) between two runs on one scan."""
    (primitives_a, a), (primitives_b, b) = first, other
    paired, (only_a, only_b) = pairs(a, b)
    diagonal = numpy.linalg.norm(vertices.max(axis=0) - vertices.min(axis=0))
    found = []
    for i, k in paired.items():
        middle = vertices[triangles[a == i]].mean(axis=(0, 1))
        if what := difference(primitives_a[i], primitives_b[k], middle, diagonal):
            found.append((what, bool(primitives_a[i]["ambiguous"] or primitives_b[k]["ambiguous"])))
    for primitives, labels, alone in ((primitives_a, a, only_a), (primitives_b, b, only_b)):
        for i in alone:
            what = f"{primitives[i]['type']} of {(labels == i).sum()} triangles"
            found.append((what, bool(primitives[i]["ambiguous"])))
    return found


def case_differences(binary, folder, out):
    vertices, triangles = cases.read_mesh(folder / "scan.ply")
    results = []
    for seed in SEEDS:
        result = out / folder.name / str(seed)
        cases.convert(binary, folder / "scan.ply", result, "--seed", seed)
        results.append(cases.read_result(result))
    lists = [differences(vertices, triangles, results[0], other) for other in results[1:]]
    return len(results[0][0]), lists


def unannounced(lists):
    """What differs without being called ambiguous."""
    return [what for found in lists for what, ambiguous in found if not ambiguous]


def main():
    bench, binary, out = cases.folders(sys.argv[1:], 3)
    cases.use_bench(bench)
    folders = [folder for folder in cases.case_folders(bench) if folder.name.endswith(GRADES)]
    compared = {folder.name: case_differences(binary, folder, out) for folder in folders}
    silent = {name: unannounced(lists) for name, (_, lists) in compared.items()}
    others = SEEDS[1:]
    n_same = sum(not found for found in silent.values())
    print(f"Seed {SEEDS[0]} against seeds {', '.join(map(str, others))}:", end=" ")
    print(f"{n_same} of {len(folders)} clean and scan cases give the same faces every time, or call what differs ambiguous.")
    if n_same == len(folders):
        return
    print("Faces that differ (of them called ambiguous), and the first of them:\n")
    print("| | faces |", " | ".join(f"seed {seed}" for seed in others), "| |")
    print("|---|---|" + "---|" * len(SEEDS))
    for name, (n_faces, lists) in compared.items():
        if silent[name]:
            cells = [f"{len(found)} ({sum(ambiguous for _, ambiguous in found)})" for found in lists]
            print(f"| {name} | {n_faces} |", " | ".join(cells), f"| {silent[name][0]} |")


if __name__ == "__main__":
    main()
