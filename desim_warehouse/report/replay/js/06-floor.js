// What stands still: floor, zones, aisles with arrows, letters and storage places; drawn once for each view.

class Floor {
  constructor(header, columns, edges) {
    this.header = header;
    this.edges = edges;
    this.radius = header.radii.reduce((a, b) => Math.max(a, b), 0);
    this.storageX = totals(columns.storage_x).map((value) => value * header.grain);
    this.storageY = totals(columns.storage_y).map((value) => value * header.grain);
    this.storageEdge = totals(columns.storage_edge);
    this.size = header.goods_size || this.radius * 1.3;
    if (!header.goods_size) this.besideEdges();
    this.floor = this.extent();
    this.zones = this.boxes();
    this.bounds = this.everything();
    this.sheet = document.createElement("canvas");
  }

  // Where goods have no size of their own they lie on their edge: shown to the right of it; or below their node.
  besideEdges() {
    const { edges } = this;
    for (let i = 0; i < this.storageX.length; i++) {
      const edge = this.storageEdge[i];
      const heading = (edge < 0 ? 0 : edges.heading[edge]) + Math.PI / 2;
      this.storageX[i] += Math.cos(heading) * this.radius * 2.2;
      this.storageY[i] += Math.sin(heading) * this.radius * 2.2;
    }
  }

  extent() {
    const box = { left: Infinity, top: Infinity, right: -Infinity, bottom: -Infinity };
    const grow = (x, y, by) => {
      box.left = Math.min(box.left, x - by);
      box.top = Math.min(box.top, y - by);
      box.right = Math.max(box.right, x + by);
      box.bottom = Math.max(box.bottom, y + by);
    };
    const margin = this.header.aisle / 2 || this.radius * 2.5;
    for (const [, x, y] of this.header.nodes) grow(x, y, margin);
    for (let i = 0; i < this.storageX.length; i++) grow(this.storageX[i], this.storageY[i], this.size / 2);
    return box;
  }

  // Bays and stations: a box round their places.
  boxes() {
    let next = 0;
    return this.header.zones.map(([kind, name, node, count]) => {
      const places = this.header.places.slice(next, (next += count));
      const xs = places.map((p) => p[0]), ys = places.map((p) => p[1]), r = this.radius * 1.25;
      return { kind, name, node, places, left: Math.min(...xs) - r, right: Math.max(...xs) + r,
        top: Math.min(...ys) - r, bottom: Math.max(...ys) + r };
    });
  }

  // Where the goods delivered at a node are counted: below its station, or below the node.
  counter(node) {
    const station = this.zones.find((zone) => zone.node === node && zone.kind === "station");
    if (station) return [(station.left + station.right) / 2, station.bottom + this.radius * 1.3];
    const [, x, y] = this.header.nodes[node];
    return [x, y + Math.max(this.header.aisle / 2, this.radius * 2) + this.radius * 1.3];
  }

  everything() {
    const { left, top, right, bottom } = this.floor;
    const all = { left, top, right, bottom };
    for (const zone of this.zones) {
      all.left = Math.min(all.left, zone.left);
      all.right = Math.max(all.right, zone.right);
      all.top = Math.min(all.top, zone.top);
      all.bottom = Math.max(all.bottom, zone.bottom);
    }
    const air = this.radius;
    // Room below for the count of delivered goods.
    return { left: all.left - air, top: all.top - air, right: all.right + air, bottom: all.bottom + 3.2 * this.radius };
  }

  draw(view, colours, ratio) {
    const sheet = this.sheet;
    sheet.width = Math.round(view.width * ratio);
    sheet.height = Math.round(view.height * ratio);
    const ctx = sheet.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.fillStyle = colours.back;
    ctx.fillRect(0, 0, view.width, view.height);
    this.ground(ctx, view, colours);
    this.drawZones(ctx, view, colours);
    this.storage(ctx, view, colours);
    this.aisles(ctx, view, colours);
    this.letters(ctx, view, colours);
  }

  ground(ctx, view, colours) {
    const { left, top, right, bottom } = this.floor, s = view.scale;
    ctx.fillStyle = colours.floor;
    ctx.strokeStyle = colours.border;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.rect(left * s + view.x, top * s + view.y, (right - left) * s, (bottom - top) * s);
    ctx.fill();
    ctx.stroke();
  }

  drawZones(ctx, view, colours) {
    const s = view.scale, half = Math.max(this.header.aisle / 2, this.radius * 1.6) * 0.92 * s;
    for (const node of this.header.unload_at) {
      const [, x, y] = this.header.nodes[node];
      this.box(ctx, x * s + view.x - half, y * s + view.y - half, 2 * half, 2 * half, colours.out, colours.outLine);
    }
    for (const zone of this.zones) {
      const [fill, line] = zone.kind === "bay" ? [colours.bay, colours.bayLine] : [colours.out, colours.outLine];
      if (zone.kind === "bay") {
        const [, x, y] = this.header.nodes[zone.node];
        this.box(ctx, x * s + view.x - half, y * s + view.y - half, 2 * half, 2 * half, fill, null);
      }
      this.box(ctx, zone.left * s + view.x, zone.top * s + view.y, (zone.right - zone.left) * s,
        (zone.bottom - zone.top) * s, fill, line);
    }
  }

  box(ctx, x, y, width, height, fill, line) {
    ctx.fillStyle = fill;
    ctx.beginPath();
    if (ctx.roundRect) ctx.roundRect(x, y, width, height, Math.min(width, height) * 0.15);
    else ctx.rect(x, y, width, height);
    ctx.fill();
    if (line === null || width < 6) return;
    ctx.strokeStyle = line;
    ctx.lineWidth = 1;
    ctx.setLineDash([4, 3]);
    ctx.stroke();
    ctx.setLineDash([]);
  }

  storage(ctx, view, colours) {
    ctx.fillStyle = this.size * view.scale < 4 ? colours.noneFar : colours.none;
    this.squares(ctx, view, this.storageX.length, (i) => i);
  }

  // Squares of storage places `which(0..count-1)`; -1 is none.
  squares(ctx, view, count, which) {
    const s = view.scale, size = Math.max(this.size * s * 0.94, 1), half = size / 2;
    for (let n = 0; n < count; n++) {
      const i = which(n);
      if (i < 0) continue;
      const x = this.storageX[i] * s + view.x - half, y = this.storageY[i] * s + view.y - half;
      if (x > -size && y > -size && x < view.width && y < view.height) ctx.fillRect(x, y, size, size);
    }
  }

  // One-way lanes have arrows; two-way ones are dashed, as their direction changes.
  aisles(ctx, view, colours) {
    const every = [...this.edges.twin.slice(0, this.edges.real).keys()];
    this.lines(ctx, view, colours.aisle, every.filter((i) => this.edges.twin[i] < 0), true);
    ctx.setLineDash([7, 5]);
    this.lines(ctx, view, colours.aisle, every.filter((i) => this.edges.twin[i] > i), false);
    ctx.setLineDash([]);
  }

  lines(ctx, view, colour, some, arrows) {
    const { edges } = this, s = view.scale;
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.lineWidth = Math.min(Math.max(this.radius * s * 0.12, 0.6), 2.5);
    ctx.beginPath();
    for (const i of some) {
      ctx.moveTo(edges.x[i] * s + view.x, edges.y[i] * s + view.y);
      ctx.lineTo((edges.x[i] + edges.dx[i]) * s + view.x, (edges.y[i] + edges.dy[i]) * s + view.y);
    }
    ctx.stroke();
    if (!arrows) return;
    const size = Math.min(Math.max(this.radius * s * 0.55, 3), 9);
    ctx.beginPath();
    for (const i of some) {
      const long = Math.hypot(edges.dx[i], edges.dy[i]) * s;
      if (long < 4 * size) continue;
      const count = Math.min(Math.max(Math.round(long / 150), 1), 4);
      for (let n = 1; n <= count; n++) this.arrow(ctx, view, i, n / (count + 1), size);
    }
    ctx.fill();
  }

  arrow(ctx, view, edge, part, size) {
    const { edges } = this, s = view.scale;
    const x = (edges.x[edge] + part * edges.dx[edge]) * s + view.x;
    const y = (edges.y[edge] + part * edges.dy[edge]) * s + view.y;
    if (x < -size || y < -size || x > view.width + size || y > view.height + size) return;
    const cos = Math.cos(edges.heading[edge]) * size, sin = Math.sin(edges.heading[edge]) * size;
    ctx.moveTo(x + cos, y + sin);
    ctx.lineTo(x - cos - 0.75 * sin, y - sin + 0.75 * cos);
    ctx.lineTo(x - cos + 0.75 * sin, y - sin - 0.75 * cos);
    ctx.closePath();
  }

  shortest() {
    const { edges } = this;
    return (this.least ??= edges.dx.slice(0, edges.real).reduce((least, dx, i) => Math.min(least, Math.hypot(dx, edges.dy[i])), Infinity));
  }

  longestName() {
    return (this.longest ??= Math.min(this.header.nodes.reduce((most, [name]) => Math.max(most, name.length), 1), 14));
  }

  letters(ctx, view, colours) {
    const s = view.scale, room = (this.header.aisle || this.radius * 4) * s;
    if (room < 11 || this.shortest() * s < this.longestName() * 6 + 8) return;
    const size = Math.min(Math.max(room * 0.26, 8), 22), away = Math.min(room * 0.3, 26);
    ctx.font = `600 ${size}px system-ui, sans-serif`;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 3;
    ctx.lineJoin = "round";
    ctx.strokeStyle = colours.floor;
    ctx.fillStyle = colours.ink;
    for (const [name, wx, wy] of this.header.nodes) {
      const x = wx * s + view.x + away, y = wy * s + view.y - away;
      if (!view.shows(wx, wy, this.radius * 4)) continue;
      const short = name.length > 14 ? `${name.slice(0, 13)}…` : name;
      ctx.strokeText(short, x, y);
      ctx.fillText(short, x, y);
    }
  }
}
