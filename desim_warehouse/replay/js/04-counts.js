// What is counted over time (in ticks): curves of steps, and how many servers or chargers are in use.

// A value that stays as it is until the next step; before the first it is `none`.
class Steps {
  constructor(times, values, none = 0) {
    this.times = times;
    this.values = values;
    this.none = none;
  }

  at(time) {
    const i = lastBefore(this.times, time + 1e-6);
    return i < 0 ? this.none : this.values[i];
  }
}

// The servers of a station or the chargers of a bay.
class Resource {
  constructor([kind, name, node, number, one], busy, queue, from) {
    Object.assign(this, { kind, name, node, number, one, busy, queue, from }); // one: the word for one of them
    this.area = new Float64Array(busy.times.length); // of busy servers x ticks, at each step
    for (let i = 1; i < this.area.length; i++)
      this.area[i] = this.area[i - 1] + busy.values[i - 1] * (busy.times[i] - busy.times[i - 1]);
  }

  until(time) {
    const i = lastBefore(this.busy.times, time);
    return i < 0 ? 0 : this.area[i] + this.busy.values[i] * (time - this.busy.times[i]);
  }

  // Servers x ticks in use since the warm-up.
  used(time) {
    return time > this.from ? this.until(time) - this.until(this.from) : 0;
  }

  // The share of the time of its servers or chargers in which they were in use since the warm-up.
  utilisation(time) {
    return time > this.from ? this.used(time) / (this.number * (time - this.from)) : NaN;
  }
}

function resourcesOf(header, columns) {
  const from = (header.begin - header.start) / header.tick;
  const curves = (what) => {
    const first = starts(columns[`${what}_count`]), time = totals(columns[`${what}_time`]);
    const now = totals(columns[`${what}_now`]);
    return header.resources.map((_, i) => new Steps(time.slice(first[i], first[i + 1]), now.slice(first[i], first[i + 1])));
  };
  const busy = curves("busy"), queue = curves("queue");
  return header.resources.map((item, i) => new Resource(item, busy[i], queue[i], from));
}
