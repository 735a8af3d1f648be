// Lifts between floors: each floor with its name, the way of each cabin, a cabin on every floor, and who queues for it.

Object.assign(Floor.prototype, {
  // Whether an edge is a ride in a lift: it has no length of its own.
  isRide(edge) {
    return edge >= 0 && edge < this.edges.real && this.edges.length[edge] === 0;
  },

  // The floors, from the lowest: its name, and a box round its nodes and what is beside them.
  levels() {
    if (this.storeys) return this.storeys;
    const { floors, nodes, floor_titles: titles } = this.header, boxes = new Map(), by = this.header.aisle / 2 || this.radius * 2.5;
    const grow = (floor, left, top, right, bottom) => {
      const box = boxes.get(floor) ?? { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
      boxes.set(floor, { left: Math.min(box.left, left), top: Math.min(box.top, top), right: Math.max(box.right, right),
        bottom: Math.max(box.bottom, bottom) });
    };
    nodes.forEach(([, x, y], node) => grow(floors[node], x - by, y - by, x + by, y + by));
    for (const { node, left, top, right, bottom } of this.zones) grow(floors[node], left, top, right, bottom);
    const order = [...boxes.keys()].sort((a, b) => a - b);
    return (this.storeys = order.map((floor) => ({ name: titles[floor], ...boxes.get(floor) })));
  },

  grounds(ctx, view, colours) {
    const s = view.scale;
    ctx.font = "600 12px system-ui, sans-serif";
    ctx.textAlign = "right";
    ctx.textBaseline = "bottom";
    for (const { name, left, top, right, bottom } of this.levels()) {
      const x = left * s + view.x, y = top * s + view.y;
      ctx.fillStyle = colours.floor;
      ctx.strokeStyle = colours.border;
      ctx.lineWidth = 1.5;
      ctx.beginPath();
      ctx.rect(x, y, (right - left) * s, (bottom - top) * s);
      ctx.fill();
      ctx.stroke();
      ctx.fillStyle = colours.ink;
      ctx.fillText(name, right * s + view.x - 6, bottom * s + view.y - 4);
    }
  },

  lifts(ctx, view, colours) {
    const s = view.scale, half = this.cabin() * s, place = (node) => this.header.nodes[node].slice(1);
    for (const [name, stops] of this.header.lifts) {
      const points = stops.map(place).map(([x, y]) => [x * s + view.x, y * s + view.y]);
      ctx.strokeStyle = ctx.fillStyle = colours.ink;
      ctx.lineWidth = 1;
      ctx.setLineDash([2, 5]);
      ctx.beginPath();
      for (const [x, y] of points) ctx.lineTo(x, y);
      ctx.stroke();
      ctx.setLineDash([]);
      for (const [x, y] of points) this.box(ctx, x - half, y - half, 2 * half, 2 * half, colours.floor, colours.ink);
      ctx.font = "11px system-ui, sans-serif";
      ctx.textAlign = "left";
      ctx.textBaseline = "middle";
      ctx.fillStyle = colours.ink;
      ctx.fillText(`lift ${name}`, points[0][0] + half + 4, points[0][1]);
    }
  },

  // Half the side of a cabin: a robot fits in.
  cabin() {
    return this.radius * 1.8;
  },

  // How many robots wait before each node of a lift, for their turn or for the cabin: of the waits that are under way.
  queuing(story, waits) {
    const cabins = new Set(this.header.lifts.flatMap(([, stops]) => stops)), counts = new Map();
    for (const wait of waits) {
      const node = story.waitNode[wait];
      if (cabins.has(node) && !this.isRide(story.waitEdge[wait])) counts.set(node, (counts.get(node) ?? 0) + 1);
    }
    return counts;
  },

  queues(ctx, view, colours, counts) {
    const s = view.scale;
    ctx.font = "600 11px system-ui, sans-serif";
    ctx.textAlign = "center";
    ctx.textBaseline = "bottom";
    ctx.fillStyle = colours.ink;
    for (const [node, count] of counts) {
      const [, x, y] = this.header.nodes[node];
      ctx.fillText(`queue ${count}`, x * s + view.x, (y - this.cabin()) * s + view.y - 3);
    }
  },
});
