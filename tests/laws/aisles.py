"""Wide aisles in random models: beside some lanes or all of them robots stand while they load and unload."""

import random

import desim_warehouse as dw

LONGER = 4
"""How many times as long edges are where no battery has to last for them: on short ones robots load in the lane."""


def with_wide_aisles(mapping, key):
    """The model with wide aisles, all or some; places asked for often, and robots that load for long."""
    draw = random.Random(f"aisles {key}")
    layout, tasks = dict(mapping["layout"]), dict(mapping["tasks"])
    if mapping.get("pods"):
        return mapping
    if mapping.get("battery") is None and "edges" in layout and not mapping["fleet"].get("start_on_lanes"):
        layout = longer(layout)
    if draw.random() < 0.5 and "storage" in layout:
        layout["storage"] = [{**place, "popularity": draw.choice((0, 1, 20))} for place in layout["storage"]]
        layout["storage"][0] = {**layout["storage"][0], "popularity": 1}
    if draw.random() < 0.7 and mapping.get("battery") is None:
        slow = draw.choice((3, 10, 40))
        for time in ("load_time", "unload_time"):
            if isinstance(tasks.get(time, 0), int | float):
                tasks[time] = tasks.get(time, 0) + slow
    made = {**mapping, "layout": layout, "tasks": tasks}
    layout["aisles"] = draw.choice(("wide", "wide", 1000, some(made, draw)))
    return made


def longer(layout):
    """The layout with edges so many times as long, and the places on them as far along."""
    edges = []
    for edge in layout["edges"]:
        row = {"from": edge[0], "to": edge[1]} if isinstance(edge, list) else dict(edge)
        if row.get("length"):
            row["length"] *= LONGER
        edges.append(row)
    drawn = {(row["from"], row["to"]) for row in edges if row.get("length")}
    storage = [
        {**place, "offset": place["offset"] * LONGER} if tuple(place.get("edge", ())) in drawn else place
        for place in layout["storage"]
    ]
    return {**layout, "edges": edges, "storage": storage}


def some(mapping, draw):
    """Some lanes with storage places, by name, each as wide as it happens to be."""
    floor = dw.load(mapping).floor
    lines = sorted({tuple(sorted(place.edge)) for place in floor.storage if place.edge[0] != place.edge[1]})
    chosen = [line for line in lines if draw.random() < 0.7]
    if not chosen:
        return "wide"
    middle = len(chosen) // 2
    wide = {"a": {"along": chosen[middle:]}}
    return {**wide, "b": {"along": chosen[:middle], "width": draw.choice(("narrow", 900))}} if middle else wide
