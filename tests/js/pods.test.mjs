// Pods of the replay page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { Pods } = load("replay", ["01-unpack", "09-pods", "12-side"], ["Pods"]);

// Two pods on places 4 and 2: robot 3 lifts the first at 10 and puts it down on 5 at 50; two lines are picked meanwhile.
const pods = () => new Pods({
  pod_at: [4, 2], move_time: [10, 40], move_pod: [0, 0], move_to: [-4, 5],
  hold_count: [2, 1], hold_item: [7, 9, 7], hold_units: [3, 1, -1],
  line_time: [5, 15], line_length: [25, 20], line_pod: [0, 0], line_task: [11, 12], line_item: [9, 7], line_node: [6, 6],
  line_units: [1, -2],
});
const plain = (value) => JSON.parse(JSON.stringify(value));

test("a pod is on its place, with its robot, and where that put it down, also when time goes back", () => {
  const some = pods();
  assert.deepEqual([0, 10, 60, 9].map((time) => some.place(time)[0]), [4, -4, 5, 4]);
  assert.deepEqual([some.on(2, 0), some.on(-4, 20), some.on(4, 20)], [1, 0, -1]);
});

test("lines are those for which a robot is on its way, until they are picked", () => {
  assert.deepEqual(plain([4, 5, 20, 30, 40].map((time) => pods().lines(time, 0))), [[], [0], [0, 1], [1], []]);
  assert.deepEqual(plain(pods().lines(20, 1)), []);
});

test("a pod says what it holds and for whom it goes", () => {
  const place = (node) => `node ${node}`;
  assert.deepEqual(plain(pods().said(0, 20, place)), ["for node 6: lines 11 (item 9), 12 (item 7)", "holds items 7 (3), 9 (1)"]);
  assert.deepEqual(plain(pods().said(0, 60, place)), ["for no line", "holds item 7 (5)"]); // 9 is gone, two of 7 were put there
  assert.deepEqual(plain(pods().said(1, 60, place)), ["for no line", "holds item 7"]);
  const named = pods();
  named.names = { 7: "tea", 9: "milk" };
  assert.deepEqual(plain(named.said(0, 60, place)), ["for no line", "holds item \u2068tea\u2069 (5)"]);
});
