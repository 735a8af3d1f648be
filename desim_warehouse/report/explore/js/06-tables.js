// B beside A, and all designs: the texts that `desim compare` and `desim what-if` print.

const COLUMNS = ["B − A", "from", "to", "p", "verdict"];

function showDifferences(study, state) {
  const [a, b] = SIDES.map((side) => study.at(state[side]));
  const rows = study.indicators.map(({ name, label: title }, rank) => {
    const found = a === b ? null : study.differences[name][a][b];
    const cells = found ?? ["", "", "", "", a === b ? "the same design" : "no replication in common"];
    const row = element("tr", { "data-indicator": name, class: rank === state.indicator ? "now" : "" }, element("th", { scope: "row" }, title));
    for (const [rank, design] of [a, b].entries())
      row.append(element("td", { "data-name": SIDES[rank].toUpperCase() }, study.means[name][design]?.[3] ?? "–"));
    COLUMNS.forEach((name, rank) => row.append(element("td", { "data-name": name }, cells[rank])));
    return row;
  });
  byId("differences").tBodies[0].replaceChildren(...rows);
  const promise = study.promises[study.indicators[state.indicator].name][a];
  byId("promise").textContent = a === b || promise === null ? "" : `${study.statements[promise]}.`;
  byId("answer").textContent = a === b ? "A and B are the same design." : inWords(study, a, b);
}

// In which indicators B is better, worse, other, or not shown to differ, and how many runs would show it.
function inWords(study, a, b) {
  const found = { "B is better": [], "B is worse": [], "B is other": [], "Not shown to differ": [] };
  for (const { name, label: title, better } of study.indicators) {
    const row = study.differences[name][a][b];
    if (!row) continue;
    const less = row[0].startsWith("−"), differs = row[4].startsWith("differs");
    const kind = better === null ? "B is other" : less === (better === "less") ? "B is better" : "B is worse";
    const more = row[5] ? ` (about ${row[5]} runs of each would probably show it)` : "";
    found[differs ? kind : "Not shown to differ"].push(title.replace(/ \([^)]*\)$/, "") + more);
  }
  const said = Object.entries(found).filter(([, titles]) => titles.length).map(([kind, titles]) => `${kind}: ${titles.join("; ")}.`);
  return said.length ? said.join(" ") : "A and B have no replication in common.";
}

function showWrong(study, state) {
  const lines = SIDES.flatMap((side) => {
    const { wrong, failed, runs, error } = study.designs[study.at(state[side])];
    const all = failed ? [...wrong, `${failed} of ${runs} runs failed: ${error}`] : wrong;
    return all.map((text) => element("p", { class: side }, letter(side), ` ${text}`));
  });
  byId("wrong").replaceChildren(...lines);
}

class Designs {
  constructor(study) {
    this.study = study;
    const judged = study.designs.some(({ marks }) => marks), settled = study.designs[0].counted_from !== null;
    const heads = [...study.factors.map(({ head }) => head), ...study.indicators.map(({ label: title }) => title)];
    const aim = study.target;
    heads.push(...(aim ? [aim.words] : []), ...(settled ? ["counted from"] : []), "runs");
    const head = element("tr", {}, ...heads.map((text, rank) => element("th", { scope: "col", ...(rank < study.factors.length ? { class: "words" } : {}) }, text)));
    if (judged) head.append(element("th", { scope: "col", class: "words" }, "verdict"));
    byId("designs").tHead.append(head);
    this.rows = study.designs.map(({ levels, runs, failed, marks, met, counted_from: from }, design) => {
      const row = element("tr", {}, ...study.factors.map((factor, rank) => element("th", { scope: "row", class: "words" }, factor.levels[levels[rank]])));
      for (const { name } of study.indicators) row.append(element("td", {}, study.means[name][design]?.[3] ?? "–"));
      if (aim) row.append(element("td", {}, met));
      if (settled) row.append(element("td", {}, from));
      row.append(element("td", {}, failed ? `${runs} (${failed} failed)` : `${runs}`));
      if (judged) row.append(element("td", { class: "words" }, marks));
      return row;
    });
    byId("designs").tBodies[0].append(...this.rows);
  }

  show(state) {
    this.rows.forEach((row) => (row.className = ""));
    for (const side of [...SIDES].reverse()) this.rows[this.study.at(state[side])].className = side;
  }
}
