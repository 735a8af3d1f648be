"""Wide aisles for random models: robots stand beside some or all lanes while they load and unload."""

import random

import desim_warehouse as dw

LONGER = 4
"""Factor by which edges become longer in models without batteries, as robots load in the lane on short edges."""


def with_wide_aisles(mapping, key):
    """Return the model with some or all aisles wide, often with popular places and long handling times."""
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
    """Return the layout with edges `LONGER` times as long, and the places on them at the same relative positions."""
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
    """Return named aisles along some lanes with storage places, with random widths."""
    floor = dw.load(mapping).floor
    lines = sorted({tuple(sorted(place.edge)) for place in floor.storage if place.edge[0] != place.edge[1]})
    chosen = [line for line in lines if draw.random() < 0.7]
    if not chosen:
        return "wide"
    middle = len(chosen) // 2
    wide = {"a": {"along": chosen[middle:]}}
    return {**wide, "b": {"along": chosen[:middle], "width": draw.choice(("narrow", 900))}} if middle else wide
