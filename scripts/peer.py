"""Runs CGAL's Efficient RANSAC beside `convert`, case by case: faces recovered per type, and CPU times.

    python scripts/peer.py BENCH BIN OUT

BENCH is the folder with peers/cgal_ransac.py and the cases, BIN our program, OUT a folder for the results. Needs g++ and CGAL.
One process at a time, one thread each. CGAL is told the true noise; its time is its detection alone, of the setting kept.
"""

import json
import statistics
import subprocess
import sys

import cases

MOST_CONVERT, MOST_DETECTION = 8, 3
# Recognition and fitting are parts of the stage `segment`; `regularize` refits.
DETECTION_STAGES = ("segment", "regularize")


def build_peer(bench, out):
    """Compiles the peer and returns its Python module, told where the program lies."""
    out.mkdir(parents=True, exist_ok=True)
    source = bench / "peers" / "cgal_ransac.cpp"
    options = ["-O3", "-DNDEBUG", "-march=native", "-std=c++17"]
    subprocess.run(["g++", *options, source, "-o", out / "cgal_ransac", "-lgmp", "-lmpfr"], check=True)
    sys.path.insert(0, str(bench / "peers"))
    import cgal_ransac

    cgal_ransac.HERE = out
    return cgal_ransac


def compare(peer, binary, folder, out):
    """CPU seconds of one case: `convert`, its detection, the peer's detection."""
    ours = out / "ours" / folder.name
    cost = cases.convert(binary, folder / "scan.ply", ours, "--threads", "1")
    timings = json.loads((ours / "timings.json").read_text())
    # Stages are timed by the clock, which other processes slow down; their shares are not.
    share = sum(timings["seconds"][stage] for stage in DETECTION_STAGES) / timings["total_seconds"]
    theirs = out / "peer" / folder.name
    peer.run(folder, theirs)
    return {
        "case": folder.name,
        "convert": cost["cpu"],
        "detection": cost["cpu"] * share,
        "peer": json.loads((theirs / "run.json").read_text())["cpu_seconds"],
    }


def recovered(bench, results):
    """Found or not, per grade and type, of all surfaces asked for."""
    lists = {}
    for folder in cases.case_folders(bench):
        truth, _, found = cases.found_in(folder, results / folder.name)
        for i, surface in enumerate(truth["surfaces"]):
            if surface["asked"]:
                lists.setdefault((truth["grade"], surface["type"]), []).append(i in found)
    return lists


def print_recovered(ours, theirs):
    print("Faces recovered (right type, overlap of at least a half, parameters not absurd) of those asked for:\n")
    print("| | n | Scanwright | CGAL |")
    print("|---|---|---|---|")
    for grade in cases.GRADES:
        for kind in cases.TYPES:
            asked = ours.get((grade, kind), [])
            if asked:
                shares = [f"{sum(side[grade, kind])} ({sum(side[grade, kind]) / len(asked):.2f})" for side in (ours, theirs)]
                print(f"| {grade}: {kind} | {len(asked)} |", " | ".join(shares), "|")


def print_times(rows):
    print("\nCPU seconds, one thread, medians over the cases, and the ratio to CGAL's detection, median / largest:\n")
    print("| | n | CGAL, detection | convert | ratio | segment to fit | ratio |")
    print("|---|---|---|---|---|---|---|")
    for grade in (*cases.GRADES, ""):
        some = [r for r in rows if r["case"].endswith(grade)]
        middle = lambda key: f"{statistics.median(r[key] for r in some):.2f}"
        ratios = {key: [r[key] / r["peer"] for r in some] for key in ("convert", "detection")}
        ratio = lambda key: f"{statistics.median(ratios[key]):.1f} / {max(ratios[key]):.0f}"
        cells = [middle("peer"), middle("convert"), ratio("convert"), middle("detection"), ratio("detection")]
        print(f"| {grade or 'all'} | {len(some)} |", " | ".join(cells), "|")
    asked = f"{MOST_CONVERT} for `convert`, {MOST_DETECTION} for segmentation, recognition and fitting"
    print(f"\nAsked: median ratios over all cases of at most {asked}.")


def main():
    bench, binary, out = cases.folders(sys.argv[1:], 3)
    cases.use_bench(bench)
    peer = build_peer(bench, out)
    rows = [compare(peer, binary, folder, out) for folder in cases.case_folders(bench)]
    (out / "times.json").write_text(json.dumps(rows, indent=1))
    print_recovered(recovered(bench, out / "ours"), recovered(bench, out / "peer"))
    print_times(rows)


if __name__ == "__main__":
    main()
