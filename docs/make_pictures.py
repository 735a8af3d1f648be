"""The pictures of the documentation, made anew: `python docs/make_pictures.py`.

Needs Chromium, Selenium and, for the notebook, nbconvert; the pictures go to docs/pictures.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

import desim_warehouse as dw  # noqa: E402
from desim_warehouse.folders import gallery  # noqa: E402
from tests.browser.chromium import start  # noqa: E402

PICTURES = ROOT / "docs" / "pictures"
MOST_BYTES = 200_000
READY = "const done = arguments[0]; desimReplay.ready.then(done, (error) => done(String(error.stack)))"
SETTLE = 0.4
"""Seconds for a page to be laid out again."""


def multibots(**changes: Any) -> dw.Run:
    """The paper's warehouse."""
    return dw.simulate(dw.load(ROOT / "models" / "multibots.yaml", changes))


def shoot(browser: Any, name: str, width: int, height: int, *, phone: bool = False) -> None:
    """Save what the browser shows on a screen of a size, in few bytes."""
    from PIL import Image

    metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": phone}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    time.sleep(SETTLE)
    path = PICTURES / name
    browser.save_screenshot(str(path))
    with Image.open(path) as picture:
        picture.convert("RGB").save(path, optimize=True)
    size = path.stat().st_size
    print(f"{path.relative_to(ROOT)}: {size / 1000:.0f} kB")
    if size > MOST_BYTES:
        raise SystemExit(f"{name} is larger than {MOST_BYTES:,} bytes")


def drafted(folder: Path) -> Path:
    """The model that docs/plan-a-warehouse.md drafts."""
    from desim_warehouse.draft import Draft, draft

    model = folder / "w.yaml"
    model.write_text(draft(Draft(aisles=8, stations=3, due=5.0)), encoding="utf-8")
    return model


def floor(folder: Path) -> None:
    """The floor of that warehouse, as `desim draw` draws it."""
    from desim_warehouse.plot.floor import save

    (PICTURES / "floor.png").unlink(missing_ok=True)
    save(dw.load(drafted(folder)), PICTURES / "floor.png")


def gallery_floors() -> None:
    """The floors of docs/gallery.md, in few colours."""
    from PIL import Image

    from desim_warehouse.plot.floor import save

    for name, file in gallery().items():
        path = PICTURES / f"gallery-{name}.png"
        path.unlink(missing_ok=True)
        save(dw.load(file), path)
        with Image.open(path) as picture:
            picture.convert("P", palette=Image.Palette.ADAPTIVE, colors=32).save(path, optimize=True)


def replays(browser: Any, folder: Path) -> None:
    """A drafted warehouse with a robot's panel, and on a phone; the paper's: heat map of a crowd, two runs."""
    run = dw.simulate(dw.load(drafted(folder), {"log": "all", "run.length": "4 h"}), seed=1)
    middle = (run.history.begin + run.history.end) / 2
    busy = max(range(int(middle), int(run.history.end), 60), key=lambda time: len(_loaded(run, time)))
    play(browser, run, folder)
    browser.execute_script("desimReplay.seek(arguments[0])", busy)
    _click(browser, max(_loaded(run, busy), key=lambda span: span.end).robot)
    shoot(browser, "replay.png", 1400, 900)
    browser.execute_script("document.getElementById('theme').click()")
    shoot(browser, "replay-phone.png", 390, 844, phone=True)
    crowd = {"fleet.size": 24, "tasks.goods": {"random": 80}, "battery": None}
    play(browser, multibots(**crowd), folder)
    browser.execute_script("desimReplay.seek(1500); document.getElementById('heat').click()")
    shoot(browser, "heat-map.png", 1200, 800)
    play(browser, multibots(), folder, beside=multibots(**{"fleet.size": 3}))
    browser.execute_script("desimReplay.seek(930)")
    shoot(browser, "beside.png", 1400, 800)


def _loaded(run: dw.Run, time: float) -> list[Any]:
    """What robots that carry a good do at a time."""
    return [
        span
        for spans in run.history.states
        for span in spans
        if span.state == "loaded" and span.start <= time < span.end
    ]


def _click(browser: Any, robot: int) -> None:
    """Open the panel of a robot."""
    box = browser.find_element("id", "floor").rect
    left, top = browser.execute_script("return desimReplay.drawn()[arguments[0]]", robot)
    for kind in ("mousePressed", "mouseReleased"):
        point = {"type": kind, "x": box["x"] + left, "y": box["y"] + top, "button": "left", "clickCount": 1}
        browser.execute_cdp_cmd("Input.dispatchMouseEvent", point)


def play(browser: Any, run: dw.Run, folder: Path, **options: Any) -> None:
    """Open the replay of a run."""
    page = folder / "replay.html"
    run.replay(page, **options)
    browser.get(page.as_uri())
    browser.execute_async_script(READY)


def report(browser: Any, folder: Path) -> None:
    """The first page of the report of the plan that docs/plan-a-warehouse.md makes, which takes some minutes."""
    desim, page = str(Path(sys.executable).with_name("desim")), folder / "report.html"
    options = "--growth 30% --robots 6..20 --chargers 1..6 --price-robot 9000 --price-charger 800 --workers 2 --quiet"
    plan = [desim, "plan", str(drafted(folder)), "--target", "on_time >= 95 %", *options.split()]
    for command in ([*plan, "--out", str(folder / "plan")], [desim, "report", str(folder / "plan"), "-o", str(page)]):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # noqa: S603 - our own commands
    browser.get(page.as_uri())
    metrics = {"width": 1100, "height": 900, "deviceScaleFactor": 1, "mobile": False}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    end = browser.execute_script("return document.querySelector('h2').getBoundingClientRect().top")
    shoot(browser, "report.png", 1100, int(end))


def what_if(browser: Any, folder: Path) -> None:
    """The what-if page of docs/how-to/share-results.md, with other designs chosen than it begins with."""
    factors = {"fleet.size": range(2, 7), "policies.allocation": ["in-order", "nearest"]}
    changes, page = {"tasks.goods": {"random": 20}}, folder / "what-if.html"
    study = dw.Study(
        ROOT / "models" / "multibots.yaml", factors, changes=changes, replications=10, indicators=["T", "S", "C"]
    )
    dw.what_if_page(study.run().results, page)
    browser.get(page.as_uri())
    browser.execute_script(
        "for (const [id, level] of [['knob-0', 2], ['knob-1', 1]]) {"
        "const field = document.getElementById(id); field.value = level; field.dispatchEvent(new Event('input')); }"
    )
    shoot(browser, "what-if.png", 1400, 900)


def live_page(browser: Any, folder: Path) -> None:
    """The live page of the drafted warehouse: ten robots beside today's, which are pinned."""
    with dw.serve(drafted(folder), out=folder / "live") as live:
        browser.get(live.address)

        def wait(test: str) -> None:
            while not browser.execute_script(f"const live = window.desimLive?.live; return Boolean({test})"):
                time.sleep(SETTLE)

        wait("live?.answer?.n > 5")
        browser.find_element("id", "pin").click()
        browser.execute_script(
            "const field = document.getElementById('knob-0'); field.value = 9; field.dispatchEvent(new Event('input'))"
        )
        wait("live.floorOf === live.asked.id && live.answer.n > 7")
        browser.execute_script("document.activeElement.blur()")
        shoot(browser, "live.png", 1400, 960)


def notebook(browser: Any, folder: Path) -> None:
    """A notebook with a run of the drafted warehouse, as Jupyter shows it."""
    import nbclient
    import nbformat.v4
    from nbconvert import HTMLExporter

    load = f"import desim_warehouse as dw\n\nmodel = dw.load({drafted(folder).name!r})\nrun = dw.simulate(model)\nrun"
    cells = [load, "run.robots[['delivered', 'distance', 'loaded', 'waiting']].describe().round(1)", "dw.plot.day(run)"]
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    nbclient.NotebookClient(book, timeout=300, resources={"metadata": {"path": str(folder)}}).execute()
    page = folder / "notebook.html"
    page.write_text(HTMLExporter().from_notebook_node(book)[0], encoding="utf-8")
    browser.get(page.as_uri())
    shoot(browser, "notebook.png", 1100, 1130)


def main() -> None:
    """All pictures."""
    PICTURES.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        browser = start(Path(folder) / "profile")
        try:
            floor(Path(folder))
            gallery_floors()
            replays(browser, Path(folder))
            report(browser, Path(folder))
            what_if(browser, Path(folder))
            live_page(browser, Path(folder))
            notebook(browser, Path(folder))
        finally:
            browser.quit()


if __name__ == "__main__":
    main()
