"""What Open CASCADE makes of STEP files: one JSON line per file.

    python occ.py PART.step...

Volumes are in cubic millimetres, whatever the file's unit.
"""
import json
import sys
from collections import Counter

from OCP.BRep import BRep_Tool
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_EDGE, TopAbs_FACE, TopAbs_SOLID, TopAbs_VERTEX
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS


def parts(shape, kind):
    explorer = TopExp_Explorer(shape, kind)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def judge(path):
    reader = STEPControl_Reader()
    if int(reader.ReadFile(path)) != 1:
        return {"readable": False}
    reader.TransferRoots()
    shape = reader.OneShape()
    volume = GProp_GProps()
    BRepGProp.VolumeProperties_s(shape, volume)
    kinds = Counter(
        str(BRepAdaptor_Surface(TopoDS.Face(face)).GetType()).split("GeomAbs_")[-1].split(":")[0].rstrip(">")
        for face in parts(shape, TopAbs_FACE)
    )
    tolerances = [BRep_Tool.Tolerance_s(TopoDS.Edge(e)) for e in parts(shape, TopAbs_EDGE)]
    tolerances += [BRep_Tool.Tolerance_s(TopoDS.Vertex(v)) for v in parts(shape, TopAbs_VERTEX)]
    return {
        "readable": True,
        "valid": BRepCheck_Analyzer(shape).IsValid(),
        "solids": sum(1 for _ in parts(shape, TopAbs_SOLID)),
        "volume": volume.Mass(),
        "faces": dict(sorted(kinds.items())),
        "gap": max(tolerances, default=0.0),
    }


for path in sys.argv[1:]:
    print(json.dumps(judge(path)))
