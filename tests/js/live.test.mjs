// Parts of the live page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const world = { AbortController, TextDecoderStream, clearTimeout, setTimeout };
const files = ["00-parts", "01-feed", "01-frozen", "02-knobs"];
const { Feed, Frozen, RefusedError, placeOf, rounds } = load("live", files, ["Feed", "Frozen", "RefusedError", "placeOf", "rounds"], {
  ...world,
  URL,
  fetch: (path, options) => world.fetch(path, options),
});

test("a number has its place among the values of a slider, also between two of them", () => {
  assert.equal(placeOf([2, 4, 8], 4), 1);
  assert.equal(placeOf([2, 4, 8], 5), 1.25);
  assert.equal(placeOf([2, 4, 8], 1), 0);
  assert.equal(placeOf([2, 4, 8], 100), 2);
});

test("answers are read however the stream is cut, with the token, and other events are left out", async () => {
  const text = 'id: 1\nevent: answer\ndata: {"n": 1}\n\nevent: alive\ndata: {}\n\nid: 2\nevent: answer\ndata: {"n": 2}\n\n';
  const cuts = [text.slice(0, 13), text.slice(13, 60), text.slice(60)].map((part) => new TextEncoder().encode(part));
  let headers = null;
  world.fetch = async (_, options) => {
    headers = options.headers;
    return { ok: true, body: new ReadableStream({ start: (to) => (cuts.forEach((cut) => to.enqueue(cut)), to.close()) }) };
  };
  const told = [];
  await assert.rejects(new Feed("secret").listen("/x", new AbortController().signal, (answer) => told.push(answer.n)), /ended/);
  assert.deepEqual(told, [1, 2]);
  assert.equal(headers.Authorization, "Bearer secret");
});

test("a call that is refused says why", async () => {
  world.fetch = async () => ({ ok: false, status: 422, json: async () => ({ problems: ["one", "two"] }) });
  const error = await new Feed("").ask("/api/design", {}).catch((found) => found);
  assert.ok(error instanceof RefusedError);
  assert.deepEqual([error.status, error.message], [422, "one\ntwo"]);
});

test("axes have round numbers that span the values", () => {
  assert.deepEqual(Array.from(rounds(0.93, 0.99)), [0.93, 0.94, 0.95, 0.96, 0.97, 0.98, 0.99].map((value) => rounds(0.93, 0.99).find((one) => Math.abs(one - value) < 1e-9)));
  assert.deepEqual(Array.from(rounds(100, 100)), [50, 60, 70, 80, 90, 100]); // a share that all runs agree in
  assert.ok(rounds(0, 0)[0] === 0 && rounds(0, 0).length > 1);
});

test("a page without a server answers for its options, beside the pinned one, and refuses others", async () => {
  const answer = (mean) => ({ sentence: `${mean}.`, more: [], measured: [{ mean, low: mean - 1, high: mean + 1 }] });
  const feed = new Frozen({
    about: { knobs: [{ key: "robots" }] }, tried: [1, 2], differences: [[null, "+4 (3 to 5)"], ["−4 (−5 to −3)", null]],
    designs: [[{ id: "a", words: "1 robot", levels: { robots: 1 } }, answer(5)], [{ id: "b", words: "2 robots", levels: { robots: 2 } }, answer(9)]],
  });
  assert.equal((await feed.ask("/api/design", { levels: { robots: 2 } })).id, "b");
  await assert.rejects(feed.ask("/api/design", { levels: { robots: 3 } }), RefusedError);
  let told = null;
  await feed.listen("/api/design/b/events?pinned=a", null, (one) => (told = one));
  assert.deepEqual(Array.from(told.more), ["Pinned: 5.", "Difference, run by run: +4 (3 to 5)."]);
  assert.deepEqual(Array.from(told.pinned_at), [5, 4, 6]);
});

// The page itself, of which no part is shown: elements are what was asked for, and a server that never answers.
const element = (tag, facts, ...within) => ({ tag, facts, within, on: {}, addEventListener(what, then) { this.on[what] = then; } });
const { Live } = load("live", ["00-parts", "01-feed", "01-frozen", "02-knobs", "05-live"], ["Live"], {
  element, byId: () => null, window: {}, location: { hash: "" }, fetch: () => new Promise(() => {}),
});
const made = (facts) => Object.assign(Object.create(Live.prototype), { show() {}, listen() {}, pinned: null, ...facts });

test("a button asks for as many runs more, stops them, and goes on with as many", () => {
  const heard = [], live = made({ state: "done", answer: { n: 35 }, about: { runs: 35 }, stream: { abort: () => heard.push("end") } });
  live.listen = () => heard.push(live.more);
  for (const state of ["running", "stopped", "running"]) {
    live.stopOrGoOn();
    assert.equal(live.state, state);
  }
  assert.deepEqual(heard, [70, "end", 70]);
});

test("a click on what was tried goes back to it, and its words stay text", () => {
  const done = [], words = "<img src=x onerror=alert(1)>", knobs = { set: (levels) => done.push(levels.robots), wrong: done.push.bind(done) };
  const live = made({ knobs, move: () => done.push("moved") });
  const [button] = live.chip({ id: "a", verdict: "met", text: "5 min", words, levels: { robots: 3 } }, { id: "b" }).within;
  const [found, small] = button.within;
  assert.deepEqual([found.within[0], small.within[0]], ["5 min ✓", words]);
  button.on.click();
  assert.deepEqual(done, [3, null, "moved"]);
});

test("a page whose server is back asks it for the pinned design again, then for its own", async () => {
  const asked = [], feed = { ask: async (path, { levels }) => asked.push(path, levels.robots) };
  const live = made({ feed, pinned: { levels: { robots: 2 } }, settled: false, byHand: () => asked.push("own") });
  await live.back();
  assert.deepEqual([live.settled, ...asked], [true, "/api/design", 2, "own"]);
});
