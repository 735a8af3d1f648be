// The panel of the robot that was clicked, pinned until it is closed: its task, its route, its battery over time.

class Panel {
  constructor(root, player, close) {
    this.root = root;
    this.player = player;
    this.side = null;
    this.robot = -1;
    const part = (name) => root.querySelector(`[data-part=${name}]`);
    this.parts = Object.fromEntries(["title", "doing", "task", "pod", "due", "route", "battery"].map((name) => [name, part(name)]));
    this.canvas = root.querySelector("canvas");
    part("close").addEventListener("click", close);
  }

  pin(side, robot) {
    [this.side, this.robot] = [side, robot];
    this.root.hidden = robot < 0;
  }

  draw(colours, many) {
    if (this.robot < 0) return;
    if (this.robot >= this.side.tracks.count) return this.picker(this.robot - this.side.tracks.count, many);
    const { side, robot } = this, { story, header, scene } = side, time = this.player.in(side);
    const row = story.row(robot, time), task = story.task[row], wait = story.waiting(robot, time);
    const doing = header.states[story.state[row]].doing;
    this.say("title", `Robot ${robot}${many ? `, ${side.letter}` : ""}`);
    this.say("doing", [doing, wait < 0 ? side.comes(robot, time) : side.why(robot, time)].filter(Boolean).join(", "));
    this.say("task", this.taskText(task));
    this.say("pod", this.podText(robot, time));
    this.say("due", this.dueText(task, time));
    this.say("route", this.routeText(scene.ahead(time), story.until(row, robot), time));
    const level = header.capacity === null ? "" : `Battery ${percent(story.charge(robot, time))}`;
    this.say("battery", level);
    this.canvas.hidden = !level;
    if (level) this.curve(colours, time);
  }

  picker(picker, many) {
    const { side } = this;
    for (const name in this.parts) this.say(name, "");
    this.say("title", `Picker ${picker}${many ? `, ${side.letter}` : ""}`);
    this.say("doing", side.work(picker, this.player.in(side)));
    this.canvas.hidden = true;
  }

  // A line of the panel; a line without words is not shown.
  say(name, text) {
    if (this.parts[name].textContent !== text) this.parts[name].textContent = text;
    this.parts[name].hidden = !text;
  }

  taskText(task) {
    const { story } = this.side, i = story.rowOf.get(task);
    if (task < 0) return "No task";
    if (i === undefined) return `Task ${task}`;
    const good = story.good[i] >= 0 ? `, item ${story.called(story.good[i])}` : "", to = story.to[i];
    return `Task ${task}${good}${to >= 0 ? `, to ${this.side.place(to)}` : ""}`;
  }

  podText(robot, time) {
    const { pods } = this.side, pod = pods.on(-1 - robot, time);
    return pod < 0 ? "" : `Pod ${pod}, ${pods.said(pod, time, (node) => this.side.place(node)).join("; ")}`;
  }

  dueText(task, time) {
    const { story } = this.side, i = story.rowOf.get(task);
    if (task < 0 || i === undefined || story.due[i] === 0) return "";
    const left = story.released[i] + story.due[i] - 1 - time;
    return left >= 0 ? `Due in ${this.side.lasts(left)}` : `Late by ${this.side.lasts(-left)}`;
  }

  routeText({ nodes, far }, until, time) {
    const { side } = this;
    if (!nodes.length && !far) return "";
    const names = nodes.map((node) => isolated(side.name(node)));
    const some = names.length > 5 ? [...names.slice(0, 3), "…", names.at(-1)] : names;
    const there = Number.isFinite(until) ? `, ${side.lasts(until - time)}` : "";
    return `Route ${some.length ? `by ${some.join(", ")}: ` : ""}${shortNumber(far)} ${side.header.units.length}${there}`;
  }

  // The battery's level over the window, up to now and, pale, to its end.
  curve(colours, time) {
    const { canvas, side, robot } = this, { story } = side;
    const { ctx, width, height } = emptied(canvas), box = plotBox(width, height);
    axes(ctx, width, height, colours, "100 %", this.player.ends());
    const x = (at) => box.left + (at / side.span) * box.width, y = (part) => box.bottom - part * box.height;
    const line = (from, to, colour) => {
      ctx.strokeStyle = colour;
      ctx.lineWidth = 1.5;
      ctx.beginPath();
      ctx.moveTo(x(from), y(story.charge(robot, from)));
      for (let i = story.energyFirst[robot]; i < story.energyFirst[robot + 1]; i++)
        if (story.energyTime[i] > from && story.energyTime[i] < to) ctx.lineTo(x(story.energyTime[i]), y(story.energy[i]));
      ctx.lineTo(x(to), y(story.charge(robot, to)));
      ctx.stroke();
    };
    line(time, side.span, colours.bar);
    line(0, time, colours.full);
    ctx.fillStyle = colours.ink;
    ctx.beginPath();
    ctx.arc(x(time), y(story.charge(robot, time)), 3, 0, 7);
    ctx.fill();
  }
}
