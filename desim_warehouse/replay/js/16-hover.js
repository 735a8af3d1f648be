// What is under the pointer, in words. Names are put in as text, each kept apart from its neighbours (bdi).

class Hover {
  constructor(side, player, tip) {
    this.side = side;
    this.scene = side.scene;
    this.player = player;
    this.tip = tip;
    this.point = null;
  }

  show(sx, sy) {
    this.point = [sx, sy];
    const lines = this.lines(sx, sy);
    this.tip.hidden = lines === null;
    if (lines === null) return;
    this.tip.replaceChildren(...lines.map((parts, i) => this.line(parts, i === 0 ? "b" : "span")));
    const { width, height } = this.scene.view;
    const left = Math.min(sx + 14, Math.max(width - this.tip.offsetWidth - 6, 0));
    const top = sy + 18 + this.tip.offsetHeight > height ? sy - this.tip.offsetHeight - 12 : sy + 18;
    this.tip.style.left = `${left}px`;
    this.tip.style.top = `${Math.max(top, 0)}px`;
  }

  hide() {
    this.point = null;
    this.scene.pointed = -1;
    this.tip.hidden = true;
  }

  get time() {
    return this.player.in(this.side);
  }

  again() {
    if (this.point !== null) this.show(...this.point);
  }

  // A node's name, as part of a line.
  name(node) {
    return { name: this.side.name(node) };
  }

  // A line from plain words and names ({name}).
  line(parts, tag) {
    return element(tag, {}, ...parts.map((one) => (typeof one === "string" ? one : element("bdi", {}, one.name))));
  }

  lines(sx, sy) {
    const who = this.whoAt(sx, sy), picker = who - this.scene.tracks.count;
    this.scene.pointed = who;
    if (picker >= 0) return [[`Picker ${picker}`], [this.side.work(picker, this.time)]];
    if (who >= 0) return this.robotLines(who);
    const [wx, wy] = this.scene.view.world(sx, sy);
    return this.nodeLines(wx, wy) ?? this.storageLines(wx, wy) ?? this.edgeLines(wx, wy);
  }

  // The robot or picker at a point of the screen; -1: none.
  whoAt(sx, sy) {
    const { scene } = this;
    let best = -1, near = Infinity;
    for (let who = 0; who < scene.everybody(); who++) {
      const [x, y] = scene.standing(who), away = Math.hypot(x - sx, y - sy);
      if (away < near && away < scene.radius(who) + 5) [best, near] = [who, away];
    }
    return best;
  }

  robotLines(robot) {
    const { story, tracks, edges, header } = this.scene, { time } = this;
    const row = story.row(robot, time), task = story.task[row], wait = story.waiting(robot, time);
    const lines = [[`Robot ${robot}: ${header.states[story.state[row]].doing}`]];
    if (task >= 0) {
      const good = story.good[story.rowOf.get(task)] ?? -1;
      lines.push([`task ${task}${good >= 0 ? `, item ${story.called(good)}` : ""}`]);
    }
    lines.push(...this.podLines(-1 - robot));
    if (wait >= 0) lines.push([this.side.why(robot, time)]);
    const comes = this.side.comes(robot, time);
    if (comes) lines.push([comes]);
    if (header.capacity !== null) lines.push([`battery ${percent(story.charge(robot, time))}`]);
    const edge = tracks.on[robot];
    if (edge < edges.real)
      lines.push(["on ", this.name(edges.source[edge]), " → ", this.name(edges.target[edge]), ` at ${shortNumber(tracks.at[robot])} ${header.units.length}`]);
    else lines.push(["beside ", this.name(edges.source[edge])]);
    return lines;
  }

  nodeLines(wx, wy) {
    const { header, floor, story, resources } = this.scene, { time } = this;
    const inside = floor.zones.find((zone) => wx >= zone.left && wx <= zone.right && wy >= zone.top && wy <= zone.bottom);
    const node = inside?.node ?? header.nodes.findIndex(([, x, y]) => Math.hypot(x - wx, y - wy) < floor.radius * 1.2);
    if (node < 0) return null;
    const lines = [["Node ", this.name(node)]];
    for (const zone of floor.zones.filter((one) => one.node === node)) {
      lines.push([`${zone.kind} `, { name: zone.name }, `, ${zone.places.length} slot${zone.places.length > 1 ? "s" : ""}`]);
      if (zone.resource < 0) continue;
      const one = resources[zone.resource];
      lines.push([`${one.number} ${one.one}${one.number > 1 ? "s" : ""}, in use ${percent(one.utilisation(time))} of the time`]);
      lines.push([`${one.queue.at(time)} in the queue`]);
    }
    if (header.unload_at.includes(node)) lines.push([`${story.deliveredAt(node, time)} delivered here`]);
    return lines;
  }

  storageLines(wx, wy) {
    const { floor, story, edges } = this.scene, half = floor.size / 2, { time } = this;
    const good = floor.storageX.findIndex((x, i) => Math.abs(x - wx) < half && Math.abs(floor.storageY[i] - wy) < half);
    if (good < 0) return null;
    const edge = floor.storageEdge[good];
    const where = edge < 0 ? ["at ", this.name(-1 - edge)] : ["from ", this.name(edges.source[edge]), " → ", this.name(edges.target[edge])];
    if (this.side.pods.any) {
      const said = this.podLines(good);
      return [[`Place ${story.called(good)}`], ...(said.length ? said : [["no pod"]]), where];
    }
    const there = story.good.some((g, i) => g === good && story.released[i] <= time && time < story.loaded[i]);
    return [[`Item ${story.called(good)}`], [there ? "to be picked" : "nothing to pick"], where];
  }

  // The pod on a storage place, or carried by robot -1 - n: for whom it goes, and what it holds.
  podLines(where) {
    const { side, time } = this, pod = side.pods.on(where, time);
    return pod < 0 ? [] : [[`pod ${pod}`], ...side.pods.said(pod, time, (node) => side.place(node)).map((one) => [one])];
  }

  // A line that says in which direction a two-way lane is used now.
  presentDirection(edge) {
    const { edges } = this.scene;
    if (edges.twin[edge] < 0) return [];
    const now = this.scene.directions().find((used) => used === edge || used === edges.twin[edge]);
    return [now === undefined ? ["free"] : ["now ", this.name(edges.source[now]), " → ", this.name(edges.target[now])]];
  }

  edgeLines(wx, wy) {
    const { edges, floor, header, heat } = this.scene;
    for (let i = 0; i < edges.real; i++) {
      const long = floor.span[i] || 1;
      const along = ((wx - edges.x[i]) * edges.dx[i] + (wy - edges.y[i]) * edges.dy[i]) / long;
      const off = Math.abs((wx - edges.x[i]) * edges.dy[i] - (wy - edges.y[i]) * edges.dx[i]) / long;
      if (along < 0 || along > long || off > floor.radius * 0.8) continue;
      const { units } = header, waited = percent(heat.shares[i]);
      const [word, sign] = edges.twin[i] < 0 ? ["Lane ", " → "] : ["Two-way lane ", " ↔ "];
      return [[word, this.name(edges.source[i]), sign, this.name(edges.target[i])],
        ...this.presentDirection(i), [`${shortNumber(edges.length[i])} ${units.length}`], [`a robot waits here ${waited} of the time`]];
    }
    return null;
  }
}
