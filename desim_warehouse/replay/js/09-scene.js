// What changes: goods, heat, stations, robots; drawn over the floor for every frame.

const LEAST = 5; // robots are drawn at least this large (radius in CSS pixels) where the floor allows
const CROWD = 0.14; // the most of the floor that enlarged robots may cover
const LINK = 0.42; // the most of the distance between lanes that an enlarged robot's radius may be, but
const QUEUE = 8; // radii of a robot: the end of a lane, where those stand that wait
const SEEN = 3; // where lanes are closer than can be drawn, robots are at least this large

// Somebody: a head and shoulders.
function figure(ctx, x, y, r) {
  ctx.beginPath();
  ctx.arc(x, y - r * 0.55, r * 0.45, 0, 7);
  ctx.fill();
  ctx.beginPath();
  ctx.arc(x, y + r * 0.8, r * 0.8, Math.PI, 0);
  ctx.fill();
}

class Scene {
  constructor(parts, canvas) {
    Object.assign(this, parts); // header, edges, tracks, story, heat, resources, floor, view, colours
    this.canvas = canvas;
    this.ctx = canvas.getContext("2d", { alpha: false });
    this.showHeat = false;
    this.chosen = -1; // the robot whose panel is open
    this.following = false;
    this.pointed = -1; // the robot under the pointer
    this.trail = 0; // ticks of their way that robots are drawn as, where they are too fast to be followed
    this.queue = null; // what was jumped to
    this.stale = true;
    this.groups = Object.fromEntries(this.header.states.map(({ role }) => [role, []])); // robots by what they are drawn as
    this.mood = new Uint8Array(this.tracks.count);
    this.wait = new Int32Array(this.tracks.count).fill(-1);
    this.waiting = [];
  }

  // Fit the drawing to its place on the page, with so many pixels in one of the page's.
  resize(ratio = pixelRatio()) {
    const box = this.canvas.getBoundingClientRect();
    const width = Math.max(Math.round(box.width * ratio), 1), height = Math.max(Math.round(box.height * ratio), 1);
    if (this.ratio === ratio && this.canvas.width === width && this.canvas.height === height) return;
    this.ratio = ratio;
    this.canvas.width = width;
    this.canvas.height = height;
    this.view.resize(box.width, box.height);
    this.stale = true;
  }

  // The least radius on the screen: less than LEAST where lanes are close or robots are many.
  get least() {
    const { left, top, right, bottom } = this.floor.bounds, s = this.view.scale;
    const crowd = Math.sqrt((CROWD * (right - left) * (bottom - top) * s * s) / (Math.PI * this.tracks.count));
    return Math.max(Math.min(LEAST, crowd, Math.max(LINK * this.floor.pitch * s, SEEN)), 1.6);
  }

  // A robot in a slot is not drawn over its neighbours.
  radius(robot) {
    if (robot >= this.tracks.count) return this.size();
    const size = this.header.radii[robot] * this.view.scale;
    const room = this.floor.room[this.tracks.on[robot] - this.edges.real];
    if (room === undefined) return Math.max(size, this.small, 1.6); // on a lane, or beside one in a wide aisle
    const fits = Math.min(size, room * this.view.scale);
    return Math.max(fits, Math.min(this.small, 1.25 * fits), 1.6);
  }

  // Everybody where they are at a time.
  put(time) {
    this.tracks.place(time);
    this.people.place(time, this.tracks);
  }

  // As it is at a time; what is counted, up to another time.
  draw(time, upTo = time) {
    const { ctx, view } = this, colours = this.colours.now;
    this.put(time);
    if (this.chosen >= 0 && this.following) {
      view.centre(this.tracks.x[this.chosen], this.tracks.y[this.chosen]);
      this.stale = true;
    }
    if (this.stale) this.floor.draw(view, colours, this.ratio);
    this.stale = false;
    this.small = this.least;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.floor.sheet, 0, 0);
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    if (this.showHeat) this.heatMap(colours);
    ctx.globalAlpha = this.showHeat ? 0.3 : 1;
    this.goods(time, colours);
    ctx.globalAlpha = 1;
    this.blocked(time, colours);
    this.floor.lines(ctx, view, colours.soft, this.directions(), true);
    this.unloading(time, upTo, colours);
    this.sort(time);
    if (this.header.lifts)
      this.floor.queues(ctx, view, colours, this.floor.queuing(this.story, this.waiting.map((robot) => this.wait[robot])));
    this.rotations(time, colours);
    this.route(time, colours);
    ctx.globalAlpha = this.showHeat ? 0.3 : 1;
    if (this.trail) this.trails(time, colours);
    else this.crowd(time, colours);
    ctx.globalAlpha = 1;
    this.mark(colours);
    this.chain(time, colours);
    this.spot(colours);
  }

  // All robots, with what they do.
  crowd(time, colours) {
    this.waits(colours);
    for (const mood in this.groups) this.robots(mood, colours);
    this.dots(colours);
    this.bars(time, colours);
    this.numbers(colours);
    this.pickers(time, colours);
  }

  // The way that robots have just come, with and without a load: where there is much traffic lines lie over each other.
  trails(time, colours) {
    const { ctx, view, tracks } = this, s = view.scale;
    ctx.lineWidth = Math.max(this.floor.radius * s, 2);
    ctx.lineJoin = "round";
    ctx.globalAlpha = 0.35;
    for (const mood of ["idle", "empty", "loaded"]) {
      ctx.strokeStyle = colours[mood];
      for (const robot of this.groups[mood]) {
        const points = tracks.behind(robot, time - this.trail, time);
        if (points.length < 2) continue;
        ctx.beginPath();
        for (const [x, y] of points) ctx.lineTo(x * s + view.x, y * s + view.y);
        ctx.stroke();
      }
    }
    ctx.globalAlpha = 1;
  }

  // The two-way lanes in use, each in its present direction: that of the robots on it.
  directions() {
    const { tracks, edges } = this;
    return [...new Set(tracks.on)].filter((edge) => edges.twin[edge] >= 0);
  }

  // Goods that are there: released and not yet loaded. Or the pods: those that a robot comes for or carries stand out.
  goods(time, colours) {
    if (this.pods.any) return this.shelves(time, colours);
    const { released, loaded, good } = this.story;
    this.ctx.fillStyle = colours.good;
    this.floor.squares(this.ctx, this.view, good.length, (i) =>
      released[i] <= time && time < loaded[i] ? good[i] : -1, 0.74);
  }

  shelves(time, colours) {
    const { ctx, pods, tracks, view, floor } = this, at = pods.place(time), all = [...at.keys()];
    const called = new Set(pods.lines(time).map((i) => pods.lineOf[i])), side = Math.max(floor.size * view.scale, 3);
    for (const [colour, some] of [[colours.pod, all.filter((pod) => !called.has(pod))], [colours.good, [...called]]]) {
      ctx.fillStyle = colour;
      floor.squares(ctx, view, some.length, (n) => at[some[n]], 0.74);
      for (const pod of some.filter((one) => at[one] < 0)) {
        const robot = -1 - at[pod];
        ctx.fillRect(tracks.x[robot] * view.scale + view.x - side / 2, tracks.y[robot] * view.scale + view.y - side / 2, side, side);
      }
    }
  }

  // Edges that are closed, as broad lines; those with people in them have somebody in the middle.
  blocked(time, colours) {
    const { ctx, view, edges, story } = this, s = view.scale;
    for (const i of story.blocked(time)) {
      const edge = story.shutEdge[i], person = story.shutVisit[i] >= 0;
      const x = edges.x[edge] * s + view.x, y = edges.y[edge] * s + view.y, dx = edges.dx[edge] * s, dy = edges.dy[edge] * s;
      ctx.strokeStyle = ctx.fillStyle = person ? colours.person : colours.shut;
      ctx.globalAlpha = 0.5;
      ctx.lineWidth = Math.max(this.floor.radius * s * 1.3, 4);
      ctx.beginPath();
      ctx.moveTo(x + dx * 0.08, y + dy * 0.08);
      ctx.lineTo(x + dx * 0.92, y + dy * 0.92);
      ctx.stroke();
      ctx.globalAlpha = 1;
      if (person) figure(ctx, x + dx / 2, y + dy / 2, Math.max(this.floor.radius * s, 5));
    }
  }

  heatMap(colours) {
    const { ctx, view, edges } = this, s = view.scale;
    const wide = this.floor.cell ? this.floor.cell * s * 0.55 : this.floor.radius * s * 1.8;
    ctx.globalAlpha = 0.7;
    ctx.fillStyle = colours.floor;
    ctx.fillRect(0, 0, view.width, view.height);
    ctx.globalAlpha = 1;
    ctx.lineCap = "round";
    this.heat.shaded.forEach((lanes, shade) => {
      ctx.lineWidth = Math.max(wide * (0.5 + 0.25 * shade), 3 + 2.5 * shade);
      ctx.strokeStyle = colours.heat[shade];
      ctx.beginPath();
      for (const i of lanes) {
        const from = Math.max(0.08, 1 - (QUEUE * this.floor.radius) / (this.floor.span[i] || 1));
        ctx.moveTo((edges.x[i] + edges.dx[i] * from) * s + view.x, (edges.y[i] + edges.dy[i] * from) * s + view.y);
        ctx.lineTo((edges.x[i] + edges.dx[i] * 0.96) * s + view.x, (edges.y[i] + edges.dy[i] * 0.96) * s + view.y);
      }
      ctx.stroke();
    });
    ctx.lineCap = "butt";
  }

  // Below stations and chargers how much they were in use and who queues; below other nodes the goods delivered there.
  unloading(time, upTo, colours) {
    const { ctx, view } = this, s = view.scale;
    ctx.font = "600 11px system-ui, sans-serif";
    ctx.textBaseline = "top";
    ctx.textAlign = "center";
    const taken = [];
    for (const zone of this.floor.zones) {
      const room = this.floor.apart(zone) * s;
      if (zone.resource < 0 || room < 26) continue;
      const found = this.resources[zone.resource], used = found.utilisation(upTo), queue = found.queue.at(time);
      const [wx, wy, outward] = this.floor.beside(zone), x = wx * s + view.x, y = wy * s + view.y + (outward > 0 ? 2 : -6);
      const wide = Math.min((zone.right - zone.left) * s, room - 8);
      ctx.fillStyle = colours.bar;
      ctx.fillRect(x - wide / 2, y, wide, 4);
      ctx.fillStyle = zone.kind === "bay" ? colours.full : colours.outLine;
      ctx.fillRect(x - wide / 2, y, wide * (used || 0), 4);
      if (room < 44) continue;
      ctx.fillStyle = colours.ink;
      const state = [used ? percent(used) : "", queue ? `queue ${queue}` : ""].filter(Boolean).join(", "), named = zone.kind === "station" ? `${zone.name} ${state}`.trim() : state;
      const free = this.floor.cell ? Math.min(room, 2 * this.floor.cell * s) : room; // beside cells are others
      const words = [named, state, used ? percent(used) : ""].filter((text) => text && ctx.measureText(text).width < free - 6);
      this.write(words, x, outward > 0 ? y + 6 : y - 12, taken);
    }
    for (const node of this.floor.outlets) {
      const [wx, wy] = this.floor.below(node), x = wx * s + view.x, y = wy * s + view.y + 3;
      ctx.fillStyle = colours.ink;
      const count = grouped(this.story.deliveredAt(node, upTo));
      this.write([`${count} delivered`, count], x, y, taken);
    }
  }

  // The first words about a point that cover none of those taken, moved into view where its edges would cut them off.
  write(words, x, y, taken) {
    for (const text of words) {
      const half = this.ctx.measureText(text).width / 2 + 3;
      const at = x > -half && x < this.view.width + half ? Math.min(Math.max(x, half), this.view.width - half) : x;
      if (taken.some(([left, right, top]) => left < at + half && right > at - half && Math.abs(top - y) < 13)) continue;
      taken.push([at - half, at + half, y]);
      this.ctx.fillText(text, at, y);
      return;
    }
  }

  // Who is in which mood, and who waits.
  sort(time) {
    const { tracks, story } = this;
    for (const mood in this.groups) this.groups[mood].length = 0;
    this.waiting.length = 0;
    for (let robot = 0; robot < tracks.count; robot++) {
      const row = story.row(robot, time), state = story.state[row];
      this.mood[robot] = state;
      this.wait[robot] = story.waiting(robot, time);
      if (this.wait[robot] >= 0) this.waiting.push(robot);
      this.groups[this.header.states[state].role].push(robot);
    }
  }

  rotations(time, colours) {
    const { ctx, view, tracks } = this, last = (12 * this.floor.radius) / this.header.grain;
    ctx.strokeStyle = colours.ring;
    ctx.lineWidth = Math.max(2, this.floor.radius * view.scale * 0.3);
    for (const { time: turned, robots } of this.story.rings) {
      if (time < turned || time > turned + last) continue;
      ctx.beginPath();
      for (const robot of robots)
        ctx.lineTo(tracks.x[robot] * view.scale + view.x, tracks.y[robot] * view.scale + view.y);
      ctx.closePath();
      ctx.stroke();
    }
  }

  // Where the chosen robot drives next, up to its next stop.
  ahead(time) {
    const { count } = this.tracks;
    if (this.chosen >= count) return { points: this.people.ahead(this.chosen - count, time), nodes: [], far: 0 };
    const row = this.story.row(this.chosen, time);
    return this.tracks.ahead(this.chosen, time, this.story.until(row, this.chosen));
  }

  route(time, colours) {
    if (this.chosen < 0) return;
    const { ctx, view } = this, { points } = this.ahead(time);
    if (points.length < 2) return;
    ctx.strokeStyle = colours.ink;
    ctx.lineWidth = 3;
    ctx.lineJoin = "round";
    ctx.beginPath();
    for (const [x, y] of points) ctx.lineTo(x * view.scale + view.x, y * view.scale + view.y);
    ctx.stroke();
    const [x, y] = points.at(-1);
    ctx.fillStyle = colours.ink;
    ctx.beginPath();
    ctx.arc(x * view.scale + view.x, y * view.scale + view.y, 5, 0, 7);
    ctx.fill();
  }

  // From the robot that is chosen or pointed at along those it waits for, to the root.
  chain(time, colours) {
    const robot = this.pointed >= 0 ? this.pointed : this.chosen;
    if (robot < 0 || robot >= this.tracks.count) return;
    const { ctx, view, tracks, story } = this, { waits, last } = story.chain(robot, time);
    if (!waits.length) return;
    const chain = [...waits.map((wait) => story.waitRobot[wait]), ...(last < 0 ? [] : [last])];
    const points = chain.map((one) => [tracks.x[one] * view.scale + view.x, tracks.y[one] * view.scale + view.y]);
    for (const [wide, colour] of [[7, colours.floor], [3.5, colours.ring]]) {
      ctx.strokeStyle = ctx.fillStyle = colour;
      ctx.lineWidth = wide;
      ctx.lineJoin = ctx.lineCap = "round";
      ctx.beginPath();
      for (const [x, y] of points) ctx.lineTo(x, y);
      ctx.stroke();
    }
    ctx.lineCap = "butt";
    const [x, y] = points.at(-1);
    ctx.beginPath();
    ctx.arc(x, y, 6, 0, 7);
    ctx.fill();
  }

  // Where what was jumped to is: x, y and radius of its zone, or of its robots.
  around({ number, robots }) {
    const { tracks, floor } = this;
    let points = robots?.map((robot) => [tracks.x[robot], tracks.y[robot]]);
    if (!points) {
      const { left, top, right, bottom } = floor.zones.find((one) => one.resource === number);
      points = [[left, top], [right, bottom]];
    }
    const xs = points.map(([x]) => x), ys = points.map(([, y]) => y);
    const [left, right, top, bottom] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
    return [(left + right) / 2, (top + bottom) / 2, Math.hypot(right - left, bottom - top) / 2 + 2.5 * floor.radius];
  }

  // A ring round it.
  spot(colours) {
    if (this.queue === null) return;
    const { ctx, view } = this, [x, y, reach] = this.around(this.queue);
    ctx.strokeStyle = colours.ink;
    ctx.lineWidth = 2;
    ctx.setLineDash([8, 5]);
    ctx.beginPath();
    ctx.arc(x * view.scale + view.x, y * view.scale + view.y, Math.max(reach * view.scale, 24), 0, 7);
    ctx.stroke();
    ctx.setLineDash([]);
  }
}
