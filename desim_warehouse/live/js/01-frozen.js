// Answers that are all in the page: asked as the server is.

class Frozen {
  constructor(data) {
    Object.assign(this, data);
  }

  async ask(path, body) {
    if (path === "/api/model") return this.about;
    const same = ({ levels }) => this.about.knobs.every(({ key }) => levels[key] === body.levels[key]);
    const found = this.designs.find(([asked]) => same(asked));
    if (!found) throw new RefusedError(422, ["It is not on this page."]);
    return found[0];
  }

  async listen(path, signal, tell) {
    const { pathname, searchParams } = new URL(path, "http://page/");
    const at = (id) => this.designs.findIndex(([asked]) => asked.id === id);
    const here = at(pathname.split("/")[3]), [, answer] = this.designs[here], then = at(searchParams.get("pinned"));
    tell({ ...answer, tried: this.tried, ...(then >= 0 && then !== here ? this.beside(answer, here, then) : {}) });
  }

  beside(answer, here, then) {
    const [asked, pinned] = this.designs[then], [first] = pinned.measured, difference = this.differences[then][here];
    const more = [...answer.more, `Pinned: ${first ? pinned.sentence : asked.words}`];
    if (difference) more.push(`Difference, run by run: ${difference}.`);
    return { more, pinned: asked.id, pinned_at: first ? [first.mean, first.low, first.high] : null };
  }
}
