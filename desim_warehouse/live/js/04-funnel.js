// The indicator run by run: dots, their mean with its interval; the target, and the pinned design.

function drawFunnel(svg, answer, aim, target, runs) {
  const { values, measured, pinned_at: pin } = answer, known = values.filter((value) => value !== null);
  if (!known.length) return svg.replaceChildren();
  const found = measured[0] ?? null, ends = found && found.low !== null ? [found.low, found.high] : [];
  const spread = Math.max(...known) - Math.min(...known) || Math.abs(known[0]) / 20 || 1;
  const near = ends.filter((end) => Math.abs(end - found.mean) <= 3 * spread);
  const { y, left, right, bottom } = frame(svg, [...known, ...near, ...(target === null ? [] : [target]), ...(pin ? pin.slice(0, 1) : [])]);
  const most = Math.max(runs, values.length), wide = right - left - (pin ? 34 : 0);
  const x = (i) => left + ((i + 0.5) / most) * wide;
  const clip = (value) => Math.min(Math.max(y(value), 20), bottom);
  if (ends.length) svg.append(shape("path", { class: "band", d: `M${left} ${clip(ends[0])}H${left + wide}V${clip(ends[1])}H${left}Z` }));
  if (found) svg.append(shape("path", { class: "mean", d: `M${left} ${clip(found.mean)}H${left + wide}` }));
  values.forEach((value, i) => {
    if (value !== null) svg.append(shape("circle", { class: "dot", cx: x(i), cy: y(value), r: 2.6 }));
  });
  if (target !== null) {
    svg.append(shape("path", { class: "aim", d: `M${left} ${y(target)}H${right}` }));
    svg.append(shape("text", { x: left + wide, y: y(target) - 5, "text-anchor": "end" }, `target ${short(target)} ${aim.unit}`));
  }
  if (pin) {
    const at = right - 14;
    svg.append(shape("path", { class: "pinned", d: `M${at} ${clip(pin[1] ?? pin[0])}V${clip(pin[2] ?? pin[0])}` }), shape("circle", { class: "pinned", cx: at, cy: clip(pin[0]), r: 4 }));
    svg.append(shape("text", { class: "soft", x: right, y: 14, "text-anchor": "end" }, "pinned"));
  }
  svg.append(shape("text", { class: "soft", x: left, y: bottom + 17 }, "1"), shape("text", { class: "soft", x: left + wide, y: bottom + 17, "text-anchor": "end" }, `${most} run${most === 1 ? "" : "s"}`));
  svg.setAttribute("aria-label", found ? `${found.label}: ${found.text}` : "");
}
