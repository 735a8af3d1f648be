"""Where classes of goods lie: the first places, those nearest to the stations by the way with the load, or any."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import desim_warehouse as dw
from desim_warehouse.model.facts.places import by_distance, place_shares
from desim_warehouse.study.suspects import suspects

ABC = [{"share": 0.25, "demand": 0.8}, {"share": 0.75, "demand": 0.2}]
# A one-way ring of 40 m with four places; those behind the station are the farthest from it by the lanes.
RING = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [10, 0], "C": [10, 10], "D": [0, 10]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [
            {"edge": ["C", "D"], "offset": 2},  # just behind the station: 38 m to it
            {"edge": ["A", "B"], "offset": 5},  # 15 m
            {"edge": ["B", "C"], "offset": 9},  # 1 m
            {"edge": ["D", "A"], "offset": 5},  # 25 m
        ],
        "bays": {"rest": {"at": ["A"], "places": 2}},
        "stations": {"pack": {"at": ["C"]}},
    },
    "fleet": {"size": 1, "robot": {"radius": 0.4, "margin": 0.2, "speed": 1}},
    "tasks": {
        "goods": {"poisson": 20},
        "unload_at": ["pack"],
        "load_time": 10,
        "unload_time": 20,
        "popularity": {"classes": ABC, "by": "distance"},
    },
    "run": {"length": 36_000},
}


def ring(changes=None):
    return dw.load(RING, changes or {})


@pytest.mark.parametrize(
    ("by", "place"), [("distance", 2), ("number", 0), (None, 0)], ids=["nearest", "first", "by default the first"]
)
def test_fast_movers_lie_where_the_rule_says(by, place):
    model = ring({"tasks.popularity.by": by})

    shares = place_shares(model, model.floor)

    assert shares[place] == 0.8
    assert sorted(shares) == pytest.approx([0.2 / 3] * 3 + [0.8])


def test_a_run_fetches_fast_movers_from_the_nearest_place_as_often_as_they_are_asked_for():
    released = dw.simulate(ring()).log.query("kind == 'released'")

    assert len(released) > 150
    assert (released["value"] == 2).mean() == pytest.approx(0.8, abs=0.08)


def test_put_away_is_by_the_way_from_the_dock_where_nothing_leaves_storage():
    flow = {"from": "pack", "to": "storage", "arrivals": {"poisson": 20}}
    model = ring({"tasks.goods": dw.UNSET, "tasks.unload_at": dw.UNSET, "tasks.flows": {"in": flow}})

    shares = place_shares(model, model.floor)

    assert shares[0] == 0.8  # 2 m beyond C


def test_flows_from_storage_say_where_fast_movers_lie_for_those_to_it_too():
    flows = {
        "in": {"from": "A", "to": "storage", "arrivals": {"poisson": 10}},
        "out": {"from": "storage", "to": "pack", "arrivals": {"poisson": 10}},
    }
    model = ring({"tasks.goods": dw.UNSET, "tasks.unload_at": dw.UNSET, "tasks.flows": flows})

    assert place_shares(model, model.floor, model.tasks.flows["in"].target)[2] == 0.8


def test_scattered_classes_are_alike_in_all_runs_and_not_in_order_of_number():
    wide = {
        "layout.storage": [{"edge": ["A", "B"], "offset": 0.2 + rank * 0.2} for rank in range(40)],
        "tasks.popularity": {"classes": ABC, "by": "random"},
    }

    once, again = (place_shares(model, model.floor) for model in (ring(wide), ring({**wide, "fleet.size": 2})))

    assert (once == again).all()
    fast = np.flatnonzero(once == once.max())
    assert len(fast) == 10
    assert fast.max() > 19
    assert fast.min() < 20


def test_nothing_lies_near_a_station_where_none_is_served_from_storage():
    flows = {"tasks.flows": {"move": {"from": "storage", "to": "storage", "arrivals": {"poisson": 20}}}}

    with pytest.raises(dw.ModelError, match=r"tasks.popularity.by: nothing is brought from storage to a station"):
        ring({"tasks.goods": dw.UNSET, "tasks.unload_at": dw.UNSET, **flows})


def test_weights_say_themselves_where_goods_lie():
    with pytest.raises(dw.ModelError, match="a weight for each place says where goods lie"):
        ring({"tasks.popularity": {"weights": [1, 2, 3, 4], "by": "distance"}})


def test_check_says_what_nearer_fast_movers_save():
    # By number the mean way with a load is 0.8 x 38 + 0.2 / 3 x (15 + 1 + 25) = 33.13 m, by distance 0.8 x 1 +
    # 0.2 / 3 x (38 + 15 + 25) = 6 m. The way to the next load and with it is round the ring: what is saved here is
    # driven empty, so nothing is saved in all.
    by_number = dw.check(ring({"tasks.popularity.by": "number"}))
    assert not [line for line in by_number.facts if "fast movers" in line]

    # Two places in a row of two-way lanes, the one asked for most at its end: 40 m there and back, or 20 m to the
    # other. So 0.8 x 40 + 0.2 x 20 = 36 m are driven for a task, and 24 m with the two exchanged: 12 s of 66 s, which
    # the estimate measures on some 950 tasks.
    row = {
        "layout.nodes": {"C": [0, 0], "B": [10, 0], "A": [20, 0]},
        "layout.edges": [{"from": a, "to": b, "two_way": True} for a, b in ("CB", "BA")],
        "layout.storage": [{"edge": ["B", "A"], "offset": 5}, {"edge": ["C", "B"], "offset": 5}],
        "tasks.popularity": {"classes": [{"share": 0.5, "demand": 0.8}, {"share": 0.5, "demand": 0.2}]},
    }
    there_and_back = dw.check(ring(row))
    assert [line for line in there_and_back.facts if "fast movers" in line] == [
        "fast movers nearest to the stations would save 12.07 of 66.03 s a task (tasks.popularity.by: distance)"
    ]


def test_why_tries_fast_movers_nearer():
    by_number = ring({"tasks.popularity.by": "number", "log": "all", "run.length": 3600})

    tried = {suspect.relief: suspect.overrides for suspect in suspects(dw.simulate(by_number))}

    assert tried["fast movers nearer"] == {"tasks.popularity.by": "distance"}
    assert "fast movers nearer" not in {
        suspect.relief for suspect in suspects(dw.simulate(ring({"log": "all", "run.length": 3600})))
    }


@st.composite
def floors(draw):
    """A strongly connected floor of up to 7 nodes with lanes of drawn lengths, some two-way, and places beside them."""
    size = draw(st.integers(3, 7))
    nodes = {f"n{i}": [i, i * i % 5 + 0.1 * i] for i in range(size)}
    pairs = {(i, (i + 1) % size) for i in range(size)}
    pairs |= set(draw(st.lists(st.tuples(st.integers(0, size - 1), st.integers(0, size - 1)), max_size=6)))
    pairs = sorted(pair for pair in pairs if pair[0] != pair[1])
    lengths = {frozenset(pair): draw(st.integers(4, 12)) for pair in pairs}
    edges = [{"from": f"n{a}", "to": f"n{b}", "length": lengths[frozenset((a, b))]} for a, b in pairs]
    at = st.tuples(st.integers(0, len(edges) - 1), st.sampled_from([0.5, 1, 2, 3, 3.5]))
    storage = [
        {"edge": [edges[rank]["from"], edges[rank]["to"]], "offset": offset}
        for rank, offset in draw(st.lists(at, min_size=2, max_size=10))
    ]
    ends = sorted(draw(st.sets(st.sampled_from(sorted(nodes)), min_size=1, max_size=3)))
    return {"nodes": nodes, "edges": edges, "storage": storage, "stations": {"pack": {"at": ends}}}


@given(floors(), st.booleans())
def test_the_order_of_places_is_that_of_every_way_tried(layout, there):
    floor = ring({"layout": layout, "tasks.station_choice": "nearest"}).floor
    ends = tuple(layout["stations"]["pack"]["at"])
    lanes = {(edge["from"], edge["to"]): edge["length"] for edge in layout["edges"]}
    far = {(a, b): 0 if a == b else lanes.get((a, b), np.inf) for a in layout["nodes"] for b in layout["nodes"]}
    for by in layout["nodes"]:
        for a, b in list(far):
            far[a, b] = min(far[a, b], far[a, by] + far[by, b])

    def way(place):
        (a, b), offset = place["edge"], place["offset"]
        length, ways = lanes[a, b], []
        for end in ends:
            if there:
                ways += [length - offset + far[b, end]] + [offset + far[a, end]] * ((b, a) in lanes)
            else:
                ways += [far[end, a] + offset] + [far[end, b] + length - offset] * ((b, a) in lanes)
        return min(ways)

    expected = sorted(range(len(layout["storage"])), key=lambda i: (way(layout["storage"][i]), i))
    assert list(by_distance(floor, ends, to_ends=there)) == expected
