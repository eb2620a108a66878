"""Holds stated uncertainties against the errors that were made.

    python scripts/coverage.py BENCH OUT

BENCH is the folder with evaluate.py and the cases, OUT that of the results. Of every surface found: radius, half-angle, radii of
tori, and of planes the place at the middle of what was seen, each error over its stated standard uncertainty. Then the noise that
was measured over the noise that was made, per grade.
"""

import json
import sys

import cases
import numpy

WIDE = 1.96  # standard uncertainties of a 95 % interval
ROBUST = 1.4826  # median of magnitudes to standard deviation
SIZES = {
    "plane": ("offset",),
    "cylinder": ("radius",),
    "cone": ("half_angle",),
    "sphere": ("radius",),
    "torus": ("major_radius", "minor_radius"),
}


def errors(surface, primitive, center):
    """Name, error and standard uncertainty of each size."""
    stated = dict(zip(primitive["parameters"], primitive["uncertainty"]))
    for name in SIZES[surface["type"]]:
        if name not in stated:
            continue
        if name == "offset":
            points, normal = (numpy.array(x) for x in ((primitive["point"], surface["point"]), surface["normal"]))
            made = numpy.array(primitive["normal"])
            # Where the line through the middle along the true normal meets our plane, over the true one.
            height = (points[0] - center) @ made / (normal @ made)
            error = (center - points[1]) @ normal + height
        else:
            error = primitive[name] - surface[name]
        yield name, error, stated[name]


def rows_of(folder, result):
    truth, primitives, found = cases.found_in(folder, result)
    vertices, triangles = cases.read_mesh(folder / "scan.ply")
    labels = cases.read_result(result)[1]
    for i, made in sorted(found.items()):
        surface = truth["surfaces"][i]
        if surface["type"] in SIZES:
            center = vertices[triangles[labels == made]].mean(axis=(0, 1))
            for name, error, stated in errors(surface, primitives[made], center):
                yield truth["grade"], f"{surface['type']}: {name}", error, stated


MADE_LENGTH = 10  # grid spacings over which the benchmark's wavy noise falls to 1/e


def noise_of(folder, result):
    """Grade, and measured over made: white noise, correlated noise, its length."""
    truth = cases.read_truth(folder)[0]
    made, spacing = truth["noise"], truth["grid_spacing"]
    measured = json.loads((result / "part.json").read_text())["scan"]["residual_noise"]
    pairs = (measured["white"], made["white"]), (measured["correlated"], made["wavy"]), (measured["length"], MADE_LENGTH)
    return truth["grade"], [a / (b * spacing) for a, b in pairs]


def print_noise(rows):
    print("\n| noise measured over made | white | correlated | length |")
    print("|---|---|---|---|")
    for grade in cases.GRADES:
        of_grade = numpy.array([ratios for g, ratios in rows if g == grade])
        spans = zip(*numpy.quantile(of_grade, (0, 0.25, 0.5, 0.75, 1), axis=0))
        cells = " | ".join(f"{m:.2f} ({q:.2f} .. {r:.2f}; all {a:.2f} .. {b:.2f})" for a, q, m, r, b in spans)
        print(f"| {grade} | {cells} |")


def main():
    bench, out = cases.folders(sys.argv[1:], 2)
    cases.use_bench(bench)
    rows = [row for folder in cases.case_folders(bench) for row in rows_of(folder, out / folder.name)]
    print("| | n | within 95 % intervals | median of the uncertainty over that of the errors |")
    print("|---|---|---|---|")
    for grade in cases.GRADES:
        kinds = sorted({kind for g, kind, *_ in rows if g == grade})
        for kind in ["all", *kinds]:
            some = [(e, u) for g, k, e, u in rows if g == grade and kind in ("all", k)]
            error, stated = (numpy.array(x) for x in zip(*some))
            within = numpy.mean(numpy.abs(error) <= WIDE * stated)
            ratio = numpy.median(stated) / (ROBUST * numpy.median(numpy.abs(error)))
            print(f"| {grade}: {kind} | {len(some)} | {100 * within:.0f} % | {ratio:.2f} |")
    print_noise([noise_of(folder, out / folder.name) for folder in cases.case_folders(bench)])



if __name__ == "__main__":
    main()
