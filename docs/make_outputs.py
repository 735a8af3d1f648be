"""What the examples print, made anew: `python -m docs.make_outputs [--slow] [PAGE ...]`.

For a change that moves numbers on purpose: look at the difference, and say under "Results change" in CHANGELOG.md
what moved and why. Write `?` for an output that is not known yet. Of an output that is elided (`...`), lines that are
shown one after the other are replaced by as many new lines, one after the other, that are most like them: look whether
they still say what the page wants to show. Blocks that take minutes, marked `<!-- slow: why -->`, run with
`--slow` only.
"""

from __future__ import annotations

import difflib
import math
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from itertools import groupby
from pathlib import Path

from tests.docs import pages

NO_ERROR = {0, 3}
"""Exit statuses of commands that have answered: 3 says that nothing was shown to meet a target."""
Change = tuple[int, int, list[str]]
"""First line (from 1), how many lines, and the lines to put there."""


def changes(page: Path, folder: Path, *, slow: bool) -> list[Change]:
    """What has to change in a page, from running its blocks in a copy of the folder."""
    edits: list[Change] = []
    names: dict[str, object] = {"__name__": "page"}
    for block in pages.blocks(page):
        word, rest = block.note
        if word == "file":
            (folder / rest).parent.mkdir(parents=True, exist_ok=True)
            (folder / rest).write_text(block.text, encoding="utf-8")
        elif word == "not run" or (word == "slow" and not slow):
            continue
        elif block.kind == "python":
            printed = pages.run_python(block, names, page)
            if block.output is not None:
                edits += _change(block.output_line, block.output.splitlines(), printed)
        elif block.kind == "console":
            at = block.line
            for command in pages.commands(block):
                at += len(command.lines)
                if command.words.startswith("desim"):
                    status, out, err = pages.run_desim(command.words)
                    if word != "fails" and status not in NO_ERROR:
                        sys.exit(f"{page.name}: {command.words}\n{err}")
                    if command.output:
                        edits += _change(at, command.output, out + err if word == "fails" else out)
                at += len(command.output)
    return edits


def _change(line: int, want: list[str], got: str) -> list[Change]:
    if pages.same("\n".join(want), got):
        return []
    printed = [text.rstrip() for text in got.strip("\n").splitlines()]
    if "..." not in "\n".join(want):
        return [(line, len(want), printed)]
    made, begin = list[Change](), 0
    for at, shown in _between_elisions(want):
        starts = range(begin, len(printed) - len(shown) + 1)
        if starts:
            start = max(starts, key=lambda start: _likeness(shown, printed[start:]))
            begin = start + len(shown)
            made.append((line + at, len(shown), printed[start:begin]))
    return made


def _between_elisions(lines: Sequence[str]) -> Iterator[tuple[int, list[str]]]:
    """Yield the lines between elisions, each group with the number of its first line."""
    for elided, group in groupby(enumerate(lines), key=lambda numbered: "..." in numbered[1]):
        if not elided:
            numbers, texts = zip(*group, strict=True)
            yield numbers[0], list(texts)


def _likeness(lines: Sequence[str], others: Sequence[str]) -> float:
    """Return how alike lines are to others, one by one: 1 for each pair of equal ones."""
    pairs = zip(lines, others, strict=False)
    return math.fsum(difflib.SequenceMatcher(None, one, other).ratio() for one, other in pairs)


def main(arguments: list[str]) -> None:
    """Bring the pages up to date."""
    os.environ["COLUMNS"] = "120"
    home = Path.cwd()
    every = [page for page in pages.PAGES if page not in pages.ELSEWHERE]
    slow = "--slow" in arguments
    for page in [Path(name).resolve() for name in arguments if name != "--slow"] or every:
        with tempfile.TemporaryDirectory() as folder:
            for name in ("models", "studies"):
                shutil.copytree(pages.ROOT / name, Path(folder) / name)
            os.chdir(folder)
            made = changes(page, Path(folder), slow=slow)
            os.chdir(home)
        lines = page.read_text(encoding="utf-8").splitlines()
        for line, many, text in reversed(made):
            lines[line - 1 : line - 1 + many] = text
        if made:
            page.write_text("\n".join(lines) + "\n", encoding="utf-8")
            sys.stdout.write(f"{page.relative_to(pages.ROOT)}: {len(made)} outputs\n")


if __name__ == "__main__":
    main(sys.argv[1:])
