"""Judge STEP files with Open CASCADE through the benchmark's own scoring.

    python judge.py BENCH_DIR CASE_DIR PART.step          one case, in a child process with a time limit
"""
import json
import pathlib
import re
import subprocess
import sys

LIMIT_SECONDS = 300


def child(bench, case, step):
    sys.path.insert(0, bench)
    import evaluate
    import truth
    case = pathlib.Path(case)
    shape = truth.read_step(case / "truth.step")
    row = evaluate.solid(step, shape, truth.diagonal(shape), n=10000)
    row["usable"] = float(evaluate.usable(row)) if "step_faces" in row else 0.0
    row["written"] = len(re.findall(r"=ADVANCED_FACE\(", pathlib.Path(step).read_text()))
    if row["step_valid"] == 0 and row["step_readable"]:
        from OCP.BRepCheck import BRepCheck_Analyzer
        made = truth.read_step(step)
        check = BRepCheck_Analyzer(made)
        row["bad_faces"] = [i for i, f in enumerate(truth.faces_of(made)) if not check.IsValid(f)]
    print(json.dumps(row))


def main():
    if sys.argv[1] == "--child":
        return child(*sys.argv[2:5])
    try:
        done = subprocess.run([sys.executable, __file__, "--child", *sys.argv[1:4]], capture_output=True, text=True, timeout=LIMIT_SECONDS)
        lines = done.stdout.strip().splitlines()
        row = json.loads(lines[-1]) if lines else {"crashed": done.stderr[-300:]}
    except subprocess.TimeoutExpired:
        row = {"hang": LIMIT_SECONDS}
    name = pathlib.Path(sys.argv[2]).name
    get = lambda k: row.get(k, float("nan"))
    same = "" if row.get("written") == row.get("step_faces") else f" WRITTEN {row.get('written')}"
    print(f"{name:22s} valid {get('step_valid'):.0f} solid {get('step_solid'):.0f} usable {get('usable'):.0f} type {get('step_type'):.3f} "
          f"vol {get('volume_error'):.4f} miss {get('missing'):.4f} extra {get('extra'):.4f} gap {get('step_gap'):.2e} "
          f"faces {row.get('step_faces')}/{row.get('true_faces')}{same} {row.get('bad_faces', '')} {row.get('crashed', '')}{row.get('hang', '')}")


if __name__ == "__main__":
    main()
