"""What a notebook shows: frames of one style without scripts, one bar, short errors; and work that is interrupted."""

import html
import re
from queue import Empty

import pytest

import desim_warehouse as dw
from desim_warehouse.answer.numbers import sentence
from desim_warehouse.look.html import _short
from desim_warehouse.look.web import colours
from desim_warehouse.report.example import example
from tests.lasting import LASTING

pytestmark = pytest.mark.usefixtures("brief_probes")

FRAME = re.compile(r'<iframe title="[^"]+" srcdoc="([^"]*)" sandbox="" style="[^"]*"></iframe>')


def shown(thing):
    """The page in the frame that Jupyter shows of a thing."""
    return html.unescape(FRAME.fullmatch(thing._repr_html_())[1])


@pytest.mark.slow
def test_runs_results_answers_and_checks_are_shown_in_one_style_without_scripts():
    model = example().replace(LASTING)
    study = dw.Study(model, {"fleet.size": [1, 3]}, replications=2)
    things = {
        "run": dw.simulate(model),
        "results": study.run().results,
        "why": dw.why(model, search=dw.Search(first=2, cap=2)),
        "check": dw.check(model),
    }
    pages = {name: shown(thing) for name, thing in things.items()}
    assert all(_short(colours(themes=False)) in page for page in pages.values())
    assert all("prefers-color-scheme:dark" in page for page in pages.values())
    assert not [name for name, page in pages.items() if re.search(r"<script|\son\w+=|javascript:", page)]
    run, check = things["run"], things["check"]
    assert "Throughput" in pages["run"]
    assert f"<li>{sentence(check.verdict)}</li>" in pages["check"]
    assert all(html.escape(line) in pages["check"] for line in check.lines)
    assert run.model.name in pages["run"]


def test_a_check_shows_its_findings_with_what_to_do():
    report = dw.check(example().replace({"fleet.size": 60}))
    page = shown(report)
    assert report.findings
    for item in report.findings:
        assert {item.code, item.level} <= set(re.findall(r"<td>([^<]*)</td>", page))
    assert "<summary>The model</summary>" in page


def test_a_cell_shows_the_message_of_an_error_and_not_the_way_through_the_code(capsys):
    from IPython.core.interactiveshell import InteractiveShell

    shell = InteractiveShell()
    shell.run_cell("import desim_warehouse as dw\ndw.load('models/tutorial.yaml', {'fleet.sise': 3})")
    lines = capsys.readouterr().out.strip().splitlines()
    assert lines == ["ModelError: override fleet.sise: unknown key, did you mean 'fleet.size'?"]


@pytest.fixture
def kernel(tmp_path, monkeypatch):
    """A notebook's kernel that has the study of the tests below."""
    from jupyter_client.manager import start_new_kernel

    monkeypatch.setenv("IPYTHONDIR", str(tmp_path / "ipython"))
    manager, client = start_new_kernel(kernel_name="python3", cwd=str(tmp_path))
    lines = (
        "import desim_warehouse as dw",
        "from desim_warehouse.report.example import example",
        f"study = dw.Study(example(), {{'fleet.size': [2, 3]}}, changes={LASTING}, replications=N)",
    )
    yield manager, client, "\n".join(lines)
    client.stop_channels()
    manager.shutdown_kernel(now=True)


def cell(client, code, meanwhile=lambda message: None):
    """Run a cell: its messages, by kind and content."""
    asked = client.execute(code)
    messages = []
    while True:
        message = client.get_iopub_msg(timeout=60)
        if message["parent_header"].get("msg_id") != asked:
            continue
        messages.append((message["msg_type"], message["content"]))
        meanwhile(messages[-1])
        if messages[-1] == ("status", {"execution_state": "idle"}):
            return messages


@pytest.mark.slow
def test_a_study_is_one_bar_and_can_be_interrupted_and_resumed(kernel):
    manager, client, study = kernel
    interrupted = []

    def interrupt(message):
        if message[0] == "update_display_data" and not interrupted:
            interrupted.append(message)
            manager.interrupt_kernel()

    run = "study.run(out='study', progress=True);"
    first = cell(client, f"{study.replace('N', '400')}\n{run}", interrupt)
    kinds = [kind for kind, _ in first]
    assert kinds.count("display_data") == 1
    assert not [content for kind, content in first if kind == "stream"]
    assert next(content["ename"] for kind, content in first if kind == "error") == "KeyboardInterrupt"
    done = cell(client, "print(len(study.rows))")
    before = int(next(content["text"] for kind, content in done if kind == "stream"))
    assert 0 < before < 800

    again = cell(client, f"{study.replace('N', str(before // 2 + 5))}\n{run}")
    bars = [content["data"] for kind, content in again if kind in {"display_data", "update_display_data"}]
    assert [kind for kind, _ in again].count("display_data") == 1
    assert "<progress" in bars[-1]["text/html"]
    assert "were there already" in bars[-1]["text/plain"]
    with pytest.raises(Empty):
        client.get_iopub_msg(timeout=0.1)
