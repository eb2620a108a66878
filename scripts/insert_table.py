"""Replaces the block between the table markers of a Markdown page by the text of a file."""

import pathlib
import sys

BEGIN, END = "<!-- table begins -->", "<!-- table ends -->"


def main():
    page, table = (pathlib.Path(argument) for argument in sys.argv[1:])
    before, rest = page.read_text().split(BEGIN)
    _, after = rest.split(END)
    block = f"{BEGIN}\n```text\n{table.read_text().rstrip()}\n```\n{END}"
    page.write_text(before + block + after)


if __name__ == "__main__":
    main()
