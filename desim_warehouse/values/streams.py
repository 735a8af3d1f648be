"""Random streams by purpose: another policy or fleet draws the same demand."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

from desim_warehouse.errors import ModelError, shown
from desim_warehouse.values.arguments import is_whole

if TYPE_CHECKING:
    from numpy.random import Generator


def whole_seed(seed: int) -> int:
    """Return a seed, refused where no run could be repeated with it; raises ModelError."""
    if not is_whole(seed, 0):
        raise ModelError([f"seed {shown(seed):.60}: expected a whole number from 0 on, such as 1"])
    return int(seed)


class Streams:
    """The random streams of one run.

    `used` says whether any was requested, so whether chance could play a part.
    """

    def __init__(self, seed: int) -> None:
        self.seed = whole_seed(seed)
        self.used = False

    def stream(self, purpose: str, entity: int = 0) -> Generator:
        """Return a new stream for a purpose and the entity, such as a robot, that it is for."""
        from numpy.random import PCG64, Generator, SeedSequence

        self.used = True
        return Generator(PCG64(SeedSequence(self.seed, spawn_key=(zlib.crc32(purpose.encode()), entity))))
