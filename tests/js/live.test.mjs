// Parts of the live page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const world = { AbortController, TextDecoderStream, clearTimeout, setTimeout };
const files = ["01-feed", "02-knobs", "04-held-up"];
const { Feed, RefusedError, heldUp, placeOf } = load("../live", files, ["Feed", "RefusedError", "heldUp", "placeOf"], {
  ...world,
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

test("the page names what is busiest, nothing where that has time left, and traffic where robots wait in it most", () => {
  assert.equal(heldUp(["chargers", 0.863, "86.3 % (85.2 to 87.1)"]), "The chargers: 86.3 % busy.");
  assert.equal(heldUp(["stations", 0.5, "50 % (49 to 51)"]), "Nothing: even the servers are free 50 % of the time.");
  const said = heldUp(["traffic", 0.509, "50.9 % (50.4 to 51.2)"]);
  assert.equal(said, "Traffic: robots wait in it 50.9 % of the time, longer than they are busy.");
});
