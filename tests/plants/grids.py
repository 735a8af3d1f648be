"""Grids drawn for the tests of their readers."""

import json

MAP = """\
type octile
height 3
width 4
map
..@.
.T..
...W
"""
KIVA = """\
5 8
8
2
1000
........
.eeee.r.
.@@@@...
.eeee.r.
........
"""
TASKS = """\
3
0 0 5 0 0
4 2 7 0 0
4 1 6 0 0
"""
GGO = {
    "name": "two shelves",
    "layout": ["w....", ".e@e.", ".e@e.", "....w"],
    "n_row": 4,
    "n_col": 5,
    "n_endpoint": 4,
    "n_agent_loc": 0,
    "weight": False,
    "maxtime": 500,
}
PROBLEM = {
    "mapFile": "maps/yard.map",
    "agentFile": "yard.agents",
    "taskFile": "yard.tasks",
    "teamSize": 2,
    "numTasksReveal": 1.5,
    "delayConfig": {"seed": 0, "pDelay": 0.01},
}
AGENTS = "# robots\n3\n0\n10\n3\n"
ERRANDS = "# tasks\n3\n1,8\n# with a stop on the way\n9,6,3\n7\n"
ROUND = """\
Grid size (x, y)
3,2
id,type,station,x,y,weight_to_NORTH,weight_to_WEST,weight_to_SOUTH,weight_to_EAST,weight_for_WAITING
0,Induct,7,0,0,1,inf,inf,inf,1
1,Travel,None,0,1,inf,inf,inf,1,1
2,Travel,None,1,0,inf,1,inf,inf,1
3,Travel,None,1,1,inf,inf,inf,2,1
4,Eject,9,2,0,inf,1,inf,inf,1
5,Eject,9,2,1,inf,inf,1,inf,1
"""


def written(tmp_path, name, content):
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_bytes((content if isinstance(content, str) else json.dumps(content)).encode())
    return path


def problem(tmp_path, changes=(), **files):
    """A problem of the League of Robot Runners with the files it names."""
    for name, content in {"maps/yard.map": MAP, "yard.agents": AGENTS, "yard.tasks": ERRANDS, **files}.items():
        written(tmp_path, name, content)
    return written(tmp_path, "yard.json", {**PROBLEM, **dict(changes)})
