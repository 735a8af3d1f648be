"""What desim check says: one small layout for each finding. D = 2."""

import itertools

import pytest

import desim_warehouse as dw
from desim_warehouse import LayoutError
from desim_warehouse.layout import build, checks
from desim_warehouse.layout.spec import LayoutSpec
from desim_warehouse.questions.check import check

pytestmark = pytest.mark.usefixtures("brief_probes")

SQUARE = {
    "layout": {
        "nodes": {"A": [0, 0], "B": [20, 0], "C": [20, 20], "D": [0, 20]},
        "edges": [["A", "B"], ["B", "C"], ["C", "D"], ["D", "A"]],
        "storage": [{"edge": ["A", "B"], "offset": 10}],
        "bays": {"home": {"at": ["A"]}},
    },
    "fleet": {"size": 2, "robot": {"radius": 1, "speed": 1}},
    "tasks": {"goods": [0], "unload_at": ["C"], "load_time": 0, "unload_time": 0},
}
ADVICE = "add or turn edges so that every node can be reached from every other"


def model(**changes):
    return dw.load(SQUARE, {key.replace("__", "."): value for key, value in changes.items()})


def with_edges(*more, **nodes):
    edges = [list(edge) for edge in (*SQUARE["layout"]["edges"], *more)]
    return {"layout__edges": edges, "layout__nodes": SQUARE["layout"]["nodes"] | nodes}


def findings(**changes):
    return [str(finding) for finding in check(model(**changes)).findings]


def test_a_sound_layout_has_no_findings():
    report = check(model())
    assert report.findings == []
    # each edge of 20 holds robots at 2, 4, ..., 18
    assert report.facts == [
        "model: 4 nodes, 4 edges, 1 storage place",
        "robots keep D = 2 m and drive up to 1 m/s",
        "the lanes hold 36 robots at once, the fleet has 2",
        "ring of 80 m: B > C > D > A > B",
    ]


ERRORS = [
    (
        with_edges(["E", "A"], E=[-20, 0]) | {"layout__bays": {"home": {"at": ["A", "E"]}}},
        f"layout: node E: cannot be reached, but bay home is there; {ADVICE} [UNREACHABLE]",
    ),
    (
        with_edges(["A", "E"], E=[-20, 0]) | {"tasks__unload_at": ["E"]},
        f"layout: node E: cannot be left, but unloading is there; {ADVICE} [UNREACHABLE]",
    ),
    (
        with_edges(["E", "F"], ["F", "E"], E=[-20, 0], F=[-40, 0])
        | {"layout__storage": [{"edge": ["A", "B"], "offset": 10}, {"edge": ["E", "F"], "offset": 5}]},
        (
            f"layout: node E: cannot be reached and left, but good 1 is there; {ADVICE} [UNREACHABLE]\n"
            f"layout: node F: cannot be reached and left, but good 1 is there; {ADVICE} [UNREACHABLE]"
        ),
    ),
    (
        with_edges(["A", "E"], E=[-20, 0]) | {"layout__stations": {"pack": {"at": ["E"]}}},
        f"layout: node E: cannot be left, but station pack is there; {ADVICE} [UNREACHABLE]",
    ),
    ({"layout__bays": {}}, "layout.bays: there are none; robots start from bays and go home to them [NO_BAYS]"),
    (
        {"fleet__start": ["A", "B"]},
        "fleet.start: B: there is no bay at this node; name nodes with bays [START_WITHOUT_BAY]",
    ),
    (
        {"layout__bays": {"home": {"at": ["A", "B"], "places": 1}}, "fleet__start": ["A"]},
        (
            "layout.bays.home.places: 2 robots start at A but its bay home has 1 slot; "
            "give it more, or spread fleet.start over more nodes [BAY_CROWDED]"
        ),
    ),
    (
        {"layout__bays": {"home": {"at": ["A", "B", "C"], "places": 1}}, "fleet__size": 6},
        (
            "layout.bays.home.places: 2 robots start at A but its bay home has 1 slot; "
            "give it more, or spread fleet.start over more nodes (as at B, C) [BAY_CROWDED]\n"
            "layout.bays: 6 robots but only 3 bay slots; every robot needs one [TOO_FEW_PLACES]"
        ),
    ),
]


@pytest.mark.parametrize(("changes", "text"), ERRORS)
def test_what_would_void_the_guarantee_is_an_error_and_refused_by_simulate(changes, text):
    expected = text.split("\n")
    assert [line for line in findings(**changes) if line.startswith("error")] == [f"error: {line}" for line in expected]
    with pytest.raises(LayoutError) as refused:
        dw.simulate(model(**changes))
    assert refused.value.problems == expected


LONG = {f"N{i}": [20 * i + 40, 0] for i in range(10)}

OTHERS = [
    (
        with_edges(["A", "E"], E=[-20, 0]),
        (
            "warning: layout: node E: cannot be left; nothing is there, so no robot will go; "
            f"{ADVICE} [UNREACHABLE_UNUSED]"
        ),
    ),
    (
        with_edges(["A", "E"], ["A", "F"], E=[-20, 0], F=[-20, 20]),
        (
            "warning: layout: nodes E, F: cannot be left; nothing is there, so no robot will go; "
            f"{ADVICE} [UNREACHABLE_UNUSED]"
        ),
    ),
    (
        with_edges(["B", "A"], ["D", "C"]),
        (
            "note: layout: edges: 2 lanes are two-way, used in one direction at a time: A-B, C-D; a robot takes a step "
            "only if nobody can be stuck afterwards (traffic.gridlock: avoid); robots make way for others on 2 one-way "
            "lanes [TWO_WAY]"
        ),
    ),
    (
        with_edges(["B", "A"]),
        (
            "note: layout: edges: 1 lane is two-way, used in one direction at a time: A-B; a robot takes a step only "
            "if nobody can be stuck afterwards (traffic.gridlock: avoid); robots make way for others on 3 one-way "
            "lanes [TWO_WAY]"
        ),
    ),
    (
        with_edges(["A", "C"]),
        (
            "warning: tasks.unload_at: C: robots unload standing on a node where B>C, A>C meet, and hold "
            "all of them up; "
            "a station beside the node would not (layout.stations) [UNLOAD_IN_LANE]"
        ),
    ),
    (
        {
            "layout__storage": [
                {"edge": ["A", "B"], "offset": 1.5},
                {"edge": ["A", "B"], "offset": 2},
                {"edge": ["A", "B"], "offset": 18.5},
            ]
        },
        (
            "note: layout: storage: 2 places are nearer than 2 (D) to a node; robots stop D clear of it to load there: "
            "good 0, good 2 [LOAD_NEAR_NODE]"
        ),
    ),
    (
        {"layout__stations": {"pack": {"at": ["C"], "places": 1}}},
        (
            "warning: layout.stations: 1 slot for 2 robots: 1 of 2 works at a time, as a task is given out only when "
            "its station has a slot, and does 45 tasks an hour; with a slot for each they do 90; more slots (places) "
            "at the stations [ONE_AT_WORK]"
        ),
    ),
    (
        {"layout__stations": {"pack": {"at": ["C", "D"], "places": 1}}, "tasks__unload_at": ["pack"]},
        (
            "note: layout.stations: pack: no more slots than servers at 2 nodes: while all servers are at work there, "
            "no other robot sets off for it, and robots wait in bays (slots for 2, 2 robots); more slots (places) let "
            "more of them work [STATION_PLACES]"
        ),
    ),
    (
        with_edges(["E", "B"], ["D", "E"], E=[20, -1.5]),
        (
            "warning: layout: edges: 1 are shorter than 2 (D), so the nodes at their ends are used by one "
            "robot at a time: "
            "E>B; smaller robots or longer edges avoid it [SHORT_EDGES]"
        ),
    ),
    (
        with_edges(["E", "B"], ["D", "E"], E=[20, -3]),
        (
            "note: layout: edges: 1 are shorter than 4 (2 D), so robots wait on the nodes before them: E>B "
            "[EDGES_BELOW_2D]"
        ),
    ),
    (
        # 20 along, 10 down: E>B comes at atan(10 / 20) = 27 degrees to A>B
        with_edges(["E", "B"], ["D", "E"], E=[0, 10]),
        (
            "warning: layout: edges: meet at less than 60 degrees, where robots waiting on both would come "
            "closer than D: "
            "E>B and A>B [SHARP_MERGE]"
        ),
    ),
    (
        with_edges(["A", "C"], ["D", "B"]),
        (
            "warning: layout: edges: cross where there is no node, so robots there do not give way to each other: "
            "A>C and D>B; a node where they cross makes it an intersection [CROSSING_EDGES]"
        ),
    ),
]


def test_robots_that_all_find_a_slot_need_no_more():
    """Two slots at the only station, one for each robot, whether or not as many are served at a time."""
    assert findings(layout__stations={"pack": {"at": ["C"], "places": 2, "servers": 2}}) == []


@pytest.mark.parametrize(("changes", "text"), OTHERS)
def test_what_a_planner_should_know_is_a_warning_or_a_note_and_runs(changes, text):
    assert text in findings(**changes)
    assert not any(line.startswith("error") for line in findings(**changes))
    assert dw.simulate(model(**changes)).kpis["tasks"] == 1


def test_long_lists_are_cut_short():
    names = [f"N{i}" for i in range(10)]
    # a row of 11 edges of 1.5 beside the square, and back
    nodes = {name: [21.5 + 1.5 * i, 0] for i, name in enumerate(names)}
    edges = [list(edge) for edge in itertools.pairwise(["B", *names])] + [[names[-1], "C"]]
    [line] = [line for line in findings(**with_edges(*edges, **nodes)) if "shorter than 2 (D)" in line]
    assert "10 are shorter than 2 (D)" in line
    assert "B>N0, N0>N1, N1>N2, N2>N3, N3>N4, N4>N5, N5>N6, N6>N7 and 2 more" in line


def test_edges_that_only_touch_do_not_cross():
    # a way that ends on another's node, and one that runs beside it
    touching = with_edges(["A", "M"], ["M", "C"], ["M", "N"], ["N", "C"], M=[10, 10], N=[10, 15])
    assert not [line for line in findings(**touching) if "cross" in line]


def test_errors_come_first_then_warnings_then_notes():
    changes = with_edges(["B", "A"], ["E", "B"], ["D", "E"], E=[20, -3]) | {"layout__bays": {}}
    levels = [finding.level for finding in check(model(**changes)).findings]
    assert levels == sorted(levels, key=["error", "warning", "note"].index)
    assert set(levels) == {"error", "warning", "note"}


def test_the_shortest_rings_come_first():
    # the square of 80 and, by the diagonal C>A of 28.28, a triangle of 68.28
    facts = check(model(**with_edges(["C", "A"]))).facts
    assert facts[3:] == ["ring of 68.2843 m: B > C > A > B", "ring of 80 m: D > A > B > C > D"]


def test_capacity_counts_places_d_apart_and_d_clear_of_both_ends():
    def holds(*lengths):
        nodes = {str(i): [0, 100 * i] for i in range(len(lengths) + 1)}
        edges = [{"from": str(i), "to": str(i + 1), "length": length} for i, length in enumerate(lengths)]
        layout = {"nodes": nodes, "edges": edges, "storage": [], "bays": {}}

        return checks.capacity(build(LayoutSpec.model_validate(layout)), 2)

    # places at 2, 4, ... up to 2 before the end
    assert [holds(length) for length in (1, 2, 3.9, 4, 5.9, 6, 20)] == [0, 0, 0, 1, 1, 2, 9]
    assert holds(4, 6) == 3


def test_two_lanes_drawn_on_one_aisle():
    # an edge from A past B to E on the same line; one beside A > B, 1.5 off it; one 2 off it, which is D
    def said(*edges, **nodes):
        return [line for line in findings(**with_edges(*edges, **nodes)) if "LANES_OVERLAP" in line]

    [line] = said(["A", "E"], ["E", "C"], E=[40, 0])
    assert line.startswith(
        "warning: layout: edges: run along each other less than 2 (D) apart, so robots on both would touch, unseen by "
        "the simulation: A>B and A>E; one lane there"
    )
    [line] = said(["D", "E"], ["E", "F"], ["F", "C"], E=[2, 1.5], F=[18, 1.5])
    assert "A>B and E>F" in line
    assert said(["D", "E"], ["E", "F"], ["F", "C"], E=[2, 2], F=[18, 2]) == []
    # a length of its own says that an edge is not the straight line it is drawn as
    bent = with_edges(E=[40, 0])
    bent["layout__edges"] += [{"from": "A", "to": "E", "length": 60}, ["E", "C"]]
    assert not [line for line in findings(**bent) if "LANES_OVERLAP" in line]


def test_a_two_way_lane_holds_its_robots_once_and_is_no_ring():
    nodes = {"A": [0, 0], "B": [10, 0], "C": [20, 0]}
    edges = [{"from": "A", "to": "B", "two_way": True}, {"from": "B", "to": "C", "two_way": True}]
    layout = build(LayoutSpec.model_validate({"nodes": nodes, "edges": edges}))
    assert checks.capacity(layout, 1.0) == 9 + 9
    assert checks.shortest_rings(layout.graph) == []
