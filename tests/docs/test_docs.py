"""Everything that the documentation states is carried out: its Python, its commands, its links, its made parts."""

import re
import shlex
import shutil

import pytest

import desim_warehouse as dw
from desim_warehouse.cli import GONE
from docs import make_reference
from tests.docs import pages
from tests.docs.pages import PAGES, ROOT

LONGEST_README = 90  # lines: about two screens


def _name(page):
    return str(page.relative_to(ROOT))


@pytest.fixture
def copy(tmp_path, monkeypatch):
    """The folder as a user has it: models and studies, and nothing made yet."""
    for name in ("models", "studies"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "120")
    return tmp_path


CARRIED_OUT = {"docs/tutorial.md": 6, "docs/reference/check.md": 1}
"""How many commands of the first pages that users read are carried out every day, though they take long."""
TAKE_LONG = {
    *CARRIED_OUT,
    *(
        f"docs/{name}.md"
        for name in (
            "how-to/a-working-day",
            "how-to/best-design",
            "how-to/calibrate",
            "how-to/closures-and-people",
            "how-to/compare-strategies",
            "how-to/find-the-bottleneck",
            "how-to/fleet-size",
            "how-to/from-lif-to-a-fleet-size",
            "how-to/goods-to-person",
            "how-to/how-long",
            "how-to/how-many-robots",
            "how-to/if-demand-grows",
            "how-to/import-a-grid",
            "how-to/in-a-notebook",
            "how-to/my-own-day",
            "how-to/open-rmf-fleet",
            "how-to/orders",
            "how-to/people-who-pick",
            "how-to/robots",
            "how-to/run-a-study",
            "how-to/share-results",
            "how-to/shifts",
            "how-to/tables-and-drawings",
            "how-to/ten-questions",
            "paper",
            "reference/serve",
            "reference/study",
            "tutorial-pods",
        )
    ),
}
"""Pages of over a second of processor: commands and names are read every day, and carried out in the long run."""
SHOW_FIGURES = {
    "docs/how-to/floors-and-lifts.md",
    "docs/how-to/own-layout.md",
    "docs/plan-a-warehouse.md",
    "docs/reference/check.md",
}
"""Pages that print figures of a check, which need whole probes; words of the others are the same with short ones."""
EACH = [
    pytest.param(page, id=_name(page), marks=[pytest.mark.long] if _name(page) in TAKE_LONG else [])
    for page in PAGES
    if page not in pages.ELSEWHERE
]


@pytest.fixture
def _probes(request, page):
    """Whole ones for pages with figures, else short ones."""
    if _name(page) not in SHOW_FIGURES:
        request.getfixturevalue("brief_probes")


@pytest.mark.usefixtures("_probes")
@pytest.mark.parametrize("page", EACH)
def test_every_block_of_a_page_does_what_the_page_says(page, copy):
    _carry_out_page(page, copy, {"slow": "not run"})


@pytest.mark.usefixtures("_probes")
@pytest.mark.parametrize("page", [ROOT / name for name in sorted(TAKE_LONG)], ids=_name)
def test_the_commands_of_a_page_that_takes_long_are_commands(page, copy):
    shown = pages.blocks(page)
    commands = [command.words for block in shown if block.kind == "console" for command in pages.commands(block)]
    assert any(words.startswith("desim") for words in commands) or any(block.kind == "python" for block in shown)
    daily = CARRIED_OUT.get(_name(page), 0)
    _carry_out_page(page, copy, dict.fromkeys(("", "fails", "slow"), "not run"), daily)


SLOW = [page for page in PAGES if any(block.note[0] == "slow" for block in pages.blocks(page))]


@pytest.mark.long
@pytest.mark.parametrize("page", SLOW, ids=_name)
def test_so_do_the_slow_blocks(page, copy):
    """Those that take minutes, marked `<!-- slow: why -->`."""
    _carry_out_page(page, copy, {"slow": ""})


def _carry_out_page(page, copy, read_as, carried_out=0):
    """`read_as` has the notes that stand for others, but for those of the first commands that are carried out."""
    names = {"__name__": "page"}
    for block in pages.blocks(page):
        noted, rest = block.note
        word = read_as.get(noted, noted)
        if word == "file":
            (copy / rest).parent.mkdir(parents=True, exist_ok=True)
            (copy / rest).write_text(block.text, encoding="utf-8")
        elif word == "piece":
            pages.check_piece(block, copy / rest)
        elif block.kind == "python" and word == "not run":
            compile(block.text, _name(page), "exec")
            assert all(hasattr(dw, public) for public in re.findall(r"\bdw\.([a-zA-Z]\w*)", block.text))
        elif block.kind == "python":
            printed = pages.run_python(block, names, page)
            agrees = block.output is None or pages.same(block.output, printed)
            assert agrees, f"{_name(page)}:{block.line} printed\n{printed}"
        elif block.kind == "console":
            for command in pages.commands(block):
                daily = carried_out > 0 and noted in {"", "fails"}
                _carry_out(command, noted if daily else word, f"{_name(page)}:{block.line}")
                carried_out -= daily
        else:
            where = f"{_name(page)}:{block.line}"
            assert block.kind != "yaml" or noted == "not run", (
                f"{where}: no <!-- file: NAME --> or <!-- piece: FILE -->"
            )
            assert block.kind in {"text", "yaml"}, f"{where}: what is a block of {block.kind!r}?"


def _carry_out(command, word, where):
    program = shlex.split(command.words)[0]
    if program == "make":
        targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
        assert set(shlex.split(command.words)[1:]) <= targets, f"{where}: {command.words}: no such target"
    elif program == "desim" and word == "not run":
        pages.parse_desim(command.words)
    elif program == "desim":
        status, out, err = pages.run_desim(command.words)
        assert status == (2 if word == "fails" else 0), f"{where}: {command.words}: exit status {status}\n{out}{err}"
        if command.output:
            got = out + err if word == "fails" else out
            assert pages.same("\n".join(command.output), got), f"{where}: {command.words} printed\n{got}"
    else:
        assert word == "not run", f"{where}: {program} is not run by the tests; say <!-- not run: why --> above"


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_links_lead_somewhere(page):
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for target in re.findall(r"\]\(([^)\s]+)\)", text):
        if re.match(r"[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        file = page.parent / path if path else page
        assert file.exists(), f"{_name(page)}: {target}: no such file"
        if anchor:
            assert anchor in _anchors(file), f"{_name(page)}: {target}: no such heading"


def _anchors(page):
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_commands_in_the_text_can_be_called(page):
    """The changelog and the history before it also name commands that are gone."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    commands = pages.COMMANDS | (GONE if page.name in {"CHANGELOG.md", "history.md"} else {})
    for words in re.findall(r"`desim ([^`]+)`", text):
        name = shlex.split(words)[0]
        assert name in commands or name.startswith("-"), f"{_name(page)}: desim {words}: no such command"


@pytest.mark.parametrize("page", PAGES, ids=_name)
def test_made_parts_are_up_to_date(page):
    """`python -m docs.make_reference` makes them."""
    text = page.read_text(encoding="utf-8")
    assert text == make_reference.made(text), f"{_name(page)}: run python -m docs.make_reference"


def test_every_kind_of_row_is_described():
    """Runs that between them do everything: charge, wait, turn in a ring, queue at a station."""
    model = dw.load(ROOT / "models" / "multibots.yaml")
    crowd = {"fleet.size": 60, "tasks.goods": {"random": 60}, "battery": None}
    runs = [
        dw.simulate(model.replace({"fleet.size": 2})),
        dw.simulate(model.replace(crowd)),
        dw.simulate(dw.load(ROOT / "models" / "tutorial.yaml", {"battery.threshold": 90.0})),
    ]
    seen = {row[1] for run in runs for row in run.record.rows}
    assert seen <= set(make_reference.KINDS)
    assert {"rotation", "docked", "recharged", "collision"} <= seen
    fewer = {row[1] for row in dw.simulate(model.replace({"log": "tasks"})).record.rows}
    assert fewer <= {kind for kind, (level, _, _) in make_reference.KINDS.items() if level == "tasks"}


def test_pages_tested_elsewhere_are():
    for page, test in pages.ELSEWHERE.items():
        assert page.name in test.read_text(encoding="utf-8")


def test_the_readme_is_short():
    assert len((ROOT / "README.md").read_text(encoding="utf-8").splitlines()) <= LONGEST_README


def test_the_pre_commit_file_calls_what_make_lint_calls():
    lint = (ROOT / "Makefile").read_text(encoding="utf-8").partition("\nlint: ")[2].partition("\n\n")[0]
    hooks = (ROOT / ".pre-commit-config.yaml").read_text(encoding="utf-8")
    called = [call.removesuffix(" --force-exclude") for call in re.findall(r"entry: \.venv/bin/(.*)", hooks)]
    assert called == ["ruff check", "ruff format --check", "mypy"]
    assert all(f"$(BIN)/{call}" in lint for call in called)
