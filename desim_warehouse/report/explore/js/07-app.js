// Puts the parts together; whatever is chosen, everything is shown anew, and stands in the address.

function addressOf(state, study) {
  const sides = SIDES.map((side) => `${side}=${state[side].join(".")}`).join("&");
  return `#${sides}&i=${encodeURIComponent(study.indicators[state.indicator].name)}&over=${state.over}`;
}

// What an address says, as far as the study has it.
function chosenBy(hash, study) {
  const said = new URLSearchParams(hash.slice(1)), found = {};
  for (const side of SIDES) {
    const levels = said.get(side)?.split(".").map(Number);
    if (levels && study.at(levels) !== undefined) found[side] = levels;
  }
  const indicator = study.indicators.findIndex(({ name }) => name === said.get("i")), over = Number(said.get("over") ?? -1);
  if (indicator >= 0) found.indicator = indicator;
  if (study.factors[over]) found.over = over;
  return found;
}

function begin() {
  const study = new Study(JSON.parse(byId("study").textContent));
  const [a, b] = study.start.map((design) => study.designs[design].levels);
  const state = { a, b, indicator: 0, over: 0, ...chosenBy(location.hash, study) };
  byId("answers").append(...study.answer.map((line) => element("li", {}, line)));
  byId("model").textContent = study.model;
  byId("name").textContent = study.name;
  byId("description").textContent = study.description;
  byId("summary").textContent = study.summary;
  byId("all-wrong").append(...study.wrong.map((line) => element("li", {}, line)));
  byId("facts").append(...study.facts.flatMap(([name, value]) => [element("dt", {}, name), element("dd", {}, value)]));
  byId("again").hidden = !study.command;
  byId("command").append(...study.command.split(" ").flatMap((word) => [element("span", {}, word), " "])); // no break within --options
  const designs = new Designs(study), curves = new Curves(study, state), controls = new Controls(study, state, show);

  function draw() {
    curves.show();
    showRuns(study, state);
  }

  function show() {
    controls.show();
    showWrong(study, state);
    showDifferences(study, state);
    designs.show(state);
    draw();
    if (location.protocol !== "about:") history.replaceState(null, "", addressOf(state, study)); // a frame in a notebook has none
  }

  show();
  new ResizeObserver(draw).observe(byId("curves"));
}

try {
  begin();
} catch (error) {
  byId("problem").hidden = false;
  byId("problem").textContent = `This page cannot be shown: ${error.message}. It needs a browser of 2021 or later.`;
  throw error;
}
