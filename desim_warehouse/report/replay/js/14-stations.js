// A table of stations and chargers: how much they were in use since the warm-up, who queues now, what was delivered.

class Stations {
  constructor(root, side, caption) {
    this.side = side;
    root.hidden = side.resources.length === 0;
    if (root.hidden) return;
    const table = root.appendChild(document.createElement("table"));
    table.createCaption().textContent = caption;
    const head = table.createTHead().insertRow();
    for (const text of ["", "in use", "queue", "delivered"]) {
      const cell = head.appendChild(document.createElement("th"));
      cell.textContent = text;
      cell.scope = "col";
    }
    const body = table.createTBody();
    this.rows = side.resources.map((one) => this.row(body, one));
  }

  row(body, one) {
    const row = body.insertRow(), name = row.appendChild(document.createElement("th")), many = one.number > 1 ? "s" : "";
    name.scope = "row";
    name.appendChild(document.createElement("bdi")).textContent = one.name;
    name.append(" ");
    const where = name.appendChild(document.createElement("small"));
    const parts = one.kind === "station" ? `server${many}` : `charger${many}`;
    where.textContent = `${this.side.name(one.node)}, ${one.number} ${parts}`;
    const used = row.insertCell(), bar = used.appendChild(document.createElement("span"));
    bar.className = `bar ${one.kind}`;
    const text = used.appendChild(document.createElement("span"));
    return { one, bar, text, queue: row.insertCell(), done: row.insertCell() };
  }

  draw(time) {
    for (const { one, bar, text, queue, done } of this.rows ?? []) {
      const used = one.utilisation(time), robots = one.queue.at(time);
      bar.style.setProperty("--used", `${100 * (used || 0)}%`);
      text.textContent = percent(used);
      queue.textContent = robots;
      queue.className = robots ? "some" : "";
      done.textContent = one.kind === "station" ? this.side.story.deliveredAt(one.node, time) : "";
    }
  }
}
