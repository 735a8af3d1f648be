"""Damaged files: each is read, or refused with one message."""

import time

import desim_warehouse as dw
from desim_warehouse.plants import import_layout

SECONDS = 20
"""Of processor time for one file, at most."""
NUMBERS = [b"NaN", b"inf", b"-1", b"1e308", b"1e-308", b"9" * 400, b"", b"null", b"0", b'"x"', b"[]"]
BYTES = b"\x00\xff\"'<>&{}[],;:#-9eE\n\t "


def outcome(source, **options):
    """What is said of a layout that cannot be read: one problem, in one line; None if a model can be made of it."""
    begin, problem = time.process_time(), None
    try:
        made = import_layout(source, **options)
        assert made.text()
        assert made.model is not None
    except dw.ModelError as error:
        assert len(error.problems) == 1, error.problems  # noqa: PT017 - it may as well be read
        [problem] = error.problems
        problem.encode()
        assert "\n" not in problem
        assert len(problem) < 3000
    assert time.process_time() - begin < SECONDS
    return problem


def one_message(source, **options):
    """What is said of a layout that cannot be read."""
    problem = outcome(source, **options)
    assert problem is not None
    return problem


def damaged(content, draw):
    """The bytes of a file with something taken out, put in, doubled or changed."""
    made = bytearray(content)
    for _ in range(draw.choice([1, 1, 1, 4])):
        at, much = draw.randrange(len(made) or 1), draw.choice([1, 3, 20, 200])
        kind = draw.choice(["cut", "byte", "twice", "number", "swap", "end"])
        if kind == "cut":
            del made[at : at + much]
        elif kind == "byte":
            made[at : at + 1] = bytes([draw.choice(BYTES)])
        elif kind == "twice":
            made[at:at] = made[at : at + much]
        elif kind == "number":
            digits = [i for i in range(len(made)) if chr(made[i]).isdigit()]
            if digits:
                at = draw.choice(digits)
                made[at : at + 1] = draw.choice(NUMBERS)
        elif kind == "swap":
            other = draw.randrange(len(made) or 1)
            made[at : at + much], made[other : other + much] = made[other : other + much], made[at : at + much]
        else:
            del made[at:]
    return bytes(made)
