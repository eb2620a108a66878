"""Holds what the library reads from STEP files against Open CASCADE: volume, area, faces by type, closedness.

    python scripts/step_faces.py --bin target/debug/examples/step_faces FILE.step...

Needs cadquery-ocp. Prints a line for each file that differs or is open, then counts.
"""

import argparse
import json
import subprocess
from collections import Counter
from pathlib import Path

from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepGProp import BRepGProp
from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

to_face = getattr(TopoDS, "Face_s", None) or TopoDS.Face
surface_properties = getattr(BRepGProp, "SurfaceProperties_s", None) or BRepGProp.SurfaceProperties
volume_properties = getattr(BRepGProp, "VolumeProperties_s", None) or BRepGProp.VolumeProperties
NAMES = {
    GeomAbs_Plane: "plane",
    GeomAbs_Cylinder: "cylinder",
    GeomAbs_Cone: "cone",
    GeomAbs_Sphere: "sphere",
    GeomAbs_Torus: "torus",
}


def reference(path):
    reader = STEPControl_Reader()
    if reader.ReadFile(str(path)) != IFSelect_RetDone:
        return None
    reader.TransferRoots()
    shape = reader.OneShape()
    area, volume = GProp_GProps(), GProp_GProps()
    surface_properties(shape, area)
    volume_properties(shape, volume)
    kinds, areas = Counter(), []
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        face = to_face(explorer.Current())
        kind = NAMES.get(BRepAdaptor_Surface(face).GetType(), "freeform")
        kinds[kind] += 1
        part = GProp_GProps()
        surface_properties(face, part)
        areas.append((kind, part.Mass()))
        explorer.Next()
    return {"volume": volume.Mass(), "area": area.Mass(), "kinds": dict(kinds), "areas": areas}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--bin", required=True)
    parser.add_argument("--all", action="store_true", help="a line for every file")
    parser.add_argument("--faces", action="store_true", help="and one for every face whose area is off")
    parser.add_argument("files", nargs="+", type=Path)
    arguments = parser.parse_args()
    counts = Counter()
    out = subprocess.run([arguments.bin, *map(str, arguments.files)], capture_output=True, text=True, check=True)
    for line in out.stdout.splitlines():
        ours = json.loads(line)
        theirs = reference(ours["path"])
        counts["files"] += 1
        if "error" in ours or theirs is None:
            counts["not read"] += 1
            print(ours["path"], ours.get("error"), "" if theirs else "(nor by Open CASCADE)")
            continue
        # Open CASCADE gives millimetres.
        unit = ours["millimetres"] or 1.0
        volume = ours["volume"] * unit**3 / theirs["volume"] - 1 if theirs["volume"] else float("nan")
        area = ours["area"] * unit**2 / theirs["area"] - 1
        checks = {
            "volume within 0.1 %": abs(volume) < 1e-3,
            "area within 0.1 %": abs(area) < 1e-3,
            "watertight": ours["open"] == 0,
            "same faces by type": ours["kinds"] == theirs["kinds"],
            "all read": not ours["unread"],
        }
        counts.update(name for name, holds in checks.items() if holds)
        if arguments.all or not all(checks.values()):
            print(
                f"{ours['path']}: volume {volume:+.2e}, area {area:+.2e}, open {ours['open']}, "
                f"{ours['triangles']} triangles, {ours['seconds']:.2f} s, faces {ours['kinds']} "
                f"(Open CASCADE {theirs['kinds']}) {ours['unread'][:3]}"
            )
        if arguments.faces and len(ours["areas"]) == len(theirs["areas"]):
            for i, ((name, a), (kind, b)) in enumerate(zip(ours["areas"], theirs["areas"], strict=True)):
                if abs(a * unit**2 - b) > 0.01 * b:
                    print(f"    face {i} {name} {kind}: {a * unit**2:.6g}, should be {b:.6g}")
    for name, count in counts.items():
        print(f"{count:5d} {name}")


if __name__ == "__main__":
    main()
