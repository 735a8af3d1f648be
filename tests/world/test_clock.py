"""The clock of a run keeps the time whoever lets it go on."""

from desim_warehouse.world.traffic.events import Arrival, Clock


def seen(clock, let_go):
    """What a process reads off the clock that wakes at three times."""
    times = []

    def process():
        for _ in range(3):
            yield clock.timeout(2.5)
            times.append(clock.now)

    clock.process(process())
    let_go(clock)
    return times


def test_the_time_is_that_of_the_event_in_simpys_own_loop_as_in_ours():
    assert seen(Clock(), lambda clock: clock.run(until=6)) == [2.5, 5]
    assert seen(Clock(), lambda clock: clock.run_to(Arrival(clock, 6))) == [2.5, 5]
    assert seen(Clock(), lambda clock: clock.run()) == [2.5, 5, 7.5]


def test_our_loop_says_whether_the_event_came_up():
    clock = Clock()
    assert clock.run_to(clock.timeout(3))
    assert clock.now == 3
    assert not clock.run_to(clock.event())
