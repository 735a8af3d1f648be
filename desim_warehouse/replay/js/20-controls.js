// Buttons, fields and keys.

class Controls {
  constructor(app) {
    this.app = app;
    const { player, sides } = app;
    for (const { speed, words } of player.speeds) byId("speed").add(new Option(words, speed));
    this.reserve(byId("time"), sides[0].clock(sides[0].span));
    byId("scrub").min = player.start;
    byId("scrub").max = player.end;
    byId("follow").max = Math.max(...sides.map((side) => side.tracks.count)) - 1;
    this.stops = sides.flatMap((side) => side.header.stops.map((stop) => ({ side, ...stop })));
    this.at = -1;
    this.actions = {
      play: () => player.toggle(), story: () => this.nextStop(), heat: () => this.heat(), theme: () => this.theme(), help: () => this.help(),
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
      " ": actions.play, n: actions.story, h: actions.heat, s: actions.picture, d: actions.theme, "?": actions.help, "+": actions["zoom-in"],
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
    for (const one of this.app.sides) one.scene.queue = one === side ? { number } : null;
    const [x, y] = side.scene.around(side.scene.queue);
    this.see(side, x, y);
    this.say(`${this.of(side)}${side.resources[number].name}, ${side.name(side.resources[number].node)}`);
  }

  // To the next of the stops that tell what happened; after the last to the first.
  nextStop() {
    this.at = (this.at + 1) % this.stops.length;
    const { side, said, time, robots, place } = this.stops[this.at], { scene, header, view } = side, { player } = this.app;
    this.choose(side, robots?.length === 1 ? robots[0] : -1);
    if (time === null) player.rest();
    else player.stop((time * header.units.seconds) / player.seconds);
    const spot = robots ? { robots } : place === undefined ? null : { number: place };
    for (const one of this.app.sides) one.scene.queue = one === side ? spot : null;
    scene.put(player.in(side));
    if (spot) {
      const [x, y, reach] = scene.around(spot);
      view.close(x, y, Math.max(reach, 8 * scene.floor.radius));
    } else view.fit();
    scene.following = false;
    this.together(side);
    const why = robots?.length === 1 && robots[0] < side.tracks.count ? side.why(robots[0], player.in(side)) : "";
    this.say(`${this.of(side)}${said}${why ? ` It ${why}.` : ""}`);
    byId("story").textContent = `Story ${this.at + 1} of ${this.stops.length}`;
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
    scene.put(this.app.player.in(side));
    this.see(side, scene.tracks.x[robot], scene.tracks.y[robot]);
    scene.following = following;
  }

  // Open the panel of a robot that was clicked, or close it where none was; its view stays as it is.
  pin(side, robot) {
    if (robot < 0 || !side.scene.following || side.scene.chosen !== robot) for (const one of this.app.sides) one.scene.following = false;
    this.choose(side, robot);
    this.say(robot < 0 ? "No robot chosen" : `${side.who(robot).replace(/^./, (letter) => letter.toUpperCase())} chosen`);
  }

  choose(side, robot) {
    for (const one of this.app.sides) one.scene.chosen = one === side ? robot : -1;
    byId("follow").value = robot >= 0 && robot < side.tracks.count && side.scene.following ? robot : "";
    this.app.panel.pin(side, robot);
    side.scene.stale = true;
    this.app.resized();
  }

  follow(robot, side = this.side) {
    const { scene } = side, known = Number.isInteger(robot) && robot >= 0 && robot < scene.everybody();
    for (const one of this.app.sides) one.scene.following = one === side && known;
    this.choose(side, known ? robot : -1);
    if (known && scene.view.fitted) scene.view.zoom(Math.max(2, 14 / ((scene.header.radii[robot] ?? scene.floor.radius) * scene.view.scale)));
    this.say(known ? `Following ${side.who(robot)}` : "Following no robot");
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
    const { scene } = this.side, count = scene.everybody();
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

  theme() {
    const { colours } = this.app;
    colours.theme = colours.dark ? "light" : "dark";
    document.documentElement.dataset.theme = colours.theme;
    this.recolour();
  }

  recolour() {
    const { sides, colours } = this.app;
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
