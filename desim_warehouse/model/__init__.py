"""Model files: reading, checking, overriding.

A frozen `Model` comes out, or every problem with its position in the file.
"""

from __future__ import annotations

from desim_warehouse.model.overrides import UNSET, options_of, parse_assignment
from desim_warehouse.model.read import Source, as_model, json_schema, load
from desim_warehouse.model.schema import Model

__all__ = ["UNSET", "Model", "Source", "as_model", "json_schema", "load", "options_of", "parse_assignment"]
