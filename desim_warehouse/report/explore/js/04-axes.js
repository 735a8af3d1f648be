// Axes of a figure in pixels.

const AROUND = { left: 58, right: 16, top: 30, bottom: 44 };
const TICKS = 6;
const NARROW = 56; // pixels for a word below an axis from which on it lies level
const SLANTED = 14; // letters of a word that does not
const LOWER = 44; // pixels more below an axis with such words

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
function frame(svg, values, title, lower = 0) {
  const width = svg.clientWidth, height = svg.clientHeight;
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  svg.replaceChildren();
  const marks = rounds(Math.min(...values), Math.max(...values));
  const low = marks[0], high = marks.at(-1), bottom = height - AROUND.bottom - lower;
  const y = (value) => bottom - ((value - low) / (high - low)) * (bottom - AROUND.top);
  for (const mark of marks) {
    svg.append(shape("path", { class: "grid", d: `M${AROUND.left} ${y(mark)}H${width - AROUND.right}` }));
    svg.append(shape("text", { class: "soft", x: AROUND.left - 6, y: y(mark) + 4, "text-anchor": "end" }, short(mark)));
  }
  if (title) svg.append(shape("text", { x: 0, y: 14 }, title));
  return { y, left: AROUND.left, right: width - AROUND.right, bottom, height };
}

// Where the levels of a factor stand: numbers to scale, words side by side.
function places(factor, { left, right }) {
  const { numbers, levels } = factor, inset = numbers ? 20 : (right - left) / levels.length / 2;
  const from = left + inset, to = right - inset;
  if (!numbers) return levels.map((_, level) => from + (level * (to - from)) / Math.max(levels.length - 1, 1));
  const low = numbers[0], high = numbers.at(-1);
  return numbers.map((number) => from + ((number - low) / (high - low)) * (to - from));
}

// Whether words below an axis are so many that they slant.
function slants({ numbers, levels }, svg) {
  return !numbers && (svg.clientWidth - AROUND.left - AROUND.right) / levels.length < NARROW && levels.some((text) => text.length > 4);
}

// Labels below an axis: cut to the room that there is, or slanted, left out where numbers would meet.
function label(svg, factor, where, { right, bottom, height }) {
  let free = -Infinity;
  const slanted = slants(factor, svg);
  factor.levels.forEach((text, level) => {
    if (slanted) {
      const at = `translate(${where[level] + 4} ${bottom + 12}) rotate(-40)`, short = text.length > SLANTED ? `${text.slice(0, SLANTED - 1)}…` : text;
      const word = shape("text", { class: "soft level", transform: at, "text-anchor": "end" }, short);
      if (short !== text) word.append(shape("title", {}, text));
      return svg.append(word);
    }
    const word = svg.appendChild(shape("text", { class: "soft level", x: where[level], y: bottom + 17, "text-anchor": "middle" }, text));
    const room = factor.numbers ? Infinity : where.length > 1 ? where[1] - where[0] - 8 : right;
    for (let cut = text; word.getComputedTextLength() > room && cut; ) word.textContent = `${(cut = cut.slice(0, -1))}…`;
    const half = word.getComputedTextLength() / 2;
    if (where[level] - half < free) return word.remove();
    free = where[level] + half + 6;
    if (word.textContent !== text) word.append(shape("title", {}, text));
  });
  svg.append(shape("text", { x: right, y: height - 6, "text-anchor": "end" }, factor.label));
}
