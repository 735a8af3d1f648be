// The indicators as they grow: a number and a small curve each.

const SAMPLES = 200;

function shortNumber(value) {
  const size = Math.abs(value);
  if (size >= 10000) return Math.round(value).toLocaleString("en");
  return String(Number(value.toFixed(size >= 100 ? 1 : 2)));
}

class Strip {
  constructor(root, header, story, span) {
    const per = (time) => time * header.tick + header.start;
    const unit = header.units.time;
    this.span = span;
    this.cells = [
      { key: "T", title: `T, time (${unit})`, value: per, text: (t) => shortNumber(per(t)) },
      { key: "S", title: "S, collisions", value: (t) => story.S(t) },
      { key: "C", title: "C, chargings", value: (t) => story.C(t) },
      { key: "delivered", title: "delivered", value: (t) => story.delivered(t) },
      { key: "throughput", title: "throughput / h", value: (t) => story.throughput(t) },
    ];
    if (header.capacity !== null)
      this.cells.push({ key: "battery", title: "battery % (least)", value: (t) => story.battery(t)[0] * 100,
        low: (t) => story.battery(t)[1] * 100, top: 100,
        text: (t) => story.battery(t).map((part) => Math.round(part * 100)).join(" (") + ")" });
    for (const cell of this.cells) this.build(root, cell);
  }

  build(root, cell) {
    const box = root.appendChild(document.createElement("div"));
    box.className = "cell";
    const title = box.appendChild(document.createElement("h2"));
    title.textContent = title.title = cell.title;
    cell.out = box.appendChild(document.createElement("p"));
    cell.out.dataset.key = cell.key;
    cell.canvas = box.appendChild(document.createElement("canvas"));
    cell.canvas.setAttribute("aria-hidden", "true");
    const sample = (f) => Float64Array.from({ length: SAMPLES + 1 }, (_, i) => f((i / SAMPLES) * this.span));
    cell.curve = sample(cell.value);
    cell.lowCurve = cell.low ? sample(cell.low) : null;
    cell.most = cell.top ?? cell.curve.reduce((a, b) => Math.max(a, b), 1e-9);
  }

  draw(time, colours) {
    for (const cell of this.cells) {
      const text = cell.text ? cell.text(time) : shortNumber(cell.value(time));
      if (cell.out.textContent !== text) cell.out.textContent = text;
      this.curve(cell, time, colours);
    }
  }

  curve(cell, time, colours) {
    const { canvas } = cell, ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = canvas.clientWidth, height = canvas.clientHeight;
    if (!width) return;
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const ctx = canvas.getContext("2d");
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    ctx.clearRect(0, 0, width, height);
    const part = this.span ? time / this.span : 1;
    const now = cell.value(time);
    if (cell.lowCurve) this.line(ctx, cell, cell.lowCurve, part, cell.low(time), colours.low);
    this.line(ctx, cell, cell.curve, part, now, colours.soft);
    ctx.fillStyle = colours.ink;
    ctx.beginPath();
    ctx.arc(1 + part * (width - 4), this.y(now, cell, height), 2.5, 0, 7);
    ctx.fill();
  }

  y(value, cell, height) {
    return height - 3 - (value / cell.most) * (height - 6);
  }

  // The curve up to now, with the value that it has now at its end.
  line(ctx, cell, curve, part, now, colour) {
    const width = cell.canvas.clientWidth, height = cell.canvas.clientHeight;
    ctx.strokeStyle = colour;
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    for (let i = 0; i <= SAMPLES && i / SAMPLES <= part; i++)
      ctx.lineTo(1 + (i / SAMPLES) * (width - 4), this.y(curve[i], cell, height));
    ctx.lineTo(1 + part * (width - 4), this.y(now, cell, height));
    ctx.stroke();
  }
}
