"""Robust orthogonal least squares of a plane, cylinder, cone, sphere or torus, from a start near the solution.

Surfaces are dictionaries as in truth.json. Lengths in the scan's unit, angles in radians.
"""

import numpy
from scipy.optimize import least_squares

LINEAR = 2.0  # standard deviations from which on distances count linearly, not squared
NORMAL = 1.4826  # standard deviation over median of the absolute value


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


# A model turns a surface and the middle of its points into start values, and values into a surface and signed distances.


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


def fit(surface, points, noise):
    """The surface of the same type with the least sum of robust squared distances, started at `surface`.

    `noise` is the standard deviation expected at least.
    """
    middle = points.mean(axis=0)
    scale = numpy.linalg.norm(points.max(axis=0) - points.min(axis=0))
    model = MODELS[surface["type"]](surface, middle)
    ends = {"xtol": 1e-14, "ftol": 1e-14, "gtol": 1e-14, "max_nfev": 200}
    # Lengths enter in units of the face's size.
    steps = numpy.where(model.lengths, scale, 1.0)
    off = lambda values: model.distances(values * steps, points)
    plain = least_squares(off, model.start / steps, jac="3-point", **ends)
    spread = max(noise, NORMAL * numpy.median(numpy.abs(plain.fun)))
    robust = least_squares(off, plain.x, jac="3-point", loss="soft_l1", f_scale=LINEAR * spread, **ends)
    values = robust.x * steps
    return {"type": surface["type"], **model.surface(values)}
