"""`make bench`: every measurement of this folder; `--long` also those that take minutes."""

from __future__ import annotations

import sys

from benchmarks import allocation_call, growth, pods, replay, studies, traffic, waits

if __name__ == "__main__":
    waits.report(long="--long" in sys.argv)
    traffic.report(long="--long" in sys.argv)
    allocation_call.main()
    studies.report()
    print(replay.report())
    if "--long" in sys.argv:
        growth.report()
        pods.main()
