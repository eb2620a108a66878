"""Measures `scanwright assemble` on scans of parts joined at known places.

    python scripts/assemblies.py --bench BENCH --bin target/release/scanwright --out FOLDER [--n 3]

Three procedural parts of the benchmark are joined: a block, upside down, carries a bushing and a ball joint at random places
and turns, and the whole is turned at random. The scan is simulated at the benchmark's grade `scan`. For every part: the
error of its place in units of the registration's own standard uncertainty (six numbers; a turn that is open is left out),
and the largest displacement of its corners. The STEP assembly is opened in Open CASCADE with its names (XCAF).

Needs build123d, open3d, scipy and the benchmark's own modules.
"""

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

PARTS = ("vblock-1", "bushing-1", "balljoint-1")
GRADE = dict(blur=0.8, white=0.08, wavy=0.08, views=60)


def box(shape):
    import truth

    vertices, _, _ = truth.triangulate(shape, truth.diagonal(shape) * 1e-4)
    return vertices.min(0), vertices.max(0)


def joined(bench, seed):
    """The solid and, per part, the 4 x 4 matrix of its place."""
    import truth
    from build123d import Location, Plane, Solid
    from OCP.gp import gp_Trsf

    rng = np.random.default_rng(seed)
    shapes = [truth.read_step(bench / "cases" / f"{name}-clean" / "truth.step") for name in PARTS]
    places = [np.eye(4) for _ in PARTS]
    places[0][:3, :3] = Rotation.from_euler("x", 180, degrees=True).as_matrix()
    low, high = box(shapes[0])
    top = -low[2]
    sides = [-1.0, 1.0]
    for i in (1, 2):
        low_i, _ = box(shapes[i])
        places[i][:3, :3] = Rotation.from_euler("z", rng.uniform(0, 360), degrees=True).as_matrix()
        x = sides[i - 1] * 0.26 * (high[0] - low[0]) + (high[0] + low[0]) / 2
        places[i][:3, 3] = [x + rng.uniform(-1, 1), rng.uniform(-2, 2), top - low_i[2]]
    if PARTS[2] == "balljoint-1":
        # Its hexagon sits on the block, its shank in it.
        places[2][2, 3] = top
    whole = np.eye(4)
    whole[:3, :3] = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
    whole[:3, 3] = rng.uniform(-50, 50, 3)
    places = [whole @ p for p in places]
    solid = None
    for shape, place in zip(shapes, places, strict=True):
        move = gp_Trsf()
        move.SetValues(*place[:3].ravel().tolist())
        part = Solid.cast(shape) if hasattr(Solid, "cast") else Solid(shape)
        part = part.moved(Location(move))
        solid = part if solid is None else solid + part
    del Plane
    return solid, places


def errors(found, true):
    """Place errors in sigmas, turn and way: of the place found, or of the one nearest to the truth that fits as well."""
    return min((error(found, np.array(place), true) for place in [found["scan_from_part"], *found["alternatives"]]),
               key=lambda e: np.linalg.norm(e[1]))


def error(found, scan_from_part, true):
    # The motion left after the true place, in the coordinates of the place found; from another place by the symmetry.
    symmetry = np.linalg.inv(scan_from_part) @ np.array(found["scan_from_part"])
    left = np.linalg.inv(symmetry) @ np.linalg.inv(scan_from_part) @ true @ symmetry
    pivot = np.array(found["pivot_in_part"])
    if found["open"]:
        # These parts are drawn about their z axis: what is open is a turn about it.
        about = Rotation.from_matrix(left[:3, :3]).as_rotvec()[2]
        left[:3, :3] = left[:3, :3] @ Rotation.from_rotvec([0, 0, -about]).as_matrix()
    turn = Rotation.from_matrix(left[:3, :3]).as_rotvec()
    way = left[:3, :3] @ pivot + left[:3, 3] - pivot
    covariance = np.array(found["covariance"])
    # Motions that are open have no variance.
    values, vectors = np.linalg.eigh(covariance)
    known = values > 1e-9 * values.max()
    z = (vectors.T @ np.concatenate([turn, way]))[known] / np.sqrt(values[known])
    return z, turn, way


def names(path):
    """Names of components and of their parts as Open CASCADE's XCAF reads them."""
    script = Path(__file__).parents[1] / "crates/scanwright/tests/xcaf.py"
    run = subprocess.run([sys.executable, script, path], capture_output=True, text=True)
    return run.stdout.strip().splitlines()[-1:] or run.stderr


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--bench", type=Path, required=True)
    parser.add_argument("--bin", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--models", type=Path, help="folder of reconstructed parts, NAME-scan/part.step [default: the truth]")
    parser.add_argument("--n", type=int, default=3)
    arguments = parser.parse_args()
    sys.path.insert(0, str(arguments.bench))
    import scan

    arguments.out.mkdir(parents=True, exist_ok=True)
    all_z = []
    for seed in range(arguments.n):
        folder = arguments.out / f"case-{seed}"
        folder.mkdir(exist_ok=True)
        if not (folder / "places.json").exists():
            solid, places = joined(arguments.bench, seed)
            vertices, triangles, _, h, _ = scan.scan(solid.wrapped, triangles=120_000, seed=seed, **GRADE)
            scan.write_ply(folder / "scan.ply", vertices, triangles)
            (folder / "places.json").write_text(json.dumps({"h": h, "places": [p.tolist() for p in places]}))
        places = json.loads((folder / "places.json").read_text())["places"]
        files = []
        for name in PARTS:
            source = arguments.bench / "cases" / f"{name}-clean" / "truth.step"
            if arguments.models:
                source = arguments.models / f"{name}-scan" / "part.step"
            target = folder / f"{name}.step"
            target.write_bytes(source.read_bytes())
            files.append(target)
        command = [arguments.bin, "assemble", *files, "--scan", folder / "scan.ply", "-o", folder / "all.step"]
        run = subprocess.run(
            [*map(str, command), "--json", str(folder / "all.json"), "--force"], capture_output=True, text=True
        )
        print(f"case {seed}: exit {run.returncode}\n{run.stdout}{run.stderr}", end="")
        if run.returncode not in (0, 4):
            continue
        result = json.loads((folder / "all.json").read_text())
        for part, place in zip(result["parts"], places, strict=True):
            if not part["placed"]:
                continue
            z, turn, way = errors(part, np.array(place))
            all_z.extend(z)
            print(
                f"  {part['name']}: largest |z| {np.abs(z).max():.2f} of {len(z)}, way {np.linalg.norm(way):.4f}, "
                f"turn {np.degrees(np.linalg.norm(turn)):.4f} deg"
            )
        print("  names:", names(folder / "all.step"))
    if all_z:
        print(f"{len(all_z)} numbers, rms {np.sqrt(np.mean(np.square(all_z))):.2f}, largest {np.abs(all_z).max():.2f}")


if __name__ == "__main__":
    main()
