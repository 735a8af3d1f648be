"""How often is a run wrong about keeping up? Small halls at 70 to 130 % load, four hours beside two hundred.

    python -m benchmarks.keeps_up [HALLS] [HOURS]

Each hall is limited by its packer, by a worker behind the station or by its robots. The sentence of a run of four hours
is held against a run of `HOURS` with the same rates, which cannot keep up where its verdict says so. Prints a row for
each wrong sentence, and how many there are of each answer.
"""

import random
import sys
from collections import Counter
from copy import deepcopy

import desim_warehouse as dw
from desim_warehouse.outcome.verdicts import piles_up
from desim_warehouse.questions.run.lasting import lasting
from tests.run.test_lasting import RING

SHORT = "4 h"


def hall(number: int, hours: str) -> dw.Model:
    """A hall by number: what limits it, and at which load, are drawn."""
    drawn, content = random.Random(number), deepcopy(RING) | {"log": "tasks"}
    load, limit = drawn.uniform(0.7, 1.3), drawn.choice(["packer", "worker", "robots"])
    time = drawn.uniform(40, 150)
    content["tasks"]["unload_time"] = 10
    if limit == "packer":
        content["tasks"]["unload_time"], most = (
            {"lognormal": {"mean": time, "cv": drawn.uniform(0.1, 1.0)}},
            3600 / time,
        )
    elif limit == "worker":
        content["layout"]["stations"]["packing"]["work_time"], most = time, 3600 / time
    else:
        size = drawn.choice([1, 2, 3])
        content["fleet"]["size"], most = size, size * 3600 / 60
    content["tasks"]["goods"], content["run"] = {"poisson": load * most}, {"length": hours}
    return dw.load(content)


def main() -> None:
    """Print wrong sentences, and how many there are of each answer."""
    halls, hours = (int(text) for text in (sys.argv[1:] + ["200", "200"][len(sys.argv) - 1 :]))
    counts: Counter[tuple[str, bool]] = Counter()
    for number in range(halls):
        run, long = dw.simulate(hall(number, SHORT), 1), dw.simulate(hall(number, f"{hours} h"), 2)
        judged, grows = lasting(run), piles_up(long.verdicts)
        assert judged is not None
        said = "cannot" if piles_up(run.verdicts) else "keeps up" if judged.keeps_up else "not shown"
        counts[said, grows] += 1
        if (said == "keeps up" and grows) or (said == "cannot" and not grows):
            print(number, said, f"{long.kpis['backlog']:.0f} open after {hours} h", run.model.tasks.goods, flush=True)
    for (said, grows), count in sorted(counts.items()):
        print(f"{said:10} after {hours} h {'cannot keep up' if grows else 'keeps up'}: {count}")


if __name__ == "__main__":
    main()
