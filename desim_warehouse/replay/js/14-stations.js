// A table of stations and chargers: how much they were in use since the warm-up, who queues now, what was delivered.

// A text that may go on in the next line after an underscore, as names of imported plants are long.
function parted(text) {
  return text.split(/(?<=_)/).flatMap((part, i) => (i ? [element("wbr"), part] : [part]));
}

class Stations {
  constructor(root, side, caption, go) {
    this.side = side;
    this.go = go;
    root.hidden = side.resources.length === 0;
    if (root.hidden) return;
    const table = root.appendChild(element("table"));
    table.createCaption().textContent = caption;
    const head = table.createTHead().insertRow();
    head.append(...["where", "in use", "queue", "delivered"].map((text) => element("th", { scope: "col" }, text)));
    const body = table.createTBody();
    this.rows = side.resources.map((one, number) => this.row(body, one, number));
  }

  row(body, one, number) {
    const row = body.insertRow();
    const where = `${this.side.name(one.node)}, ${one.number} ${one.one}${one.number > 1 ? "s" : ""}`;
    const name = element("button", { id: `place-${this.side.letter}-${number}`, type: "button", class: "link", title: "Show it on the floor" }, element("bdi", {}, ...parted(one.name)));
    name.addEventListener("click", () => this.go(this.side, number));
    row.append(element("th", { scope: "row" }, name, " ", element("small", {}, ...parted(where))));
    const bar = element("span", { class: `bar ${one.kind}` }), text = element("span");
    row.insertCell().append(bar, text);
    return { one, bar, text, queue: row.insertCell(), done: row.insertCell() };
  }

  // In use and delivered up to one time, queues at another.
  draw(upTo, time) {
    for (const { one, bar, text, queue, done } of this.rows ?? []) {
      const used = one.utilisation(upTo), robots = one.queue.at(time);
      bar.style.setProperty("--used", `${100 * (used || 0)}%`);
      text.textContent = percent(used);
      queue.textContent = robots;
      queue.className = robots ? "some" : "";
      done.textContent = one.kind === "station" ? grouped(this.side.story.deliveredAt(one.node, upTo)) : "";
    }
  }
}
