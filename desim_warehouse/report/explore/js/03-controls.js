// A slider or a select for each factor, once for A and once for B.

const SIDES = ["a", "b"];
const MOST_TICK_LETTERS = 26; // of all labels below a slider together; with more, only its ends have one

function control(study, factor, side, chosen, changed) {
  const { key, levels, numbers } = study.factors[factor], id = `${side}-${factor}`;
  const field = numbers ? slider(levels) : element("select", {}, ...levels.map((text, level) => new Option(text, level)));
  const now = element("output", { for: id });
  const show = () => {
    field.value = chosen()[factor];
    if (numbers) field.setAttribute("aria-valuetext", levels[field.value]);
    now.textContent = numbers ? levels[field.value] : "";
  };
  field.id = id;
  field.dataset.key = key;
  field.addEventListener("input", () => changed(Number(field.value)));
  field.setAttribute("aria-label", `${side.toUpperCase()}: ${key}`);
  const made = element("div", { class: `side ${side}` }, element("label", { for: id }, letter(side), now), field);
  if (numbers) made.append(ticks(levels));
  return { made, show };
}

function slider(levels) {
  return element("input", { type: "range", min: 0, max: levels.length - 1, step: 1 });
}

function ticks(levels) {
  const every = levels.join("").length <= MOST_TICK_LETTERS, last = levels.length - 1;
  const texts = levels.map((text, level) => (every || level === 0 || level === last ? text : ""));
  return element("div", { class: "ticks", "aria-hidden": "true" }, ...texts.map((text) => element("span", {}, text)));
}

class Controls {
  constructor(study, state, changed) {
    this.state = state;
    this.shown = [];
    study.factors.forEach((factor, rank) => {
      const sides = element("div", { class: "sides" });
      for (const side of SIDES) {
        const { made, show } = control(study, rank, side, () => state[side], (level) => {
          state[side] = changedAt(state[side], rank, level);
          changed();
        });
        sides.append(made);
        this.shown.push(show);
      }
      byId("controls").append(element("fieldset", {}, element("legend", {}, factor.label), sides));
    });
    byId("swap").addEventListener("click", () => {
      [state.a, state.b] = [state.b, state.a];
      changed();
    });
    study.indicators.forEach(({ label }, rank) => byId("indicator").add(new Option(label, rank)));
    study.factors.forEach(({ label }, rank) => byId("over").add(new Option(label, rank)));
    for (const name of ["indicator", "over"])
      byId(name).addEventListener("input", (event) => {
        state[name] = Number(event.target.value);
        changed();
      });
  }

  show() {
    for (const show of this.shown) show();
    for (const name of ["indicator", "over"]) byId(name).value = this.state[name];
  }
}
