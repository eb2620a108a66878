"""Holds parameter errors against a floor: a robust orthogonal fit of the true type on the true labels, away from borders.

    python scripts/floor.py BENCH OUT

BENCH is the folder with evaluate.py and the cases, OUT that of the results; writes OUT/floor.json, a row per surface.
The fit starts at the truth and runs until it no longer moves, so that no wrong minimum is in its way. It sees one surface at a
time: no neighbour, no relation to others, no correction for the scanner's spot; errors below the floor are possible.
"""

import json
import sys

import cases
import fits
import numpy
from scipy.spatial import cKDTree
from summary import percentile

MOST = 2.0  # ratio of the medians that is asked
BORDER = 2.5  # grid spacings from a border within which vertices are left out, ...
BORDER_SHARE = 0.25  # ... on narrow faces this share of the width
COMPLETE = 330.0  # degrees of turn from which a round face counts as seen all round
MOST_POINTS = 20_000
MEASURES = ("axis, degrees", "position / diagonal", "size, %")


def interior(vertices, triangles, spacing, width):
    """The vertices of a face of this width (in spacings) that lie away from its border."""
    edges = numpy.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, count = numpy.unique(edges, axis=0, return_counts=True)
    border, mine = numpy.unique(edges[count == 1]), vertices[numpy.unique(triangles)]
    if len(border):
        depth = cKDTree(vertices[border]).query(mine)[0]
        mine = mine[depth > min(BORDER, BORDER_SHARE * width) * spacing]
    return mine[:: -(-len(mine) // MOST_POINTS)]


def seen_turn(surface, points, vertices, triangles):
    """Degrees about its axis in which a round face is seen; of a sphere the share of its area, as degrees of 360."""
    if surface["type"] == "plane":
        return None
    if surface["type"] == "sphere":
        corners = vertices[triangles]
        normals = numpy.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = numpy.linalg.norm(normals, axis=1).sum() / 2
        return 360 * min(1.0, area / (4 * numpy.pi * surface["radius"] ** 2))
    origin = next(surface[key] for key in ("axis_point", "apex", "center") if key in surface)
    a, b = fits.frame(fits.unit(numpy.array(surface["axis_direction"])))
    offset = points - numpy.array(origin)
    angles = numpy.sort(numpy.degrees(numpy.arctan2(offset @ b, offset @ a)))
    gaps = numpy.diff(angles, append=angles[0] + 360)
    return float(360 - gaps.max())


def errors(truth, i, primitive):
    """Angle, position and size of one surface as the benchmark measures them."""
    import evaluate

    measured = evaluate.parameters({i: 0}, truth["surfaces"], [primitive | {"id": 0}], truth["diagonal"])
    return measured["parameter_errors"][truth["surfaces"][i]["type"]][0]


def rows_of(folder, result):
    truth, primitives, found = cases.found_in(folder, result)
    vertices, triangles = cases.read_mesh(folder / "scan.ply")
    _, true = cases.read_truth(folder)
    spacing = truth["grid_spacing"]
    noise = spacing * numpy.hypot(truth["noise"]["white"], truth["noise"]["wavy"])
    for i, made in sorted(found.items()):
        surface, mine = truth["surfaces"][i], triangles[true == i]
        points = interior(vertices, mine, spacing, surface["width"])
        yield {
            "case": folder.name,
            "grade": truth["grade"],
            "surface": i,
            "primitive": made,
            "type": surface["type"],
            "width": surface["width"],
            "points": len(points),
            "turn": seen_turn(surface, points, vertices, mine),
            "ours": errors(truth, i, primitives[made]),
            "floor": errors(truth, i, fits.fit(surface, points, noise)),
        }


def groups(rows):
    """Name, kind and rows of each line of the tables: grade and type, round ones complete and partial apart."""
    for grade in cases.GRADES:
        for kind in cases.TYPES:
            some = [r for r in rows if r["grade"] == grade and r["type"] == kind]
            if kind == "plane":
                parts = {"": some}
            else:
                whole = lambda row: row["turn"] >= COMPLETE
                parts = {", complete": list(filter(whole, some)), ", partial": [r for r in some if not whole(r)]}
            yield from ((f"{grade}: {kind}{name}", kind, part) for name, part in parts.items() if part)


def compared(rows, measure, share):
    """Our error and the floor's at this share of the surfaces."""
    factor = 100 if measure == 2 else 1
    return tuple(factor * percentile([r[side][measure] for r in rows], share) for side in ("ours", "floor"))


def print_table(rows, share, above):
    print("| | n |", " | ".join(f"{name} | ratio" for name in MEASURES), "|")
    print("|---|---" + "|---|---" * len(MEASURES) + "|")
    for name, kind, some in groups(rows):
        cells = []
        for measure, form in enumerate((".3f", ".1e", ".2f")):
            if (kind, measure) in (("plane", 2), ("sphere", 0)):
                cells += ["", ""]
                continue
            ours, floor = compared(some, measure, share)
            ratio = ours / max(floor, 1e-12)
            cells += [f"{ours:{form}} / {floor:{form}}", f"{ratio:.1f}"]
            if ratio > MOST:
                above.append(f"{name} ({len(some)}), {MEASURES[measure].split(',')[0]} {ratio:.1f}")
        print(f"| {name} | {len(some)} |", " | ".join(cells), "|")


def main():
    bench, out = cases.folders(sys.argv[1:], 2)
    cases.use_bench(bench)
    rows = [row for folder in cases.case_folders(bench) for row in rows_of(folder, out / folder.name)]
    (out / "floor.json").write_text(json.dumps(rows, indent=1, default=float))
    above = []
    print("Medians, ours / floor:\n")
    print_table(rows, 0.5, above)
    print(f"\nAbove {MOST:g} times the floor:", "; ".join(above) or "none", end=".\n")
    print("\n95th percentiles, ours / floor:\n")
    print_table(rows, 0.95, [])


if __name__ == "__main__":
    main()
