"""Draws reconstructions for docs/benchmark.md, one sheet each: the scan, its regions, the solid.

    python scripts/gallery.py BENCH BIN OUT IMAGES

BENCH is the folder with the cases, BIN our program, OUT a folder for the results, IMAGES where the sheets go.
Only procedural parts, which are free to ship.
"""

import json
import subprocess
import sys

import cases
from PIL import Image, ImageChops, ImageOps

SHOWN = ("cover-1-scan", "fork-1-scan", "ubolt-1-scan", "valvebody-1-scan", "balljoint-1-scan", "vblock-1-rough")
SIDE = 400  # pixels of one of the three pictures
MARGIN = 10
COLORS = 160  # a palette of this size keeps a sheet small
MOST_BYTES = 150_000
# Where the first view lies, as shares of width and height: `render` draws two views in a row, `convert` draws the part
# top right, under a title.
FIRST_OF_TWO, TOP_RIGHT = (0.0, 0.0, 0.5, 1.0), (0.5, 0.05, 1.0, 0.49)


def view(path, part):
    """What is drawn in a part of a picture, fitted into a square."""
    picture = Image.open(path).convert("RGB")
    width, height = picture.size
    picture = picture.crop((part[0] * width, part[1] * height, part[2] * width, part[3] * height))
    background = picture.getpixel((0, 0))
    picture = picture.crop(ImageChops.difference(picture, Image.new("RGB", picture.size, background)).getbbox())
    return ImageOps.pad(picture, (SIDE - 2 * MARGIN, SIDE - 2 * MARGIN), Image.Resampling.LANCZOS, background)


def sheet(views):
    """Views side by side."""
    joined = Image.new("RGB", (SIDE * len(views), SIDE), views[0].getpixel((0, 0)))
    for i, picture in enumerate(views):
        joined.paste(picture, (SIDE * i + MARGIN, MARGIN))
    return joined.quantize(COLORS, dither=Image.Dither.NONE)


def draw(binary, folder, out):
    result = out / folder.name
    cases.convert(binary, folder / "scan.ply", result, "--picture", result / "part.png")
    table = json.loads((result / "part.json").read_text())["support"]
    # With `=`, for a direction may begin with a minus.
    up = ["--up=" + ",".join(map(str, table["normal"]))] if table else []
    for source, name in ((folder / "scan.ply", "scan"), (result / "segments.ply", "regions")):
        subprocess.run([binary, "render", source, "-o", result / f"{name}.png", "--force", *up], check=True)
    views = [view(result / f"{name}.png", FIRST_OF_TWO) for name in ("scan", "regions")]
    return sheet([*views, view(result / "part.png", TOP_RIGHT)])


def main():
    bench, binary, out, images = cases.folders(sys.argv[1:], 4)
    print("Scan, regions, solid; colors of the solid stand for types of surface, pale faces are assumed.\n")
    for name in SHOWN:
        path = images / f"{name}.png"
        draw(binary, bench / "cases" / name, out).save(path, optimize=True)
        if path.stat().st_size > MOST_BYTES:
            sys.exit(f"{path} has {path.stat().st_size} bytes, more than {MOST_BYTES}")
        print(f"![{name}: scan, regions, solid](images/{path.name})\n")


if __name__ == "__main__":
    main()
