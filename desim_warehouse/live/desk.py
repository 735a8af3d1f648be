"""The designs of a live page and their runs: listeners, the order of simulation, and results so far.

A run is simulated only while its design has listeners. The design with the fewest runs comes next, and among equals the
design requested last. So a pinned design and the shown design grow together, and no listener waits for all others.
"""

from __future__ import annotations

import hashlib
import json
import math
import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import count
from pathlib import Path
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any

from desim_warehouse.answer.numbers import NONE, capital
from desim_warehouse.errors import ReportError, StudyError, WarehouseError
from desim_warehouse.folders import STUDY
from desim_warehouse.live.answers import FEWEST, ByHand, Named, RunsSoFar, by_hand, results_of
from desim_warehouse.live.busy import Busy
from desim_warehouse.live.frozen import FrozenPage
from desim_warehouse.live.messages import About, Calculated, Tried, Watched
from desim_warehouse.live.offers import Offer, levels_of, spoken_design
from desim_warehouse.model import Model
from desim_warehouse.outcome.targets import Target
from desim_warehouse.questions.compare_words import difference
from desim_warehouse.questions.study import Results
from desim_warehouse.study.execution import worker_count
from desim_warehouse.study.execution.kept_fleets import FleetsOfACommand
from desim_warehouse.study.execution.pool import Pool
from desim_warehouse.study.execution.signals import Interrupts
from desim_warehouse.study.execution.store import Store
from desim_warehouse.study.execution.work import Handle, Outcome, Wanted
from desim_warehouse.study.plan import run_seed
from desim_warehouse.study.record import read_record, write_record

Band = tuple[float, float | None, float | None]
"""A mean and the ends of its interval, if there is one."""
RUNS = 35
"""Number of runs of a design, unless its verdict becomes clear before."""
MOST_RUNS = 1000
MOST_DESIGNS = 2000
MOST_LISTENERS = 64
_AHEAD = 3  # runs handed to the executor for each worker
_POLL = 0.5  # seconds between looks at the executor's health
_LISTED = 24  # designs that a page lists
_WRITE_EVERY = 5.0  # seconds between writes of the study


@dataclass(eq=False)
class Design:
    """A requested design, and its runs."""

    id: str
    number: int
    named: Named
    levels: Mapping[str, Any]
    digest: str
    hand: ByHand
    asked: float = 0.0
    outcomes: dict[int, Outcome] = field(default_factory=dict)
    handles: dict[int, Handle] = field(default_factory=dict)
    floor: Mapping[str, Any] | None = None
    runs_so_far: RunsSoFar | None = None
    clear: dict[float | None, tuple[int, bool]] = field(default_factory=dict)

    @property
    def n(self) -> int:
        """The number of runs from the first without gaps, which does not depend on the speed of workers."""
        n = 0
        while n in self.outcomes:
            n += 1
        return n


@dataclass(eq=False)
class Listener:
    """A listener to a design and, if any, to a pinned design.

    `runs`: least number of runs, regardless of the verdict. `notify`: called from another thread when results change.
    `most`: number of runs without a verdict. `floor`: whether the listener watches a run on the floor.
    """

    design: Design
    pinned: Design | None
    target: Target | None
    runs: int
    notify: Callable[[], None] = lambda: None
    most: int = RUNS
    floor: bool = False


class Desk:
    """The designs of a model, which are simulated while they have listeners."""

    def __init__(
        self,
        model: Model,
        offers: Mapping[str, Offer],
        main: str,
        target: Target | None,
        *,
        workers: int | str,
        folder: Path,
        seed: int = 0,
    ) -> None:
        """Open the folder and prepare the workers, which start with the first run.

        Raises:
            StudyError: the folder cannot be used, or another study is writing to it.
        """
        self.model, self.offers, self.main, self.target, self.seed = model, offers, main, target, seed
        self.folder = folder
        self.workers = worker_count(workers)
        self.notes: list[str] = []
        self.lock = threading.RLock()
        self.designs: dict[str, Design] = {}
        self._number = count()
        self.listeners: list[Listener] = []
        self.ended: SimpleQueue[Handle] = SimpleQueue()
        self.of: dict[Handle, tuple[Design, int]] = {}
        self.error: str | None = None
        self.written, self.changed = monotonic(), False
        self.store = Store(folder, self.notes.append)
        self.pool = Pool(self.workers, None, self.notes.append, Interrupts(), FleetsOfACommand(cache=True))
        self.closing = False
        self.thread = threading.Thread(target=self._work, daemon=True)
        self.thread.start()

    def begin(self) -> None:
        """Start the workers with the first two runs of the model as it is."""
        try:
            today = self.design({})
        except WarehouseError as error:  # the page reports it too
            self.notes.append(str(error))
        else:
            self.listen(Listener(today, None, self.target, 0, most=2))

    def close(self) -> None:
        """End all workers, and write the record of the study; finished runs are kept in the folder."""
        self.closing = True
        self.thread.join()
        self.pool.close()
        with self.lock:
            self._write()
            self.store.close()
            for listener in self.listeners:
                listener.notify()

    # Designs

    def design(self, levels: Mapping[str, Any]) -> Design:
        """Return the design with these values by key; all other keys are as in the model.

        Raises:
            StudyError: a key or value that is not offered.
            ModelError: an invalid combination of values.
            CheckError: a design that cannot work.
        """
        places = {key: offer.today for key, offer in self.offers.items()}
        for key, value in levels.items():
            offer = self.offers.get(key)
            if offer is None:
                raise StudyError(f"{key!r:.80}: not offered, expected one of {', '.join(self.offers)}")
            place = offer.place(value)
            if place is None:
                raise StudyError(f"{key}: {value!r:.80} is not offered, expected one of {', '.join(offer.texts)}")
            places[key] = place
        whole = {key: offer.values[places[key]] for key, offer in self.offers.items()}
        name = hashlib.sha256(json.dumps(whole, sort_keys=True).encode()).hexdigest()[:16]
        with self.lock:
            if name in self.designs:
                return self.designs[name]
        changes: dict[str, Any] = {}
        for key, offer in self.offers.items():
            changes |= offer.changes[places[key]]
        model = self.model.replace(changes) if changes else self.model
        text = spoken_design(self.offers, places)
        hand = by_hand(model, text)
        with self.lock:
            if name not in self.designs:
                self._forget_designs()
                named = Named(text, changes, model)
                made = Design(name, next(self._number), named, whole, model.digest(), hand, asked=monotonic())
                self.designs[name] = made
                self._recall(made)
            return self.designs[name]

    def _forget_designs(self) -> None:
        """Make room for another design: drop designs without listeners, the least recently requested first.

        Designs with runs are dropped last, and the model as it is never. Runs remain in the folder, and are recalled.
        """
        listened = {design for listener in self.listeners for design in (listener.design, listener.pinned)}
        left = [
            design
            for design in self.designs.values()
            if design.number and design not in listened and not design.handles
        ]
        left.sort(key=lambda design: (design.n > 0, design.asked))
        for design in left[: max(len(self.designs) + 1 - MOST_DESIGNS, 0)]:
            del self.designs[design.id]

    def _recall(self, design: Design) -> None:
        """Take the runs of a design that the folder holds, up to the first gap."""
        for r in range(MOST_RUNS):
            outcome = self.store.get(design.digest, run_seed(self.seed, r))
            if outcome is None or self.store.missing(design.digest, run_seed(self.seed, r)):
                return
            design.outcomes[r] = outcome

    def _recall_designs(self) -> None:
        """Recall the latest designs that were tried in this folder before and are still on offer."""
        if not (self.folder / STUDY).exists():
            return
        try:
            tried = [levels_of(self.offers, point.overrides) for point in read_record(self.folder).plan.points()]
            for levels in [values for values in tried if values is not None][-_LISTED:]:
                if not self.closing:
                    self.design(levels)
        except WarehouseError as error:
            self.notes.append(str(error))

    # Listening

    def listen(self, listener: Listener) -> None:
        """Begin to simulate for a listener; raise StudyError if there are too many listeners."""
        with self.lock:
            if len(self.listeners) >= MOST_LISTENERS:
                raise StudyError(f"{MOST_LISTENERS} listen already: close a page")
            listener.design.asked = monotonic()
            self.listeners.append(listener)
            self._schedule()

    def leave(self, listener: Listener) -> None:
        """Remove a listener, and cancel runs that no other listener wants."""
        with self.lock:
            if listener in self.listeners:
                self.listeners.remove(listener)
                self._schedule()

    # Runs

    def wanted(self, design: Design, listener: Listener) -> int:
        """Return the number of runs of a design that a listener wants."""
        least = listener.runs if design is listener.design else 0
        return max(design.n if self._is_clear(design, listener.target) else listener.most, least)

    def _is_clear(self, design: Design, target: Target | None) -> bool:
        """Whether no more runs are needed; the result is cached for each number of runs."""
        n, key = design.n, None if target is None else target.value
        if design.clear.get(key, (-1, False))[0] != n:
            design.clear[key] = n, n > 0 and self._says_enough(design, n, target)
        return design.clear[key][1]

    def _says_enough(self, design: Design, n: int, target: Target | None) -> bool:
        if design.outcomes[0].deterministic:
            return True
        if sum(outcome.error is not None for outcome in design.outcomes.values()) and n >= FEWEST:
            return True
        return n >= FEWEST and self.runs_of(design).met(target) in {"met", "not met", "overloaded", "drained"}

    def runs_of(self, design: Design) -> RunsSoFar:
        """Return the runs of a design so far, with their results."""
        with self.lock:
            if design.runs_so_far is None or design.runs_so_far.n != design.n:
                outcomes = [design.outcomes[r] for r in range(design.n)]
                design.runs_so_far = RunsSoFar(design.named, outcomes, self.main, self.seed)
            return design.runs_so_far

    def _schedule(self) -> None:
        """Cancel runs that no listener wants, and submit the runs wanted next."""
        want: dict[Design, int] = {}
        for listener in self.listeners:
            for design in filter(None, (listener.design, listener.pinned)):
                want[design] = max(want.get(design, 0), self.wanted(design, listener))
        watched = {listener.design for listener in self.listeners if listener.floor}
        for handle, (design, r) in list(self.of.items()):
            if r >= want.get(design, 0):
                del self.of[handle], design.handles[r]
                handle.cancel()
        while len(self.of) < _AHEAD * self.workers and self.error is None:
            ready = [
                (len(design.outcomes) + len(design.handles), -design.asked, design.number, design, run)
                for design, most in want.items()
                if (run := self._next(design, most, design in watched)) is not None
            ]
            if not ready:
                return
            *_, chosen, run = min(ready)
            self._submit(chosen, run)

    def _next(self, design: Design, most: int, watched: bool) -> int | None:
        """Return the next run of a design, or None; if its floor is watched, the latest run again, for a replay."""
        under_way = any(r in design.outcomes for r in design.handles)
        if watched and design.n and design.floor is None and not under_way:
            return design.n - 1
        most = min(most, design.n + _AHEAD * self.workers)  # runs count in order, so none is far ahead of a slow run
        return next((r for r in range(most) if r not in design.outcomes and r not in design.handles), None)

    def _submit(self, design: Design, r: int) -> None:
        run = Wanted(design.number, design.named.changes, run_seed(self.seed, r), floor=r in design.outcomes)
        handle = self.pool.submit(self.model, run)
        design.handles[r] = handle
        self.of[handle] = design, r
        handle.tell(self.ended)

    def _work(self) -> None:
        """Take finished runs and schedule others until the desk closes; runs in a separate thread."""
        self._recall_designs()
        while not self.closing:
            handle: Handle | None = None
            with suppress(Empty):
                handle = self.ended.get(timeout=_POLL)
            with self.lock:
                if self.pool.error is not None and self.error is None:
                    self.error = str(self.pool.error)
                    self.notes.append(self.error)
                    self._tell(None)
                while handle is not None:
                    self._take(handle)
                    handle = None if self.ended.empty() else self.ended.get()
                if not self.closing:
                    self._schedule()
                    if self.changed and monotonic() - self.written > _WRITE_EVERY:
                        self._write()

    def _take(self, handle: Handle) -> None:
        design, r = self.of.pop(handle, (None, 0))
        if design is None or handle.outcome is None:
            return
        del design.handles[r]
        outcome = handle.outcome
        if outcome.floor is not None:
            design.floor = outcome.floor
            self._forget_floors(design)
        outcome = outcome._replace(floor=None)  # the design keeps the floor
        if r not in design.outcomes:
            try:
                self.store.add(design.digest, run_seed(self.seed, r), outcome)
            except StudyError as error:
                self.error = str(error)
                self.notes.append(self.error)
            design.outcomes[r] = outcome
            self.changed = True
        elif design.floor is None:  # the repeated run failed, although the first did not
            design.floor = {}
        self._tell(None if r == 0 else design)  # all pages list the designs tried

    def _forget_floors(self, latest: Design) -> None:
        kept = [design for design in self.designs.values() if design.floor and design is not latest]
        for design in sorted(kept, key=lambda design: design.asked)[: max(len(kept) - MOST_LISTENERS, 0)]:
            design.floor = None

    def _tell(self, design: Design | None) -> None:
        for listener in self.listeners:
            if design is None or design in (listener.design, listener.pinned):
                listener.notify()

    # Looking

    def _beside(self, other: RunsSoFar, pinned: Design, listener: Listener, by: float) -> tuple[Band | None, list[str]]:
        """Return the band of the pinned design, times `by`, and sentences that compare it with the shown design."""
        band: Band | None = None
        lines: list[str] = []
        estimate = other.estimate(self.main)
        if estimate is not None:
            band = _times(by, (estimate.mean, *(estimate.interval or (None, None))))
            result = capital(other.reached(other.main_in_words(listener.target)))
            lines.append(f"Pinned: {result} with {pinned.named.words}.")
        apart = self._difference(pinned, listener.design)
        return band, lines + ([] if apart is None else [f"Difference, run by run: {apart}."])

    def answer(self, listener: Listener) -> Watched:
        """Return the state of a listener's design as a message."""
        with self.lock:
            design, pinned = listener.design, listener.pinned
            runs, wanted = self.runs_of(design), self.wanted(design, listener)
            other = self.runs_of(pinned) if pinned is not None and pinned is not design and pinned.n else None
            later = [pinned] if pinned is not None and pinned is not design else []
            left = sum(max(self.wanted(each, listener) - each.n, 0) for each in [design, *later])
            taken = [outcome.run_time for outcome in design.outcomes.values()]
            clear = self._is_clear(design, listener.target)
            floor, notes = bool(design.floor), self.notes[-3:]
            tried = [each for each in self.designs.values() if each.outcomes.get(0)]
        scale = runs.scale(self.main)
        summary = runs.in_words(listener.target)
        sentence, more, verdict, label = summary.sentence, list(summary.more), summary.verdict, summary.label
        if runs.n == 0:
            sentence, more = design.hand.sentence, [design.hand.more]
        pinned_at = None
        if other is not None and pinned is not None and runs.n:
            pinned_at, beside = self._beside(other, pinned, listener, scale.by)
            more += beside
        done = ""
        if self.error is not None:
            done = "fails"
            more.append(f"Nothing more can be simulated: {self.error}")
        elif left <= 0:
            done = "exact" if runs.exact else "fails" if runs.failed else "verdict" if clear else "all"
        busy = runs.busy() if runs.n and not runs.failed else Busy("", [])
        return Watched(
            id=design.id,
            n=runs.n,
            wanted=wanted,
            done=done,  # type: ignore[arg-type]
            seconds_left=None if not taken else round(left * math.fsum(taken) / len(taken) / self.workers, 1),
            verdict=verdict,
            label=label,
            sentence=sentence,
            more=more,
            values=runs.values(scale.by),
            measured=runs.measured(listener.target) if runs.n else [],
            busiest=busy.busiest,
            busy=busy.loads,
            pinned=None if pinned is None else pinned.id,
            pinned_at=pinned_at,
            floor=floor,
            tried=[
                self._tried(each, listener.target) for each in sorted(tried, key=lambda each: -each.asked)[:_LISTED]
            ],
            notes=notes,
        )

    def _tried(self, design: Design, target: Target | None) -> Tried:
        runs = self.runs_of(design)
        estimate = runs.estimate(self.main)
        text = NONE if estimate is None else runs.scale(self.main).value(estimate.mean)
        return Tried(
            id=design.id,
            words=design.named.words,
            levels=dict(design.levels),
            runs=runs.n,
            text=text,
            verdict=runs.met(target),
        )

    def results(self, designs: Sequence[Design], target: str = "") -> Results:
        """Return the runs of some designs as the results of a study, whose baseline is the first design."""
        with self.lock:
            pairs = [(design.named, [design.outcomes[r] for r in range(design.n)]) for design in designs]
        return replace(results_of(self.model, pairs, self.seed, target), folder=self.folder, notes=tuple(self.notes))

    def page(self, designs: Sequence[Design], about: About) -> FrozenPage:
        """Return the page of some designs, which needs no server; the first is pinned, the second shown.

        Raises:
            ReportError: too few or too many designs.
        """
        from desim_warehouse.live import frozen

        if not 1 < len(designs) <= frozen.MOST:
            raise ReportError(f"a page compares 2 to {frozen.MOST} options that have runs (got {len(designs)})")
        watched = [(asked(design), self.answer(Listener(design, None, self.target, 0))) for design in designs]
        table = [[self._difference(base, other) for other in designs] for base in designs]
        return frozen.page(about.model_copy(update={"folder": ""}), watched, table, start=1, pinned=0)

    def _difference(self, base: Design, other: Design) -> str | None:
        """Return the difference of `other` from `base`, run by run, as text; None if there is none."""
        if base is other:
            return None
        results = self.results([base, other])
        comparison = results.compare_finished(self.main)
        return None if comparison is None else difference(results, self.main, comparison.differences[0]).text

    def _write(self) -> None:
        """Write the record of the study into the folder for `desim report`; runs are in the journal."""
        self.changed, self.written = False, monotonic()
        tried = [design for design in self.designs.values() if design.n]
        if not tried:
            return
        results = self.results(tried, self.target.text if self.target else "")
        keys = {point.number: design.digest for point, design in zip(results.points, tried, strict=True)}
        try:
            write_record(results.plan, results.points, keys, self.folder)
        except WarehouseError as error:
            self.notes.append(str(error))


def asked(design: Design) -> Calculated:
    """Return the quick estimate of a design, which the page shows immediately, as a message."""
    return Calculated(
        id=design.id,
        words=design.named.words,
        levels=dict(design.levels),
        runs=design.n,
        sentence=design.hand.sentence,
        more=design.hand.more,
        needed=dict(design.hand.needed),
    )


def _times(by: float, band: Band) -> Band:
    """Return a band multiplied by a factor."""
    mean, low, high = band
    return by * mean, None if low is None else by * low, None if high is None else by * high
