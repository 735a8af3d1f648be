// Axes of a figure in pixels, and a call that is refused.

const AROUND = { left: 58, right: 16, top: 30, bottom: 44 };
const TICKS = 6;

class RefusedError extends Error {
  constructor(status, problems) {
    super(problems.join("\n"));
    this.status = status;
  }
}

function shape(tag, attributes = {}, text = null) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== null) made.textContent = text;
  return made;
}

const short = (value) => value.toLocaleString("en", { maximumSignificantDigits: 4 });

// Round numbers that span `low` to `high`.
function rounds(low, high) {
  if (low === high) [low, high] = low > 0 ? [low / 2, low] : [low, low + 1]; // never beyond 100 %
  const rough = (high - low) / TICKS, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].find((factor) => factor * power >= rough) * power;
  const first = Math.floor(low / step + 1e-9), last = Math.ceil(high / step - 1e-9);
  return Array.from({ length: last - first + 1 }, (_, i) => (first + i) * step);
}

// A figure's frame with its vertical axis; `y` turns a value into pixels.
function frame(svg, values) {
  const width = svg.clientWidth, height = svg.clientHeight;
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.replaceChildren();
  const marks = rounds(Math.min(...values), Math.max(...values));
  const low = marks[0], high = marks.at(-1), bottom = height - AROUND.bottom;
  const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - AROUND.top);
  for (const mark of marks) {
    svg.append(shape("path", { class: "grid", d: `M${AROUND.left} ${y(mark)}H${width - AROUND.right}` }));
    svg.append(shape("text", { class: "soft", x: AROUND.left - 6, y: y(mark) + 4, "text-anchor": "end" }, short(mark)));
  }
  return { y, left: AROUND.left, right: width - AROUND.right, bottom };
}
