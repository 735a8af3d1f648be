"""A real browser for the tests of pages; they are skipped where there is none."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import pytest

from tests.browser.chromium import start

if TYPE_CHECKING:
    from collections.abc import Iterator


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    try:
        driver = start(tmp_path_factory.mktemp("profile"))
    except LookupError as missing:
        pytest.skip(str(missing))
    yield driver
    driver.quit()
