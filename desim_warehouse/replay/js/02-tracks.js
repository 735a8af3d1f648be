// Where every robot is at any time: legs on edges, as positions.py has them. Times in ticks.

class Edges {
  constructor(header) {
    const count = header.source.length;
    this.source = header.source;
    this.target = header.target;
    this.real = header.real;
    this.length = Float64Array.from(header.length);
    this.x = new Float64Array(count);
    this.y = new Float64Array(count);
    this.dx = new Float64Array(count);
    this.dy = new Float64Array(count);
    this.heading = new Float64Array(count);
    this.out = header.nodes.map(() => []);
    this.twin = new Int32Array(count).fill(-1); // of a two-way lane: its other direction
    for (const [edge, back] of header.two_way) [this.twin[edge], this.twin[back]] = [back, edge];
    const pair = (from, to) => from * header.nodes.length + to;
    const pairs = new Set(Array.from({ length: this.real }, (_, i) => pair(this.source[i], this.target[i])));
    // whether another lane leads back beside a one-way lane
    this.beside = Uint8Array.from({ length: this.real }, (_, i) => this.twin[i] < 0 && pairs.has(pair(this.target[i], this.source[i])));
    for (let i = 0; i < count; i++) {
      const from = i < this.real ? header.nodes[this.source[i]].slice(1) : header.places[i - this.real];
      const to = header.nodes[this.target[i]].slice(1);
      [this.x[i], this.y[i]] = from;
      [this.dx[i], this.dy[i]] = [to[0] - from[0], to[1] - from[1]];
      this.heading[i] = Math.atan2(this.dy[i], this.dx[i]);
      if (i < this.real) this.out[this.source[i]].push(i);
    }
  }

  // The edge that stands for a lane: of a two-way one the first of its two.
  lane(edge) {
    return this.twin[edge] >= 0 ? Math.min(edge, this.twin[edge]) : edge;
  }
}

class Tracks {
  constructor(header, columns, edges) {
    this.edges = edges;
    this.count = header.radii.length;
    this.first = starts(columns.leg_count);
    const legs = columns.leg_time.length;
    this.begin = new Float64Array(legs);
    this.end = new Float64Array(legs);
    this.edge = new Int32Array(legs);
    this.origin = new Float64Array(legs);
    this.target = new Float64Array(legs);
    this.read(header.grain, columns);
    this.cursor = this.first.slice(0, this.count);
    this.on = new Int32Array(this.count);
    this.at = new Float64Array(this.count);
    const all = this.count + (columns.picker_edge?.length ?? 0); // pickers after the robots
    this.x = new Float64Array(all);
    this.y = new Float64Array(all);
    this.heading = new Float64Array(this.count);
    this.moves = new Uint8Array(this.count);
  }

  read(grain, columns) {
    const { leg_pause, leg_time, leg_code, leg_other, leg_left, leg_origin } = columns;
    const { out, target, length } = this.edges;
    let other = 0;
    for (let robot = 0; robot < this.count; robot++) {
      let now = 0, edge = 0, position = 0;
      for (let i = this.first[robot]; i < this.first[robot + 1]; i++) {
        const code = leg_code[i];
        if (code === 1) edge = leg_other[other++];
        else if (code > 1) edge = out[target[edge]][code - 2];
        if (i === this.first[robot]) position = leg_origin[robot];
        else if (code > 0) position = 0;
        this.begin[i] = now += leg_pause[i];
        this.end[i] = now += leg_time[i];
        this.edge[i] = edge;
        this.origin[i] = position * grain;
        position = Math.round(length[edge] / grain) - leg_left[i];
        this.target[i] = position * grain;
      }
    }
  }

  // The leg of a robot at a time.
  leg(robot, time) {
    return rowAt(this.begin, this.first, this.cursor, robot, time);
  }

  place(time) {
    const { edges } = this;
    for (let robot = 0; robot < this.count; robot++) {
      const i = this.leg(robot, time);
      const span = this.end[i] - this.begin[i];
      const part = span > 0 ? Math.min(Math.max((time - this.begin[i]) / span, 0), 1) : 1;
      const edge = this.edge[i];
      const at = this.origin[i] + part * (this.target[i] - this.origin[i]);
      const along = edges.length[edge] > 0 ? at / edges.length[edge] : part; // a ride in a lift has no length
      this.on[robot] = edge;
      this.at[robot] = at;
      this.x[robot] = edges.x[edge] + along * edges.dx[edge];
      this.y[robot] = edges.y[edge] + along * edges.dy[edge];
      this.heading[robot] = edges.heading[edge];
      this.moves[robot] = part < 1 && time >= this.begin[i] ? 1 : 0;
    }
  }

  // The points of the way that a robot has come between two times, up to where it is.
  behind(robot, from, time) {
    const { edges } = this, points = [];
    for (let i = this.leg(robot, time); i >= this.first[robot] && this.end[i] > from; i--) {
      const edge = this.edge[i], part = edges.length[edge] > 0 ? this.origin[i] / edges.length[edge] : 0;
      points.push([edges.x[edge] + part * edges.dx[edge], edges.y[edge] + part * edges.dy[edge]]);
    }
    return [[this.x[robot], this.y[robot]], ...points];
  }

  // Where a robot goes from a time on until another: the points of its route, the nodes on it, and how far it is.
  ahead(robot, time, until) {
    const { edges } = this, points = [[this.x[robot], this.y[robot]]], nodes = [];
    let far = 0;
    for (let i = this.leg(robot, time); i < this.first[robot + 1] && this.begin[i] < until; i++) {
      if (this.end[i] <= time) continue;
      const edge = this.edge[i], part = edges.length[edge] > 0 ? this.target[i] / edges.length[edge] : 1;
      const from = this.begin[i] <= time ? this.at[robot] : this.origin[i];
      far += Math.abs(this.target[i] - from);
      points.push([edges.x[edge] + part * edges.dx[edge], edges.y[edge] + part * edges.dy[edge]]);
      if (part > 1 - 1e-9 && edge < edges.real && nodes.at(-1) !== edges.target[edge]) nodes.push(edges.target[edge]);
    }
    return { points, nodes, far };
  }
}
