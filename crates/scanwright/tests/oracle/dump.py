"""Dump a clean benchmark case with its true labels and surfaces for `examples/oracle.rs`.

    python dump.py CASE_DIR OUT.raw [--move H] [--turn DEG] [--flip ROUNDS] [--seed N]

--move translates every surface by that many grid spacings in a random direction, --turn turns it about its
own centroid, --flip swaps labels of triangles at borders at random, that many rounds.
"""
import argparse
import json
import pathlib
import struct
import sys

import numpy as np
from plyfile import PlyData


def rotation(axis, angle):
    k = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    return np.eye(3) + np.sin(angle) * k + (1 - np.cos(angle)) * k @ k


def largest_piece(triangles):
    """Triangles of the piece with the most of them, joined over vertices."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.csgraph import connected_components
    n = triangles.max() + 1
    a = np.concatenate([triangles[:, 0], triangles[:, 1]])
    b = np.concatenate([triangles[:, 1], triangles[:, 2]])
    _, piece = connected_components(coo_matrix((np.ones(len(a)), (a, b)), shape=(n, n)), directed=False)
    ids, count = np.unique(piece[triangles[:, 0]], return_counts=True)
    return piece[triangles[:, 0]] == ids[count.argmax()]


def flip_borders(triangles, labels, rounds, rng):
    edges = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((edges[:, 1], edges[:, 0]))
    edges, owner = edges[order], owner[order]
    same = (edges[1:] == edges[:-1]).all(1)
    pairs = np.stack([owner[:-1][same], owner[1:][same]], 1)
    for _ in range(rounds):
        border = pairs[labels[pairs[:, 0]] != labels[pairs[:, 1]]]
        pick = border[rng.random(len(border)) < 0.4]
        swap = rng.random(len(pick)) < 0.5
        target, source = np.where(swap, pick[:, 0], pick[:, 1]), np.where(swap, pick[:, 1], pick[:, 0])
        labels[target] = labels[source]
    return labels


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("case", type=pathlib.Path)
    parser.add_argument("out")
    parser.add_argument("--move", type=float, default=0.0)
    parser.add_argument("--turn", type=float, default=0.0)
    parser.add_argument("--flip", type=int, default=0)
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    info = json.loads((args.case / "truth.json").read_text())
    rng = np.random.default_rng(args.seed)
    ply = PlyData.read(str(args.case / "scan.ply"))
    vertices = np.stack([np.asarray(ply["vertex"][k], float) for k in "xyz"], 1)
    triangles = np.vstack(ply["face"]["vertex_indices"]).astype(int)
    labels = np.load(args.case / "truth.npz")["surface"].astype(int)
    keep = (labels >= 0) & largest_piece(triangles)
    triangles, labels = triangles[keep], labels[keep]
    used, triangles = np.unique(triangles.ravel(), return_inverse=True)
    vertices, triangles = vertices[used], triangles.reshape(-1, 3)
    if args.flip:
        labels = flip_borders(triangles, labels, args.flip, rng)
    h = info["grid_spacing"]
    area = np.linalg.norm(np.cross(vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
                                   vertices[triangles[:, 2]] - vertices[triangles[:, 0]]), axis=1).sum() / 2
    spacing = np.sqrt(area / len(vertices))
    with open(args.out, "wb") as f:
        f.write(struct.pack("<diii", spacing, len(vertices), len(triangles), len(info["surfaces"])))
        f.write(vertices.astype("<f8").tobytes())
        f.write(triangles.astype("<i4").tobytes())
        f.write(labels.astype("<i4").tobytes())
        for s in info["surfaces"]:
            axis = rng.normal(size=3)
            turn = rotation(axis / np.linalg.norm(axis), np.radians(args.turn))
            offset = rng.normal(size=3)
            offset *= args.move * h / np.linalg.norm(offset)
            center = np.array(s["centroid"])
            point = lambda p: center + turn @ (np.array(p) - center) + offset
            direction = lambda d: turn @ np.array(d)
            pack = lambda *v: f.write(struct.pack(f"<{len(v)}d", *v))
            t = s["type"]
            kind = ["plane", "cylinder", "cone", "sphere", "torus", "freeform"].index(t)
            f.write(struct.pack("<i", kind))
            if t == "plane":
                pack(*point(s["point"]), *direction(s["normal"]))
            elif t == "cylinder":
                pack(*point(s["axis_point"]), *direction(s["axis_direction"]), s["radius"])
            elif t == "cone":
                a, d = point(s["apex"]), direction(s["axis_direction"])
                d = d / np.linalg.norm(d)
                height = (center + offset - a) @ d
                if height < 0:
                    d, height = -d, -height
                pack(*(a + height * d), *d, height * np.tan(s["half_angle"]), s["half_angle"])
            elif t == "sphere":
                pack(*point(s["center"]), s["radius"])
            elif t == "torus":
                major = s["major_radius"]
                if major < s["minor_radius"]:
                    mine = vertices[triangles[labels == info["surfaces"].index(s)]].reshape(-1, 3)
                    d = np.array(s["axis_direction"]) / np.linalg.norm(s["axis_direction"])
                    w = mine - np.array(s["center"])
                    hgt = w @ d
                    rad = np.linalg.norm(w - np.outer(hgt, d), axis=1)
                    off = lambda R: np.abs(np.hypot(rad - R, hgt) - s["minor_radius"]).mean()
                    major = min(major, -major, key=off)
                pack(*point(s["center"]), *direction(s["axis_direction"]), major, s["minor_radius"])


if __name__ == "__main__":
    sys.exit(main())
