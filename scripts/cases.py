"""What the measurements share: the benchmark's modules, results held against the truth, processes with their cost."""

import json
import os
import pathlib
import subprocess
import sys
import time

import numpy
import plyfile

GRADES = ("clean", "scan", "rough")
TYPES = ("plane", "cylinder", "cone", "sphere", "torus")


def use_bench(bench):
    """Makes the benchmark's modules importable, without leaving compiled files in its folder."""
    sys.dont_write_bytecode = True
    sys.path.insert(0, str(bench))


def case_folders(bench):
    return sorted(folder for folder in (bench / "cases").iterdir() if (folder / "truth.npz").exists())


def read_truth(folder):
    """The truth of a case, and the true surface of each triangle of its scan."""
    truth = json.loads((folder / "truth.json").read_text())
    return truth, numpy.load(folder / "truth.npz")["surface"].astype(int)


def read_mesh(path):
    """Vertices and triangles of a PLY file."""
    ply = plyfile.PlyData.read(str(path))
    vertices = numpy.stack([ply["vertex"][axis] for axis in "xyz"], axis=1).astype(float)
    return vertices, numpy.vstack(ply["face"]["vertex_indices"])


def read_result(result):
    """Primitives by id, and the primitive of each triangle."""
    primitives = json.loads((result / "part.json").read_text())["primitives"]
    faces = plyfile.PlyData.read(str(result / "segments.ply"))["face"]
    return {p["id"]: p for p in primitives}, numpy.asarray(faces["primitive"]).astype(int)


def found_in(folder, result):
    """The truth of a case, the primitives found, and which of them each found surface is (index of surface: id)."""
    import evaluate

    truth, true = read_truth(folder)
    primitives, made = read_result(result)
    _, found = evaluate.segmentation(true, made, truth["surfaces"], list(primitives.values()), truth["diagonal"])
    return truth, primitives, found


def peak_mib(pid):
    """The largest memory of a running process so far, 0 once it has ended.

    The figure that comes with its exit counts the memory of this process too, as the child starts as a copy of it.
    """
    try:
        status = pathlib.Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0.0
    return max([int(line.split()[1]) / 1024 for line in status.splitlines() if line.startswith("VmHWM")], default=0.0)


def run(command, log):
    """Runs one process: its CPU and wall seconds, peak memory in MiB, and exit code."""
    largest, ended = 0.0, 0
    with open(log, "wb") as stream:
        start = time.monotonic()
        child = subprocess.Popen([str(word) for word in command], stdout=stream, stderr=stream)
        while not ended:
            time.sleep(0.01)
            largest = max(largest, peak_mib(child.pid))
            ended, status, usage = os.wait4(child.pid, os.WNOHANG)
    child.returncode = os.waitstatus_to_exitcode(status)
    return {
        "cpu": usage.ru_utime + usage.ru_stime,
        "wall": time.monotonic() - start,
        "mib": largest,
        "code": child.returncode,
    }


def convert(binary, scan, result, *options):
    """Converts a scan as the benchmark does, with further options; 0 and 4 mean that files were written."""
    result.mkdir(parents=True, exist_ok=True)
    outputs = ["-o", result / "part.step", "--json", result / "part.json", "--segments", result / "segments.ply"]
    command = [binary, "convert", scan, *outputs, "--timings", result / "timings.json", "--force", *options]
    cost = run(command, result / "log.txt")
    if cost["code"] not in (0, 4):
        sys.exit(f"exit code {cost['code']}, see {result / 'log.txt'}")
    return cost


def folders(arguments, n):
    """The first `n` arguments as paths."""
    return [pathlib.Path(argument).resolve() for argument in arguments[:n]]
