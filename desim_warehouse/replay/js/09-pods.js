// Pods at any time (in ticks): where each is, what it holds, and the lines that a robot brings it for.

class Pods {
  constructor(columns, items) {
    this.names = items; // of items, where a file calls them by name
    this.at = Int32Array.from(columns.pod_at ?? []);
    this.begin = this.at.slice();
    this.time = totals(columns.move_time ?? []);
    this.pod = columns.move_pod ?? [];
    this.to = columns.move_to ?? [];
    this.next = 0; // the first move that has not been made
    this.now = -Infinity;
    this.first = starts(columns.hold_count ?? []);
    this.item = columns.hold_item ?? [];
    this.units = columns.hold_units ?? [];
    this.from = totals(columns.line_time ?? []);
    this.until = this.from.map((time, i) => time + columns.line_length[i]);
    Object.assign(this, { lineOf: columns.line_pod ?? [], task: columns.line_task, asked: columns.line_item, node: columns.line_node, taken: columns.line_units });
  }

  get any() {
    return this.at.length > 0;
  }

  // Make the moves up to a time: a storage place, or below 0 the robot -1 - n that carries it.
  place(time) {
    if (time < this.now) {
      this.at.set(this.begin);
      this.next = 0;
    }
    for (this.now = time; this.next < this.time.length && this.time[this.next] <= time; this.next++) this.at[this.pod[this.next]] = this.to[this.next];
    return this.at;
  }

  // The pod on a storage place, or carried by robot -1 - n; -1: none.
  on(where, time) {
    return this.place(time).indexOf(where);
  }

  // The lines that a pod goes for, by their rows; of all pods without one.
  lines(time, pod = -1) {
    const found = [];
    for (let i = 0; i < this.from.length && this.from[i] <= time; i++)
      if (time < this.until[i] && (pod < 0 || this.lineOf[i] === pod)) found.push(i);
    return found;
  }

  // What is on a pod: units by item, Infinity where they never run out.
  holds(pod, time) {
    const held = new Map();
    for (let i = this.first[pod]; i < this.first[pod + 1]; i++) held.set(this.item[i], this.units[i] < 0 ? Infinity : this.units[i]);
    for (let i = 0; i < this.until.length; i++)
      if (this.lineOf[i] === pod && this.until[i] <= time) held.set(this.asked[i], (held.get(this.asked[i]) ?? 0) - this.taken[i]);
    return held;
  }

  name(item) {
    return this.names ? isolated(this.names[item]) : `${item}`;
  }

  // For whom a pod goes and what it holds, in words; `place` says where a node is.
  said(pod, time, place) {
    const some = this.lines(time, pod), held = [...this.holds(pod, time)].filter(([, units]) => units > 0).sort(([a], [b]) => a - b);
    const items = held.map(([item, units]) => (Number.isFinite(units) ? `${this.name(item)} (${units})` : this.name(item))).join(", ");
    const lines = some.map((i) => `${this.task[i]} (item ${this.name(this.asked[i])})`).join(", ");
    const goes = some.length ? `for ${place(this.node[some[0]])}: line${some.length > 1 ? "s" : ""} ${lines}` : "for no line";
    return [goes, `holds ${held.length === 1 ? "item" : "items"} ${items || "none"}`];
  }
}
