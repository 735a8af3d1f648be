"""The plain SimPy model beside which docs/dev/performance.md puts the time of a task."""

from benchmarks.plain import AN_HOUR, ROBOTS, Plain, drafted


def test_the_plain_model_keeps_up_with_the_orders_of_the_draft():
    model = drafted()
    plain = Plain(model.floor, model.fleet.contact, ROBOTS)
    plain.env.run(2 * 3600)
    assert len(plain.orders.items) < ROBOTS
    assert abs(plain.done - 2 * AN_HOUR) < 5 * (2 * AN_HOUR) ** 0.5
    assert plain.moves > 5 * plain.done
