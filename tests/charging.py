"""What each robot of a model has for its own, read from its kind: a battery and a charging policy."""


def kinds_of(model):
    """By robot its kind, None for ordinary robots."""
    return [model.fleet.kinds.get(kind) for kind in model.fleet.kinds_of_robots()]


def batteries(model):
    """By robot, None without one."""
    return [(kind and kind.battery) or model.battery for kind in kinds_of(model)]


def swaps(model):
    """By robot, whether its battery is swapped."""
    return [((kind and kind.charging) or model.policies.charging).name == "swap" for kind in kinds_of(model)]
