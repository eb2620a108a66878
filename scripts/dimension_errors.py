"""What relations are worth: errors of dimensions with and without them.

    python scripts/dimension_errors.py BENCH WITH WITHOUT [WORD]

BENCH is the folder with evaluate.py and the cases, WITH the results of `convert`, WITHOUT those of `convert --relations off`; WORD
chooses cases by their name, "-1-scan" by default: the procedural parts. A dimension is between surfaces that both runs found.
"""

import itertools
import sys

import cases
import numpy

EXACT = 1e-6  # sine below which true directions are parallel, cosine below which they are perpendicular
SIZES = ("radius", "half_angle", "major_radius", "minor_radius")


class Seen:
    """A surface, true or fitted, with the middle of what was seen of it."""

    def __init__(self, surface, center):
        self.surface = surface
        direction = surface.get("normal") or surface.get("axis_direction")
        self.direction = direction and numpy.array(direction)
        self.is_plane = surface["type"] == "plane"
        place = next((surface[k] for k in ("point", "axis_point", "center", "apex") if k in surface), None)
        if self.is_plane:
            point = numpy.array(place)
            self.at = center - ((center - point) @ self.direction) * self.direction
        elif self.direction is not None:
            point = numpy.array(place)
            self.at = point + ((center - point) @ self.direction) * self.direction
        else:
            self.at = numpy.array(place)


def dimensions(a, b, kind):
    """The value of a dimension of two surfaces."""
    if kind == "angle":
        return numpy.arctan2(numpy.linalg.norm(numpy.cross(a.direction, b.direction)), abs(a.direction @ b.direction))
    sign = numpy.sign(a.direction @ b.direction)
    mean = a.direction + sign * b.direction
    mean /= numpy.linalg.norm(mean)
    between = b.at - a.at
    return abs(between @ mean) if kind == "distance of planes" else numpy.linalg.norm(between - (between @ mean) * mean)


def kinds(a, b):
    """Which dimensions two true surfaces have."""
    if a.direction is None or b.direction is None:
        return
    parallel = numpy.linalg.norm(numpy.cross(a.direction, b.direction)) < EXACT
    if parallel or abs(a.direction @ b.direction) < EXACT:
        yield "angle"
    if parallel and a.is_plane and b.is_plane:
        yield "distance of planes"
    if parallel and not a.is_plane and not b.is_plane:
        yield "distance of axes"


def errors_of(folder, results):
    """Kind and the errors under each of `results` of every dimension of a case."""
    runs = [cases.found_in(folder, result) for result in results]
    truth = runs[0][0]
    vertices, triangles = cases.read_mesh(folder / "scan.ply")
    labels = [cases.read_result(result)[1] for result in results]
    common = sorted(set.intersection(*(set(found) for _, _, found in runs)))
    seen = {}
    for i in common:
        surface = truth["surfaces"][i]
        made = [primitives[found[i]] for _, primitives, found in runs]
        if any(m["type"] != surface["type"] for m in made) or surface["type"] not in cases.TYPES:
            continue
        center = vertices[triangles[labels[0] == runs[0][2][i]]].mean(axis=(0, 1))
        seen[i] = [Seen(x, center) for x in (surface, *made)]
        for name in SIZES:
            if name in surface:
                yield name, [m[name] - surface[name] for m in made]
    for i, j in itertools.combinations(seen, 2):
        (true_a, *made_a), (true_b, *made_b) = seen[i], seen[j]
        for kind in kinds(true_a, true_b):
            true = dimensions(true_a, true_b, kind)
            yield kind, [dimensions(a, b, kind) - true for a, b in zip(made_a, made_b)]


def main():
    bench, *results = cases.folders(sys.argv[1:], 3)
    word = sys.argv[4] if len(sys.argv) > 4 else "-1-scan"
    cases.use_bench(bench)
    folders = [folder for folder in cases.case_folders(bench) if word in folder.name]
    rows = [row for folder in folders for row in errors_of(folder, [result / folder.name for result in results])]
    print("| dimension | n | median error with | without | ratio | root mean square with | without | ratio |")
    print("|---|---|---|---|---|---|---|---|")
    for kind in sorted({kind for kind, _ in rows}):
        errors = numpy.abs([errors for k, errors in rows if k == kind])
        cells = []
        for measure in (lambda e: numpy.median(e, axis=0), lambda e: numpy.sqrt((e**2).mean(axis=0))):
            having, lacking = measure(errors)
            cells += [f"{having:.5f}", f"{lacking:.5f}", f"{having / lacking:.2f}"]
        print(f"| {kind} | {len(errors)} | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
