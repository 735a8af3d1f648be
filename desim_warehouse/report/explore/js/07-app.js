// Puts the parts together; whatever is chosen, everything is shown anew.

function begin() {
  const study = new Study(JSON.parse(byId("study").textContent));
  const [a, b] = study.start.map((design) => study.designs[design].levels);
  const state = { a, b, indicator: 0, over: 0 };
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
