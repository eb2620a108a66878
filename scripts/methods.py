"""Segments every case by every method, and prints the overlap of regions with the true surfaces.

    python scripts/methods.py BENCH BIN OUT

BENCH is the folder with the cases, BIN our program, OUT a folder for the results. Needs numpy, scipy and plyfile alone.
The spectral methods run twice: told the true number of surfaces, and finding it.
"""

import concurrent.futures
import pathlib
import statistics
import sys
import time

import cases
import numpy
import plyfile
from scipy.optimize import linear_sum_assignment

METHODS = {
    "default": ("--method", "default"),
    "3D-NCuts, number given": ("--method", "ncuts", "--regions"),
    "3D-NCuts": ("--method", "ncuts"),
    "3D-PIC, number given": ("--method", "pic", "--regions"),
    "3D-PIC": ("--method", "pic"),
}


def overlap(truth, true, made):
    """Mean intersection over union of the surfaces asked for with the regions they are paired with."""
    asked = [i for i, surface in enumerate(truth["surfaces"]) if surface["asked"]]
    ids, size = numpy.unique(made[made >= 0], return_counts=True)
    share = numpy.zeros((len(asked), len(ids)))
    for row, surface in enumerate(asked):
        inside = true == surface
        found, count = numpy.unique(made[inside & (made >= 0)], return_counts=True)
        columns = numpy.searchsorted(ids, found)
        share[row, columns] = count / (inside.sum() + size[columns] - count)
    rows, columns = linear_sum_assignment(-share)
    return share[rows, columns].sum() / len(asked)


def measure(binary, folder, name, out):
    truth, true = cases.read_truth(folder)
    options = list(METHODS[name])
    if options[-1] == "--regions":
        options.append(len(truth["surfaces"]))
    result = out / f"{folder.name}-{'-'.join(name.replace(',', '').split())}.ply"
    start = time.monotonic()
    cost = cases.run([binary, "segment", folder / "scan.ply", "-o", result, "--force", "--threads", 1, *options], out / "log.txt")
    seconds = cost["cpu"] if "cpu" in cost else time.monotonic() - start
    if not result.exists():
        return truth["grade"], name, 0.0, 0, seconds
    made = numpy.asarray(plyfile.PlyData.read(str(result))["face"]["primitive"]).astype(int)
    return truth["grade"], name, overlap(truth, true, made), made.max() + 1 - len(truth["surfaces"]), seconds


def main():
    bench, binary, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
    out.mkdir(parents=True, exist_ok=True)
    tasks = [(folder, name) for folder in cases.case_folders(bench) for name in METHODS]
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        rows = list(pool.map(lambda task: measure(binary, *task, out), tasks))
    print("Mean overlap (intersection over union) of the surfaces asked for with their regions:\n")
    print("| method | clean | scan | rough | regions too many, median | CPU seconds, median |")
    print("|---|---|---|---|---|---|")
    for name in METHODS:
        mine = [row for row in rows if row[1] == name]
        by_grade = [statistics.mean(row[2] for row in mine if row[0] == grade) for grade in cases.GRADES]
        extra, seconds = (statistics.median(row[k] for row in mine) for k in (3, 4))
        print(f"| {name} |", " | ".join(f"{share:.3f}" for share in by_grade), f"| {extra:+.0f} | {seconds:.1f} |")


if __name__ == "__main__":
    main()
