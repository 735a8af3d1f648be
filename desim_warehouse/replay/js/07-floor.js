// The floor as it is: where shelves, bays and stations stand, how far it extends, and whether it is a grid of cells.

class Floor {
  constructor(header, columns, edges) {
    this.header = header;
    this.edges = edges;
    this.radius = header.radii.reduce((a, b) => Math.max(a, b), 0);
    this.span = Array.from({ length: edges.real }, (_, i) => Math.hypot(edges.dx[i], edges.dy[i]));
    this.cell = header.cell; // the side of its cells, if it is a grid of them; else 0
    this.storageX = totals(columns.storage_x).map((value) => value * header.grain);
    this.storageY = totals(columns.storage_y).map((value) => value * header.grain);
    this.storageEdge = totals(columns.storage_edge);
    this.size = header.goods_size || this.cell * 0.82 || this.radius * 1.3;
    if (!header.goods_size && !this.cell) this.besideEdges();
    this.shelves = new Set(this.cell ? Array.from(this.storageEdge).filter((edge) => edge < 0).map((edge) => -1 - edge) : []);
    this.floor = this.extent();
    this.zones = this.boxes();
    this.room = this.zones.flatMap(({ places, room }) => places.map(() => room)); // radius that fits, by slot
    this.bounds = this.everything();
    this.longestName = Math.min(header.nodes.reduce((most, [name]) => Math.max(most, name.length), 1), 14);
    this.sheet = document.createElement("canvas");
  }

  // The length that separates lanes: a quarter of all edges are shorter.
  get pitch() {
    return (this.quarter ??= this.span.slice().sort((a, b) => a - b)[Math.floor(this.span.length / 4)] ?? Infinity);
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
    const margin = this.cell / 2 || this.header.aisle / 2 || this.radius * 2.5;
    for (const [, x, y] of this.header.nodes) grow(x, y, margin);
    for (let i = 0; i < this.storageX.length; i++) grow(this.storageX[i], this.storageY[i], this.size / 2);
    return box;
  }

  // Bays and stations: a box round their places.
  boxes() {
    const chargers = new Map(), servers = new Map();
    this.header.resources.forEach(([kind, , node, number], i) => {
      (kind === "station" ? servers : chargers).set(node, [number, i]);
    });
    let next = 0;
    return this.header.zones.map(([kind, name, node, count, room]) => {
      const places = this.header.places.slice(next, (next += count));
      const xs = places.map((p) => p[0]), ys = places.map((p) => p[1]), r = room * (this.cell ? 1 : 1.25);
      const [number, resource] = (kind === "station" ? servers : chargers).get(node) ?? [0, -1];
      return { kind, name, node, places, room, number, resource, left: Math.min(...xs) - r, right: Math.max(...xs) + r,
        top: Math.min(...ys) - r, bottom: Math.max(...ys) + r };
    });
  }

  // Nodes where goods are unloaded beside no station, as far as there are few.
  get outlets() {
    if (this.outside) return this.outside;
    const stations = new Set(this.zones.filter((zone) => zone.kind === "station").map((zone) => zone.node));
    const others = this.header.unload_at.filter((node) => !stations.has(node));
    return (this.outside = others.length <= 12 ? others : []);
  }

  // Where something is written about a zone: on the side away from its node if that is above (-1), else below (1).
  beside(zone) {
    const [, x, y] = this.header.nodes[zone.node], cx = (zone.left + zone.right) / 2, cy = (zone.top + zone.bottom) / 2;
    const above = y - cy > Math.abs(x - cx);
    return [cx, above ? zone.top : zone.bottom, above ? -1 : 1];
  }

  // Where the goods delivered at a node are counted.
  below(node) {
    const [, x, y] = this.header.nodes[node];
    return [x, y + Math.max(this.header.aisle / 2, this.cell / 2, this.radius * 2)];
  }

  // The distance from a zone to the nearest of its kind of which there is something to write.
  apart(zone) {
    return (zone.apart ??= this.zones.reduce((least, other) => {
      if (other === zone || other.resource < 0 || other.kind !== zone.kind) return least;
      const [x, y] = this.beside(zone), [ox, oy] = this.beside(other);
      return Math.min(least, Math.max(Math.abs(x - ox), 4 * Math.abs(y - oy)));
    }, Infinity));
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
    const air = this.radius, words = Math.max(1.5 * air, (all.bottom - all.top) * 0.04);
    const above = this.zones.some((zone) => zone.resource >= 0 && this.beside(zone)[2] < 0);
    return { left: all.left - air, top: all.top - air - (above ? words : 0), right: all.right + air, bottom: all.bottom + air + words };
  }
}
