// One run of the page: all that is known of it, and its floor on a canvas of its own.

const LINKS = 4; // of a chain of waits that are told one by one

class Side {
  constructor(header, columns, colours, root, letter) {
    this.header = header;
    this.root = root;
    this.letter = letter;
    const edges = new Edges(header);
    this.story = new Story(header, columns);
    this.tracks = new Tracks(header, columns, edges);
    this.pods = new Pods(columns, header.items);
    this.people = new People(columns, edges, header);
    this.resources = resourcesOf(header, columns);
    this.span = Math.round((header.end - header.start) / header.tick);
    this.heat = new Heat(this.story, edges, colours.steps, this.span);
    const floor = new Floor(header, columns, edges);
    this.view = new View(floor.bounds);
    this.curves = Object.fromEntries(header.tiles.map(([key, , form]) => [key, this.curve(key, form, columns)]));
    this.scene = new Scene({ header, edges, floor, tracks: this.tracks, story: this.story, heat: this.heat, pods: this.pods,
      people: this.people, resources: this.resources, view: this.view, colours }, root.querySelector("canvas"));
  }

  curve(key, form, columns) {
    const unit = { share: 1e-6, time: this.header.tick }[form] ?? 1;
    const values = totals(columns[`${key}_value`]).map((value) => value * unit);
    return new Steps(totals(columns[`${key}_time`]), values, ["count", "open", "lost"].includes(form) ? 0 : NaN);
  }

  // A time of the clock, which is in the time unit of the first run, in this run's ticks; it stops at the end of this one.
  local(time, seconds) {
    const { start, end, tick, units } = this.header, own = (time * seconds) / units.seconds;
    return own >= end ? this.span : Math.max((own - start) / tick, 0);
  }

  // A time in ticks as the run has it; the end exactly.
  moment(time) {
    const { start, end, tick } = this.header;
    return time >= this.span ? end : time * tick + start;
  }

  // The value of an indicator at a time in ticks.
  value(key, form, time) {
    const { header, story } = this;
    if (form === "battery") return story.battery(time)[0];
    if (form === "rate") {
      const hours = ((this.moment(time) - header.begin) * header.units.seconds) / 3600;
      return hours > 0 ? this.curves.tasks.at(time) / hours : 0;
    }
    if (form === "lost") {
      const all = ((this.moment(time) - header.begin) / header.tick) * header.radii.length;
      return all > 0 ? this.curves[key].at(time) / all : NaN;
    }
    if (form === "chargers") {
      const some = this.resources.filter((one) => one.kind === "chargers");
      const most = some.reduce((sum, one) => sum + one.number, 0) * (time - some[0].from);
      return most > 0 ? some.reduce((sum, one) => sum + one.used(time), 0) / most : NaN;
    }
    return this.curves[key].at(time);
  }

  // A time in words: of day if the run says when it starts, else since its start; and in the model's unit.
  clock(time) {
    const { units, day } = this.header, own = this.moment(time);
    const seconds = own * units.seconds + 0.01 + day;
    const hours = seconds >= 3600 || day ? `${two((seconds / 3600) % (day ? 24 : Infinity))}:` : "";
    return `${hours}${two((seconds / 60) % 60)}:${two(seconds % 60)} (${own.toFixed(1)} ${units.times})`;
  }

  name(node) {
    return this.header.nodes[node][0];
  }

  // A node by the name of the station there, and its own.
  place(node) {
    const zone = this.scene.floor.zones.find((one) => one.node === node && one.kind === "station");
    return zone ? `${isolated(zone.name)} (${isolated(this.name(node))})` : isolated(this.name(node));
  }

  // A robot or a picker by its number, in words.
  who(number) {
    const { count } = this.tracks;
    return number < count ? `robot ${number}` : `picker ${number - count}`;
  }

  // What a picker does, for which robot and until when.
  work(picker, time) {
    const { does, robot, until } = this.people.doing(picker, time);
    if (robot < 0) return DOES[FREE];
    if (does === FREE) return `there before robot ${robot}`;
    return `${DOES[does]} ${does === WALKS ? "to" : "into"} robot ${robot} until ${this.short(until)}`;
  }

  // Who comes to a robot that waits for a picker.
  comes(robot, time) {
    if (this.header.states[this.story.state[this.story.row(robot, time)]].role !== "picker") return "";
    const picker = this.people.with(robot, time);
    return picker < 0 ? "nobody is on the way" : `picker ${picker} is ${this.work(picker, time).replace(` to robot ${robot}`, "")}`;
  }

  // Why a robot waits, link by link to the root: "waits 4 s before V for robot 11, which waits behind robot 3, which ...".
  why(robot, time) {
    const { story, header } = this, { waits, last, ring } = story.chain(robot, time);
    if (!waits.length) return "";
    const shown = waits.slice(0, LINKS);
    const words = shown.map((wait, i) => {
      const other = story.waitOther[wait], node = story.waitNode[wait], cause = story.waitCause?.[wait] ?? 0;
      const since = i === 0 ? ` ${this.lasts(time - story.waitBegin[wait])}` : "";
      if (cause > 0) return `waits${since}${header.apart[cause - 1].replace("waiting", "")} until ${this.short(story.opens(wait, time))}`;
      const where = node < 0 ? " behind" : ` before ${isolated(this.name(node))}`;
      if (other < 0) return `waits${since}${node < 0 ? "" : where} for its turn`;
      return `waits${since}${where}${node < 0 ? "" : " for"} robot ${other}`;
    });
    if (waits.length > LINKS) words.push(`and so on to robot ${last}`);
    if (ring) words.push("and so on in a ring");
    else if (last >= 0) words.push(this.present(last, time));
    return words.join(", which ");
  }

  // What a robot does that others wait for, and until when.
  present(robot, time) {
    const { story, header } = this, row = story.row(robot, time);
    const until = story.until(row, robot);
    const state = header.states[story.state[row]], stands = !state.drives;
    const place = stands ? this.standing(robot) : "";
    return `is ${state.doing}${place}${stands && Number.isFinite(until) ? ` until ${this.short(until)}` : ""}`;
  }

  // Where a robot stands that does not drive: at its node, or on the lane beside which it stopped.
  standing(robot) {
    const { edges, tracks } = this.scene, on = tracks.on[robot];
    if (on >= edges.real) return ` at ${isolated(this.name(edges.source[on]))}`;
    const left = Math.hypot(edges.x[on] + edges.dx[on] - tracks.x[robot], edges.y[on] + edges.dy[on] - tracks.y[robot]);
    const [from, to] = [edges.source[on], edges.target[on]].map((node) => this.name(node));
    return left > this.scene.floor.radius ? ` on ${isolated(`${from}>${to}`)}` : ` at ${isolated(to)}`;
  }

  // The clock alone.
  short(time) {
    return this.clock(time).replace(/ \(.*/, "");
  }

  // Words for a length of time in ticks.
  lasts(ticks) {
    const { tick, units } = this.header, long = ticks * tick;
    if (units.seconds === 1 && long >= 120) return `${Math.floor(long / 60)} min ${Math.floor(long % 60)} s`;
    const text = shortNumber(long);
    return `${text} ${text === "1" ? units.time : units.times}`;
  }
}

// A number in two digits, as a clock shows it.
const two = (n) => String(Math.floor(n)).padStart(2, "0");

// A name whose writing direction leaves the words around it as they are.
function isolated(name) {
  return `\u2068${name}\u2069`;
}

function shortNumber(value) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size >= 1000) return grouped(Math.round(value));
  return String(Number(value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : 2)));
}

// A whole number with its thousands apart.
function grouped(value) {
  return value.toLocaleString("en");
}

function percent(share) {
  if (share > 0 && share < 0.0005) return "under 0.1 %";
  return Number.isFinite(share) ? `${Number((100 * share).toFixed(share > 0 && share < 0.0995 ? 1 : 0))} %` : "–";
}
