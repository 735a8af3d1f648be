// What robots waited for, most time first: sums over the run by the root of each wait; a click goes to the longest wait.

class LostTime {
  constructor(root, sides, controls) {
    this.controls = controls;
    const found = sides.flatMap((side) => side.header.lost.map((one) => ({ side, ...one })));
    root.hidden = found.length === 0;
    if (root.hidden) return;
    const table = element("table"), body = table.createTBody();
    found.forEach((one, number) => this.row(body, one, number));
    const list = element("div", { class: "list", tabindex: 0, role: "group", "aria-label": "Waits, most time first" }, table);
    root.append(element("h2", {}, "What robots waited for, and that part of their time"));
    root.append(list);
  }

  row(body, one, number) {
    const row = body.insertRow(), many = this.controls.of(one.side);
    const words = element("button", { id: `lost-${number}`, type: "button", class: "link" }, element("bdi", {}, `${many}${one.words}`));
    row.append(element("th", { scope: "row" }, words), element("td", {}, one.time));
    let next = 0;
    words.disabled = one.longest.length === 0;
    words.addEventListener("click", () => this.controls.waitFor(one, next++ % one.longest.length));
  }
}
