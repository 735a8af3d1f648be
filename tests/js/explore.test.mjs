// Parts of the what-if page, worked out by hand.

import assert from "node:assert/strict";
import { test } from "node:test";
import { load } from "./load.mjs";

const { Study, rounds } = load("explore", ["01-parts", "02-study", "04-axes"], ["Study", "rounds"]);

test("a design is found by the ranks of its levels, and the others along a factor", () => {
  const study = new Study({
    factors: [{ head: "Number of robots", levels: ["2", "3"] }, { head: "Load time (s)", levels: ["5", "9"] }],
    designs: [[0, 0], [0, 1], [1, 0], [1, 1]].map((levels) => ({ levels })),
  });
  assert.equal(study.at([1, 0]), 2);
  assert.equal(study.at([2, 0]), undefined);
  assert.deepEqual(Array.from(study.along([1, 0], 1)), [2, 3]);
  assert.equal(study.words([1, 0]), "Number of robots 3, Load time 5");
  assert.equal(study.words([1, 0], 0), "Load time 5");
});

test("axes have round numbers that span the values", () => {
  assert.deepEqual(Array.from(rounds(0.93, 0.99)), [0.93, 0.94, 0.95, 0.96, 0.97, 0.98, 0.99].map((value) => rounds(0.93, 0.99).find((one) => Math.abs(one - value) < 1e-9)));
  assert.deepEqual(Array.from(rounds(100, 100)), [50, 60, 70, 80, 90, 100]); // a share that all runs agree in
  assert.ok(rounds(0, 0)[0] === 0 && rounds(0, 0).length > 1);
});
