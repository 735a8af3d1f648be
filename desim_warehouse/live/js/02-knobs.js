// Sliders for numbers, lists for words, with marks: by estimate, today, pinned.

const KNOWN = { met: "met", "not met": "not-met", overloaded: "not-met", drained: "not-met", fails: "not-met", known: "" };

class Knobs {
  constructor(root, offers, moved) {
    this.offers = offers;
    this.moved = moved;
    this.levels = Object.fromEntries(offers.map(({ key, values, today }) => [key, values[today ?? 0]]));
    this.parts = offers.map((offer, rank) => this.make(root, offer, rank));
  }

  make(root, offer, rank) {
    const number = offer.kind === "number", last = offer.values.length - 1, name = `knob-${rank}`;
    const output = element("output", { id: `${name}-value`, for: name });
    const field = number ? element("input", { id: name, type: "range", min: 0, max: last, step: 1 }) : element("select", { id: name });
    if (!number) field.append(...offer.texts.map((text, place) => element("option", { value: place }, text)));
    const rail = element("div", { class: "rail", "aria-hidden": "true" });
    const head = element("div", { class: "head" }, element("label", { for: name }, offer.label), ...(number ? [output] : []));
    const knob = element("div", { class: "knob", "data-key": offer.key }, head, field, ...(number ? [rail] : []));
    field.addEventListener("input", () => {
      this.levels[offer.key] = offer.values[Number(field.value)];
      this.wrong(null);
      this.last = offer.key;
      this.moved();
    });
    root.append(knob);
    return { offer, field, output, rail, knob, number };
  }

  set(levels) {
    Object.assign(this.levels, levels);
  }

  // Outline the slider whose value was refused; none for null.
  wrong(key) {
    for (const { offer, knob } of this.parts) knob.classList.toggle("wrong", offer.key === key);
  }

  show(needed, pinned, tried) {
    for (const { offer, field, output, rail, number } of this.parts) {
      const { key, values, texts, today } = offer, at = values.indexOf(this.levels[key]);
      field.value = at;
      if (!number) continue;
      const then = pinned ? values.indexOf(pinned[key]) : -1, differs = then >= 0 && then !== at;
      const beside = differs ? [element("small", {}, `pinned ${texts[then]}`)] : [];
      output.replaceChildren(...beside, texts[at]);
      field.setAttribute("aria-valuetext", `${texts[at]}${differs ? `, pinned ${texts[then]}` : ""}`);
      const hand = needed?.[key];
      const marks = this.worn(key, values, tried);
      if (today !== null) marks.push({ at: today, text: "today" });
      if (hand !== undefined) marks.push({ at: placeOf(values, hand), text: `by estimate ${hand}`, kind: "hand" });
      if (differs) marks.push({ at: then, text: "", kind: "pinned" });
      rail.replaceChildren(...marks.map((mark) => this.mark(mark, values.length - 1)));
    }
  }

  // What is known of the values of a slider, all others as they are now: met, not met or open.
  worn(key, values, tried) {
    const like = (levels) => Object.keys(this.levels).every((other) => other === key || levels[other] === this.levels[other]);
    return tried.filter(({ levels }) => like(levels)).map(({ levels, verdict }) => (
      { at: values.indexOf(levels[key]), text: "", kind: `worn ${KNOWN[verdict] ?? "unclear"}` }));
  }

  mark({ at, text, kind = "" }, last) {
    const part = last > 0 ? at / last : 0, side = part < 0.15 ? "left" : part > 0.85 ? "right" : "";
    return element("span", { class: `${kind} ${side}`, style: `left: ${100 * part}%` }, text);
  }
}

// Where a number lies among ascending ones, between two of them as a fraction of their ranks.
function placeOf(values, number) {
  const above = values.findIndex((value) => value >= number);
  if (above < 0) return values.length - 1;
  if (above === 0 || values[above] === number) return above;
  return above - (values[above] - number) / (values[above] - values[above - 1]);
}
