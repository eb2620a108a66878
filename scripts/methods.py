"""Segments every case by every method, and prints the overlap of regions with the true surfaces.

    python scripts/methods.py BENCH BIN OUT

BENCH is the folder with the cases, BIN our program, OUT a folder for the results. Needs what the benchmark needs.
Methods that can be told the number of surfaces run twice: told the true one, and finding it.
"""

import concurrent.futures
import statistics
import sys

import cases
import numpy
import plyfile

METHODS = {
    "default": ("--method", "default"),
    "3D-NCuts, number given": ("--method", "ncuts", "--regions"),
    "3D-NCuts": ("--method", "ncuts"),
    "3D-PIC, number given": ("--method", "pic", "--regions"),
    "3D-PIC": ("--method", "pic"),
    "fitting primitives, number given": ("--method", "hfp", "--regions"),
    "fitting primitives": ("--method", "hfp"),
    "Liu and Zhang, number given": ("--method", "liu-zhang", "--regions"),
    "Liu and Zhang": ("--method", "liu-zhang"),
    "after Xiao and others": ("--method", "xiao"),
}


def overlap(truth, true, made):
    """The benchmark's own overlap of the surfaces asked for with the regions they are paired with; types do not count."""
    import evaluate

    regions = [{"id": int(i), "type": "freeform"} for i in numpy.unique(made[made >= 0])]
    return evaluate.segmentation(true, made, truth["surfaces"], regions, truth["diagonal"])[0]["seg_iou"]


def measure(binary, folder, name, out):
    truth, true = cases.read_truth(folder)
    options = list(METHODS[name])
    if options[-1] == "--regions":
        options.append(len(truth["surfaces"]))
    result = out / f"{folder.name}-{'-'.join(name.replace(',', '').split())}.ply"
    command = [binary, "segment", folder / "scan.ply", "-o", result, "--force", "--threads", 1, *options]
    log = result.with_suffix(".txt")
    cost = cases.run(command, log)
    if cost["code"] != 0:
        sys.exit(f"exit code {cost['code']}, see {log}")
    made = numpy.asarray(plyfile.PlyData.read(str(result))["face"]["primitive"]).astype(int)
    return truth["grade"], name, overlap(truth, true, made), made.max() + 1 - len(truth["surfaces"]), cost["cpu"]


def main():
    bench, binary, out = cases.folders(sys.argv[1:], 3)
    cases.use_bench(bench)
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
