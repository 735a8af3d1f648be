// What robots waited for, most time first: sums over the run by the root of each wait; a click goes to the longest wait.

const FILTERED = 8; // roots from which on a field narrows the list

class LostTime {
  constructor(root, sides, controls) {
    this.controls = controls;
    const found = sides.flatMap((side) => side.header.lost.map((one) => ({ side, ...one })));
    root.hidden = found.length === 0;
    if (root.hidden) return;
    const table = element("table"), body = table.createTBody();
    this.rows = found.map((one, number) => this.row(body, one, number));
    const list = element("div", { class: "list", tabindex: 0, role: "region", "aria-label": "What robots waited for" }, table);
    root.append(element("h2", {}, "What robots waited for"));
    if (found.length >= FILTERED) root.append(this.filter());
    root.append(list);
  }

  row(body, one, number) {
    const row = body.insertRow(), many = this.controls.of(one.side);
    const words = element("button", { id: `lost-${number}`, type: "button", class: "link" }, element("bdi", {}, `${many}${one.words}`));
    row.append(element("th", { scope: "row" }, words), element("td", {}, one.time));
    let next = 0;
    words.disabled = one.longest.length === 0;
    words.addEventListener("click", () => this.controls.waitFor(one, next++ % one.longest.length));
    return { row, text: one.words.toLowerCase() };
  }

  filter() {
    const field = element("input", { id: "lost-words", type: "search", placeholder: "only those with ...", "aria-label": "Only waits with these words" });
    field.addEventListener("input", () => {
      const wanted = field.value.trim().toLowerCase();
      for (const { row, text } of this.rows) row.hidden = !text.includes(wanted);
    });
    return field;
  }
}
