"""When tasks are done, by the rows of a log: with their delivery, or with the work on their load units."""


def workplaces(run):
    """The stations, by node, where what is put down is worked on, as the model says."""
    specs = run.model.layout.stations
    of = {node: specs[station.zone] for node, station in run.layout.stations.items()}
    return {node: spec for node, spec in of.items() if spec.work_time is not None}


def ends(run):
    """The rows with which tasks are done, in order."""
    at = workplaces(run) if run.model.tasks.done_when == "worked" else {}
    last = "worked" if at else "delivered"
    return [row for row in run.record.rows if row[1] == last or (row[1] == "delivered" and not for_workers(row, at))]


def for_workers(row, at):
    """Whether what is delivered is put down before workers, and not into a storage place beside them."""
    return row[4] in at and row[5] is None


def done(run):
    """When each task was done, in that order."""
    return {row[3]: row[0] for row in ends(run)}
