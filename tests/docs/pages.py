"""The pages of the documentation, read as a person would: blocks in order, commands with what they print."""

import contextlib
import doctest
import io
import itertools
import re
import shlex
import sys
import textwrap
from dataclasses import dataclass, field
from pathlib import Path

import click
from ruamel.yaml import YAML

import desim_warehouse as dw
from desim_warehouse.cli import COMMANDS, desim
from desim_warehouse.errors import WarehouseError
from desim_warehouse.model import parse_assignment
from desim_warehouse.study.reading import read_study

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted((ROOT / "docs").rglob("*.md"))]
ELSEWHERE = {ROOT / "docs/how-to/own-policy.md": ROOT / "tests/policies/test_own_policy_page.py"}
"""Pages that have a test of their own."""
_FENCE = re.compile(r"^(?P<indent> *)```(?P<kind>[a-z]*)( [a-z]+=.*)? *$")
_NOTE = re.compile(r"^ *<!-- (?P<word>file|piece|not run|fails|slow)(: (?P<rest>.*?))? -->$")
_CHECKER = doctest.OutputChecker()


@dataclass
class Block:
    """A fenced block: its kind, text and first line; `note` is the comment above it; `output` the block below."""

    kind: str
    text: str
    line: int
    note: tuple[str, str] = ("", "")
    output: str | None = None
    output_line: int = 0


@dataclass
class Command:
    """A line after `$`, as it stands there and as words, and what should be printed."""

    words: str
    lines: list[str]
    output: list[str] = field(default_factory=list)


def blocks(path):
    """The fenced blocks of a page, each python block with the text block that follows it at once."""
    fenced = []
    note, open_block, between = ("", ""), None, True
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        fence = _FENCE.match(line)
        if open_block is not None:
            if fence:
                open_block.text = textwrap.dedent(open_block.text)
                last = fenced[-1] if fenced else None
                if open_block.kind == "text" and not between and last and last.kind == "python":
                    last.output, last.output_line = open_block.text, open_block.line
                else:
                    fenced.append(open_block)
                open_block, between, note = None, False, ("", "")
            else:
                open_block.text += line + "\n"
        elif fence:
            open_block = Block(fence["kind"], "", number + 1, note)
        elif match := _NOTE.match(line):
            note = (match["word"], match["rest"] or "")
        elif line.strip():
            note, between = ("", ""), True
    assert open_block is None, f"{path.name}: a block that is not closed"
    return fenced


def commands(block):
    """The commands of a console block; a line that ends with a backslash goes on."""
    listed = []
    goes_on = False
    for line in block.text.splitlines():
        if goes_on:
            listed[-1].words += " " + line.strip().removesuffix("\\")
            listed[-1].lines.append(line)
        elif line.startswith("$ "):
            listed.append(Command(line[2:].removesuffix("\\"), [line]))
        else:
            assert listed, f"line {block.line}: a console block begins with `$ `"
            listed[-1].output.append(line)
            continue
        goes_on = line.endswith("\\")
    return listed


def same(want, got):
    """Whether the output is as the page says: `...` stands for anything, and spaces do not count."""
    flags = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
    return _CHECKER.check_output(want.strip() + "\n", got.strip() + "\n", flags)


def check_piece(block, file):
    """See that a piece of a model or study is accepted in a file; sections that both have are merged."""
    content = _merged(YAML(typ="safe").load(file.read_text(encoding="utf-8")), YAML(typ="safe").load(block.text))
    whole = file.with_name(f"{file.stem} with the piece of line {block.line}.yaml")
    YAML().dump(content, whole)
    if "model" in content:
        read_study(whole)
    else:
        assert dw.load(whole).floor is not None, "the layout is built"


def _merged(before, piece):
    if not (isinstance(before, dict) and isinstance(piece, dict)):
        return piece
    return before | {key: _merged(before.get(key), value) for key, value in piece.items()}


def run_python(block, names, page):
    """Run a block in the names of its page; what it printed."""
    code = compile("\n" * (block.line - 1) + block.text, str(page), "exec")
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(code, names)  # noqa: S102 - our own pages
    return printed.getvalue()


def run_desim(words):
    """Exit status, output and messages of a `desim` line."""
    out, err = io.StringIO(), io.StringIO()
    status = 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            desim.main(shlex.split(words)[1:], prog_name="desim", standalone_mode=False)
        except WarehouseError as error:
            status = 2
            sys.stderr.write(f"{error}\n")
        except click.ClickException as error:
            status = error.exit_code
            error.show(sys.stderr)
        except click.exceptions.Exit as error:
            status = error.exit_code
        except SystemExit as error:
            status = int(error.code or 0)
    return status, out.getvalue(), err.getvalue()


def parse_desim(words):
    """See that a line could be called so, without doing it: the command is there, and so are its options."""
    name, *rest = shlex.split(words)[1:] or ["--help"]
    if name.startswith("-"):
        assert name in {"--help", "-h", "--version"}, words
        return
    assert name in COMMANDS, f"no such command: {words}"
    outer = click.Context(desim, info_name="desim", **desim.context_settings)
    command = desim.get_command(outer, name)
    assert command is not None
    if {"-h", "--help"} & set(rest):
        return
    with contextlib.redirect_stdout(io.StringIO()):
        command.make_context(name, rest, parent=outer)


def models(page, folder):
    """The models of a page as it stands: of every command with a model file, `--set` and `--unset` applied.

    Nothing is run.

    `folder` has models/ and studies/ already; files of the page are put there, and those that `new` and `import` write.
    """
    for block in blocks(page):
        word, rest = block.note
        if word == "file":
            (folder / rest).parent.mkdir(parents=True, exist_ok=True)
            (folder / rest).write_text(block.text, encoding="utf-8")
        for command in commands(block) if block.kind == "console" and word != "fails" else ():
            words = shlex.split(command.words)
            writes = words[0] == "desim" and words[1] in {"new", "import", "orders"}
            if writes and "--help" not in words:
                run_desim(command.words)
            file = next((item for item in words[2:] if item.endswith(".yaml") and Path(item).is_file()), None)
            if words[0] == "desim" and file and "fleet:" in Path(file).read_text(encoding="utf-8"):
                given = [after for before, after in itertools.pairwise(words) if before == "--set"]
                unset = [after for before, after in itertools.pairwise(words) if before == "--unset"]
                changes = dict(map(parse_assignment, given)) | dict.fromkeys(unset, dw.UNSET)
                yield command.words, dw.load(file, changes)
