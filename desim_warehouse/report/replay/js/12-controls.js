// Buttons, fields and keys.

const byId = (id) => document.getElementById(id);

class Controls {
  constructor(app) {
    this.app = app;
    const { player, scene } = app;
    for (const speed of SPEEDS) byId("speed").add(new Option(`${speed}×`, speed));
    byId("scrub").max = player.span;
    byId("follow").max = scene.tracks.count - 1;
    const nothing = (id, when) => (byId(id).disabled = when);
    nothing("next", app.story.byBegin.length === 0);
    nothing("previous", app.story.byBegin.length === 0);
    nothing("ring", app.story.rings.length === 0);
    this.actions = {
      play: () => player.toggle(), back: () => player.step(-1), on: () => player.step(1),
      next: () => this.collision(1), previous: () => this.collision(-1), ring: () => this.rotation(),
      heat: () => this.heat(), palette: () => this.palette(), theme: () => this.theme(), help: () => this.help(),
      "zoom-in": () => this.zoom(1.4), "zoom-out": () => this.zoom(1 / 1.4), "zoom-fit": () => this.fit(),
    };
    for (const [id, act] of Object.entries(this.actions)) byId(id).addEventListener("click", act);
    byId("scrub").addEventListener("input", (event) => player.seek(Number(event.target.value)));
    byId("speed").addEventListener("change", (event) => {
      player.speed = Number(event.target.value);
      app.wake();
    });
    byId("follow").addEventListener("change", (event) => this.follow(event.target.value === "" ? -1 : Number(event.target.value)));
    document.addEventListener("keydown", (event) => this.key(event));
    scene.colours.system.addEventListener("change", () => this.recolour());
    this.keys = this.bindings();
  }

  bindings() {
    const { player } = this.app;
    const pan = (dx, dy) => this.pan(dx, dy);
    return {
      " ": this.actions.play, n: this.actions.next, p: this.actions.previous, r: this.actions.ring, h: this.actions.heat,
      c: this.actions.palette, d: this.actions.theme, "?": this.actions.help, "+": this.actions["zoom-in"],
      "=": this.actions["zoom-in"], "-": this.actions["zoom-out"], 0: this.actions["zoom-fit"],
      f: () => this.followNext(1), F: () => this.followNext(-1), Escape: () => this.escape(),
      ArrowRight: (e) => player.step(e.ctrlKey ? 10 : 1), ArrowLeft: (e) => player.step(e.ctrlKey ? -10 : -1),
      ArrowUp: () => player.faster(1), ArrowDown: () => player.faster(-1),
      Home: () => player.seek(0), End: () => player.seek(player.span),
      ShiftArrowRight: () => pan(-60, 0), ShiftArrowLeft: () => pan(60, 0),
      ShiftArrowUp: () => pan(0, 60), ShiftArrowDown: () => pan(0, -60),
    };
  }

  key(event) {
    if (event.metaKey || event.altKey || (event.ctrlKey && !event.key.startsWith("Arrow"))) return;
    const field = event.target.closest?.("input, select");
    if (field && event.key !== "Escape" && !(field.type === "range" && !/Arrow|Home|End/.test(event.key))) return;
    if (event.target.closest?.("button") && event.key === " ") return; // the button is pressed
    const shifted = event.shiftKey && event.key.startsWith("Arrow") ? `Shift${event.key}` : event.key;
    const act = this.keys[shifted] ?? this.keys[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    act(event);
  }

  collision(direction) {
    const { player, story, header } = this.app;
    const wait = player.collision(direction);
    if (wait < 0) return this.say(direction > 0 ? "No further collision" : "No earlier collision");
    const other = story.waitOther[wait];
    this.look(story.waitRobot[wait]);
    const whom = other >= 0 ? ` for robot ${other}` : "";
    const lasts = shortNumber(story.waitLength[wait] * header.tick);
    this.say(`Robot ${story.waitRobot[wait]} waits${whom}, ${lasts} ${header.units.time} in all`);
  }

  rotation() {
    const ring = this.app.player.rotation();
    if (ring === null) return this.say("No further rotation");
    this.look(ring.robots[0]);
    this.say(`A ring of ${ring.robots.length} robots turns: ${ring.robots.join(", ")}`);
  }

  // Mark a robot, and see that it is in view.
  look(robot) {
    const { scene, player } = this.app;
    scene.chosen = robot;
    scene.following = byId("follow").value !== "";
    if (scene.following) byId("follow").value = robot;
    scene.tracks.place(player.time);
    if (!scene.view.shows(scene.tracks.x[robot], scene.tracks.y[robot], -scene.floor.radius))
      scene.view.centre(scene.tracks.x[robot], scene.tracks.y[robot]);
    scene.stale = true;
    this.app.wake();
  }

  follow(robot) {
    const { scene } = this.app, known = Number.isInteger(robot) && robot >= 0 && robot < scene.tracks.count;
    scene.chosen = known ? robot : -1;
    scene.following = known;
    byId("follow").value = known ? robot : "";
    if (known && scene.view.fitted) scene.view.zoom(Math.max(2, 14 / (scene.header.radii[robot] * scene.view.scale)));
    this.say(known ? `Following robot ${robot}` : "Following nobody");
    scene.stale = true;
    this.app.wake();
  }

  followNext(by) {
    const { scene } = this.app, count = scene.tracks.count;
    this.follow((scene.chosen < 0 ? (by > 0 ? 0 : count - 1) : scene.chosen + by + count) % count);
  }

  escape() {
    byId("keys").hidden = true;
    byId("help").setAttribute("aria-expanded", "false");
    this.app.hover.hide();
    if (this.app.scene.chosen >= 0) this.follow(-1);
  }

  heat() {
    const { scene } = this.app;
    scene.showHeat = !scene.showHeat;
    byId("heat").setAttribute("aria-pressed", String(scene.showHeat));
    this.app.wake();
  }

  palette() {
    const { colours } = this.app.scene;
    colours.palette = colours.palette === "safe" ? "paper" : "safe";
    this.recolour();
  }

  theme() {
    const { colours } = this.app.scene;
    colours.theme = colours.dark ? "light" : "dark";
    document.documentElement.dataset.theme = colours.theme;
    this.recolour();
  }

  recolour() {
    const { scene } = this.app, { colours } = scene;
    byId("palette").setAttribute("aria-pressed", String(colours.palette === "paper"));
    byId("theme").setAttribute("aria-pressed", String(colours.dark));
    scene.stale = true;
    this.app.redress();
  }

  help() {
    const keys = byId("keys");
    keys.hidden = !keys.hidden;
    byId("help").setAttribute("aria-expanded", String(!keys.hidden));
  }

  zoom(factor, x, y) {
    this.app.scene.view.zoom(factor, x, y);
    this.app.scene.stale = true;
    this.app.wake();
  }

  fit() {
    const { scene } = this.app;
    if (scene.following) this.follow(-1);
    scene.view.fit();
    scene.stale = true;
    this.app.wake();
  }

  pan(dx, dy) {
    const { scene } = this.app;
    if (scene.following) this.follow(-1);
    scene.view.pan(dx, dy);
    scene.stale = true;
    this.app.wake();
  }

  say(text) {
    byId("status").textContent = text;
  }

  // Bring fields and buttons in line with the player.
  show() {
    const { player } = this.app, text = this.app.clock();
    const word = player.playing ? "Pause" : "Play";
    byId("play").textContent = player.playing ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", word);
    byId("speed").value = player.speed;
    byId("scrub").value = player.time;
    byId("scrub").setAttribute("aria-valuetext", text);
    byId("time").textContent = text;
  }
}
