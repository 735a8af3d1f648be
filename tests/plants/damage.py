"""Files that somebody damaged: each is read, or is one message."""

import random

import pytest

import desim_warehouse as dw


def one_message(path):
    """What is said of a file that cannot be read: one problem."""
    with pytest.raises(dw.ModelError) as refused:
        dw.read_layout(path)
    [problem] = refused.value.problems
    return problem


def refused_at_random(path, content, *, seed, files, odd):
    """How many of so many files are refused, each damaged at 1 or 5 places: bytes left out, or one of `odd` put in."""
    draw, refused = random.Random(seed), 0
    for _ in range(files):
        damaged = bytearray(content)
        for _ in range(draw.choice([1, 1, 5])):
            at = draw.randrange(len(damaged))
            if draw.random() < 0.5:
                damaged[at : at + draw.randrange(40)] = b""
            else:
                damaged[at] = draw.choice(odd)
        path.write_bytes(damaged)
        try:
            dw.read_layout(path)
        except dw.ModelError as error:
            refused += 1
            assert len(error.problems) == 1, error  # noqa: PT017 - it may as well be read
    return refused
