"""Short lanes, by the distance D that robots keep: the nodes at the ends of the shortest are one intersection."""

EPS = 1e-6
"""Tolerance: lengths closer than this are equal."""


def exact_length(length: float, contact: float) -> float:
    """Return a lane's length, or D (`contact`) or 2 D where it is within the tolerance of them.

    Lanes of at least D, and of at least 2 D, obey other rules than shorter ones. The choice must not depend on
    rounding, and a lane that reaches them only by the tolerance would have stop lines that do not fit it.
    """
    for exact in (contact, 2 * contact):
        if abs(length - exact) <= EPS:
            return exact
    return length


def joins(length: float, contact: float) -> bool:
    """Whether a lane is shorter than D (`contact`), so that the nodes at its ends are one intersection."""
    return exact_length(length, contact) < contact


def waited_for(length: float, contact: float) -> bool:
    """Whether robots wait on the node before a lane: it is too short to stand on, and its nodes are used apart."""
    return contact <= exact_length(length, contact) < 2 * contact


def is_short(length: float, contact: float) -> bool:
    """Whether a lane is shorter than 2 D, so that no robot can stand on it clear of both ends."""
    return exact_length(length, contact) < 2 * contact
