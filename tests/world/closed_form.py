"""How long a drive takes that gathers speed and brakes, worked out otherwise than in the package: over squared speeds.

Over the place the square of the speed rises by 2 a, falls by 2 d, and is capped by the limits: the fastest drive is the
lower envelope of these straight lines, and between two of its corners the time is the length over the mean speed.
"""

import math
from itertools import accumulate, pairwise


def drive_time(pieces, acceleration, deceleration):
    """From a stand over pieces of (length, speed limit) to a stand."""
    ends = [0.0, *accumulate(length for length, _ in pieces)]
    # Where the speed is capped from an instant on: (from, to, square of the cap); it stands at both ends.
    caps = [(a, b, limit * limit) for (a, b), (_, limit) in zip(pairwise(ends), pieces, strict=True)]
    caps += [(0.0, 0.0, 0.0), (ends[-1], ends[-1], 0.0)]

    def squared(x):
        lowest = math.inf
        for begin, end, cap in caps:
            if x < begin:
                lowest = min(lowest, cap + 2 * deceleration * (begin - x))
            elif x > end:
                lowest = min(lowest, cap + 2 * acceleration * (x - end))
            else:
                lowest = min(lowest, cap)
        return lowest

    corners = set(ends)
    for _, end, cap in caps:  # where it has gathered the speed of another cap, or of another cap's braking
        for begin, _, other in caps:
            corners.add(end + (other - cap) / (2 * acceleration))
            corners.add(begin - (cap - other) / (2 * deceleration))
            up, down = 2 * acceleration, 2 * deceleration
            corners.add((other - cap + down * begin + up * end) / (up + down))
    places = sorted(x for x in corners if 0 <= x <= ends[-1])
    return sum(2 * (b - a) / (math.sqrt(squared(a)) + math.sqrt(squared(b))) for a, b in pairwise(places))
