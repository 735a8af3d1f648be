"""What is true of a key stands on its field: every quantity has a unit, every key is called something."""

import pytest

from desim_warehouse.answer import words
from desim_warehouse.model.facts.keys import about, containers, kind_of, sections, whole_annotation
from desim_warehouse.model.schema import Model, Units


def every_key(annotation=Model, path=""):
    """The keys of all sections, in all forms that they can have; names are NAME, ranks 0."""
    for section in sections(annotation):
        for name, field in section.model_fields.items():
            key = f"{path}{field.alias or name}"
            yield key, whole_annotation(field)
            yield from every_key(whole_annotation(field), f"{key}.")
    for inner, by in containers(annotation):
        yield from every_key(inner, f"{path}{'NAME' if by else 0}.")


KEYS = dict(every_key())


def test_every_key_of_the_schema_is_known():
    assert len(KEYS) > 600
    assert [key for key in KEYS if about(key) is None] == []
    assert about("fleet.robot.colour") is None
    assert about("relief") is None


def test_every_quantity_has_a_unit_and_a_label():
    for key, annotation in KEYS.items():
        quantity, unit = about(key), words.factor_unit(key, Units(length="cm", time="min"))
        assert quantity.label.strip(" ,"), key
        assert quantity.kind == kind_of(annotation), key
        assert bool(unit) == (quantity.kind not in {"", "share"}), key


def test_labels_are_words_that_do_not_repeat_the_key():
    for key in KEYS:
        label = about(key).label
        assert "_" not in label.replace("NAME", ""), key
        assert ", " not in label or key.rpartition(".")[2] in label or "mean" in label, key
        assert label[:1].islower() or label[:1] == "[", key


@pytest.mark.parametrize(
    ("key", "label", "unit"),
    [
        ("fleet.size", "number of robots", ""),
        ("fleet.robot.breakdowns.every", "time between breakdowns", "s"),
        ("fleet.robot.delays.time", "delay at a node", "s"),
        ("fleet.kinds.fast.speed", "speed of fast", "m per s"),
        ("fleet.robot.acceleration", "acceleration", "m per s^2"),
        ("layout.bays.parking.chargers", "chargers in parking", ""),
        ("layout.bays.parking.outages.every.exponential", "time between outages in parking, mean", "s"),
        ("layout.stations.pack.unload_time", "unload time at pack", "s"),
        ("layout.edges.0.speed", "speed limit", "m per s"),
        ("tasks.load_time", "load time", "s"),
        ("tasks.load_time.lognormal.mean", "load time, mean", "s"),
        ("tasks.load_time.lognormal.cv", "load time, cv", ""),
        ("tasks.flows.work.load_time.beta.most", "load time of work, most", "s"),
        ("tasks.flows.work.arrivals.poisson", "tasks of work", "per hour"),
        ("tasks.goods.poisson", "tasks", "per hour"),
        ("people.pickers.per_hour", "visits of pickers", "per hour"),
        ("traffic.nodes.A.time", "node time at A", "s"),
        ("traffic.slow.walkway.speed", "speed limit in walkway", "m per s"),
        ("traffic.collision_angle", "collision angle", "degrees"),
        ("battery.capacity", "battery capacity", "energy"),
        ("battery.charge_rate", "charge rate", "energy per s"),
        ("battery.consumption.loaded", "consumption with a load", "energy per s"),
        ("policies.interval", "time between decisions", "s"),
        ("policies.charging.full", "full", ""),
        ("run.warm_up", "warm-up", "s"),
    ],
)
def test_a_key_is_called_what_people_call_it(key, label, unit):
    assert (about(key).label, words.factor_unit(key, Units())) == (label, unit)
