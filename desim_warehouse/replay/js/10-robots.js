// Robots: a circle with a line for its head and a bar for its battery behind it. What it does can be told without colour:
// empty ones are full circles, carrying ones hold a square, charging ones a bolt, broken ones a cross, idle ones are
// hollow, and those that wait wear a ring.

const SMALL = 2.2; // below this radius on the screen, a square will do
const PLAIN = 4.5; // below this one, no bar and no head

Object.assign(Scene.prototype, {
  each(robots, act) {
    const { tracks, view } = this, s = view.scale;
    for (const robot of robots) {
      const x = tracks.x[robot] * s + view.x, y = tracks.y[robot] * s + view.y, r = this.radius(robot);
      if (x > -3 * r && y > -3 * r && x < view.width + 3 * r && y < view.height + 3 * r) act(robot, x, y, r);
    }
  },

  robots(mood, colours) {
    const { ctx } = this, robots = this.groups[mood];
    const hollow = mood === "idle";
    ctx.fillStyle = hollow ? colours.floor : colours[mood];
    ctx.strokeStyle = hollow ? colours[mood] : colours.outline;
    ctx.beginPath();
    let width = 0;
    this.each(robots, (robot, x, y, r) => {
      if (r < SMALL) return ctx.rect(x - r, y - r, 2 * r, 2 * r);
      const inner = hollow ? r * 0.86 : r;
      ctx.moveTo(x + inner, y);
      ctx.arc(x, y, inner, 0, 7);
      width = hollow ? r * 0.3 : Math.min(r * 0.1, 1.5);
    });
    if (hollow && !width) ctx.fillStyle = colours[mood];
    ctx.fill();
    ctx.lineWidth = width;
    if (width) ctx.stroke();
    this.heads(robots, hollow ? colours[mood] : colours.outline);
    if (mood === "loaded") this.loads(robots, colours);
    if (mood === "charging") this.bolts(robots, colours);
    if (mood === "broken") this.crosses(robots, colours);
  },

  bolts(robots, colours) {
    const { ctx } = this;
    ctx.fillStyle = colours.label;
    this.each(robots, (robot, x, y, r) => r >= PLAIN && bolt(ctx, x, y, r * 0.75));
  },

  crosses(robots, colours) {
    const { ctx } = this;
    this.each(robots, (robot, x, y, r) => r >= SMALL && cross(ctx, x, y, r * 0.55, colours.label));
  },

  heads(robots, colour) {
    const { ctx, tracks } = this;
    ctx.strokeStyle = colour;
    ctx.beginPath();
    this.each(robots, (robot, x, y, r) => {
      if (r < PLAIN) return;
      const cos = Math.cos(tracks.heading[robot]), sin = Math.sin(tracks.heading[robot]);
      ctx.moveTo(x + cos * r * 0.75, y + sin * r * 0.75);
      ctx.lineTo(x + cos * r * 1.45, y + sin * r * 1.45);
      ctx.lineWidth = Math.max(r * 0.18, 1.5);
    });
    ctx.stroke();
  },

  loads(robots, colours) {
    const { ctx } = this;
    ctx.strokeStyle = colours.label;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    this.each(robots, (robot, x, y, r) => {
      if (r >= PLAIN) ctx.rect(x - r * 0.62, y - r * 0.62, r * 1.24, r * 1.24);
    });
    ctx.stroke();
  },

  // Batteries: a grey bar across behind the robot, and on it what is left.
  bars(time, colours) {
    if (this.header.capacity === null) return;
    const { ctx } = this;
    const all = Array.from(this.mood.keys());
    const charge = all.map((robot) => Math.min(Math.max(this.story.charge(robot, time), 0), 1));
    const low = all.filter((robot) => charge[robot] < 0.4), full = all.filter((robot) => charge[robot] >= 0.4);
    for (const [robots, colour, part] of [
      [all, colours.bar, () => 1],
      [low, colours.low, (robot) => charge[robot]],
      [full, colours.full, (robot) => charge[robot]],
    ]) {
      ctx.strokeStyle = colour;
      ctx.beginPath();
      this.each(robots, (robot, x, y, r) => {
        if (r < PLAIN) return;
        const heading = this.tracks.heading[robot], cos = Math.cos(heading) * r, sin = Math.sin(heading) * r;
        const bx = x - cos * 1.35 + sin * 0.9, by = y - sin * 1.35 - cos * 0.9, long = 1.8 * part(robot);
        ctx.moveTo(bx, by);
        ctx.lineTo(bx - sin * long, by + cos * long);
        ctx.lineWidth = Math.max(r * 0.32, 2);
      });
      ctx.stroke();
    }
  },

  numbers(colours) {
    const { ctx } = this;
    ctx.textAlign = "center";
    ctx.textBaseline = "middle";
    for (const [mood, robots] of Object.entries(this.groups)) {
      if (mood === "charging" || mood === "broken") continue; // they show a bolt or a cross
      ctx.fillStyle = mood === "idle" ? colours.ink : colours.label;
      this.each(robots, (robot, x, y, r) => {
        if (r < 6.5) return;
        const text = String(robot);
        const share = (text.length > 2 ? 0.72 : 0.95) * (mood === "loaded" ? 0.85 : 1);
        ctx.font = `600 ${r * share}px system-ui, sans-serif`;
        ctx.fillText(text, x, y + r * 0.05);
      });
    }
  },

  // Rings round robots that wait, and a line to the one they wait for.
  waits(colours) {
    const { ctx, tracks, view, story } = this, s = view.scale;
    this.discs(colours.wait, (r) => Math.max(r * 1.5, r + 1));
    this.discs(colours.floor, (r) => (r < PLAIN ? 0 : r * 1.2)); // a gap: robots may be as dark as their rings
    ctx.strokeStyle = colours.wait;
    ctx.setLineDash([5, 4]);
    ctx.lineWidth = 2;
    ctx.beginPath();
    this.each(this.waiting, (robot, x, y, r) => {
      const other = story.waitOther[this.wait[robot]];
      if (other < 0 || r < PLAIN) return;
      ctx.moveTo(x, y);
      ctx.lineTo(tracks.x[other] * s + view.x, tracks.y[other] * s + view.y);
    });
    ctx.stroke();
    ctx.setLineDash([]);
  },

  // Robots drawn larger than they are hide each other's rings when they queue: of those that wait the middle shows it.
  dots(colours) {
    const enlarged = (r, robot) => r >= 1.3 * this.header.radii[robot] * this.view.scale;
    this.discs(colours.label, (r, robot) => (enlarged(r, robot) ? r * 0.62 : 0));
    this.discs(colours.wait, (r, robot) => (enlarged(r, robot) ? r * 0.44 : 0));
  },

  // Discs about the robots that wait, each of a radius that follows from its own.
  discs(colour, reachOf) {
    const { ctx } = this;
    ctx.fillStyle = colour;
    ctx.beginPath();
    this.each(this.waiting, (robot, x, y, r) => {
      const reach = reachOf(r, robot);
      ctx.moveTo(x + reach, y);
      ctx.arc(x, y, reach, 0, 7);
    });
    ctx.fill();
  },

  // The robot whose panel is open.
  mark(colours) {
    if (this.chosen < 0) return;
    const { ctx } = this;
    ctx.strokeStyle = colours.ink;
    ctx.lineWidth = 2;
    ctx.beginPath();
    this.each([this.chosen], (robot, _x, _y, r) => {
      const [x, y] = this.standing(robot);
      const reach = Math.max(r * 1.9, r + 6);
      for (let quarter = 0; quarter < 4; quarter++) {
        const from = (quarter * Math.PI) / 2 + 0.35;
        ctx.moveTo(x + Math.cos(from) * reach, y + Math.sin(from) * reach);
        ctx.arc(x, y, reach, from, from + Math.PI / 2 - 0.7);
      }
    });
    ctx.stroke();
  },
});

function cross(ctx, x, y, r, colour) {
  ctx.strokeStyle = colour;
  ctx.lineWidth = Math.max(r * 0.4, 1);
  ctx.beginPath();
  for (const side of [1, -1]) {
    ctx.moveTo(x - r, y - side * r);
    ctx.lineTo(x + r, y + side * r);
  }
  ctx.stroke();
}
