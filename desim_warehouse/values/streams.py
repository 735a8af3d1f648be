"""Random streams by purpose: another policy or fleet draws the same demand."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy.random import Generator


class Streams:
    """The random streams of one run.

    `used` says whether any was requested, so whether chance could play a part.
    """

    def __init__(self, seed: int) -> None:
        self.seed = seed
        self.used = False

    def stream(self, purpose: str, entity: int = 0) -> Generator:
        """A new stream for a purpose and the entity, such as a robot, that it is for."""
        from numpy.random import PCG64, Generator, SeedSequence

        self.used = True
        return Generator(PCG64(SeedSequence(self.seed, spawn_key=(zlib.crc32(purpose.encode()), entity))))
