// The page: what is asked, what was answered, and in which state it is.

const SETTLE = 250; // milliseconds without a move after which a design is simulated
const RETRY = 2000;
const MARKS = { met: "✓", "not met": "✗", overloaded: "✗", drained: "✗", fails: "✗", open: "?" };

class Live {
  constructor(feed, about) {
    Object.assign(this, { feed, about, answer: null, asked: null, pinned: null, state: "stale", more: 0, stream: null });
    this.target = about.target?.value ?? null;
    this.knobs = new Knobs(byId("knobs"), about.knobs, () => this.move());
    this.frozen = feed instanceof Frozen;
    document.body.classList.toggle("frozen", this.frozen);
    if (this.frozen) this.begin(feed);
    else this.watch = new Watch(about.colours);
    if (about.target && !this.frozen) this.aim(about.target);
    byId("name").textContent = document.title = about.name;
    byId("funnel-head").textContent = `${about.label}${about.unit ? ` (${about.unit})` : ""}, run by run`;
    byId("promise").textContent = about.promise;
    byId(this.frozen ? "command" : "folder").textContent = about.folder;
    byId("kept").hidden = this.frozen;
    byId("again").hidden = !this.frozen || !about.folder;
    byId("pin").addEventListener("click", () => this.pin());
    byId("share").addEventListener("click", () => this.share());
    byId("stop").addEventListener("click", () => this.stopOrGoOn());
    document.addEventListener("keydown", (event) => this.key(event));
    new ResizeObserver(() => this.draw()).observe(byId("funnel"));
    this.move();
  }

  // The designs that a page without a server begins with, and the sentences above them.
  begin({ designs, start, pinned, answers }) {
    this.knobs.set(designs[start][0].levels);
    if (pinned !== null) this.pinned = { id: designs[pinned][0].id, levels: designs[pinned][0].levels };
    byId("answers").replaceChildren(...answers.map((line) => element("li", {}, line)));
    byId("answers").hidden = !answers.length;
  }

  aim({ label: title, relation, least, most, step, unit }) {
    const words = { ">=": "at least", "<=": "at most", ">": "more than", "<": "less than" };
    const field = element("input", { id: "target", type: "range", min: least, max: most, step });
    const output = element("output", { for: "target" });
    const head = element("div", { class: "head" }, element("label", { for: "target" }, `Target: ${title}`), output);
    const show = () => (output.textContent = `${words[relation]} ${short(this.target)} ${unit}`.trim());
    field.value = this.target;
    field.addEventListener("input", () => {
      this.target = Number(field.value);
      show();
      this.later(() => this.listen());
    });
    show();
    byId("knobs").append(element("div", { class: "knob" }, head, field));
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey || event.target.closest("input, select, button, summary")) return;
    if (event.key.toLowerCase() === "p") byId("pin").click();
    else if (event.key === " ") byId("stop").click();
    else return;
    event.preventDefault();
  }

  later(act) {
    clearTimeout(this.clock);
    this.clock = setTimeout(act, this.frozen ? 0 : SETTLE);
  }

  // A slider moved: what was known is old, the quick estimate comes at once, the runs once the slider rests.
  move() {
    this.stream?.abort();
    this.state = "stale";
    this.more = 0;
    this.settled = false;
    this.show();
    this.byHand();
    this.later(() => {
      this.settled = true;
      if (!this.asking) this.listen();
    });
  }

  // Ask for the latest levels, one call at a time.
  async byHand() {
    if (this.asking) return (this.again = true);
    this.asking = true;
    do {
      this.again = false;
      try {
        const asked = await this.feed.ask("/api/design", { levels: this.knobs.levels });
        if (!this.again) this.calculated(asked);
      } catch (error) {
        if (!this.again) this.failed(error);
      }
    } while (this.again);
    this.asking = false;
    if (this.settled) this.listen();
  }

  calculated(asked) {
    this.asked = asked;
    this.refused = null;
    this.note("");
    this.show();
  }

  // A design that is refused leaves the last good answer as it is; without a server the page stays readable.
  failed(error) {
    if (error instanceof RefusedError && error.status === 422) {
      this.refused = error;
      this.state = "refused";
      this.knobs.wrong(this.knobs.last);
      this.note(`${this.frozen ? "" : "This option cannot run. "}${error.message}\nThe answer below is of the last option that is.`);
      return this.show();
    }
    const gone = error instanceof RefusedError && error.status === 401 ? "This link has expired: open the address that desim serve printed." : "The page resumes when the simulator is back.";
    this.state = "offline";
    this.note(`Connection lost. This is the last answer. ${gone}`);
    this.show();
    clearTimeout(this.clock);
    this.clock = setTimeout(() => this.back(), RETRY);
  }

  async back() {
    if (this.pinned) await this.feed.ask("/api/design", { levels: this.pinned.levels }).catch(() => {});
    this.settled = true;
    this.byHand();
  }

  async listen() {
    if (!this.asked || this.refused) return;
    this.stream?.abort();
    const stream = (this.stream = new AbortController());
    const query = new URLSearchParams({ runs: this.more, floor: 1 });
    if (this.pinned) query.set("pinned", this.pinned.id);
    if (this.target !== null) query.set("target", this.target);
    try {
      await this.feed.listen(`/api/design/${this.asked.id}/events?${query}`, stream.signal, (answer) => this.take(answer));
    } catch (error) {
      if (!stream.signal.aborted) this.failed(error);
    }
  }

  take(answer) {
    if (answer.id !== this.asked.id) return;
    this.waits = answer.n === 0;
    this.answer = this.waits && this.answer ? { ...this.answer, tried: answer.tried } : answer;
    this.state = answer.done ? "done" : "running";
    if (answer.floor && this.shown !== answer.id) this.play(answer.id);
    this.show();
  }

  async play(id) {
    this.shown = id;
    try {
      const floor = await this.feed.ask(`/api/design/${id}/floor`);
      if (this.asked.id !== id) return;
      await this.watch.show(floor);
      this.floorOf = id;
      this.show();
    } catch {
      this.shown = null; // the next answer asks again
    }
  }

  pin() {
    const { asked, answer, pinned } = this;
    if (!asked || !answer) return;
    this.pinned = pinned?.id === answer.id ? null : { id: answer.id, levels: { ...this.levelsOf(answer) } };
    this.show();
    if (!this.refused) this.listen();
  }

  levelsOf(answer) {
    return answer.tried.find(({ id }) => id === answer.id)?.levels ?? this.asked.levels;
  }

  stopOrGoOn() {
    if (this.state === "running") {
      this.stream?.abort();
      this.state = "stopped";
    } else if (this.answer && this.state !== "stale") {
      this.more = this.state === "stopped" ? this.more : this.answer.n + this.about.runs;
      this.state = "running";
      this.listen();
    }
    this.show();
  }

  goTo(levels) {
    this.knobs.set(levels);
    this.knobs.wrong(null);
    this.move();
  }

  async share() {
    const first = this.pinned ? [this.pinned.id] : [], tried = this.answer.tried.map(({ id }) => id);
    try {
      const page = await this.feed.call("/api/share", { ids: [...new Set([...first, this.answer.id, ...tried])] });
      const address = URL.createObjectURL(await page.blob()), link = element("a", { href: address, download: `${this.about.name}.html` });
      link.click();
      setTimeout(() => URL.revokeObjectURL(address), 10000);
    } catch (error) {
      this.note(error.message);
    }
  }

  note(text) {
    byId("note").hidden = !text;
    byId("note").textContent = text;
  }

  // Bring everything in line with what is known.
  show() {
    const { answer, asked, state } = this, fresh = answer && asked && answer.id === asked.id && state !== "stale";
    const before = state === "stale" || (answer && asked && !fresh && state !== "refused" && state !== "offline");
    document.body.classList.toggle("stale", Boolean(answer && before));
    document.body.dataset.state = state;
    this.knobs.show(asked?.needed, this.pinned?.levels, answer?.tried ?? []);
    for (const field of byId("knobs").querySelectorAll("input, select")) field.disabled = state === "offline";
    this.showState();
    const verdict = byId("verdict"), hand = before || !answer;
    verdict.dataset.verdict = hand ? "estimate" : answer.verdict;
    verdict.textContent = hand ? "Quick estimate" : answer.label;
    byId("said").textContent = hand ? (asked?.sentence ?? "") : answer.sentence;
    byId("more").textContent = hand ? (asked?.more ?? "") : answer.more.join(" ");
    const old = this.floorOf && this.floorOf !== (asked ?? answer)?.id;
    byId("floor-head").textContent = !this.floorOf ? "The floor" : old ? "The floor of the previous option" : `The floor in one run, after the warm-up, ${this.watch.player?.speed ?? 1}× real time`;
    if (answer && !before) this.showAnswer(answer);
    this.draw();
  }

  showState() {
    const { answer, state } = this, live = byId("live");
    const left = answer?.seconds_left === null || answer?.seconds_left === undefined ? "" : `, ${Math.ceil(answer.seconds_left)} s left`;
    const why = { verdict: "the verdict is clear", fails: "runs fail", exact: "nothing is left to chance" }[answer?.done];
    const count = answer ? `${answer.n} run${answer.n === 1 ? "" : "s"}` : "";
    live.dataset.state = state;
    live.lastElementChild.textContent = {
      stale: this.frozen ? "" : "new option, starting the first run",
      running: answer?.n && !this.waits ? `${answer.n} of ${answer.wanted} runs${left}` : "the first run is simulated",
      done: `${count}, done${why ? `: ${why}` : ""}`, stopped: `${count}, stopped`, refused: "refused", offline: "no connection",
    }[state];
    byId("stop").textContent = state === "running" ? "Stop" : state === "stopped" ? "Go on" : `${this.about.runs} more runs`;
    byId("stop").disabled = state === "stale" || state === "offline" || state === "refused" || answer?.done === "exact";
    const isPinned = Boolean(answer) && this.pinned?.id === answer.id;
    byId("pin").textContent = isPinned ? "Unpin" : "Pin this option";
    byId("pin").setAttribute("aria-pressed", String(isPinned));
    byId("pin").disabled = !answer;
    byId("share").disabled = (answer?.tried.length ?? 0) < 2;
  }

  showAnswer(answer) {
    byId("also").replaceChildren(...answer.measured.slice(1).flatMap((one) => [element("dt", {}, one.label), element("dd", {}, one.text)]));
    byId("hold").hidden = !answer.busiest;
    byId("busiest").textContent = answer.busiest;
    byId("busy").replaceChildren(...answer.busy.map(([name, load]) =>
      element("li", {}, element("span", {}, name), element("meter", { min: 0, max: 1, value: load, "aria-label": `${name} busy` }), element("span", {}, `${Math.round(100 * load)} %`))));
    byId("notes").textContent = answer.notes.join(" ");
    const focused = document.activeElement?.dataset?.design;
    byId("chips").replaceChildren(...answer.tried.map((one) => this.chip(one, answer)));
    if (focused) byId("chips").querySelector(`[data-design="${focused}"]`)?.focus();
  }

  chip(one, answer) {
    const kinds = [one.id === answer.id ? "now" : "", one.id === this.pinned?.id ? "pinned" : ""].join(" ").trim();
    const found = element("b", {}, one.verdict === "overloaded" ? "cannot keep up" : `${one.text} ${MARKS[one.verdict] ?? ""}`.trim());
    const button = element("button", { type: "button", class: kinds, "data-design": one.id }, found, element("small", {}, `${one.words}${kinds.includes("pinned") ? ", pinned" : ""}`));
    button.addEventListener("click", () => this.goTo(one.levels));
    return element("li", {}, button);
  }

  draw() {
    const { answer, about } = this;
    if (answer) drawFunnel(byId("funnel"), answer, about.target, this.target, Math.max(about.runs, answer.wanted));
  }
}

async function begin() {
  const data = byId("frozen"), feed = data ? new Frozen(JSON.parse(data.textContent)) : new Feed(location.hash.slice(1));
  return new Live(feed, await feed.ask("/api/model"));
}

window.desimLive = {};
window.desimLive.ready = begin().then((live) => Object.assign(window.desimLive, { live }), (error) => {
  byId("problem").hidden = false;
  byId("problem").textContent = `This page cannot be shown: ${error.message}`;
  throw error;
});
