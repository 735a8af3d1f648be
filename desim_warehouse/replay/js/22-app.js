// Puts the parts together and draws when something changed.

const TRAIL = 0.5; // seconds of their way that robots leave behind where they are too fast to be followed

class App {
  constructor(page, all) {
    this.colours = new Colours(page.palette, page.colours);
    const first = byId("side-1"), roots = [first];
    if (page.runs.length > 1) first.after((roots[1] = this.copy(first)));
    this.sides = page.runs.map((header, i) => new Side(header, all[i], this.colours, roots[i], "AB"[i]));
    this.player = new Player(this.sides);
    this.panel = new Panel(byId("robot"), this.player, () => this.controls.pin(this.sides[0], -1));
    this.tiles = new Tiles(byId("tiles"), this.sides, this.player);
    this.picture = new Picture(this);
    this.course = new Course(byId("course"), this.player);
    this.stations = this.sides.map((side, i) => this.dress(side, roots[i]));
    this.controls = new Controls(this);
    new LostTime(byId("lost"), this.sides, this.controls);
    for (const side of this.sides) this.pointer(side);
    this.frames = this.drawing = this.last = 0;
    this.asked = false;
    this.player.changed = () => this.wake();
    document.body.classList.toggle("two", this.sides.length > 1);
    byId("name").textContent = [...new Set(page.runs.map((header) => header.name))].join(" and ");
    const same = page.runs.every(({ work }) => work);
    byId("label").textContent = this.sides.length === 1 ? page.runs[0].label : `${page.better}${same ? "" : " Not the same work: differences may come from that."}`;
    const watch = new ResizeObserver(() => {
      this.resized();
      this.show(); // at once: a canvas of a new size is black
    });
    for (const root of roots) watch.observe(root.querySelector(".stage"));
    this.resized();
    this.controls.recolour();
  }

  // The parts of a second run, like the first's.
  copy(first) {
    const root = first.cloneNode(true);
    for (const item of [root, ...root.querySelectorAll("[id]")]) item.removeAttribute("id");
    return root;
  }

  // Caption, table and labels of a run; returns its table.
  dress(side, root) {
    const { header } = side, many = this.sides.length > 1;
    side.caption = many ? `${side.letter}: ${header.label}` : "";
    const caption = root.querySelector(".caption");
    caption.hidden = !many;
    caption.textContent = side.caption;
    const label = `Warehouse floor ${many ? side.caption : ""} with ${header.radii.length} robots; ? shows the keys`;
    root.querySelector("canvas").setAttribute("aria-label", label);
    const place = byId("stations").appendChild(element("section"));
    return new Stations(place, side, `Stations and chargers${many ? `, ${side.letter}` : ""}`, (...which) => this.controls.place(...which));
  }

  // What the figures beside the floor count.
  counted() {
    const { player, sides } = this, { header } = sides[0], after = header.begin > header.start ? " after the warm-up" : "";
    if (player.whole) return `Totals for the whole run${after ? ", warm-up excluded" : ""}. Press Play to watch it unfold.`;
    return player.in(sides[0]) < sides[0].story.from ? "Warm-up: nothing is counted yet." : `Counted so far${after}.`;
  }

  pointer(side) {
    side.hover = new Hover(side, this.player, side.root.querySelector(".tip"));
    new Pointer(this, side, side.root.querySelector("canvas"));
  }

  // Two floors stand beside or above one another, with figures beside or below them: whatever makes them largest.
  arrange() {
    if (this.sides.length < 2) return;
    const box = byId("sides"), { left, top, right, bottom } = this.sides[0].view.bounds;
    const scale = (wide, high) => Math.min(wide / (right - left), high / (bottom - top));
    const found = [false, true].flatMap((wide) => {
      document.body.classList.toggle("wide", wide);
      const width = box.clientWidth, height = box.clientHeight;
      return [{ wide, size: scale(width / 2, height - 30) }, { wide, stacked: true, size: scale(width, height / 2 - 30) }];
    });
    const best = found.reduce((one, other) => (other.size > 1.02 * one.size ? other : one));
    document.body.classList.toggle("wide", best.wide);
    box.classList.toggle("stacked", Boolean(best.stacked));
  }

  resized() {
    this.redress(); // first, as the legend takes more or fewer lines
    this.arrange();
    for (const { scene } of this.sides) scene.resize();
  }

  redress() {
    const colours = this.colours.now;
    drawLegend(byId("legend"), colours, this.sides);
    drawScale(byId("scale"), colours, this.colours.steps, this.sides[0].scene.showHeat);
    this.wake();
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

  // Draw everything; while it plays, words and curves only now and then.
  show() {
    const colours = this.colours.now, { player, sides } = this;
    for (const side of sides) {
      side.scene.trail = player.blurs ? ((TRAIL * player.speed) / side.header.units.seconds) / side.header.tick : 0;
      side.scene.draw(player.in(side), player.whole ? side.span : player.in(side));
    }
    this.controls.show();
    this.course.show();
    if (player.playing && this.frames % 6) return;
    this.tiles.draw(colours);
    this.stations.forEach((table, i) => table.draw(player.whole ? sides[i].span : player.in(sides[i]), player.in(sides[i])));
    const said = this.counted();
    if (byId("counted").textContent !== said) byId("counted").textContent = said;
    this.panel.draw(colours, sides.length > 1);
    for (const side of sides) side.hover.again();
  }
}
