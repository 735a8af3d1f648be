"""The simulation against theory: every case of docs/dev/validation.md, the slow ones in `make test-long`."""

import math

import pytest

import desim_warehouse as dw
from docs import make_validation
from tests.theory import hours, models
from tests.theory.cases import CASES, TURN, entries, headways
from tests.theory.formulas import headway_of_a_turn, m_d_c_wait, m_g_1_wait, m_m_c_wait, repairman

PROOFS = {
    "M/M/1//6, 6 robots and 1 picker",
    "M/D/1, one robot, load 0.3",
    "machine repairman M/D/1//1: 1 robot, one place to swap batteries",
    "ring of 80 D, 60 robots",
    "ring of 80 D, 50 robots",
    "6 robots with work at all times, 3 chargers",
    "4 robots with work at all times, 4 chargers",
    "M/D/5, 5 robots, load 0.7",
    "1 robot, a breakdown every 400 s of operation, repair 100 s",
    "5 robots with work at all times, 2 chargers",
    "two streams of 60 robots that cross at 90°",
    "ring of 80 D, 70 robots",
    "busy station with 10 s service, open 995 of 2000 s, at_close: finish",
    "ring of 80 D, 55 robots",
    "ring of 80 D, 45 robots",
    "closed line D/D/1, 8 robots, 30 s round, 10 s service",
    "closed line D/D/1, 5 robots, 30 s round, 10 s service",
    "M/G/1//8, 8 robots and a lift",
    "1 robot with work at all times, 1 charger",
    "busy station with 10 s service, open 995 of 2000 s, at_close: pause",
}
"""The dear ones, and those that lie between others of their kind."""
EACH = [
    pytest.param(case, id=case.title, marks=[pytest.mark.long] if case.long or case.title in PROOFS else [])
    for case in CASES
]


@pytest.mark.parametrize("case", EACH)
def test_a_case_agrees_with_theory_and_stands_on_the_page(case):
    """The 99 % interval of runs with fixed seeds contains the value, and lies within 3 % of it."""
    for outcome in case.simulate():
        assert outcome.contains, f"the interval misses it: {outcome}"
        assert outcome.near, f"the interval reaches too far: {outcome}"
        assert make_validation.row(outcome) in make_validation.PAGE.read_text(encoding="utf-8")


def test_a_robot_that_breaks_down_is_available_for_its_share_of_the_time():
    """Of 100 s of operation and 25 s of repair, at random: 320 of them, of which the mean is known to 1.3 %."""
    model = dw.load(models.crews_that_break_down(1, 100.0, 25.0, 10_000))
    available = [dw.simulate(model, seed).kpis["availability"] for seed in range(4)]
    assert sum(available) / 4 == pytest.approx(0.8, abs=0.026)


def test_eight_robots_that_ride_in_one_lift_are_machines_with_one_repairer():
    """The lift is nearly always busy: runs of five hours vary by half a per cent, and doors are a tenth of a ride."""
    model = dw.load(models.upstairs(8, 150.0, 5 * 3600.0))
    rides = [dw.simulate(model, seed).kpis["throughput_per_hour"] for seed in range(2)]
    assert sum(rides) / 2 == pytest.approx(repairman(8, 150.0, models.RIDING) * 3600 / models.RIDING, rel=0.02)


@pytest.mark.parametrize(("at_close", "done"), [("pause", 995), ("finish", 1000)])
def test_in_ten_openings_of_995_s_a_service_of_10_s_is_cut_or_ends(at_close, done):
    """A service that is cut goes on at the next opening: 99.5 in each, and 100 where it ends after hours."""
    run = {"run": {"length": 11 * hours.EVERY, "warm_up": hours.EVERY}}
    model = dw.load(hours.busy_station(995.0, 10.0, at_close), run)
    assert dw.simulate(model).kpis["tasks"] == pytest.approx(done, abs=1)


# Formulas


def test_one_server_of_m_d_c_is_that_of_pollaczek_and_khinchine():
    assert m_d_c_wait(0.07, 10.0, 1) == pytest.approx(0.7 * 10.0 / (2 * (1 - 0.7)), rel=1e-9)
    assert m_d_c_wait(0.07, 10.0, 1) == pytest.approx(m_g_1_wait(0.07, 10.0, 100.0), rel=1e-9)


def test_one_server_of_m_m_c_waits_for_the_load_over_what_is_left():
    assert m_m_c_wait(0.07, 10.0, 1) == pytest.approx(10.0 * 0.7 / 0.3)
    assert m_m_c_wait(0.07, 10.0, 1) == pytest.approx(m_g_1_wait(0.07, 10.0, 200.0))


def test_two_servers_worked_by_hand():
    """Offered load 1: both are busy with probability 1/3 (Erlang), and who then waits does so for one service time."""
    assert m_m_c_wait(0.1, 10.0, 2) == pytest.approx(10.0 / 3)


def test_one_machine_is_a_renewal_process():
    assert repairman(1, 30.0, 10.0) == pytest.approx(10 / 40)


def test_a_straight_turn_costs_no_more_than_the_distance():
    assert headway_of_a_turn(0.0, math.radians(30), 1.0, 2.0) == 0.5


# What a mean does not show


def test_every_robot_in_the_street_keeps_its_headway():
    run = dw.simulate(dw.load(models.street(30)))
    close = models.D / models.SPEED
    for lane, headway in ((("A", "B"), close), (("B", "C"), close), (("C", "E"), TURN), (("E", "F"), TURN)):
        assert headways(run, lane) == pytest.approx([headway] * 29)


def test_nobody_turns_off_at_the_crossing():
    run = dw.simulate(dw.load(models.crossing(20)))
    beyond = {row[5] for row in run.record.rows if row[1] == "enter" and row[5][0] == "X"}
    assert beyond == {("X", "E1"), ("X", "S1")}
    assert len(entries(run, *beyond)) > 100


def test_no_energy_is_lost():
    """What was drawn is what was charged and what is missing from the batteries at the end."""
    run = dw.simulate(dw.load(models.fleet_on(2, 5, 0.5, 1.0), {"run": {"length": 3e4}}))
    levels = run.history.changes
    now = 0.0
    for spans in levels:
        last = spans[-1]
        rate = 1.0 if last.state == "charging" else -0.5
        now += min(last.energy + rate * (run.T - last.start), 1000)
    charged = sum(robot["charging"] for robot in run.record.robots) * 1.0
    assert 5 * 1000 + charged - run.kpis["energy"] == pytest.approx(now, rel=1e-6)
