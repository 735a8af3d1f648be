// Curves over one factor, the others held as in A and as in B; each mean with its interval.

const APART = 4; // pixels between the intervals of two curves

class Curves {
  constructor(study, state) {
    this.study = study;
    this.state = state;
    this.svg = byId("curve");
  }

  show() {
    const { study, state, svg } = this, factor = study.factors[state.over];
    const { name, label: title } = study.indicators[state.indicator], means = study.means[name];
    const aim = study.target?.name === name ? [study.target.value] : [];
    const every = [...means.flatMap((mean) => mean?.slice(0, 3) ?? []).filter((value) => value !== null), ...aim];
    const axes = frame(svg, every, title, slants(factor, svg) ? LOWER : 0), where = places(factor, axes);
    for (const value of aim) this.aim(axes, value);
    label(svg, factor, where, axes);
    const held = SIDES.map((side) => study.words(state[side], state.over)), one = held[0] === held[1];
    const drawn = one ? [["both", state.a, 0]] : [["a", state.a, -APART / 2], ["b", state.b, APART / 2]];
    for (const [kind, levels, off] of drawn) {
      const points = study.along(levels, state.over).map((design, level) => ({
        design, x: where[level] + off, mean: means[design],
        sides: SIDES.filter((side) => (one || side === kind) && state[side][state.over] === level),
      }));
      this.curve(points, kind, axes.y, name);
    }
    this.legend(held, one);
  }

  // A line at the target; its words stand below the curve, where they hide no point.
  aim({ left, right, y }, value) {
    this.svg.append(shape("path", { class: "target", d: `M${left} ${y(value)}H${right}` }));
  }

  curve(points, kind, y, name) {
    const { svg, study } = this;
    const step = ({ x, mean }, i) => (mean ? `${points[i - 1]?.mean ? "L" : "M"}${x} ${y(mean[0])}` : "");
    const path = points.map(step).join("");
    if (study.factors[this.state.over].numbers) svg.append(shape("path", { class: `line ${kind}`, d: path }));
    for (const { x, mean: [middle, low, high], design, sides } of points.filter((point) => point.mean)) {
      const classes = `${sides[0] ?? kind} ${sides.length ? "chosen" : ""}`;
      if (low !== null)
        svg.append(shape("path", { class: `bar ${sides[0] ?? kind}`, d: `M${x - 4} ${y(low)}h8m-4 0V${y(high)}m-4 0h8` }));
      const at = { class: `mark ${classes}`, "data-design": design };
      const mark = study.designs[design].marks
        ? shape("path", { ...at, d: `M${x} ${y(middle) - 8}l8 14h-16z` })
        : shape("circle", { ...at, cx: x, cy: y(middle), r: sides.length ? 6 : 4 });
      mark.append(shape("title", {}, study.said(name, design)));
      svg.append(mark);
      if (!sides.length) continue;
      const beside = sides.join() === "a" ? { x: x - 9, "text-anchor": "end" } : { x: x + 9 };
      svg.append(shape("text", { class: `chosen ${sides[0]}`, y: y(middle) - 8, ...beside }, sides.join(" ").toUpperCase()));
    }
  }

  legend(held, one) {
    const rest = this.study.factors.length > 1, { better } = this.study.indicators[this.state.indicator];
    const lines = one ? (rest ? [element("span", {}, letter("a"), letter("b"), ` ${held[0]}`)] : [])
      : SIDES.map((side, rank) => element("span", {}, letter(side), ` ${held[rank]}`));
    const { target } = this.study;
    if (target?.name === this.study.indicators[this.state.indicator].name) lines.push(element("span", {}, `╌╌ target: ${target.words}`));
    if (this.study.designs.some(({ marks }) => marks)) lines.push(element("span", {}, "△ something is wrong with the design"));
    if (better) lines.push(element("span", {}, `${better === "less" ? "Less" : "More"} is better`));
    byId("legend").replaceChildren(...lines);
  }
}

// Every replication of A beside the same of B.
function showRuns(study, state) {
  const svg = byId("runs"), { name } = study.indicators[state.indicator];
  const [ours, theirs] = SIDES.map((side) => study.values[name][study.at(state[side])]);
  const pairs = ours.map((value, rank) => [value, theirs[rank] ?? null]).filter((pair) => pair.every((value) => value !== null));
  const sides = { levels: ["A", "B"], numbers: null, label: "" };
  if (!pairs.length) return svg.replaceChildren(shape("text", { x: 0, y: 14 }, "No replication in both."));
  const axes = frame(svg, pairs.flat(), ""), where = places(sides, axes);
  label(svg, sides, where, axes);
  for (const pair of pairs) {
    svg.append(shape("path", { class: "pair", d: `M${where[0]} ${axes.y(pair[0])}L${where[1]} ${axes.y(pair[1])}` }));
    pair.forEach((value, rank) => svg.append(shape("circle", { class: `run ${SIDES[rank]}`, cx: where[rank], cy: axes.y(value), r: 3 })));
  }
}
