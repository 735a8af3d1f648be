"""The part of the auditor for the hours of stations, robots and flows, and for buffers."""

from collections import Counter, defaultdict

TOL = 1e-6


class Hours:
    """Checks of hours and buffers, for `Audit`."""

    def check_hours(self):
        model = self.run.model
        of = {node: model.layout.stations[item.zone] for node, item in self.run.layout.stations.items()}
        self.check_stations({node: (model.hours(spec.hours), spec.at_close) for node, spec in of.items() if spec.hours})
        self.check_duty([model.hours(name) for name in model.fleet.hours_of_robots()])
        self.check_flows({name: model.hours(flow.hours) for name, flow in model.tasks.flows.items()})
        self.check_buffers(of)

    def check_stations(self, hours):
        """In a closed station no robot begins to load or unload; if the station pauses, none continues."""
        docked, doing = {}, {}
        for time, kind, robot, _, node, *_ in self.rows:
            if kind == "docked":
                docked[robot] = node
            elif kind in {"enter", "parked"}:
                docked.pop(robot, None)
            if kind in {"loading", "unloading"} and docked.get(robot) in hours:
                opening, _ = hours[docked[robot]]
                if not opening.is_open(time) and not opening.is_open(time + TOL):
                    self.fault(time, f"robot {robot} begins {kind} at {node}, which is closed")
            began = doing.get(robot)
            if began is not None and kind in {"closed", "delivered", "loaded", "returning", "empty"}:
                opening, at_close = hours[began[1]]
                _, closes = opening.following(began[0] + TOL)
                if at_close == "pause" and time > closes + TOL:
                    self.fault(time, f"robot {robot} is served at {began[1]} until {time:g}, closed since {closes:g}")
                doing.pop(robot)
            if kind in {"loading", "unloading"} and docked.get(robot) in hours:
                doing[robot] = time, docked[robot]
            if kind == "closed" and docked.get(robot) not in hours:
                self.fault(time, f"robot {robot} waits for a station to open, and is in none that closes")

    def check_duty(self, hours):
        """Outside their hours robots get no tasks; resting robots are on a break then, and only then."""
        visits = self.run.model.pods is not None
        visiting = set()
        for time, kind, robot, task, *_ in self.rows:
            joins = visits and robot in visiting  # a line joins the robot's current visit
            if kind == "assigned" and not joins and not hours[robot].is_open(time):
                self.fault(time, f"robot {robot} is given task {task} outside its hours")
            if kind == "assigned":
                visiting.add(robot)
            elif kind in {"stored", "returned"}:
                visiting.discard(robot)
        for spans, opening in zip(self.run.history.states, hours, strict=True):
            for span in spans:
                if span.state not in {"idle", "on_break"} or span.end - span.start <= 2 * TOL:
                    continue
                at_work = opening.share(span.start + TOL, span.end - TOL)
                if abs(at_work - (span.state == "idle")) > TOL:
                    self.fault(span.start, f"robot {span.robot} is {span.state}, in its hours {at_work:g} of the time")

    def check_flows(self, hours):
        """Tasks are released within the hours of their flow."""
        for time, kind, _, task, *_ in self.rows:
            if kind == "released":
                opening = hours.get(self.run.record.flows.get(task))
                if opening is not None and not opening.is_open(time) and not opening.is_open(time + TOL):
                    self.fault(time, f"task {task} is released outside the hours of its flow")

    def check_buffers(self, of):
        """No buffer holds more load units than it has places, and each load unit is worked on once, where it is."""
        docked, held, put = {}, defaultdict(set), {}
        for time, kind, robot, task, node, *_ in self.rows:
            if kind == "docked":
                docked[robot] = node
            elif kind in {"enter", "parked"}:
                docked.pop(robot, None)
            elif kind == "delivered" and docked.get(robot) in of and of[node].work_time is not None:
                put[task] = node
                held[node].add(task)
                places = of[node].buffer
                if places is not None and len(held[node]) > places:
                    self.fault(time, f"{len(held[node])} load units are in the buffer at {node}, which has {places}")
            elif kind == "worked":
                if task not in held[node]:
                    self.fault(time, f"task {task} is worked on at {node}, where it is not")
                held[node].discard(task)
        worked = Counter(row[3] for row in self.rows if row[1] == "worked")
        if any(count > 1 for count in worked.values()):
            self.fault(self.run.record.end, "a load unit was worked on twice")
