// What the signs mean, drawn with the same brushes; and the marks above the time slider.

const SIGNS = [
  ["empty", "empty, to a good"], ["loaded", "carrying"], ["idle", "idle, charging, returning"], ["wait", "waits"],
  ["good", "good to be fetched"], ["none", "none"], ["bay", "departure and charging zone"], ["out", "unloading zone"],
];

const TWO_WAY = [["free", "two-way lane, free"], ["used", "in use, in this direction"]];

function drawLegend(root, colours, twoWay) {
  root.replaceChildren(...[...SIGNS, ...(twoWay ? TWO_WAY : [])].map(([sign, words]) => {
    const item = document.createElement("li");
    const canvas = item.appendChild(document.createElement("canvas"));
    canvas.width = canvas.height = 36;
    canvas.setAttribute("aria-hidden", "true");
    const ctx = canvas.getContext("2d");
    ctx.scale(2, 2);
    drawSign(ctx, sign, colours);
    item.append(words);
    return item;
  }));
}

function drawSign(ctx, sign, colours) {
  const circle = (r) => {
    ctx.beginPath();
    ctx.arc(9, 9, r, 0, 7);
    ctx.fill();
  };
  if (sign === "free" || sign === "used") return drawLane(ctx, sign === "used", colours);
  ctx.fillStyle = colours[sign];
  if (sign === "good" || sign === "none") return ctx.fillRect(3, 3, 12, 12);
  if (sign === "bay" || sign === "out") {
    ctx.fillRect(2, 2, 14, 14);
    ctx.strokeStyle = colours[`${sign}Line`];
    ctx.setLineDash([3, 2]);
    return ctx.strokeRect(2.5, 2.5, 13, 13);
  }
  if (sign === "wait") {
    circle(9);
    ctx.fillStyle = colours.empty;
    return circle(6);
  }
  circle(7);
  if (sign === "idle") {
    ctx.fillStyle = colours.floor;
    circle(5);
  }
  if (sign === "loaded") {
    ctx.strokeStyle = colours.label;
    ctx.lineWidth = 1.5;
    ctx.strokeRect(5, 5, 8, 8);
  }
}

function drawLane(ctx, used, colours) {
  ctx.strokeStyle = ctx.fillStyle = used ? colours.soft : colours.aisle;
  ctx.lineWidth = 1.5;
  if (!used) ctx.setLineDash([4, 3]);
  ctx.beginPath();
  ctx.moveTo(0, 9);
  ctx.lineTo(18, 9);
  ctx.stroke();
  if (!used) return;
  ctx.beginPath();
  ctx.moveTo(14, 9);
  ctx.lineTo(6, 4.5);
  ctx.lineTo(6, 13.5);
  ctx.fill();
}

// Collisions as grey marks, darker where there are many, rotations as coloured ones, over the whole window.
function drawRibbon(canvas, app, colours) {
  const ratio = Math.min(window.devicePixelRatio || 1, 2), width = canvas.clientWidth, height = canvas.clientHeight;
  canvas.width = Math.max(Math.round(width * ratio), 1);
  canvas.height = Math.max(Math.round(height * ratio), 1);
  const ctx = canvas.getContext("2d"), { story, player } = app, columns = Math.max(Math.floor(width / 2), 1);
  ctx.scale(ratio, ratio);
  const counts = new Float64Array(columns + 1);
  for (const begin of story.beginnings)
    if (begin >= 0 && begin <= player.span) counts[Math.floor((begin / player.span) * columns)]++;
  const most = counts.reduce((a, b) => Math.max(a, b), 1);
  ctx.fillStyle = colours.soft;
  counts.forEach((count, i) => {
    const high = count ? (0.35 + 0.65 * (count / most)) * height : 0;
    ctx.fillRect(i * 2, height - high, 1.5, high);
  });
  ctx.fillStyle = colours.ring;
  for (const ring of story.rings) ctx.fillRect((ring.time / player.span) * width - 1, 0, 2, height);
}

function drawScale(box, app, colours) {
  box.hidden = !app.scene.showHeat;
  if (box.hidden) return;
  const canvas = box.querySelector("canvas"), ctx = canvas.getContext("2d"), wide = canvas.width / colours.heat.length;
  colours.heat.forEach((colour, i) => {
    ctx.fillStyle = colour;
    ctx.fillRect(i * wide, 0, wide + 1, canvas.height);
  });
  const { tick, units } = app.header;
  const text = `${shortNumber(app.scene.heat.most * tick)} ${units.time} on an edge`;
  if (byId("scale-most").textContent !== text) byId("scale-most").textContent = text;
}
