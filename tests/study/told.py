"""What harnesses of planted truths print: each answer as it is found."""

import sys


def told(numbers, answer):
    """The answers for some numbers, or cases, each printed at once."""
    found = []
    for number in numbers:
        found.append(answer(number))
        sys.stdout.write(f"{found[-1]}\n")
        sys.stdout.flush()
    return found
