// Buttons, fields and keys.

class Controls {
  constructor(app) {
    this.app = app;
    const { player, sides } = app, none = (id, when) => (byId(id).disabled = when);
    for (const { speed, words } of player.speeds) byId("speed").add(new Option(words, speed));
    this.reserve(byId("time"), sides[0].clock(sides[0].span));
    byId("scrub").min = player.start;
    byId("scrub").max = player.end;
    byId("follow").max = Math.max(...sides.map((side) => side.tracks.count)) - 1;
    this.queues = this.worst();
    this.queue = -1;
    none("next", sides.every((side) => side.story.byBegin.length === 0));
    none("previous", byId("next").disabled);
    none("queue", this.queues.length === 0);
    byId("ring").hidden = sides.every((side) => side.story.rings.length === 0);
    this.actions = {
      play: () => player.toggle(), back: () => player.step(-1), on: () => player.step(1),
      next: () => this.wait(1), previous: () => this.wait(-1), ring: () => this.rotation(), queue: () => this.nextQueue(),
      heat: () => this.heat(), palette: () => this.palette(), theme: () => this.theme(), help: () => this.help(),
      picture: () => app.picture.save(), "zoom-in": () => this.zoom(1.4), "zoom-out": () => this.zoom(1 / 1.4),
      "zoom-fit": () => this.fit(),
    };
    for (const [id, act] of Object.entries(this.actions)) byId(id).addEventListener("click", act);
    byId("scrub").addEventListener("input", (event) => player.seek(Number(event.target.value)));
    byId("speed").addEventListener("change", (event) => {
      player.speed = Number(event.target.value);
      app.wake();
    });
    byId("follow").addEventListener("change", (event) => this.follow(event.target.value === "" ? -1 : Number(event.target.value)));
    byId("robot").querySelector("[data-part=follow]").addEventListener("click", () => this.toggleFollow());
    document.addEventListener("keydown", (event) => this.key(event));
    app.colours.system.addEventListener("change", () => this.recolour());
    this.keys = this.bindings();
  }

  // Room for the longest text of an element, so that the buttons beside it stay where they are.
  reserve(item, text) {
    item.textContent = text;
    item.style.position = "absolute";
    const { width } = item.getBoundingClientRect();
    item.style.position = "";
    item.style.minWidth = `${Math.ceil(width) + 1}px`;
  }

  bindings() {
    const { player } = this.app, { actions } = this;
    const pan = (dx, dy) => this.pan(this.side, dx, dy);
    return {
      " ": actions.play, n: actions.next, p: actions.previous, r: actions.ring, q: actions.queue, h: actions.heat,
      s: actions.picture, c: actions.palette, d: actions.theme, "?": actions.help, "+": actions["zoom-in"],
      "=": actions["zoom-in"], "-": actions["zoom-out"], 0: actions["zoom-fit"],
      f: () => this.followNext(1), F: () => this.followNext(-1), Escape: () => this.escape(),
      ArrowRight: (e) => player.step(e.ctrlKey ? 10 : 1), ArrowLeft: (e) => player.step(e.ctrlKey ? -10 : -1),
      ArrowUp: () => player.faster(1), ArrowDown: () => player.faster(-1),
      Home: () => player.seek(player.start), End: () => player.seek(player.end),
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

  // The run whose robot is chosen, else the first.
  get side() {
    return this.app.sides.find((side) => side.scene.chosen >= 0) ?? this.app.sides[0];
  }

  of(side) {
    return this.app.sides.length > 1 ? `${side.letter}: ` : "";
  }

  wait(direction) {
    const found = this.app.player.wait(direction);
    if (found === null) return this.say(direction > 0 ? "No further wait" : "No earlier wait");
    const { side, wait } = found, { story } = side, other = story.waitOther[wait], robot = story.waitRobot[wait];
    this.look(side, robot);
    this.say(`${this.of(side)}Robot ${robot} waits${other >= 0 ? ` for robot ${other}` : ""}, ${side.lasts(story.waitLength[wait])} in all`);
  }

  rotation() {
    const found = this.app.player.rotation();
    if (found === null) return this.say("No further rotation");
    const { side, ring } = found;
    this.look(side, ring.robots[0]);
    this.say(`${this.of(side)}A ring of ${ring.robots.length} robots turns: ${ring.robots.join(", ")}`);
  }

  // The longest queues of all places and runs, the longest first.
  worst() {
    const all = this.app.sides.flatMap((side) => side.header.worst.map((queue) => ({ side, ...queue })));
    return all.sort((a, b) => b.robots - a.robots);
  }

  // To one of the longest waits for a root.
  waitFor({ side, words, longest }, rank) {
    const [robot, time, length] = longest[rank], { player } = this.app;
    player.stop((time * side.header.units.seconds) / player.seconds);
    this.look(side, robot);
    const which = rank === 0 ? "the longest wait" : `wait ${rank + 1} of the longest`;
    this.say(`${this.of(side)}Robot ${robot}: ${which} ${words}, ${side.lasts(length / side.header.tick)} in all`);
  }

  // To a station, or to a bay with chargers.
  place(side, number) {
    for (const one of this.app.sides) one.scene.queue = one === side ? { what: "place", number } : null;
    const [x, y] = side.scene.around(side.scene.queue);
    this.see(side, x, y);
    this.say(`${this.of(side)}${side.resources[number].name}, ${side.name(side.resources[number].node)}`);
  }

  // To the worst queue; pressed again, to the next worst.
  nextQueue() {
    if (!this.queues.length) return;
    this.queue = (this.queue + 1) % this.queues.length;
    const { side, what, number, robots, time } = this.queues[this.queue], { scene, header } = side, { edges } = scene;
    this.app.player.stop((time * header.units.seconds) / this.app.player.seconds);
    for (const one of this.app.sides) one.scene.queue = one === side ? { what, number } : null;
    scene.draw(this.app.player.in(side));
    const [x, y] = scene.around(scene.queue), lane = what === "lane";
    this.see(side, x, y);
    const where = lane ? ` between ${isolated(side.name(edges.source[number]))} and ${isolated(side.name(edges.target[number]))}`
      : ` for a ${what === "station" ? "server" : "charger"} at ${isolated(header.resources[number][1])} (${isolated(side.name(header.resources[number][2]))})`;
    const rank = this.queue === 0 ? "Worst queue" : `Queue ${this.queue + 1} of ${this.queues.length}`;
    this.say(`${this.of(side)}${rank}: ${robots} robot${robots > 1 ? "s" : ""} wait${robots > 1 ? "" : "s"}${where}`);
    this.app.wake();
  }

  // See that a point is in view.
  see(side, x, y) {
    const { scene } = side;
    scene.following = false;
    if (!scene.view.shows(x, y, -scene.floor.radius)) scene.view.centre(x, y);
    this.together(side);
  }

  // Open the panel of a robot, and see that the robot is in view.
  look(side, robot) {
    const { scene } = side, { following } = scene;
    this.choose(side, robot);
    scene.tracks.place(this.app.player.in(side));
    this.see(side, scene.tracks.x[robot], scene.tracks.y[robot]);
    scene.following = following;
  }

  // Open the panel of a robot that was clicked, or close it where none was; its view stays as it is.
  pin(side, robot) {
    if (robot < 0 || !side.scene.following || side.scene.chosen !== robot) for (const one of this.app.sides) one.scene.following = false;
    this.choose(side, robot);
    this.say(robot < 0 ? "No robot chosen" : `Robot ${robot} chosen`);
  }

  choose(side, robot) {
    for (const one of this.app.sides) one.scene.chosen = one === side ? robot : -1;
    byId("follow").value = robot >= 0 && side.scene.following ? robot : "";
    this.app.panel.pin(side, robot);
    side.scene.stale = true;
    this.app.resized();
  }

  follow(robot, side = this.side) {
    const { scene } = side, known = Number.isInteger(robot) && robot >= 0 && robot < scene.tracks.count;
    for (const one of this.app.sides) one.scene.following = one === side && known;
    this.choose(side, known ? robot : -1);
    if (known && scene.view.fitted) scene.view.zoom(Math.max(2, 14 / (scene.header.radii[robot] * scene.view.scale)));
    this.say(known ? `Following robot ${robot}` : "Following no robot");
    this.together(side);
  }

  toggleFollow() {
    const { scene } = this.side;
    if (!scene.following) return this.follow(scene.chosen);
    scene.following = false;
    byId("follow").value = "";
    this.app.wake();
  }

  followNext(by) {
    const { scene } = this.side, count = scene.tracks.count;
    this.follow((scene.chosen < 0 ? (by > 0 ? 0 : count - 1) : scene.chosen + by + count) % count);
  }

  escape() {
    byId("keys").hidden = true;
    byId("help").setAttribute("aria-expanded", "false");
    for (const side of this.app.sides) {
      side.hover.hide();
      side.scene.queue = null;
    }
    if (this.side.scene.chosen >= 0) this.follow(-1);
    this.app.wake();
  }

  heat() {
    const shown = byId("heat").getAttribute("aria-pressed") !== "true";
    for (const side of this.app.sides) side.scene.showHeat = shown;
    byId("heat").setAttribute("aria-pressed", String(shown));
    this.app.resized();
  }

  palette() {
    const { colours } = this.app;
    colours.palette = colours.palette === "safe" ? "paper" : "safe";
    this.recolour();
  }

  theme() {
    const { colours } = this.app;
    colours.theme = colours.dark ? "light" : "dark";
    document.documentElement.dataset.theme = colours.theme;
    this.recolour();
  }

  recolour() {
    const { sides, colours } = this.app;
    byId("palette").setAttribute("aria-pressed", String(colours.palette === "paper"));
    byId("theme").setAttribute("aria-pressed", String(colours.dark));
    for (const side of sides) side.scene.stale = true;
    this.app.redress();
  }

  help() {
    const keys = byId("keys");
    keys.hidden = !keys.hidden;
    byId("help").setAttribute("aria-expanded", String(!keys.hidden));
  }

  // Zoom one floor about a point, or all about their middles.
  zoom(factor, side, x, y) {
    for (const one of side ? [side] : this.app.sides) one.view.zoom(factor, x, y);
    this.together(side ?? this.app.sides[0]);
  }

  fit() {
    this.unfollow();
    for (const side of this.app.sides) side.view.fit();
    this.together(this.app.sides[0]);
  }

  pan(side, dx, dy) {
    this.unfollow();
    side.view.pan(dx, dy);
    this.together(side);
  }

  // Moving the view by hand ends following; the panel stays.
  unfollow() {
    for (const side of this.app.sides) side.scene.following = false;
    byId("follow").value = "";
  }

  // Floors of the same extent show the same part; then draw.
  together(side) {
    const same = (a, b) => ["left", "top", "right", "bottom"].every((edge) => Math.abs(a[edge] - b[edge]) < 1e-6);
    for (const other of this.app.sides) {
      if (other !== side && same(other.view.bounds, side.view.bounds)) other.view.as(side.view);
      other.scene.stale = true;
    }
    this.app.wake();
  }

  say(text) {
    this.moment = this.app.player.time;
    byId("status").textContent = text;
    byId("said").textContent = text;
  }

  // Words and rings about a moment go when the clock has left it.
  leave() {
    const { player, sides } = this.app;
    if (this.moment === undefined || Math.abs(player.time - this.moment) * player.seconds < 2) return;
    this.moment = undefined;
    byId("said").textContent = "";
    for (const side of sides) side.scene.queue = null;
  }

  // Bring fields and buttons in line with the player.
  show() {
    this.leave();
    const { player, sides } = this.app, text = sides[0].clock(player.in(sides[0]));
    const word = player.playing ? "Pause" : "Play";
    byId("play").textContent = player.playing ? "❚❚" : "▶";
    byId("play").setAttribute("aria-label", word);
    byId("speed").value = player.speed;
    byId("scrub").value = player.time;
    byId("scrub").setAttribute("aria-valuetext", text);
    byId("time").textContent = text;
    const { scene } = this.side;
    byId("robot").querySelector("[data-part=follow]").setAttribute("aria-pressed", String(scene.chosen >= 0 && scene.following));
  }
}
