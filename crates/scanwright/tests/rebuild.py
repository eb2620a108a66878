"""What scripts rebuild, beside the solids they are of: one JSON line per pair.

    python rebuild.py PART.py PART.step [PART.py PART.step ...]
"""
import contextlib
import io
import json
import runpy
import sys

from build123d import import_step


def measures(shape):
    box = shape.bounding_box()
    return {
        "valid": bool(shape.is_valid),
        "solids": len(shape.solids()),
        "faces": len(shape.faces()),
        "volume": shape.volume,
        "area": shape.area,
        "low": list(box.min),
        "high": list(box.max),
    }


def rebuilt(script):
    said = io.StringIO()
    sys.argv = [script]
    with contextlib.redirect_stdout(said):
        part = runpy.run_path(script)["part"]
    return {**measures(part), "said": said.getvalue()}


arguments = sys.argv[1:]
for script, step in zip(arguments[::2], arguments[1::2]):
    print(json.dumps({"rebuilt": rebuilt(script), "solid": measures(import_step(step))}), flush=True)
