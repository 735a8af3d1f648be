// The indicator run by run: dots, their mean, the usual interval; the target, and the pinned design.

function drawFunnel(svg, answer, aim, target, runs) {
  const { values, band, measured, pinned_at: pin } = answer, known = values.filter((value) => value !== null);
  const ends = band.slice(2).flatMap((one) => (one ? one.slice(1) : [])).filter((end) => end !== null);
  const spread = Math.max(...known) - Math.min(...known) || Math.abs(known[0] ?? 1) / 20 || 1;
  const middle = known.reduce((a, b) => a + b, 0) / (known.length || 1);
  const near = ends.filter((end) => Math.abs(end - middle) <= 3 * spread);
  const all = [...known, ...near, ...(target === null ? [] : [target]), ...(pin ? pin.slice(0, 1) : [])];
  if (!known.length) return svg.replaceChildren();
  const { y, left, right, bottom } = frame(svg, all, "");
  const most = Math.max(runs, values.length), wide = right - left - (pin ? 34 : 0);
  const x = (i) => left + ((i + 0.5) / most) * wide;
  const clip = (value) => Math.min(Math.max(y(value), 20), bottom);
  const some = band.map((one, i) => [x(i), one]).slice(2).filter(([, one]) => one && one[1] !== null);
  if (some.length > 1) {
    const upper = some.map(([at, one]) => `${at} ${clip(one[2])}`), lower = some.map(([at, one]) => `${at} ${clip(one[1])}`).reverse();
    svg.append(shape("path", { class: "band", d: `M${[...upper, ...lower].join("L")}Z` }));
  }
  values.forEach((value, i) => {
    if (value !== null) svg.append(shape("circle", { class: "dot", cx: x(i), cy: y(value), r: 2.6 }));
  });
  const means = band.map((one, i) => (one ? `${x(i)} ${clip(one[0])}` : null)).filter(Boolean);
  if (means.length > 1) svg.append(shape("path", { class: "mean", d: `M${means.join("L")}` }));
  if (target !== null) {
    svg.append(shape("path", { class: "aim", d: `M${left} ${y(target)}H${right}` }));
    svg.append(shape("text", { x: left + wide, y: y(target) - 5, "text-anchor": "end" }, `target ${short(target)} ${aim.unit}`));
  }
  if (pin) {
    const at = right - 14;
    svg.append(shape("path", { class: "pinned", d: `M${at} ${clip(pin[1] ?? pin[0])}V${clip(pin[2] ?? pin[0])}` }), shape("circle", { class: "pinned", cx: at, cy: clip(pin[0]), r: 4 }));
    svg.append(shape("text", { class: "soft", x: right, y: 14, "text-anchor": "end" }, "pinned"));
  }
  svg.append(shape("text", { class: "soft", x: left, y: bottom + 17 }, "1"), shape("text", { class: "soft", x: left + wide, y: bottom + 17, "text-anchor": "end" }, `${most} runs`));
  svg.setAttribute("aria-label", measured[0] ? `${measured[0].label}: ${measured[0].text}` : "");
}
