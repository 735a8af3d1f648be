"""A real browser for the tests of pages; they are skipped where there is none."""

import pytest

from tests.browser.chromium import start


@pytest.fixture(scope="session")
def _chromium(tmp_path_factory):
    try:
        driver = start(tmp_path_factory.mktemp("profile"))
    except LookupError as missing:
        pytest.skip(str(missing))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def browser(_chromium):
    """The browser of all files; each leaves no page behind that plays on, which takes half a processor."""
    yield _chromium
    _chromium.get("about:blank")
