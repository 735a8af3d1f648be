"""Rows of a study as they end, and a study that is given up in the middle."""

import multiprocessing

import pytest

import desim_warehouse as dw

from .conftest import MULTIBOTS


def study(**more):
    return dw.Study(MULTIBOTS, {"fleet.size": [1, 2, 6]}, changes={"tasks.goods": {"random": 4}}, **more)


def known(rows):
    return sorted((row.point.number, row.replication, row.value("T")) for row in rows)


@pytest.mark.usefixtures("two_processors")
@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.long), "auto"])
def test_every_row_comes_once_and_is_that_of_the_study(workers):
    made = study(replications=5)
    rows = list(made.stream(workers=workers))
    assert known(rows) == known(made.rows) == known(study(replications=5).run().rows)
    assert len(rows) == 15


def test_rows_that_are_there_come_first_and_are_not_simulated_again(tmp_path):
    study(replications=2).run(out=tmp_path)
    rows = study(replications=4).stream(out=tmp_path)
    assert {next(rows).replication for _ in range(6)} == {0, 1}
    assert {row.replication for row in rows} == {2, 3}


def test_replications_until_the_mean_is_known_come_one_by_one():
    rule = {"indicator": "T", "half_width": 0.2, "minimum": 5, "cap": 60}
    made = study(replications=rule)
    rows = list(made.stream())
    assert known(rows) == known(made.rows) == known(study(replications=rule).run().rows)


def test_designs_that_are_the_same_model_have_a_row_each():
    made = dw.Study(MULTIBOTS, {"x": {"cases": {"a": {"fleet.size": 2}, "b": {"fleet.size": 2}}}})
    assert [row.point.number for row in made.stream()] == [0, 1]


@pytest.mark.parametrize("workers", [1, pytest.param(2, marks=pytest.mark.long)])
def test_a_stream_that_is_closed_cancels_the_rest_and_keeps_what_ended(tmp_path, workers):
    made = study(replications=3000)
    rows = made.stream(workers=workers, out=tmp_path)
    first = [next(rows) for _ in range(20)]
    rows.close()
    assert not multiprocessing.active_children()
    assert 20 <= len(made.rows) < 9000
    assert set(known(first)) <= set(known(dw.Study.open(tmp_path).rows))
