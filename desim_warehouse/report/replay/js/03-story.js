// What happens besides driving: states, tasks, waiting, counts, each at any time (in ticks).

class Story {
  constructor(header, columns) {
    this.header = header;
    this.count = header.radii.length;
    this.first = starts(columns.state_count);
    this.stateTime = totals(columns.state_time);
    this.state = columns.state;
    this.task = totals(columns.state_task);
    this.energy = totals(columns.state_energy).map((value) => value / 1000);
    this.tasks = totals(columns.task);
    this.good = columns.task_good;
    this.released = totals(columns.task_released);
    this.loaded = totals(columns.task_loaded);
    this.goodOf = new Map(Array.from(this.tasks, (task, i) => [task, this.good[i]]));
    this.doneTime = totals(columns.done_time);
    this.doneNode = columns.done_node;
    this.recharged = totals(columns.recharged);
    this.from = (header.begin - header.start) / header.tick;
    this.readWaits(columns);
    this.rings = header.rings.map(([time, robots]) => ({ time: (time - header.start) / header.tick, robots }));
    this.cursor = this.first.slice(0, this.count);
    this.waitCursor = this.waitFirst.slice(0, this.count);
  }

  readWaits(columns) {
    this.waitTime = totals(columns.wait_time);
    this.waitRobot = columns.wait_robot;
    this.waitOther = columns.wait_other;
    this.waitEdge = columns.wait_edge;
    this.waitLength = columns.wait_length;
    this.waitBegin = this.waitTime.map((time, i) => time - columns.wait_begin[i]);
    const counts = new Int32Array(this.count);
    for (const robot of this.waitRobot) counts[robot]++;
    this.waitFirst = starts(counts);
    const order = Array.from(this.waitBegin.keys());
    order.sort((a, b) => this.waitBegin[a] - this.waitBegin[b]);
    this.byBegin = Int32Array.from(order);
    this.beginnings = this.waitBegin.slice().sort();
    this.waitsOf = new Int32Array(order.length);
    const next = this.waitFirst.slice();
    for (const i of order) this.waitsOf[next[this.waitRobot[i]]++] = i;
    this.beginsOf = Float64Array.from(this.waitsOf, (i) => this.waitBegin[i]);
  }

  // The row of a robot's states that holds at a time.
  row(robot, time) {
    const low = this.first[robot], high = this.first[robot + 1];
    let i = this.cursor[robot];
    if (this.stateTime[i] > time || (i + 1 < high && this.stateTime[i + 1] <= time))
      i = this.cursor[robot] = Math.max(lastBefore(this.stateTime, time, low, high), low);
    return i;
  }

  // The part of its battery that a robot has left.
  charge(robot, time) {
    const i = this.row(robot, time);
    if (i + 1 >= this.first[robot + 1]) return this.energy[i];
    const span = this.stateTime[i + 1] - this.stateTime[i];
    const part = span > 0 ? Math.min((time - this.stateTime[i]) / span, 1) : 0;
    return this.energy[i] + part * (this.energy[i + 1] - this.energy[i]);
  }

  // The collision that a robot is in at a time; -1: none.
  waiting(robot, time) {
    const low = this.waitFirst[robot], high = this.waitFirst[robot + 1];
    if (low === high) return -1;
    let i = this.waitCursor[robot];
    if (this.beginsOf[i] > time || (i + 1 < high && this.beginsOf[i + 1] <= time))
      i = this.waitCursor[robot] = Math.max(lastBefore(this.beginsOf, time, low, high), low);
    const wait = this.waitsOf[i];
    return time >= this.waitBegin[wait] && time < this.waitBegin[wait] + this.waitLength[wait] ? wait : -1;
  }

  // How many of `times` lie between the end of the warm-up and `time`, both included.
  counted(times, time) {
    return Math.max(lastBefore(times, time) - lastBefore(times, this.from - 1e-9), 0);
  }

  S(time) {
    return this.header.before.S + this.counted(this.inWindow ??= this.waitTime.filter((t) => t >= 0), time);
  }

  C(time) {
    return this.header.before.C + this.counted(this.recharged, time);
  }

  delivered(time) {
    return this.counted(this.doneTime, time);
  }

  // The same by node.
  deliveredAt(time) {
    const counts = new Map(this.header.unload_at.map((node) => [node, 0]));
    const last = lastBefore(this.doneTime, time);
    for (let i = lastBefore(this.doneTime, this.from - 1e-9) + 1; i <= last; i++)
      counts.set(this.doneNode[i], (counts.get(this.doneNode[i]) ?? 0) + 1);
    return counts;
  }

  throughput(time) {
    const { tick, units, start, begin } = this.header;
    const hours = ((time * tick + start - begin) * units.seconds) / 3600;
    return hours > 0 ? this.delivered(time) / hours : 0;
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

// Waiting per lane from the start of the window, or from the end of the warm-up if that is later; in ticks, kept up as
// time goes on.
class Heat {
  constructor(story, edges) {
    this.story = story;
    this.edges = edges;
    this.sum = new Float64Array(edges.real);
    this.next = 0;
    this.most = 0;
  }

  upTo(time) {
    const { waitTime, waitEdge, waitLength } = this.story;
    if (this.next > 0 && waitTime[this.next - 1] > time) {
      this.sum.fill(0);
      this.next = this.most = 0;
    }
    for (; this.next < waitTime.length && waitTime[this.next] <= time; this.next++) {
      const edge = waitEdge[this.next];
      if (edge < 0 || waitTime[this.next] < Math.max(0, this.story.from - 1e-9)) continue;
      const lane = this.edges.lane(edge);
      this.sum[lane] += waitLength[this.next];
      this.most = Math.max(this.most, this.sum[lane]);
    }
    return this.sum;
  }
}
