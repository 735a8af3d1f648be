"""How often is a run wrong about keeping up? Small halls at 70 to 130 % load, four hours beside two hundred.

    python -m benchmarks.keeps_up [HALLS] [HOURS]

Each hall is limited by its packer, by a worker behind the station or by its robots. The sentence of a run of four hours
is held against a run of `HOURS` with the same rates, which cannot keep up where its verdict says so. Prints a row for
each wrong sentence, and how many there are of each answer.
"""

import sys
from collections import Counter

import desim_warehouse as dw
from desim_warehouse.outcome.verdicts import piles_up
from desim_warehouse.questions.run.lasting import lasting
from tests.run.halls import loaded_hall


def main() -> None:
    """Print wrong sentences, and how many there are of each answer."""
    halls, hours = (int(text) for text in (sys.argv[1:] + ["200", "200"][len(sys.argv) - 1 :]))
    counts: Counter[tuple[str, bool]] = Counter()
    for number in range(halls):
        (short, _), (lasts, _) = loaded_hall(number, "4 h"), loaded_hall(number, f"{hours} h")
        run, long = dw.simulate(short, 1), dw.simulate(lasts, 2)
        judged, grows = lasting(run), piles_up(long.verdicts)
        assert judged is not None
        answer = "cannot" if piles_up(run.verdicts) else "keeps up" if judged.keeps_up else "not shown"
        counts[answer, grows] += 1
        if (answer == "keeps up" and grows) or (answer == "cannot" and not grows):
            print(number, answer, f"{long.kpis['backlog']:.0f} open after {hours} h", run.model.tasks.goods, flush=True)
    for (answer, grows), count in sorted(counts.items()):
        print(f"{answer:10} after {hours} h {'cannot keep up' if grows else 'keeps up'}: {count}")


if __name__ == "__main__":
    main()
