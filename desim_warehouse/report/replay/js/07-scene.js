// What changes: goods, heat, robots, deliveries; drawn over the floor for every frame.

class Scene {
  constructor(parts, canvas) {
    Object.assign(this, parts); // header, edges, tracks, story, heat, floor, view, colours
    this.canvas = canvas;
    this.ctx = canvas.getContext("2d", { alpha: false });
    this.showHeat = false;
    this.chosen = -1;
    this.stale = true;
    this.groups = { empty: [], loaded: [], idle: [] };
    this.mood = new Uint8Array(this.tracks.count);
    this.wait = new Int32Array(this.tracks.count).fill(-1);
  }

  resize() {
    const box = this.canvas.getBoundingClientRect();
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    this.canvas.width = Math.max(Math.round(box.width * this.ratio), 1);
    this.canvas.height = Math.max(Math.round(box.height * this.ratio), 1);
    this.view.resize(box.width, box.height);
    this.stale = true;
  }

  draw(time) {
    const { ctx, view } = this, colours = this.colours.now;
    this.tracks.place(time);
    if (this.chosen >= 0 && this.following) {
      view.centre(this.tracks.x[this.chosen], this.tracks.y[this.chosen]);
      this.stale = true;
    }
    if (this.stale) this.floor.draw(view, colours, this.ratio);
    this.stale = false;
    ctx.setTransform(1, 0, 0, 1, 0, 0);
    ctx.drawImage(this.floor.sheet, 0, 0);
    ctx.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.goods(time, colours);
    this.floor.lines(ctx, view, colours.soft, this.directions(), true);
    if (this.showHeat) this.heatMap(time, colours);
    this.deliveries(time, colours);
    this.sort(time);
    this.rotations(time, colours);
    this.waits(colours);
    for (const mood of ["idle", "empty", "loaded"]) this.robots(mood, colours);
    this.bars(time, colours);
    this.numbers(colours);
    this.mark(colours);
  }

  // The two-way lanes in use, each in its present direction: that of the robots on it.
  directions() {
    const { tracks, edges } = this;
    return [...new Set(tracks.on)].filter((edge) => edges.twin[edge] >= 0);
  }

  // Goods that are there: released and not yet loaded.
  goods(time, colours) {
    const { released, loaded, good } = this.story;
    this.ctx.fillStyle = colours.good;
    this.floor.squares(this.ctx, this.view, good.length, (i) =>
      released[i] <= time && time < loaded[i] ? good[i] : -1);
  }

  heatMap(time, colours) {
    const { ctx, view, edges } = this, sums = this.heat.upTo(time), s = view.scale;
    const most = this.heat.most, shades = colours.heat.length;
    ctx.lineCap = "round";
    ctx.lineWidth = Math.max(this.floor.radius * s * 1.1, 1.6);
    for (let shade = 0; shade < shades; shade++) {
      ctx.strokeStyle = colours.heat[shade];
      ctx.beginPath();
      for (let i = 0; i < edges.real; i++) {
        if (sums[i] <= 0 || Math.min(Math.floor((sums[i] / most) * shades), shades - 1) !== shade) continue;
        ctx.moveTo((edges.x[i] + edges.dx[i] * 0.08) * s + view.x, (edges.y[i] + edges.dy[i] * 0.08) * s + view.y);
        ctx.lineTo((edges.x[i] + edges.dx[i] * 0.92) * s + view.x, (edges.y[i] + edges.dy[i] * 0.92) * s + view.y);
      }
      ctx.stroke();
    }
    ctx.lineCap = "butt";
  }

  // Delivered goods counted below their node.
  deliveries(time, colours) {
    const { ctx, view } = this, counts = this.story.deliveredAt(time);
    const s = view.scale, size = Math.min(Math.max(this.floor.radius * s * 1.1, 7), 20);
    if (this.floor.radius * s < 1.5) return;
    ctx.font = `600 ${size}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    ctx.textBaseline = "middle";
    for (const [node, count] of counts) {
      const [wx, wy] = this.floor.counter(node);
      const x = wx * s + view.x - size, y = wy * s + view.y;
      ctx.fillStyle = colours.good;
      ctx.fillRect(x, y - size * 0.45, size * 0.9, size * 0.9);
      ctx.fillStyle = colours.ink;
      ctx.fillText(String(count), x + size * 1.2, y + size * 0.05);
    }
  }

  // Who is in which mood, and who waits.
  sort(time) {
    const { tracks, story } = this;
    for (const mood in this.groups) this.groups[mood].length = 0;
    for (let robot = 0; robot < tracks.count; robot++) {
      const row = story.row(robot, time), state = story.state[row];
      this.mood[robot] = state;
      this.wait[robot] = story.waiting(robot, time);
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
}
