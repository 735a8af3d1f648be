"""What harnesses of planted truths print: each answer as it is found."""

import sys


def told(numbers, answer):
    """The answers for some numbers, or cases, each printed at once."""
    answers = []
    for number in numbers:
        answers.append(answer(number))
        sys.stdout.write(f"{answers[-1]}\n")
        sys.stdout.flush()
    return answers
