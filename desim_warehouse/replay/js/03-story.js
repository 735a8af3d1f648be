// What happens besides driving: states, tasks, waiting and energy, each at any time (in ticks).

class Story {
  constructor(header, columns) {
    this.header = header;
    this.count = header.radii.length;
    this.from = Math.max((header.begin - header.start) / header.tick, 0); // waits and deliveries count from here on
    this.readStates(columns);
    this.readTasks(columns);
    this.readWaits(columns);
    this.readBlocked(columns);
    this.rings = header.rings.map(([time, robots]) => ({ time: (time - header.start) / header.tick, robots }));
  }

  readStates(columns) {
    this.first = starts(columns.state_count);
    this.stateTime = totals(columns.state_time);
    this.state = columns.state;
    this.task = totals(columns.state_task);
    this.cursor = this.first.slice(0, this.count);
    if (this.header.capacity === null) return;
    this.energyFirst = starts(columns.energy_count);
    this.energyTime = totals(columns.energy_time);
    this.energy = totals(columns.energy).map((value) => value / 1000);
    this.energyCursor = this.energyFirst.slice(0, this.count);
  }

  readTasks(columns) {
    this.tasks = totals(columns.task);
    this.good = columns.task_good;
    this.released = totals(columns.task_released);
    this.loaded = totals(columns.task_loaded);
    this.due = columns.task_due; // 1 more than the ticks from release to due time; 0: none
    this.to = columns.task_to;
    this.rowOf = new Map(Array.from(this.tasks, (task, i) => [task, i]));
    this.deliveries = new Map(this.header.unload_at.map((node) => [node, []]));
    const done = totals(columns.done_time);
    columns.done_node.forEach((node, i) => {
      if (!this.deliveries.has(node)) this.deliveries.set(node, []);
      this.deliveries.get(node).push(done[i]);
    });
  }

  called(good) {
    const name = this.header.called?.[good];
    return name === undefined ? good : isolated(name);
  }

  readWaits(columns) {
    this.waitTime = totals(columns.wait_time);
    this.waitRobot = columns.wait_robot;
    this.waitOther = columns.wait_other;
    this.waitEdge = columns.wait_edge;
    this.waitNode = columns.wait_node;
    this.waitLength = columns.wait_length;
    this.waitBegin = this.waitTime.map((time, i) => time - this.waitLength[i]);
    const counts = new Int32Array(this.count);
    for (const robot of this.waitRobot) counts[robot]++;
    this.waitFirst = starts(counts);
    const order = Array.from(this.waitBegin.keys());
    order.sort((a, b) => this.waitBegin[a] - this.waitBegin[b]);
    this.waitsOf = new Int32Array(order.length);
    const next = this.waitFirst.slice();
    for (const i of order) this.waitsOf[next[this.waitRobot[i]]++] = i;
    this.beginsOf = Float64Array.from(this.waitsOf, (i) => this.waitBegin[i]);
    this.waitCursor = this.waitFirst.slice(0, this.count);
  }

  // Edges that are closed (visit -1) or have people in them, in order of time; none in most runs.
  readBlocked(columns) {
    this.waitCause = columns.wait_cause ?? null;
    this.shutEdge = columns.shut_edge ?? [];
    this.shutBegin = totals(columns.shut_time ?? []);
    this.shutLength = columns.shut_length ?? [];
    this.shutVisit = columns.shut_visit ?? [];
  }

  // The numbers of those at a time.
  blocked(time) {
    const found = [];
    for (let i = 0; i < this.shutBegin.length && this.shutBegin[i] <= time; i++)
      if (time < this.shutBegin[i] + this.shutLength[i]) found.push(i);
    return found;
  }

  // The row of a robot's states that holds at a time.
  row(robot, time) {
    return rowAt(this.stateTime, this.first, this.cursor, robot, time);
  }

  // When the present drive ends: the time of the next state, or the end of the window.
  until(row, robot) {
    return row + 1 < this.first[robot + 1] ? this.stateTime[row + 1] : Infinity;
  }

  // The part of its battery that a robot has left.
  charge(robot, time) {
    const i = rowAt(this.energyTime, this.energyFirst, this.energyCursor, robot, time);
    if (i + 1 >= this.energyFirst[robot + 1]) return this.energy[i];
    const span = this.energyTime[i + 1] - this.energyTime[i];
    const part = span > 0 ? Math.min(Math.max((time - this.energyTime[i]) / span, 0), 1) : 0;
    return this.energy[i] + part * (this.energy[i + 1] - this.energy[i]);
  }

  // The wait in traffic that a robot is in at a time; -1: none.
  waiting(robot, time) {
    if (this.waitFirst[robot] === this.waitFirst[robot + 1]) return -1;
    const wait = this.waitsOf[rowAt(this.beginsOf, this.waitFirst, this.waitCursor, robot, time)];
    return time >= this.waitBegin[wait] && time < this.waitBegin[wait] + this.waitLength[wait] ? wait : -1;
  }

  // Who a robot waits for, who that one waits for, and so on: the waits from it to the root, and the last robot, which
  // waits for no other (-1: the last waits for nobody) or is in the chain already.
  chain(robot, time) {
    const waits = [], seen = new Set();
    for (let last = robot; ; ) {
      const wait = seen.has(last) ? -1 : this.waiting(last, time);
      if (wait < 0) return { waits, last, ring: seen.has(last) };
      seen.add(last);
      waits.push(wait);
      last = this.waitOther[wait];
      if (last < 0) return { waits, last, ring: false };
    }
  }

  // When the wait of a robot for a closure or person ends: the first moment at which its way is open again.
  opens(wait, time) {
    const ends = this.blocked(time).map((i) => this.shutBegin[i] + this.shutLength[i]);
    const over = this.waitBegin[wait] + this.waitLength[wait];
    return ends.length ? ends.reduce((a, b) => (Math.abs(b - over) < Math.abs(a - over) ? b : a)) : over;
  }

  // How many goods were delivered at a node since the warm-up.
  deliveredAt(node, time) {
    return lastBefore(this.deliveries.get(node) ?? [], time) + 1;
  }

  // Mean and least charge of the fleet.
  battery(time) {
    let sum = 0, least = 1;
    for (let robot = 0; robot < this.count; robot++) {
      const charge = this.charge(robot, time);
      sum += charge;
      if (charge < least) least = charge;
    }
    return [sum / this.count, least];
  }
}
