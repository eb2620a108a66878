"""Names of a STEP assembly as Open CASCADE's XCAF reads them: JSON, one [name, [[component, part], ...]] per free shape.

    python xcaf.py ASSEMBLY.step
"""

import json
import sys

from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPCAFControl import STEPCAFControl_Reader
from OCP.TCollection import TCollection_ExtendedString
from OCP.TDataStd import TDataStd_Name
from OCP.TDF import TDF_Label
from OCP.TDocStd import TDocStd_Document
from OCP.XCAFDoc import XCAFDoc_DocumentTool

try:
    from OCP.TDF import TDF_LabelSequence
except ImportError:
    # The kernel's Python names changed between its versions 7 and 8.
    from OCP.collections import Sequence_TDF_Label as TDF_LabelSequence


def static(cls, name):
    return getattr(cls, name + "_s", None) or getattr(cls, name)


def name(label):
    attribute = TDataStd_Name()
    found = label.FindAttribute(static(TDataStd_Name, "GetID")(), attribute)
    return attribute.Get().ToExtString() if found else ""


def names(path):
    document = TDocStd_Document(TCollection_ExtendedString("XmlXCAF"))
    reader = STEPCAFControl_Reader()
    reader.SetNameMode(True)
    if reader.ReadFile(path) != IFSelect_RetDone or not reader.Transfer(document):
        sys.exit(f"{path}: Open CASCADE does not read it")
    tool = static(XCAFDoc_DocumentTool, "ShapeTool")(document.Main())
    free = TDF_LabelSequence()
    tool.GetFreeShapes(free)
    found = []
    for i in range(1, free.Length() + 1):
        components = TDF_LabelSequence()
        static(type(tool), "GetComponents")(free.Value(i), components)
        inner = []
        for j in range(1, components.Length() + 1):
            part = TDF_Label()
            static(type(tool), "GetReferredShape")(components.Value(j), part)
            inner.append([name(components.Value(j)), name(part)])
        found.append([name(free.Value(i)), inner])
    return found


if __name__ == "__main__":
    print(json.dumps(names(sys.argv[1])))
