"""`--option` of `desim plan`: named options as the models that they are."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from desim_warehouse.cli.study_options import read_assignments
from desim_warehouse.errors import ModelError, reason

if TYPE_CHECKING:
    from desim_warehouse.model import Model


def read_options(given: tuple[str, ...], model: Model) -> dict[str, Model]:
    """Options such as `A: prices.robot=6000; fleet.robot.speed=1.5` or `B: other.yaml`, and those of files, as models.

    Raises:
        ModelError: no such option, one that is there twice, or what `load` refuses.
    """
    found: dict[str, Model] = {}
    for text in given:
        for name, what in _named(text):
            if name in found:
                raise ModelError([f"--option {name}: there twice, expected each once"])
            found[name] = _model(name, what, model)
    return found


def _named(text: str) -> Iterator[tuple[str, Any]]:
    """The options of a text: one, or all of a file."""
    from desim_warehouse.model.parse import read_yaml

    name, colon, what = text.partition(":")
    if colon and what.strip():
        yield name.strip(), what.strip()
        return
    try:
        document = read_yaml(Path(text).read_text(encoding="utf-8"), text)
    except (OSError, ValueError) as error:
        raise ModelError(
            [f"--option {text}: no NAME: KEY=VALUE, and no file ({reason(error)}), expected such as 'A: fleet.size=9'"]
        ) from None
    if document.problems or not isinstance(document.data, Mapping):
        raise ModelError([f"--option {text}: expected names, each with keys and values or the name of a model"])
    yield from ((str(name), what) for name, what in document.data.items())


def _model(name: str, what: Any, model: Model) -> Model:
    from desim_warehouse.model import load

    if isinstance(what, Mapping):
        return model.replace(what)
    if "=" not in str(what):
        return load(str(what))
    parts = tuple(part.strip() for part in str(what).split(";") if part.strip())
    return model.replace(read_assignments(parts, f"--option {name}:"))
