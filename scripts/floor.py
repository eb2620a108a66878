"""Holds parameter errors against a floor: a robust orthogonal fit of the true type on the true labels, away from borders.

    python scripts/floor.py BENCH OUT

BENCH is the folder with evaluate.py and the cases, OUT that of the results; writes OUT/floor.json, a row per surface.
The fit starts at the truth and runs until it no longer moves, so it cannot end in a wrong minimum. It sees one surface at a time:
no neighbour, no relation to others, no correction for the scanner's spot; errors below the floor are possible.
"""

import json
import sys

import cases
import numpy
from scipy.optimize import least_squares
from scipy.spatial import cKDTree
from summary import percentile

MOST = 2.0  # ratio of the medians that is asked
BORDER = 2.5  # grid spacings from a border within which vertices are left out, ...
BORDER_SHARE = 0.25  # ... on narrow faces this share of the width
LINEAR = 2.0  # standard deviations from which on distances count linearly, not squared
NORMAL = 1.4826  # standard deviation over median of the absolute value
COMPLETE = 330.0  # degrees of turn from which a round face counts as seen all round
MOST_POINTS = 20_000
MEASURES = ("axis, degrees", "position / diagonal", "size, %")


def unit(vector):
    return vector / numpy.linalg.norm(vector)


def frame(axis):
    """Two directions across `axis`."""
    across = unit(numpy.cross(axis, numpy.eye(3)[numpy.argmin(numpy.abs(axis))]))
    return across, numpy.cross(axis, across)


def tilted(axis, tilts):
    a, b = frame(axis)
    return unit(axis + tilts[0] * a + tilts[1] * b)


def about(points, on_axis, axis):
    """Height along an axis, and distance from it."""
    offset = points - on_axis
    height = offset @ axis
    return height, numpy.linalg.norm(offset - height[:, None] * axis, axis=1)


# A model turns a true surface and the middle of its points into start values, and values into a surface and signed distances.


class Plane:
    lengths = (True, False, False)  # which of the values are lengths; the others are angles

    def __init__(self, surface, middle):
        self.normal = unit(numpy.array(surface["normal"]))
        self.middle = middle
        self.start = [(numpy.array(surface["point"]) - middle) @ self.normal, 0, 0]

    def surface(self, values):
        return {"point": self.middle + values[0] * self.normal, "normal": tilted(self.normal, values[1:])}

    def distances(self, values, points):
        plane = self.surface(values)
        return (points - plane["point"]) @ plane["normal"]


class Turned:
    """What has an axis: offsets across it at the middle of the points, tilts, then what the type adds."""

    lengths = (True, True, False, False)

    def __init__(self, on_axis, axis, middle):
        self.axis = unit(numpy.array(axis))
        self.across = frame(self.axis)
        on_axis = numpy.array(on_axis)
        self.foot = on_axis + (middle - on_axis) @ self.axis * self.axis
        self.start = [0, 0, 0, 0]

    def line(self, values):
        point = self.foot + values[0] * self.across[0] + values[1] * self.across[1]
        return point, tilted(self.axis, values[2:4])


class Cylinder(Turned):
    lengths = (*Turned.lengths, True)

    def __init__(self, surface, middle):
        super().__init__(surface["axis_point"], surface["axis_direction"], middle)
        self.start += [surface["radius"]]

    def surface(self, values):
        point, axis = self.line(values)
        return {"axis_point": point, "axis_direction": axis, "radius": values[4]}

    def distances(self, values, points):
        return about(points, *self.line(values))[1] - values[4]


class Cone(Turned):
    """By the radius beside the middle of the points, which they show, and not by the apex, which may be far away."""

    lengths = (*Turned.lengths, True, False)

    def __init__(self, surface, middle):
        apex = numpy.array(surface["apex"])
        # The truth's axis may point either way.
        growing = numpy.array(surface["axis_direction"]) * numpy.sign((middle - apex) @ surface["axis_direction"])
        super().__init__(apex, growing, middle)
        height = (self.foot - apex) @ self.axis
        self.start += [height * numpy.tan(surface["half_angle"]), surface["half_angle"]]

    def surface(self, values):
        point, axis = self.line(values)
        apex = point - values[4] / numpy.tan(values[5]) * axis
        return {"apex": apex, "axis_direction": axis, "half_angle": values[5]}

    def distances(self, values, points):
        height, radius = about(points, *self.line(values))
        return (radius - values[4]) * numpy.cos(values[5]) - height * numpy.sin(values[5])


class Sphere:
    lengths = (True, True, True, True)

    def __init__(self, surface, _):
        self.start = [*surface["center"], surface["radius"]]

    def surface(self, values):
        return {"center": values[:3], "radius": values[3]}

    def distances(self, values, points):
        return numpy.linalg.norm(points - values[:3], axis=1) - values[3]


class Torus(Turned):
    lengths = (*Turned.lengths, True, True, True)

    def __init__(self, surface, _):
        super().__init__(surface["center"], surface["axis_direction"], numpy.array(surface["center"]))
        self.start += [0, surface["major_radius"], surface["minor_radius"]]

    def surface(self, values):
        point, axis = self.line(values)
        center = point + values[4] * self.axis
        return {"center": center, "axis_direction": axis, "major_radius": values[5], "minor_radius": values[6]}

    def distances(self, values, points):
        torus = self.surface(values)
        height, radius = about(points, torus["center"], torus["axis_direction"])
        return numpy.hypot(radius - values[5], height) - values[6]


MODELS = {"plane": Plane, "cylinder": Cylinder, "cone": Cone, "sphere": Sphere, "torus": Torus}


def interior(vertices, triangles, spacing, width):
    """The vertices of a face of this width (in spacings) that lie away from its border."""
    edges = numpy.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, count = numpy.unique(edges, axis=0, return_counts=True)
    border, mine = numpy.unique(edges[count == 1]), vertices[numpy.unique(triangles)]
    if len(border):
        depth = cKDTree(vertices[border]).query(mine)[0]
        mine = mine[depth > min(BORDER, BORDER_SHARE * width) * spacing]
    return mine[:: -(-len(mine) // MOST_POINTS)]


def fit(surface, points, noise):
    """The surface of the true type with the least sum of robust squared distances."""
    middle = points.mean(axis=0)
    scale = numpy.linalg.norm(points.max(axis=0) - points.min(axis=0))
    model = MODELS[surface["type"]](surface, middle)
    ends = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14, "max_nfev": 200}
    # Lengths in units of the face's size.
    steps = numpy.where(model.lengths, scale, 1.0)
    off = lambda values: model.distances(values * steps, points)
    plain = least_squares(off, model.start / steps, jac="3-point", **ends)
    spread = max(noise, NORMAL * numpy.median(numpy.abs(plain.fun)))
    robust = least_squares(off, plain.x, jac="3-point", loss="soft_l1", f_scale=LINEAR * spread, **ends)
    values = robust.x * steps
    return {"type": surface["type"], **model.surface(values)}


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
    a, b = frame(unit(numpy.array(surface["axis_direction"])))
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
            "floor": errors(truth, i, fit(surface, points, noise)),
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
