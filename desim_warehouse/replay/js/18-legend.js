// What the signs mean, drawn with the same brushes.

// The signs that a page needs, by what its runs have.
function signsOf(sides) {
  const some = (test) => sides.some(({ header, scene }) => test(header, scene.floor));
  const signs = [["empty", "driving to a pick"], ["loaded", "carrying"]];
  if (some((header) => header.capacity !== null)) signs.push(["charging", "charging"], ["battery", "battery"]);
  signs.push(["idle", "idle or returning to a bay"], ["wait", "waits"]);
  const told = new Set(["empty", "loaded", "charging", "idle", "wait"]);
  for (const { role, doing } of sides.flatMap(({ header }) => header.states)) {
    if (!told.has(role)) signs.push([role, doing]);
    told.add(role);
  }
  if (sides.some(({ people }) => people?.count)) DOES.forEach((does, i) => signs.push([i, `picker, ${does}`]));
  if (sides.some(({ pods }) => pods?.any)) signs.push(["pod", "pod"], ["good", "pod with lines to pick"]);
  else signs.push(["good", "item to pick"]);
  signs.push(["none", some((_, floor) => floor.cell) ? "storage" : "storage place"]);
  if (some((_, floor) => floor.cell)) signs.push(["wall", "no lane: shelf or wall"]);
  if (some((_, floor) => floor.zones.some((zone) => zone.kind === "bay"))) signs.push(["bay", "bay"]);
  if (some((_, floor) => floor.zones.some((zone) => zone.kind === "bay" && zone.number))) signs.push(["charger", "charger"]);
  if (some((_, floor) => floor.zones.some((zone) => zone.kind === "station"))) signs.push(["out", "station"]);
  else signs.push(["out", "items are unloaded"]);
  if (some((header) => header.lifts)) signs.push(["lift", "cabin of a lift, on each floor"]);
  if (sides.some(({ story }) => story.shutVisit.some((visit) => visit < 0))) signs.push(["shut", "closed"]);
  if (sides.some(({ story }) => story.shutVisit.some((visit) => visit >= 0))) signs.push(["person", "person in the aisle"]);
  if (some((header) => header.two_way.length > 0))
    signs.push(["free", "two-way lane, free"], ["used", "in use, in this direction"]);
  return signs;
}

function drawLegend(root, colours, sides) {
  root.replaceChildren(...signsOf(sides).map(([sign, words]) => {
    const canvas = element("canvas", { width: 36, height: 36, "aria-hidden": "true" }), ctx = canvas.getContext("2d");
    ctx.scale(2, 2);
    drawSign(ctx, sign, colours);
    return element("li", {}, canvas, words);
  }));
}

// A sign of the legend, 18 px wide and high.
function drawSign(ctx, sign, colours) {
  const circle = (r) => {
    ctx.beginPath();
    ctx.arc(9, 9, r, 0, 7);
    ctx.fill();
  };
  if (sign === "free" || sign === "used") return drawLane(ctx, sign === "used", colours);
  if (sign === "bay" || sign === "out" || sign === "charger") {
    ctx.fillStyle = colours[sign === "charger" ? "bay" : sign];
    ctx.fillRect(2, 2, 14, 14);
    ctx.fillStyle = ctx.strokeStyle = colours[sign === "out" ? "outLine" : "bayLine"];
    if (sign === "charger") return bolt(ctx, 9, 9, 6);
    ctx.setLineDash([3, 2]);
    ctx.strokeRect(2.5, 2.5, 13, 13);
    return ctx.setLineDash([]);
  }
  if (sign === "battery") {
    ctx.fillStyle = colours.bar;
    ctx.fillRect(1, 7, 16, 4);
    ctx.fillStyle = colours.full;
    return ctx.fillRect(1, 7, 10, 4);
  }
  if (sign === "lift") {
    ctx.strokeStyle = colours.ink;
    ctx.setLineDash([4, 3]);
    ctx.strokeRect(2.5, 2.5, 13, 13);
    return ctx.setLineDash([]);
  }
  if (sign in DOES) return drawPicker(ctx, 9, 9, 6.5, sign, colours);
  ctx.fillStyle = colours[sign];
  if (sign === "person") return figure(ctx, 9, 9, 8);
  if (sign === "shut") return ctx.fillRect(0, 6, 18, 6);
  if (sign === "good" || sign === "pod" || sign === "none" || sign === "wall") return ctx.fillRect(3, 3, 12, 12);
  if (sign === "wait") {
    circle(9);
    ctx.fillStyle = colours.floor;
    circle(7);
    ctx.fillStyle = colours.empty;
    return circle(6);
  }
  circle(7);
  ctx.fillStyle = sign === "idle" ? colours.floor : colours.label;
  if (sign === "idle") circle(5);
  if (sign === "charging") bolt(ctx, 9, 9, 5.5);
  if (sign === "broken") cross(ctx, 9, 9, 3.5, colours.label);
  if (sign !== "loaded") return;
  ctx.strokeStyle = colours.label;
  ctx.lineWidth = 1.5;
  ctx.strokeRect(5, 5, 8, 8);
}

function drawLane(ctx, used, colours) {
  ctx.strokeStyle = ctx.fillStyle = used ? colours.soft : colours.aisle;
  ctx.lineWidth = 1.5;
  if (!used) ctx.setLineDash([4, 3]);
  ctx.beginPath();
  ctx.moveTo(0, 9);
  ctx.lineTo(18, 9);
  ctx.stroke();
  ctx.setLineDash([]);
  if (!used) return;
  ctx.beginPath();
  ctx.moveTo(14, 9);
  ctx.lineTo(6, 4.5);
  ctx.lineTo(6, 13.5);
  ctx.fill();
}

// What the colours of the heat map mean: steps that are the same for all floors.
function drawScale(box, colours, steps, shown) {
  box.hidden = !shown;
  if (box.hidden) return;
  const ends = steps.map((step) => `${100 * step}`), last = ends.length - 1;
  const words = colours.heat.map((_, i) => (i === last ? `over ${ends[i]} %` : `${ends[i]} to ${ends[i + 1]} %`));
  const parts = words.map((text, i) => element("span", {}, element("i", { style: `background: ${colours.heat[i]}; height: ${3 + 2.5 * i}px` }), text));
  box.replaceChildren(element("span", {}, "Share of time a robot waits here:"), ...parts, element("span", {}, `no colour: under ${ends[0]} %`));
}
