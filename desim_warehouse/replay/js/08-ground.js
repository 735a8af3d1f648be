// What stands still, drawn once for each view: floor, bays with their chargers, stations, shelves, lanes and letters.

Object.assign(Floor.prototype, {
  draw(view, colours, ratio) {
    const sheet = this.sheet;
    sheet.width = Math.max(Math.round(view.width * ratio), 1); // a page that is not shown has no size yet
    sheet.height = Math.max(Math.round(view.height * ratio), 1);
    const ctx = sheet.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.fillStyle = colours.back;
    ctx.fillRect(0, 0, view.width, view.height);
    if (this.header.lifts) this.grounds(ctx, view, colours);
    else this.ground(ctx, view, colours);
    if (this.cell) this.cells(ctx, view, colours);
    this.drawZones(ctx, view, colours);
    if (!this.cell) this.storage(ctx, view, colours);
    this.lanes(ctx, view, colours);
    if (this.header.lifts) this.lifts(ctx, view, colours);
    this.letters(ctx, view, colours);
  },

  ground(ctx, view, colours) {
    const { left, top, right, bottom } = this.floor, s = view.scale;
    ctx.fillStyle = this.cell ? colours.wall : colours.floor;
    ctx.strokeStyle = colours.border;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.rect(left * s + view.x, top * s + view.y, (right - left) * s, (bottom - top) * s);
    ctx.fill();
    ctx.stroke();
  },

  // A grid: cells that robots drive on, and among them those with goods; what is no cell is a wall or a shelf.
  cells(ctx, view, colours) {
    const s = view.scale, size = this.cell * s;
    const fill = (wanted, colour) => {
      ctx.fillStyle = colour;
      this.header.nodes.forEach(([, wx, wy], node) => {
        if (this.shelves.has(node) !== wanted) return;
        const x = Math.round(wx * s + view.x - size / 2), y = Math.round(wy * s + view.y - size / 2);
        const right = Math.round(wx * s + view.x + size / 2), bottom = Math.round(wy * s + view.y + size / 2);
        if (right > 0 && bottom > 0 && x < view.width && y < view.height)
          ctx.fillRect(x, y, Math.max(right - x, 1), Math.max(bottom - y, 1));
      });
    };
    fill(false, colours.cell);
    fill(true, colours.none);
  },

  drawZones(ctx, view, colours) {
    const s = view.scale, half = (this.cell / 2 || Math.max(this.header.aisle / 2, this.radius * 1.6) * 0.92) * s;
    const square = (node, fill, line) => {
      const [, x, y] = this.header.nodes[node];
      this.box(ctx, x * s + view.x - half, y * s + view.y - half, 2 * half, 2 * half, fill, line);
    };
    for (const node of this.outlets) square(node, colours.out, colours.outLine);
    for (const zone of this.zones) {
      const bay = zone.kind === "bay";
      if (!this.cell) this.link(ctx, view, colours, zone);
      this.box(ctx, zone.left * s + view.x, zone.top * s + view.y, (zone.right - zone.left) * s,
        (zone.bottom - zone.top) * s, bay ? colours.bay : colours.out, bay ? colours.bayLine : colours.outLine);
      this.slots(ctx, view, colours, zone);
    }
  },

  // From a node to the nearest slot beside it.
  link(ctx, view, colours, zone) {
    const s = view.scale, [, nx, ny] = this.header.nodes[zone.node], [px, py] = zone.places[0];
    ctx.strokeStyle = zone.kind === "bay" ? colours.bayLine : colours.outLine;
    ctx.lineWidth = Math.min(Math.max(this.radius * s * 0.12, 0.6), 2.5);
    ctx.beginPath();
    ctx.moveTo(nx * s + view.x, ny * s + view.y);
    ctx.lineTo(px * s + view.x, py * s + view.y);
    ctx.stroke();
  },

  // The slots of a bay or station; those with a charger show a bolt.
  slots(ctx, view, colours, zone) {
    const s = view.scale, r = zone.room * s, bay = zone.kind === "bay";
    if (r < 2) return;
    ctx.fillStyle = ctx.strokeStyle = bay ? colours.bayLine : colours.outLine;
    ctx.lineWidth = 1;
    zone.places.forEach(([wx, wy], i) => {
      const x = wx * s + view.x, y = wy * s + view.y;
      if (bay && i < zone.number) return bolt(ctx, x, y, Math.max(r * 0.8, 3.5));
      ctx.globalAlpha = 0.45;
      ctx.beginPath();
      ctx.arc(x, y, r * 0.9, 0, 7);
      ctx.stroke();
      ctx.globalAlpha = 1;
    });
  },

  box(ctx, x, y, width, height, fill, line) {
    ctx.fillStyle = fill;
    ctx.beginPath();
    ctx.roundRect(x, y, width, height, Math.min(width, height) * 0.15);
    ctx.fill();
    if (line === null) return;
    ctx.strokeStyle = line;
    ctx.lineWidth = 1;
    ctx.setLineDash(width < 6 ? [] : [4, 3]);
    ctx.stroke();
    ctx.setLineDash([]);
  },

  storage(ctx, view, colours) {
    ctx.fillStyle = colours.none;
    this.squares(ctx, view, this.storageX.length, (i) => i);
  },

  // Squares on storage places `which(0..count-1)`, -1 is none, that fill a part of each.
  squares(ctx, view, count, which, part = 1) {
    const s = view.scale, whole = this.size * s;
    const size = part < 1 ? Math.max(whole * part, 3) : Math.max(whole > 8 ? whole - 1 : whole, 1), half = size / 2;
    for (let n = 0; n < count; n++) {
      const i = which(n);
      if (i < 0) continue;
      const x = this.storageX[i] * s + view.x - half, y = this.storageY[i] * s + view.y - half;
      if (x > -size && y > -size && x < view.width && y < view.height) ctx.fillRect(x, y, size, size);
    }
  },

  // One-way lanes have arrows; a two-way one is one dashed line, as its direction changes.
  lanes(ctx, view, colours) {
    if (this.cell && this.cell * view.scale < 16) return; // the cells say as much
    const every = [...this.edges.twin.slice(0, this.edges.real).keys()].filter((i) => !this.isRide(i));
    this.lines(ctx, view, colours.aisle, every.filter((i) => this.edges.twin[i] < 0), true);
    ctx.setLineDash([7, 5]);
    this.lines(ctx, view, colours.aisle, every.filter((i) => this.edges.twin[i] > i), false);
    ctx.setLineDash([]);
  },

  lines(ctx, view, colour, some, arrows) {
    const { edges } = this, s = view.scale;
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.lineWidth = Math.min(Math.max(this.radius * s * 0.12, 0.6), 2.5);
    ctx.beginPath();
    const size = Math.min(Math.max(this.radius * s * 0.55, 3), 9);
    some = some.filter((i) => view.shows(edges.x[i] + edges.dx[i] / 2, edges.y[i] + edges.dy[i] / 2, this.span[i] / 2 + this.radius));
    for (const i of some) {
      const [x, y] = this.shift(i, size, view);
      ctx.moveTo(edges.x[i] * s + x, edges.y[i] * s + y);
      ctx.lineTo((edges.x[i] + edges.dx[i]) * s + x, (edges.y[i] + edges.dy[i]) * s + y);
    }
    ctx.stroke();
    if (!arrows) return;
    ctx.beginPath();
    for (const i of some) {
      const long = this.span[i] * s;
      if (long < 4 * size) continue;
      const count = Math.min(Math.max(Math.round(long / 150), 1), 4);
      for (let n = 1; n <= count; n++) this.arrow(ctx, view, i, n / (count + 1), size);
    }
    ctx.fill();
  },

  // Where an edge's lane begins to be drawn on the screen: lanes side by side keep to the right of the line between them.
  shift(edge, size, view) {
    if (!this.edges.beside[edge]) return [view.x, view.y];
    const heading = this.edges.heading[edge] + Math.PI / 2;
    return [view.x + Math.cos(heading) * size, view.y + Math.sin(heading) * size];
  },

  arrow(ctx, view, edge, part, size) {
    const { edges } = this, s = view.scale, [left, top] = this.shift(edge, size, view);
    const x = (edges.x[edge] + part * edges.dx[edge]) * s + left;
    const y = (edges.y[edge] + part * edges.dy[edge]) * s + top;
    if (x < -size || y < -size || x > view.width + size || y > view.height + size) return;
    const cos = Math.cos(edges.heading[edge]) * size, sin = Math.sin(edges.heading[edge]) * size;
    ctx.moveTo(x + cos, y + sin);
    ctx.lineTo(x - cos - 0.75 * sin, y - sin + 0.75 * cos);
    ctx.lineTo(x - cos + 0.75 * sin, y - sin - 0.75 * cos);
    ctx.closePath();
  },

  // Names of nodes, where there is room and they are not too many to be read.
  letters(ctx, view, colours) {
    const s = view.scale, room = (this.cell || this.header.aisle || this.radius * 4) * s;
    if (room < 11 || this.pitch * s < this.longestName * 8 + 24) return;
    const shown = this.header.nodes.filter(([, x, y]) => view.shows(x, y, this.radius * 4));
    if (shown.length > 60) return;
    const size = Math.min(Math.max(room * 0.26, 9), 13), away = Math.min(room * 0.3, 22);
    ctx.font = `600 ${size}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    ctx.lineWidth = 3;
    ctx.lineJoin = "round";
    ctx.strokeStyle = colours.floor;
    ctx.fillStyle = colours.soft;
    const taken = new Set(this.zones.filter((zone) => this.beside(zone)[2] < 0).map((zone) => this.header.nodes[zone.node]));
    for (const node of shown) {
      const [name, wx, wy] = node;
      const x = wx * s + view.x + away * 0.6, y = wy * s + view.y + (taken.has(node) ? away : -away); // a bay may be above
      const short = name.length > 14 ? `${name.slice(0, 13)}…` : name;
      ctx.strokeText(short, x, y);
      ctx.fillText(short, x, y);
    }
  },
});

// The sign of a charger, filled, `r` from its middle to its ends.
function bolt(ctx, x, y, r) {
  ctx.beginPath();
  for (const [dx, dy] of [[0.25, -1], [-0.55, 0.15], [-0.05, 0.15], [-0.25, 1], [0.55, -0.2], [0.05, -0.2]])
    ctx.lineTo(x + dx * r, y + dy * r);
  ctx.closePath();
  ctx.fill();
}
