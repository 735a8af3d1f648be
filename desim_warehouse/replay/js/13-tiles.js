// The indicators as they grow: a number for each run, and a small curve with its axes where the course below has none.

const SAMPLES = 160;
const FORMS = {
  count: grouped, open: grouped,
  share: tenths, lost: tenths, chargers: tenths, battery: percent, rate: shortNumber, time: within,
};

// A share as sentences of the run have it.
function tenths(share) {
  if (share > 0.9995 && share < 1) return "over 99.9 %";
  return Number.isFinite(share) && share > 0.0005 && share < 1 ? `${(100 * share).toFixed(1)} %` : percent(share);
}

// A time in a unit that fits, as sentences of the run have it.
function within(value, { time, seconds }) {
  const long = value * seconds, [unit, size] = long < 90 ? ["s", 1] : long < 5400 ? ["min", 60] : ["h", 3600];
  return ["s", "min", "h"].includes(time) && Number.isFinite(value) ? `${shortNumber(long / size)} ${unit}` : shortNumber(value);
}

class Tiles {
  constructor(root, sides, player) {
    this.player = player;
    this.sides = sides;
    const shown = new Map(sides.flatMap((side) => side.header.tiles.map((tile) => [tile[0], tile])));
    const numbersFirst = Array.from(shown.values()).sort((a, b) => a[3] - b[3]);
    this.cells = numbersFirst.map(([key, title, form, drawn]) => this.build(root, key, title, form, drawn));
  }

  build(root, key, title, form, drawn) {
    const { units } = this.sides[0].header, named = ["s", "min", "h"].includes(units.time);
    const text = form === "time" && !named ? `${title} (${units.time})` : title;
    const head = element("h2", { title: text }, text), out = element("p", { "data-key": key });
    const canvas = drawn ? element("canvas", { "aria-hidden": "true" }) : null;
    root.append(element("div", { class: "tile" }, head, out, canvas ?? ""));
    const runs = this.sides.map((side, i) => {
      if (!side.header.tiles.some(([name]) => name === key)) return null;
      const value = out.appendChild(element("span", { class: `run-${i + 1}` }));
      return { side, value, curve: drawn ? this.samples(side, key, form) : [] };
    });
    const all = runs.flatMap((run) => (run ? Array.from(run.curve).slice(form === "rate" || form === "lost" ? SAMPLES / 10 : 0) : []));
    const whole = form === "share";
    const most = whole ? 1 : all.filter(Number.isFinite).reduce((a, b) => Math.max(a, b), 0) || 1;
    return { key, form, head, canvas, runs, most, label: whole ? "100 %" : FORMS[form](most, units) };
  }

  times() {
    const { start, end } = this.player;
    return Array.from({ length: SAMPLES + 1 }, (_, i) => start + (i / SAMPLES) * (end - start));
  }

  samples(side, key, form) {
    return Float64Array.from(this.times(), (time) => side.value(key, form, this.player.in(side, time)));
  }

  draw(colours) {
    const { whole, start, end } = this.player, until = whole ? end : this.player.time, part = (until - start) / (end - start);
    for (const cell of this.cells) {
      const ctx = cell.canvas && this.clear(cell.canvas, colours, cell.label);
      cell.runs.forEach((run, i) => {
        if (run === null) return;
        const time = this.player.in(run.side, until), now = run.side.value(cell.key, cell.form, time);
        let text = FORMS[cell.form](now, run.side.header.units);
        if (cell.form === "battery" && this.sides.length === 1) text += ` (${percent(run.side.story.battery(time)[1])})`;
        if (run.value.textContent !== text) run.value.textContent = text;
        if (!ctx) return;
        const colour = this.sides.length > 1 ? [colours.one, colours.two][i] : colours.soft;
        if (!whole) this.line(ctx, cell, run.curve, 1, NaN, colours.bar);
        this.line(ctx, cell, run.curve, part, now, colour, true);
      });
    }
  }

  // An empty canvas with its axes; null while it is not shown.
  clear(canvas, colours, label) {
    if (!canvas.clientWidth) return null;
    const { ctx, width, height } = emptied(canvas);
    axes(ctx, width, height, colours, label, this.player.ends());
    return ctx;
  }

  // The curve up to now, with the value that it has now at its end.
  line(ctx, cell, curve, part, now, colour, dot = false) {
    const box = plotBox(cell.canvas.clientWidth, cell.canvas.clientHeight);
    const x = (at) => box.left + at * box.width;
    const y = (value) => box.bottom - (Math.min(value, cell.most) / cell.most) * box.height;
    ctx.strokeStyle = ctx.fillStyle = colour;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    for (let i = 0; i <= SAMPLES && i / SAMPLES <= part; i++)
      if (Number.isFinite(curve[i])) ctx.lineTo(x(i / SAMPLES), y(curve[i]));
    if (Number.isFinite(now)) ctx.lineTo(x(part), y(now));
    ctx.stroke();
    if (!dot || !Number.isFinite(now)) return;
    ctx.beginPath();
    ctx.arc(x(part), y(now), 2.5, 0, 7);
    ctx.fill();
  }
}

// Where a small curve is drawn on its canvas.
function plotBox(width, height) {
  return { left: 2, right: width - 4, width: width - 6, top: 13, bottom: height - 12, height: height - 25 };
}

// The axes of a small curve: 0 and its top value, its first and its last moment.
function axes(ctx, width, height, colours, top, [first, last]) {
  const box = plotBox(width, height);
  ctx.strokeStyle = colours.bar;
  ctx.lineWidth = 1;
  ctx.beginPath();
  ctx.moveTo(box.left, box.top);
  ctx.lineTo(box.left, box.bottom + 0.5);
  ctx.lineTo(box.right, box.bottom + 0.5);
  ctx.moveTo(box.left, box.top);
  ctx.lineTo(box.left + 4, box.top);
  ctx.stroke();
  ctx.fillStyle = colours.soft;
  ctx.font = "9.5px system-ui, sans-serif";
  ctx.textAlign = "left";
  ctx.textBaseline = "top";
  ctx.fillText(top, 0, 1);
  ctx.fillText(first, box.left, box.bottom + 2);
  ctx.textAlign = "right";
  ctx.fillText(last, box.right, box.bottom + 2);
}
