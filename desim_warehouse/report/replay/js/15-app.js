// Puts the parts together and draws when something changed.

class App {
  constructor(header, columns) {
    this.header = header;
    const canvas = byId("floor");
    const edges = new Edges(header);
    this.story = new Story(header, columns);
    this.player = new Player(header, this.story);
    const floor = new Floor(header, columns, edges);
    this.scene = new Scene({
      header, edges, floor, tracks: new Tracks(header, columns, edges), story: this.story,
      heat: new Heat(this.story, edges), view: new View(floor.bounds), colours: new Colours(header.palette, header.colours),
    }, canvas);
    this.strip = new Strip(byId("strip"), header, this.story, this.player.span);
    this.hover = new Hover(this.scene, this.player, byId("tip"));
    this.controls = new Controls(this);
    this.pointer = new Pointer(this, canvas);
    this.frames = 0;
    this.drawing = 0;
    this.last = 0;
    this.asked = false;
    this.player.changed = () => this.wake();
    byId("name").textContent = header.name;
    byId("seed").textContent = `seed ${header.seed}`;
    canvas.setAttribute("aria-label", `Warehouse floor with ${header.radii.length} robots; ? shows the keys`);
    new ResizeObserver(() => this.resize()).observe(byId("stage"));
    this.resize();
    this.controls.recolour();
  }

  resize() {
    this.scene.resize();
    this.redress();
  }

  redress() {
    const colours = this.scene.colours.now;
    drawLegend(byId("legend"), colours, this.header.two_way.length > 0);
    drawRibbon(byId("ribbon"), this, colours);
    this.wake();
  }

  // The time in the model's unit and, where that is another, in hours, minutes and seconds.
  clock() {
    const { tick, start, units } = this.header, time = this.player.time * tick + start;
    const seconds = time * units.seconds + 0.01, two = (n) => String(Math.floor(n)).padStart(2, "0");
    const hours = seconds >= 3600 ? `${Math.floor(seconds / 3600)}:` : "";
    return `${time.toFixed(1)} ${units.time} = ${hours}${two((seconds / 60) % 60)}:${two(seconds % 60)}`;
  }

  wake() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.asked = false;
    const began = performance.now();
    if (this.player.playing) {
      this.player.advance(Math.min(now - (this.last || now), 250));
      this.last = now;
      this.wake();
    } else this.last = 0;
    this.show();
    this.frames++;
    this.drawing += performance.now() - began;
  }

  show() {
    const colours = this.scene.colours.now;
    this.scene.draw(this.player.time);
    this.strip.draw(this.player.time, colours);
    drawScale(byId("scale"), this, colours);
    this.controls.show();
    if (!this.player.playing || this.frames % 6 === 0) this.hover.again();
  }
}

// For tests and other scripts on the page. Times are the model's; `ready` is resolved when the page is ready.
function hook(app) {
  const { header, player, scene } = app, { tracks, view, story } = scene;
  const here = () => player.time * header.tick + header.start;
  const points = () => Array.from(tracks.x, (x, i) => [x, tracks.y[i]]);
  return {
    header, player, time: here,
    seek: (time) => {
      player.seek((time - header.start) / header.tick);
      app.show();
    },
    // Where the robots are at a time (world units), by moving the page there.
    positions: (time) => {
      window.desimReplay.seek(time);
      return points();
    },
    drawn: () => Array.from(tracks.x, (x, i) => [x * view.scale + view.x, tracks.y[i] * view.scale + view.y]),
    scale: () => view.scale,
    screen: (x, y) => [x * view.scale + view.x, y * view.scale + view.y],
    waiting: () => Array.from(scene.wait.keys()).filter((robot) => story.waiting(robot, player.time) >= 0),
    states: () => Array.from(scene.mood, (state) => header.states[state].name),
    chosen: () => scene.chosen,
    frames: () => ({ count: app.frames, drawing: app.drawing }),
    deliveredAt: () => Object.fromEntries(Array.from(story.deliveredAt(player.time), ([node, count]) => [header.nodes[node][0], count])),
    directions: () => scene.directions().map((edge) => [scene.edges.source[edge], scene.edges.target[edge]].map((node) => header.nodes[node][0])),
    heat: () => Array.from(scene.heat.upTo(player.time), (sum) => sum * header.tick),
  };
}

async function begin() {
  const header = JSON.parse(byId("header").textContent);
  const columns = await columnsOf(header.columns, byId("columns").textContent.trim());
  byId("columns").remove();
  const app = new App(header, columns);
  Object.assign(window.desimReplay, hook(app));
  app.show();
  return performance.now();
}

window.desimReplay = {};
window.desimReplay.ready = begin().catch((error) => {
  const problem = byId("problem");
  problem.hidden = false;
  problem.textContent = `This replay cannot be shown: ${error.message}. It needs a browser of 2023 or later.`;
  throw error;
});
