"""Damaged and hostile grids: one message each, with its place, soon and without much memory."""

import json
import time

import pytest

from benchmarks.memory import peak
from tests.plants.damage import one_message
from tests.plants.grids import GGO, KIVA, MAP, ROUND, TASKS, problem, written

MEGABYTES = 1000  # more, that a grid of a few rows makes a process need


def change(text, before, after):
    assert before in text
    return text.replace(before, after, 1)


DAMAGED = {
    "no rows": (change(MAP, "..@.\n.T..\n...W\n", ""), ":4: the file ends here, expected 3 rows as the head"),
    "a row short": (change(MAP, "...W\n", ""), ":6: the file ends here, expected 3 rows as the head of"),
    "a row more": (MAP + "....\n", ":8: one more row (got '....'), expected 3"),
    "narrow": (change(MAP, ".T..", ".T."), ":6: row 1 has 3 cells, expected 4"),
    "wide": (change(MAP, ".T..", ".T..."), ":6: row 1 has 5 cells, expected 4"),
    "gap": (change(MAP, ".T..", ""), ":6: row 1 has 0 cells, expected 4"),
    "letter": (change(MAP, ".T..", ".X.."), ":6: row 1, column 1: unknown cell (got 'X'), expected '@', 'O'"),
    "no height": (change(MAP, "height 3\n", ""), ":3: no height, expected the lines"),
    "no width": (change(MAP, "width 4\n", ""), ":3: no width"),
    "twice": (change(MAP, "height 3", "width 4"), ":3: not what it should be (got 'width 4')"),
    "negative": (change(MAP, "height 3", "height -3"), "not what it should be (got '-3 4')"),
    "words": (change(MAP, "height 3", "height three"), "not what it should be (got 'three 4')"),
    "zero": (change(MAP, "height 3", "height 0"), "a grid without cells (got 0 rows of 4)"),
    "fraction": (change(MAP, "width 4", "width 4.5"), "not what it should be (got '3 4.5')"),
    "gigantic": (change(MAP, "height 3", "height 999999999"), "the file ends here, expected 999999999 rows"),
    "endless": (change(MAP, "height 3", f"height {'9' * 4000}"), "not what it should be (got '999"),
    "only type": ("type octile\n", ":1: the file ends here, expected the lines"),
    "type and noise": ("type octile\n\0\0\0\n", ":2: not what it should be"),
    "all blocked": ("type octile\nheight 1\nwidth 2\nmap\n@@\n", "no cell that robots can enter"),
    "a single cell": ("type octile\nheight 1\nwidth 2\nmap\n.@\n", "no lanes, expected some on which robots drive"),
    "too many": (
        f"type octile\nheight 400\nwidth 300\nmap\n{('.' * 300 + chr(10)) * 400}",
        "too many cells that robots can enter (got 120,000)",
    ),
    "bytes": (b"type octile\nheight \xff", ":2: not text (got byte 0xff)"),
    "k short": (change(KIVA, "........\n", ""), ":8: the file ends here, expected 5 rows"),
    "k narrow": (change(KIVA, ".eeee.r.", ".eeee.r"), ":6: row 1 has 7 cells, expected 8"),
    "k letter": (change(KIVA, ".eeee.r.", ".eeeE.r."), ":6: row 1, column 4: unknown cell (got 'E')"),
    "k agents": (change(KIVA, "8\n2\n", "8\ntwo\n"), ":3: not what it should be (got 'two')"),
    "k two numbers": (change(KIVA, "8\n2\n", "8\n2 3\n"), ":3: more than one number (got '2 3')"),
    "k horizon": ("5 8\n8\n2\n", ":3: the file ends here, expected the number of steps"),
    "k sizes": (change(KIVA, "5 8", "0 8"), "a grid without cells (got 0 rows of 8)"),
    "k transposed": (change(KIVA, "5 8", "8 5"), ":5: row 0 has 8 cells, expected 5"),
    "g no list": ({**GGO, "layout": "w..."}, "no rows of cells, expected a grid with the key layout"),
    "g empty": ({**GGO, "layout": []}, "no rows of cells"),
    "g numbers": ({**GGO, "layout": [1, 2]}, "no rows of cells"),
    "g rows": ({**GGO, "n_row": 5}, "layout: 4 rows, expected 5 as n_row says"),
    "g columns": ({**GGO, "n_col": 6}, "row 0 has 5 cells, expected 6"),
    "g ragged": ({**GGO, "layout": ["w....", ".e@e", ".e@e.", "....w"]}, "row 1 has 4 cells, expected 5"),
    "g letter": ({**GGO, "layout": ["x....", ".e@e.", ".e@e.", "....w"]}, "row 0, column 0: unknown cell (got 'x')"),
    "g text for a number": ({**GGO, "n_row": "4"}, "n_row: not a number of cells (got '4')"),
    "g true for a number": ({**GGO, "n_row": True}, "n_row: not a number of cells (got true)"),
    "g weights missing": ({**GGO, "weight": True}, "weights: no list, expected 48, one for each step"),
    "g weights few": ({**GGO, "weight": True, "weights": [1.0] * 7}, "weights: 7 weights, expected 48"),
    "g weight 0": ({**GGO, "weight": True, "weights": [0] * 49}, "weights[1]: not a weight (got 0)"),
    "g weight text": ({**GGO, "weight": True, "weights": ["1"] * 49}, "weights[1]: not a weight (got '1')"),
    "g not a section": (b'["layout"]', "not a layout that can be read"),
    "g cut off": (json.dumps(GGO)[:60], ".json:1:"),
    "g deep": (b'{"layout": ' + b"[" * 100_000, "too many lists or objects inside one another"),
    "g twice": (b'{"layout": [".."], "layout": [".."]}', "key 'layout' given twice"),
    "g nan": (b'{"layout": [".."], "n_row": NaN}', "not a number (got NaN)"),
    "r no size": ("Grid size (x, y)\nthree,two\n", ":2: not what it should be (got 'three,two')"),
    "r short": (ROUND.rpartition("5,")[0], ":8: the file ends here, expected 3 x 2 cells as the head of"),
    "r more": (ROUND + "6,Travel,None,3,0,1,1,1,1,1\n", ":10: one more line"),
    "r columns": (change(ROUND, "0,Induct,7,0,0,1,inf", "0,Induct,7,0,0,inf"), ":4: 9 values (got "),
    "r type": (change(ROUND, "Induct", "Enter"), ":4: unknown type of a cell (got 'Enter'), expected Induct, Eject"),
    "r weight": (change(ROUND, "inf,1,inf,inf,1\n3", "inf,one,inf,inf,1\n3"), ":6: not a weight (got 'one')"),
    "r below 0": (change(ROUND, "inf,1,inf,inf,1\n3", "inf,-1,inf,inf,1\n3"), ":6: not a weight (got '-1')"),
    "r nan": (change(ROUND, "inf,1,inf,inf,1\n3", "inf,nan,inf,inf,1\n3"), ":6: not a weight (got 'nan')"),
    "r order": (change(ROUND, "1,Travel,None,0,1", "1,Travel,None,1,0"), ":5: cell 1 is x 1, y 0, expected x 0, y 1"),
    "r huge": (change(ROUND, "3,2", "999999999,999999999"), ":6: cell 2 is x 1, y 0, expected x 0, y 2: column"),
    "r nowhere": (ROUND.replace(",1,1\n", ",inf,1\n"), "nowhere can robots drive from one point to"),
}
PROBLEMS = {
    "no map": ({"mapFile": "there.map"}, {}, "there.map: no such file, expected a MovingAI map"),
    "above": ({"mapFile": "../yard.map"}, {}, "mapFile: not a file below the folder of the problem (got"),
    "absolute": ({"mapFile": "/etc/passwd"}, {}, "mapFile: not a file below the folder of the problem"),
    "a folder": ({"mapFile": "maps"}, {}, "maps: not a file, expected a MovingAI map"),
    "no text": ({"mapFile": ["maps/yard.map"]}, {}, "mapFile: not a file below the folder of the problem"),
    "itself": ({"mapFile": "yard.json"}, {}, "yard.json:1: not what it should be"),
    "team": ({"teamSize": 4}, {}, "teamSize: not so many (got 4), expected 1 to 3"),
    "team of 0": ({"teamSize": 0}, {}, "teamSize: not so many (got 0)"),
    "fat": ({"agentSize": 1.5}, {}, "agentSize: not a part of a cell (got 1.5)"),
    "agent in a wall": ({}, {"yard.agents": "1\n2\n"}, "yard.agents:2: no cell that robots can enter (got 2)"),
    "agent outside": ({}, {"yard.agents": "1\n12\n"}, "yard.agents:2: no cell that robots can enter (got 12)"),
    "agents few": ({}, {"yard.agents": "4\n0\n1\n"}, "yard.agents:3: the file ends here, expected 4 agents"),
    "agents more": ({}, {"yard.agents": "1\n0\n1\n"}, "yard.agents:3: one more line (got '1'), expected 1 agents"),
    "agents twice": ({}, {"yard.agents": "2\n0\n0\n"}, "yard.agents:3: in the cell of agent 0"),
    "agents empty": ({}, {"yard.agents": ""}, "yard.agents:1: not what it should be (got '')"),
    "task words": ({}, {"yard.tasks": "1\n1;8\n"}, "yard.tasks:2: not what it should be (got '1;8')"),
    "task in a wall": ({}, {"yard.tasks": "# x\n1\n1,2\n"}, "yard.tasks:3: no cell that robots can enter (got 2)"),
    "tasks few": ({}, {"yard.tasks": "3\n1,8\n"}, "yard.tasks:2: the file ends here, expected 3 tasks"),
    "tasks of two numbers": ({}, {"yard.tasks": "1 2\n1,8\n"}, "yard.tasks:1: more than one number (got '1 2')"),
    "tasks gigantic": ({}, {"yard.tasks": "999999999\n1,8\n"}, "too many tasks (got 999,999,999)"),
}
TASK_FILES = {
    "endpoint": (TASKS.replace("2 7", "2 8"), ":3: no such endpoint (got 8), expected a number from 0 to 7"),
    "few": (TASKS.replace("3\n", "4\n", 1), ":4: the file ends here, expected 4 tasks as the head of the file says; 3"),
    "more": (TASKS + "5 0 1\n", ":5: one more line (got '5 0 1')"),
    "negative": (TASKS.replace("4 2", "-4 2"), ":3: not what it should be (got '-4 2 7 0 0')"),
    "short line": (TASKS.replace("4 2 7 0 0", "4 2"), ":3: not what it should be (got '4 2')"),
    "another format": ("hello\n", "not tasks that can be read, expected transport orders of openTCS (XML), tasks of"),
}


def refused(path, **options):
    begin, before = time.process_time(), peak()
    message = one_message(path, **options)
    assert len(message.replace(str(path), "")) < 560
    assert time.process_time() - begin < 5
    assert peak() - before < MEGABYTES
    return message


@pytest.mark.parametrize("case", DAMAGED)
def test_a_damaged_file_gives_one_message_with_its_place(tmp_path, case):
    content, expected = DAMAGED[case]
    name = f"x{'.json' if case.startswith('g ') else '.grid' if case.startswith('r ') else '.map'}"
    path = tmp_path / name
    path.write_bytes(content if isinstance(content, bytes) else b"")
    if not isinstance(content, bytes):
        written(tmp_path, name, content)
    message = refused(path)
    assert expected in message
    assert name in message


@pytest.mark.parametrize("case", PROBLEMS)
def test_a_damaged_problem_gives_one_message_that_names_the_file(tmp_path, case):
    changes, files, expected = PROBLEMS[case]
    assert expected in refused(problem(tmp_path, changes, **files))


@pytest.mark.parametrize("case", TASK_FILES)
def test_damaged_tasks_give_one_message_with_the_line(tmp_path, case):
    content, expected = TASK_FILES[case]
    files = written(tmp_path, "small.map", KIVA), written(tmp_path, "small.task", content)
    assert expected in refused(files[0], tasks=files[1])
