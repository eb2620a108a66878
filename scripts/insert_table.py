"""Replaces the block between the markers `<!-- NAME begins -->` and `<!-- NAME ends -->` of a page by a file.

Markdown is inserted as it is, other text as code.
"""

import pathlib
import sys


def main():
    page, name, table = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
    begin, end = f"<!-- {name} begins -->", f"<!-- {name} ends -->"
    before, rest = page.read_text().split(begin)
    _, after = rest.split(end)
    text = table.read_text().strip()
    block = text if table.suffix == ".md" else f"```text\n{text}\n```"
    page.write_text(f"{before}{begin}\n{block}\n{end}{after}")


if __name__ == "__main__":
    main()
