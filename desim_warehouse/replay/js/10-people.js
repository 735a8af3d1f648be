// Pickers at any time (in ticks): where each walks, for which robot; they are numbered on from the robots. What one does
// can be told without colour: free ones are hollow, those who walk full, and those who pick have a load in front of them.

const FREE = 0, WALKS = 1, PICKS = 2;
const DOES = ["free", "walking", "picking"];
const CLOTHES = ["idle", "empty", "loaded"]; // like robots that rest, drive empty, and carry

class People {
  constructor(columns, edges, header) {
    const { picker_edge = [], picker_at, act_count = [], act_time = [], act_length, act_robot, act_nodes, act_node, act_edge, act_at } = columns;
    this.count = picker_edge.length;
    this.first = starts(act_count);
    this.cursor = this.first.slice(0, this.count);
    this.begin = totals(act_time);
    this.end = this.begin.map((time, i) => time + act_length[i]);
    this.robot = act_robot;
    this.picks = act_nodes?.map((nodes) => (nodes < 0 ? 1 : 0));
    this.ways = []; // of each act: the points of the way walked, of a pick where it is
    this.start = []; // where each picker begins
    const node = (number) => header.nodes[number].slice(1);
    const spot = (edge, at) => {
      if (edge < 0) return node(-1 - edge);
      const part = edges.length[edge] ? (at * header.grain) / edges.length[edge] : 0;
      return [edges.x[edge] + part * edges.dx[edge], edges.y[edge] + part * edges.dy[edge]];
    };
    for (let picker = 0, walk = 0, passed = 0; picker < this.count; picker++) {
      let now = (this.start[picker] = spot(picker_edge[picker], picker_at[picker]));
      for (let i = this.first[picker]; i < this.first[picker + 1]; i++) {
        const way = [now];
        for (let left = act_nodes[i]; left > 0; left--) way.push(node(act_node[passed++]));
        if (!this.picks[i]) way.push((now = spot(act_edge[walk], act_at[walk++])));
        this.ways.push(way);
      }
    }
  }

  // The act that a picker has begun last; -1: none yet.
  act(picker, time) {
    if (this.first[picker] === this.first[picker + 1]) return -1;
    const i = rowAt(this.begin, this.first, this.cursor, picker, time);
    return this.begin[i] <= time ? i : -1;
  }

  // What a picker does at a time: FREE, WALKS or PICKS; for which robot, and until when.
  doing(picker, time) {
    const i = this.act(picker, time);
    if (i < 0) return { does: FREE, robot: -1, until: NaN };
    const { robot, end } = this, under = time < end[i], next = i + 1 < this.first[picker + 1] ? i + 1 : -1;
    if (under) return { does: this.picks[i] ? PICKS : WALKS, robot: robot[i], until: end[i] };
    const waits = !this.picks[i] && next >= 0 && this.picks[next] && robot[next] === robot[i]; // sent ahead, before the robot
    return { does: FREE, robot: waits ? robot[i] : -1, until: NaN };
  }

  // The points from where a picker is at a time to where they go.
  ahead(picker, time) {
    const i = this.act(picker, time);
    if (i < 0) return [this.start[picker]];
    const way = this.ways[i], span = this.end[i] - this.begin[i];
    const long = (k) => Math.hypot(way[k + 1][0] - way[k][0], way[k + 1][1] - way[k][1]);
    const whole = way.slice(1).reduce((sum, _, k) => sum + long(k), 0);
    let left = span > 0 ? Math.min((time - this.begin[i]) / span, 1) * whole : whole;
    for (let k = 0; k + 1 < way.length; k++) {
      const part = long(k) > 0 ? left / long(k) : 1;
      if (part < 1) return [[0, 1].map((axis) => way[k][axis] + part * (way[k + 1][axis] - way[k][axis])), ...way.slice(k + 1)];
      left -= long(k);
    }
    return [way.at(-1)];
  }

  // Put all where they are, after the robots.
  place(time, tracks) {
    for (let picker = 0; picker < this.count; picker++)
      [tracks.x[tracks.count + picker], tracks.y[tracks.count + picker]] = this.ahead(picker, time)[0];
  }

  // Who is with a robot, or on the way to it; -1: nobody.
  with(robot, time) {
    for (let picker = 0; picker < this.count; picker++) if (this.doing(picker, time).robot === robot) return picker;
    return -1;
  }
}

Object.assign(Scene.prototype, {
  // Robots and pickers together.
  everybody() {
    return this.tracks.count + this.people.count;
  },

  // Pickers stand beside the lane, so that a robot there and its number are seen.
  standing(who) {
    const { tracks, view } = this, by = who < tracks.count ? 0 : Math.max(this.floor.radius * view.scale, this.small) + this.size();
    return [tracks.x[who] * view.scale + view.x + 0.7 * by, tracks.y[who] * view.scale + view.y - 0.7 * by];
  },

  // Half the height of a picker on the screen.
  size() {
    return Math.max(0.8 * this.floor.radius * this.view.scale, 1.2 * this.small);
  },

  // Pickers, and a line from each who walks to the robot that waits for them.
  pickers(time, colours) {
    const { ctx, people, tracks, story, header } = this, r = this.size();
    for (let picker = 0; picker < people.count; picker++) {
      const { does, robot } = people.doing(picker, time), [x, y] = this.standing(tracks.count + picker);
      if (does === WALKS && header.states[story.state[story.row(robot, time)]].role === "picker") {
        const [rx, ry] = this.standing(robot);
        ctx.strokeStyle = colours.picker;
        ctx.lineWidth = 1.5;
        ctx.setLineDash([2, 4]);
        ctx.beginPath();
        ctx.moveTo(x, y);
        ctx.lineTo(rx, ry);
        ctx.stroke();
        ctx.setLineDash([]);
      }
      drawPicker(ctx, x, y, r, does, colours);
    }
  },
});

function drawPicker(ctx, x, y, r, does, colours) {
  ctx.fillStyle = colours.floor;
  figure(ctx, x, y, r * 1.35);
  ctx.fillStyle = colours[CLOTHES[does]];
  figure(ctx, x, y, r);
  ctx.fillStyle = does === FREE ? colours.floor : colours.label;
  if (does === FREE) figure(ctx, x, y + r * 0.08, r * 0.6);
  if (does === PICKS) ctx.fillRect(x - r * 0.3, y + r * 0.25, r * 0.6, r * 0.45);
}
