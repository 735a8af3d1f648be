"""Random streams by purpose: changing a policy or the fleet does not shift the demand."""

from __future__ import annotations

import zlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from numpy.random import Generator


def stream(seed: int, purpose: str, entity: int = 0) -> Generator:
    """The random stream for a purpose (and the entity, such as a robot, that it is for) in a run of `seed`."""
    from numpy.random import PCG64, Generator, SeedSequence

    return Generator(PCG64(SeedSequence(seed, spawn_key=(zlib.crc32(purpose.encode()), entity))))
