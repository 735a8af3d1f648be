"""Goods to person in a browser: pods stand on their places, are carried about, and say what they hold and for whom."""

from tests.browser.pages import Page
from tests.report.replay.floors import pods_run


def test_a_robot_with_a_pod_says_what_it_holds_and_for_whom_it_goes(browser, tmp_path):
    run = pods_run()
    page = Page(browser, run, tmp_path)
    assert {"pod", "pod with lines to pick"} <= set(page.text("legend").splitlines())
    page.seek(20)
    page.tap(*page.ask("page.drawn()[0]"))
    line = next(run.history.rows("delivered"))
    sentence = f"Pod 0, for \u2068pick\u2069 (\u2068C\u2069): line {line.task} (item 0); holds item 0 (1)"
    assert sentence in page.text("robot")
    page.seek(next(row.time for row in run.history.rows("stored")) + 1)
    assert "Pod 0" not in page.text("robot")
    assert page.complaints() == []
